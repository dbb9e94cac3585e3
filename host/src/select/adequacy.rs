//! Whether a model leaves anything that these records show.

use super::fitted::{Fitted, LIKELY, SURE};
use crate::compare::dependence::Dependence;
use crate::compare::free_run::free_runs;
use crate::compare::residual_torque::residual_torque;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::simulated;

/// So many times the noise are little: equations are idealised.
const LITTLE: f64 = 2.0;
/// ... and so is this share of what the plain motor leaves, however small the noise.
const NEXT_TO_NOTHING: f64 = 0.01;
/// A larger share than this is no chance, however few stretches show it.
const MUCH: f64 = 0.2;
/// A larger torque than this, of the stall torque at the highest voltage, is no disturbance but something that nobody knows.
const MOST_DISTURBANCE: f64 = 0.1;

/// What is left of the records beside a model.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Adequacy {
    /// Whether what is left shows nothing that a model could explain.
    pub explained: bool,
    /// Where nothing was run twice: what is left beyond the noise, as an rms torque in the unit of the voltage, V, if it is a disturbance.
    pub disturbance_v: Option<f64>,
}

impl Adequacy {
    /// Of `model`, where the plain motor fitted to the same records is `plain` and the readings have noise of the rms `floor`, in the measured
    /// unit.
    ///
    /// A torque that the model lacks depends on voltage, speed, angle or time. Where what is left does not, it is noise or a disturbance:
    /// no more than two runs of one programme differ by, or, where nothing was run twice, of any size that a disturbance may have.
    pub fn of(evidence: &Evidence, plain: &Fitted, model: &Fitted, floor: f64) -> Self {
        let values = model.values();
        let torque = |run| residual_torque(run, &values.base);
        let torques: Vec<_> = free_runs(&evidence.train, &values).iter().map(torque).collect();
        let found = Dependence::of(&torques);
        // Where two runs tell the noise it takes as much to doubt a model as to accept an effect.
        let sure = if evidence.repeats.is_empty() { LIKELY } else { SURE };
        if found.is_some_and(|found| found.sure >= sure || found.share >= MUCH) {
            return Self { explained: false, disturbance_v: None };
        }
        let error = || simulated(&evidence.whole, &values).unwrap_or_default().rmse;
        if evidence.left_over(model) < LITTLE || error() < LITTLE * floor {
            return Self { explained: true, disturbance_v: None };
        }
        if !evidence.repeats.is_empty() {
            return Self { explained: is_all_but_explained(evidence, plain, model), disturbance_v: None };
        }
        let left = found.map(|found| found.left_v);
        let disturbance_v = left.filter(|left| *left < MOST_DISTURBANCE * evidence.highest_voltage());
        Self { explained: disturbance_v.is_some(), disturbance_v }
    }
}

/// Whether what `model` leaves beyond the noise is next to nothing of what `plain` leaves, in squares.
fn is_all_but_explained(evidence: &Evidence, plain: &Fitted, model: &Fitted) -> bool {
    let noise = evidence.noise_under(model);
    let excess = |model: &Fitted| model.noise.over(&noise).powi(2) - 1.0;
    excess(model) < NEXT_TO_NOTHING * excess(plain)
}
