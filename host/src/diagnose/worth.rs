//! Which of two models to believe: whether an effect is worth its parameters, and the simplest of those that are as good.

use motorlens_shared::effects::Kind;

use super::candidate::{Candidate, Errors, STANDS_OUT, STEADY};

/// An effect must lower the increments' error to this share, on the records fitted and on those kept out ...
const WORTH: f64 = 0.97;
/// ... and a first one to this on the mean of both: torque that disturbs the motor lends itself to one or another for less.
const WORTH_A_FIRST: f64 = 0.93;
/// ... and to this where two runs of a programme show such a torque: what little shows above it could be one law as well as
/// another.
const WORTH_IN_UNREST: f64 = 0.8;
/// A further effect must do more: what a slightly wrong law leaves over looks like a small effect.
const WORTH_MORE: f64 = 0.85;
/// ... and a third one still more: where two were found, what is left is mostly what their laws are wrong by.
const WORTH_A_THIRD: f64 = 0.7;
/// The error itself on unseen records must not rise by more than this, whatever its increments do ...
const NO_WORSE: f64 = 1.1;
/// ... unless they fall to this share on both sets, and it falls on their mean: of two large effects one alone may drift
/// anywhere.
const MUCH: f64 = 0.75;
/// ... or it falls to this share on their mean: one record alone may drift by chance.
const FALLS: f64 = 0.7;
/// Where the unseen records do not show an effect: their increments' error must not rise by more than this, and that
/// of the records fitted must fall to this share.
const NOT_WORSE: f64 = 1.005;
const CLEARLY: f64 = 0.8;
/// Share of the error itself, on both, that a slow effect must leave at most ...
const PLAINLY: f64 = 0.35;
/// ... or, where it leaves no more than noise ...
const ALL_OF_IT: f64 = 0.6;
const NOISE: f64 = 1.2;
/// ... of an error that was this many noise units.
pub const SLOW: f64 = 1.8;
/// A further effect that leaves noise alone on both sets of records is there where it takes this off the merit: what little
/// the increments and the error itself show of it agrees.
const OF_BOTH: f64 = 0.27;
/// Models whose increments' errors differ by less than this (6 %) count as equal: the one with fewer parameters wins.
pub const EQUAL: f64 = 0.06;
/// ... unless its error itself is that many times larger: the increments do not see slow drift.
const DRIFT: f64 = 1.5;
/// Nothing more is left to find below this many noise units in a model that explains already.
pub const NEAR_THE_FLOOR: f64 = 1.15;

/// Whether `more` is worth its parameters over `less`: better on both sets of records, in the increments or, where these
/// stay as they are, plainly in the error that they add up to.
pub fn worth(more: &Candidate, less: &Candidate) -> bool {
    if more.foretold && !less.foretold {
        return more.merit() < less.merit() + WORTH.ln();
    }
    // A richer law in the place of one that was there is no further effect; two at once must do what they would one after the other.
    let beside = less.kinds().len().min(more.kinds().len().saturating_sub(1));
    let places = beside..more.kinds().len().max(beside + 1);
    let steps = places.len() as i32;
    let of = |e: fn(&Errors) -> f64| (e(&more.train) / e(&less.train), e(&more.unseen) / e(&less.unseen));
    let (train, unseen) = of(|e| e.increments);
    let (drift, unseen_drift) = of(|e| e.position);
    let drifted = less.train.position.min(less.unseen.position);
    let left = more.larger_drift();
    // A torque that disturbs the motor makes some drift of its own, which many a law can follow.
    let calm = more.calm != Some(false);
    let slow = drifted > STEADY && drift.max(unseen_drift) < PLAINLY.powi(steps)
        || calm && drifted > SLOW && left < NOISE && drift.max(unseen_drift) < ALL_OF_IT.powi(steps);
    if slow && train.max(unseen) < NOT_WORSE {
        return true;
    }
    if promises(more, less) && left < NOISE || shows_on_a_record(more, less) || shows_in_calm(more, less) {
        return true;
    }
    let asked = |beside: usize| match beside {
        0 if !calm => WORTH_IN_UNREST,
        0 => WORTH_A_FIRST,
        1 => WORTH_MORE,
        _ => WORTH_A_THIRD,
    };
    let mean: f64 = places.map(asked).product();
    // Unseen records at the floor already cannot get better, only worse.
    let silent = less.unseen.increments < NEAR_THE_FLOOR && unseen < NOT_WORSE && train < CLEARLY;
    train < WORTH
        && (unseen < WORTH || silent)
        && (train * unseen).sqrt() < mean
        && (unseen_drift < NO_WORSE
            || train.max(unseen) < MUCH && drift * unseen_drift < 1.0
            || drift * unseen_drift < FALLS * FALLS)
        && more.merit() < less.merit() + WORTH.ln()
}

