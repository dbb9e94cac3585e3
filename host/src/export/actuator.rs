//! What targets that take a few numbers take of a model.

use motorlens_shared::effects::Kind;

use super::{Lost, effects, level};
use crate::fit::layout::Values;
use crate::model_file::Model;

/// Numbers of an actuator, in the units of voltage and output shaft.
pub(super) struct Actuator {
    /// Dry friction at speed, V.
    pub friction: f64,
    /// What breaking away takes above it, V; the speed at which that has fallen to 38 %, rad/s; and the tail of its fall.
    pub stribeck: Option<[f64; 3]>,
    /// Share of the motor's torque that friction takes.
    pub load_share: Option<f64>,
    /// Command that the driver swallows in each direction, V.
    pub dead_zone: f64,
    /// Delay of the command, s.
    pub delay_s: f64,
    /// Torque against forward motion, V.
    pub load: f64,
    /// Sine and cosine part of a weight's torque, V.
    pub weight: Option<[f64; 2]>,
}

/// Electrical time constant of a target that has none, s: a hundredth of a sample.
const NO_INDUCTANCE_S: f64 = 1e-5;

/// The numbers of those `kinds` that the target takes; everything else is lost, for the reason that `why` gives.
pub(super) fn take(model: &Model, kinds: &[Kind], why: &str) -> (Actuator, Vec<Lost>, Values) {
    let mut a = Actuator {
        friction: 0.0,
        stribeck: None,
        load_share: None,
        dead_zone: 0.0,
        delay_s: 0.0,
        load: 0.0,
        weight: None,
    };
    let (mut lost, mut carried) = (Vec::new(), model.values());
    carried.base.tau_e = NO_INDUCTANCE_S;
    for (kind, p) in effects(model) {
        if !kinds.contains(&kind) {
            carried = carried.without(kind);
            if let Some(level) = level(kind, &p).filter(|_| kinds.contains(&Kind::Coulomb)) {
                a.friction += level;
                let why = format!("{why}; its level stays as dry friction");
                lost.push(Lost::new(kind, why).but_for_its_level());
            } else {
                lost.push(Lost::new(kind, why));
            }
            continue;
        }
        match kind {
            Kind::Coulomb => a.friction += p[0],
            Kind::CoulombAsymmetric => {
                a.friction += p[0];
                a.load += p[1];
            }
            Kind::Stribeck => {
                a.friction += p[0];
                a.stribeck = Some([p[1], p[2], p[3]]);
            }
            Kind::LoadFriction => a.load_share = Some(p[0]),
            Kind::DeadZone => a.dead_zone = p[0],
            Kind::Delay => a.delay_s = p[0],
            Kind::ConstantLoad => a.load += p[0],
            Kind::Gravity => a.weight = Some([p[0], p[1]]),
            _ => {}
        }
    }
    (a, lost, carried)
}

/// Those of `kinds` that the model has, as left to others for the reason that `why` gives. A level of friction stays.
pub(super) fn leave(model: &Model, kinds: &[Kind], why: &str) -> Vec<Lost> {
    let effects = effects(model);
    let there = effects.iter().filter(|(kind, _)| kinds.contains(kind));
    there.map(|(kind, _)| Lost::new(*kind, why).but_for_its_level()).collect()
}

/// What loads are to a joint's actuator.
pub(super) const LOADS: [Kind; 3] = [Kind::ConstantLoad, Kind::Gravity, Kind::Spring];
pub(super) const OF_THE_ROBOT: &str = "belongs to the robot that the joint moves";

/// `values` with all dry friction as one level, and without `gone`.
pub(super) fn one_level(values: Values, level: f64, gone: &[Kind]) -> Values {
    let all = [Kind::Coulomb, Kind::CoulombAsymmetric, Kind::Stribeck];
    let values = all.iter().chain(gone).fold(values, |values, kind| values.without(*kind));
    if level > 0.0 { values.with(Kind::Coulomb, vec![level]) } else { values }
}
