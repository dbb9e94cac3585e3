//! The drag of eddy currents: falls again above a critical speed.

use super::spec::{Port, Scale, Search, Spec, TORQUE, shape, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "eddy_brake",
    port: Port::Torque,
    title: "an eddy-current brake",
    equation: "f = -drag w / (1 + (w / critical)^2)",
    source: "W. R. Smythe, Transactions of the AIEE 61, 1942",
    signature: "residual torque rises to a maximum at a slow speed and falls beyond it, alike in both directions",
    parameters: &[
        strength("drag", "V s/rad", "torque per speed where it is slow", Scale::One, [0.0, 1.0, 20.0]),
        shape("critical", "rad/s", "where the drag is strongest", Scale::Speed, [0.02, 0.15, 1.0]),
    ],
    probes: &[&[0.3, 0.15], &[1.5, 0.15], &[0.3, 0.4]],
    search: Search::Probes,
    laws: TORQUE,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Torque against the motion, proportional to a slow speed.
#[derive(Debug, Clone, Copy)]
pub struct EddyBrake<S> {
    drag: S,
    per_speed: S,
}

impl<S: Scalar> EddyBrake<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { drag: parameters[0], per_speed: S::one() / parameters[1] }
    }
}

impl<S: Scalar> Effect<S> for EddyBrake<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        let x = now.state.speed * self.per_speed;
        drive.torque -= self.drag * now.state.speed / x.mul_add(x, S::one());
    }
}
