//! Torques that the angle alone decides, as a controller commands against them: weight, spring, cogging, and users' formulas.
//!
//! Each is the effect's own equation with the shaft at rest, so there is no second copy of it to go wrong. A constant load stands in kG.

use motorlens_shared::effects::{Active, Effect, Memory, Now, Setting};
use motorlens_shared::step::{Drive, State};
use serde::Serialize;

use crate::model_file::{EffectValues, Model, NamedValue};

/// Parts of a period over which the torque is averaged: several ripples of torque may pass in one.
const PARTS: i32 = 16;

/// An effect whose torque depends on the angle.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Load {
    /// Its name.
    pub effect: &'static str,
    /// Its equation; the command against it is -f.
    pub equation: &'static str,
    /// What the equation's names stand for.
    pub parameters: Vec<NamedValue>,
}

/// All of them, ready to be asked.
pub(super) struct Loads {
    active: Vec<Active<f64>>,
    /// What is told of them.
    pub told: Vec<Load>,
}

impl Loads {
    /// Those of `model`.
    pub(super) fn of(model: &Model) -> Self {
        let setting = Setting::new(&model.base.base(), &model.rig(1e-3), 1);
        let active = |effect: &EffectValues| {
            let values: Vec<f64> = effect.parameters.iter().map(|p| p.value).collect();
            Active::new(effect.effect, &values, &setting)
        };
        // Turns of the output shaft and parts of the motor's.
        let angles = || (0..64).flat_map(|k| [0.37 * f64::from(k - 32), 0.003 * f64::from(k)]);
        let varies = |effect: &&EffectValues| {
            let law = active(effect);
            let first = at_rest(&law, 0.0);
            angles().any(|angle| (at_rest(&law, angle) - first).abs() > 1e-6)
        };
        let loads: Vec<&EffectValues> = model.effects.iter().filter(varies).collect();
        let tell = |effect: &EffectValues| {
            let spec = effect.effect.spec();
            Load { effect: spec.name, equation: spec.equation, parameters: effect.parameters.clone() }
        };
        Self {
            active: loads.iter().map(|effect| active(effect)).collect(),
            told: loads.iter().map(|effect| tell(effect)).collect(),
        }
    }

    /// What holds the shaft against them, the mean over an even motion from one angle to another, V.
    pub(super) fn volts(&self, from: f64, to: f64) -> f64 {
        let at = |k: i32| from + (to - from) * (f64::from(k) + 0.5) / f64::from(PARTS);
        let sum: f64 =
            (0..PARTS).map(|k| self.active.iter().map(|law| at_rest(law, at(k))).sum::<f64>()).sum();
        -sum / f64::from(PARTS)
    }
}

/// Torque of an effect on a shaft that rests at `angle`, V; positive drives forward.
fn at_rest(law: &Active<f64>, angle: f64) -> f64 {
    let now = Now { command: 0.0, state: State::moving(0.0, 0.0, angle), voltages: &[0.0, 0.0], index: 1 };
    let mut drive = Drive::plain(0.0);
    law.drive(&now, &Memory::empty(0.0), &mut drive);
    drive.torque + drive.load_torque
}