/// Whether `more`, at the noise in its increments, may come to be worth its parameters when its error itself is searched down.
pub fn promises(more: &Candidate, less: &Candidate) -> bool {
    !less.kinds().is_empty() && more.merit() < less.merit() - OF_BOTH && to_the_floor(more)
}

/// Whether a first effect lowers both errors on both sets of records where nothing disturbs the motor: nothing else would.
fn shows_in_calm(more: &Candidate, less: &Candidate) -> bool {
    const BOTH: f64 = 0.25;
    let lower = |(more, less): (&Errors, &Errors)| {
        more.increments < WORTH * less.increments && more.position < less.position
    };
    let each = [(&more.train, &less.train), (&more.unseen, &less.unseen)];
    more.calm == Some(true)
        && less.kinds().is_empty()
        && each.into_iter().all(lower)
        && more.merit() < less.merit() - BOTH
}

/// Whether `more` leaves noise alone on every record, where a second effect was missing on one that shows it: a gap of time
/// after quick changes of voltage, a ripple at low speed. Of teeth it is asked on that record alone, which must show them plainly:
/// which of them a shaft slips over on others is chance.
fn shows_on_a_record(more: &Candidate, less: &Candidate) -> bool {
    const GONE: f64 = 1.2;
    const NO_RECORD_WORSE: f64 = 1.05;
    const BY_CHANCE: f64 = 1.15;
    const SHOWN_PLAINLY: f64 = 2.0;
    let teeth = more.kinds().last() == Some(&Kind::Cogging);
    let (stands_out, most) = if teeth { (SHOWN_PLAINLY, BY_CHANCE) } else { (STANDS_OUT, NO_RECORD_WORSE) };
    let shows = less.worst();
    let each = || more.records.iter().zip(&less.records);
    let kept = each().all(|(more, less)| *more < less * most);
    let gone = each().all(|(more, less)| *more < GONE || teeth && *less < shows);
    less.kinds().len() == 1 && shows > stands_out && gone && kept
}

/// Whether the increments are at the noise on both sets of records.
fn to_the_floor(c: &Candidate) -> bool {
    c.larger_increments() < NEAR_THE_FLOOR
}

/// The simplest of those that are as good as the best.
pub fn simplest(candidates: &[Candidate]) -> Option<&Candidate> {
    let least = |of: &mut dyn Iterator<Item = &Candidate>| of.map(Candidate::merit).fold(f64::MAX, f64::min);
    let within = least(&mut candidates.iter()) + FORETOLD;
    let foretold = candidates.iter().any(|c| c.foretold && c.merit() <= within);
    let asked = || candidates.iter().filter(|c| c.foretold == foretold);
    let best = asked().min_by(|a, b| a.merit().total_cmp(&b.merit()))?;
    let good = || asked().filter(|c| as_good(c, best));
    let size = good().map(Candidate::size).min()?;
    let of_size = || good().filter(|c| c.size() == size);
    let merit = least(&mut of_size());
    of_size().filter(|c| c.merit() <= merit + TIE).min_by_key(|c| rarity(c))
}

/// What two runs show without a model is believed where no other model is better than it by more than this.
const FORETOLD: f64 = 0.5;

/// Below this difference of merit two laws of the same size fit alike, and the commoner one is meant.
const TIE: f64 = 0.04;

/// How seldom one meets the last effect of `c`: asked only where the data do not decide.
fn rarity(c: &Candidate) -> usize {
    const COMMON: [Kind; 9] = [
        Kind::Coulomb,
        Kind::DeadZone,
        Kind::Gravity,
        Kind::Backlash,
        Kind::Delay,
        Kind::Cogging,
        Kind::SensorLag,
        Kind::VoltageDrop,
        Kind::ConstantLoad,
    ];
    c.kinds().last().and_then(|k| COMMON.iter().position(|c| c == k)).unwrap_or(COMMON.len())
}

/// Whether the two cannot be told apart by their errors.
pub fn as_good(c: &Candidate, best: &Candidate) -> bool {
    let log =
        |f: fn(&Errors) -> f64, c: &Candidate| 0.5 * (f(&c.train).max(0.7).ln() + f(&c.unseen).max(0.7).ln());
    log(|e| e.increments, c) <= log(|e| e.increments, best) + EQUAL
        && log(|e| e.position, c) <= log(|e| e.position, best) + DRIFT.ln()
}

/// Whether `c` is another model about as large and not much worse than `next`.
pub fn rivals(c: &Candidate, next: &Candidate) -> bool {
    c.size() <= next.size() + 1 && !same(c, next) && c.merit() < next.merit() + RIVAL
}

/// A model this much worse (a factor of two in error and more) has lost.
const RIVAL: f64 = 0.9;

/// Whether they have the same effects.
fn same(a: &Candidate, b: &Candidate) -> bool {
    let sorted = |c: &Candidate| {
        let mut kinds = c.kinds().to_vec();
        kinds.sort();
        kinds
    };
    sorted(a) == sorted(b)
}
