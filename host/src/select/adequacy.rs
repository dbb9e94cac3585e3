//! Whether a model leaves anything that these records show.

use super::criterion::{KNOWN_VOLTAGE, LIKELY, SURE};
use super::fitted::Fitted;
use crate::compare::dependence::Dependence;
use crate::compare::free_run::{free_runs, simulated};
use crate::compare::residual_torque::residual_torque;
use crate::diagnose::evidence::Evidence;

/// So many times the noise are little: equations are idealised.
pub(crate) const LITTLE: f64 = 2.0;
/// ... and so is this share of what the plain motor leaves, however small the noise.
const NEXT_TO_NOTHING: f64 = 0.01;
/// A larger share than this is no chance, however few stretches show it.
const MUCH: f64 = 0.2;
/// A larger torque than this, of the stall torque at the highest voltage, is no disturbance but something that nobody knows: a rough floor or
/// cable comes to a twentieth (docs/EXAM.md), and what the derivatives of the readings add is beside it.
const MOST_DISTURBANCE: f64 = 0.06;

/// A model whose error is so many times that of kS-kV-kA is beaten by it.
const BEATEN: f64 = 1.1;

/// What a model leaves of the records.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub enum Adequacy {
    /// Something that depends on what was measured, or more than a disturbance.
    #[default]
    Something,
    /// No more than noise, or next to nothing of what the plain motor leaves.
    Noise,
    /// A torque that depends on nothing measured, as an rms voltage, V: a disturbance.
    Disturbance(f64),
    /// A torque smaller than the voltage is known, as an rms voltage, V.
    Trifle(f64),
}

impl Adequacy {
    /// Of `model`, where the plain motor fitted to the same records is `plain` and the readings have noise of the rms `floor`, in the measured
    /// unit.
    ///
    /// A torque that the model lacks depends on voltage, speed, angle or time. Where what is left does not, it is noise or a disturbance:
    /// no more than two runs of one programme differ by, or, where nothing was run twice, of any size that a disturbance may have.
    ///
    /// A model with a value where its search ends is at no minimum, one that kS-kV-kA beats lacks what that has, and effects beside a motor of which
    /// the records determine nothing may be anything: what they leave is not looked at.
    pub fn of(evidence: &Evidence, plain: &Fitted, model: &Fitted, floor: f64) -> Self {
        let error = simulated(&evidence.whole, &model.values()).unwrap_or_default().rmse;
        let is_beaten = evidence.usual.as_ref().is_some_and(|usual| error > BEATEN * usual.rmse);
        let is_open = !model.kinds().is_empty() && !model.knows_the_motor(evidence);
        if is_beaten || model.is_at_the_end() || is_open {
            return Self::Something;
        }
        let values = model.values();
        let torque = |run| residual_torque(run, &values.base);
        let torques: Vec<_> = free_runs(&evidence.train, &values).iter().map(torque).collect();
        let found = Dependence::of(&torques);
        let highest = evidence.highest_voltage();
        let smaller = |share: f64| found.map(|found| found.left_v).filter(|left| *left < share * highest);
        // Where two runs tell the noise it takes as much to doubt a model as to accept an effect.
        let sure = if evidence.repeats.is_empty() { LIKELY } else { SURE };
        let depends = found.is_some_and(|found| found.sure >= sure || found.share >= MUCH);
        let trifle = || smaller(KNOWN_VOLTAGE).map(Self::Trifle);
        if depends {
            return trifle().unwrap_or_default();
        }
        if error < LITTLE * floor {
            return Self::Noise;
        }
        let beside = match (evidence.left_over(model) < LITTLE, evidence.repeats.is_empty()) {
            // Two runs of one programme differ by as much.
            (true, false) => Some(found.map_or(Self::Noise, |found| Self::Disturbance(found.left_v))),
            (true, true) => Some(Self::Noise),
            (false, true) => smaller(MOST_DISTURBANCE).map(Self::Disturbance),
            (false, false) => is_all_but_explained(evidence, plain, model).then_some(Self::Noise),
        };
        beside.or_else(trifle).unwrap_or_default()
    }

    /// Whether what is left shows nothing that a model could explain.
    pub fn is_explained(self) -> bool {
        self != Self::Something
    }
}

/// Whether what `model` leaves beyond the noise is next to nothing of what `plain` leaves, in squares.
fn is_all_but_explained(evidence: &Evidence, plain: &Fitted, model: &Fitted) -> bool {
    let noise = evidence.noise_under(model);
    let excess = |model: &Fitted| model.noise.over(&noise).powi(2) - 1.0;
    excess(model) < NEXT_TO_NOTHING * excess(plain)
}
