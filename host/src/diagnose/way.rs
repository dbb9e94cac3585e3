//! The way down from the base model to the floor, and how much of it a model has gone: physics outside the library lends itself to
//! many effects in part, and is none of them.

use motorlens_shared::effects::Kind;

use super::candidate::{Candidate, STANDS_OUT, STEADY};
use super::worth::NEAR_THE_FLOOR;

/// Share of the way down to a measured floor that may be left, and of the error itself where that drifts: by laws whose searches
/// stop early, ...
pub const MOSTLY_THERE: f64 = 0.15;
const MOST_OF_THE_DRIFT: f64 = 0.55;
/// ... and by those whose searches come to their end, ...
const NEARLY_THERE: f64 = 0.05;
const NEARLY_ALL_OF_THE_DRIFT: f64 = 0.1;
/// ... or where a record stands out besides, ...
const A_LITTLE_OF_THE_DRIFT: f64 = 0.03;
/// ... or, where none but smooth laws stand, of what it stands out by, ...
const A_LITTLE_OF_A_RECORD: f64 = 0.12;
/// ... but for so much of the floor, which a law of a slightly other shape leaves.
const SHAPE: f64 = 0.1;
/// A model that leaves no more than this of the error is kept whatever its increments: no relative of a law does that.
const NONE_OF_THE_DRIFT: f64 = 0.01;
/// An error itself below this many times its floor on both sets of records is still.
const STILL: f64 = 1.5;
/// More work is done where the base model leaves so much more than the floor.
pub const FAR: f64 = 1.0;

/// Whether most of the way from `base` down to the floor is still before `model`.
pub fn is_far(model: &Candidate, base: &Candidate) -> bool {
    // Where little is missing, a share of it is less than noise: two effects that end in the noise have gone the way.
    let several = model.kinds().len() > base.kinds().len() + 1;
    let near = if several { NEAR_THE_FLOOR - 1.0 } else { 0.0 };
    let steady = base.drift() > STEADY && model.drift() <= NONE_OF_THE_DRIFT * base.drift();
    let excess = if steady { f64::INFINITY } else { near.max(MOSTLY_THERE * base.excess()) };
    leaves(model, base, excess, MOST_OF_THE_DRIFT * base.drift())
}

/// Whether `model` stops short of a measured floor that its laws, were they there, would come nearer to.
pub fn falls_short(model: &Candidate, base: &Candidate) -> bool {
    let all = |is: fn(Kind) -> bool| model.kinds().iter().all(|kind| is(*kind));
    let excess = SHAPE.max(NEARLY_THERE * base.excess());
    let drift = STEADY.max(NEARLY_ALL_OF_THE_DRIFT * base.drift());
    let one_record = model.worst() - 1.0 > A_LITTLE_OF_A_RECORD * (base.worst() - 1.0);
    let smooth = leaves(model, base, excess, drift)
        || model.worst() > STANDS_OUT && one_record
        || model.calm == Some(true) && drifts(model, base);
    is_far(model, base)
        || all(|kind| !is_rough(kind)) && smooth
        || all(|kind| !is_rough(kind) || kind == Kind::Coast) && is_uneven(model, base, A_LITTLE_OF_THE_DRIFT)
        || all(|kind| !is_rough(kind) || kind == Kind::Cogging) && is_uneven(model, base, NEARLY_THERE)
}

/// Whether `model` drifts on either set of records, and not by next to nothing of what `base` does.
pub fn drifts(model: &Candidate, base: &Candidate) -> bool {
    model.larger_drift() > STILL.max(A_LITTLE_OF_THE_DRIFT * base.larger_drift())
}

/// Whether `model` leaves a record that stands out and more than that share of the drift: what one law leaves to another shows as both,
/// and pulses whose times are not known leave records alone, as teeth do whose search stops early.
fn is_uneven(model: &Candidate, base: &Candidate, share: f64) -> bool {
    model.worst() > STANDS_OUT && model.larger_drift() > STEADY.max(share * base.larger_drift())
}

/// Whether `model` does not explain, and leaves more than `excess` above the floor or, where `base` drifts, more than `drift`.
fn leaves(model: &Candidate, base: &Candidate, excess: f64, drift: f64) -> bool {
    !model.explains() && (model.excess() > excess || base.drift() > STEADY && model.drift() > drift)
}

/// Whether a search of the effect may stop before its end, because teeth, gaps and chance make a rough way down, or pulses and holds
/// whose times are not found; and whether its law may be a rough one, because a user wrote it.
fn is_rough(kind: Kind) -> bool {
    use Kind::{Backlash, Coast, Cogging, Eccentricity, Formula, LostCounts, SensorLag};
    matches!(kind, Backlash | Coast | Cogging | Eccentricity | Formula(_) | LostCounts | SensorLag)
}
