//! A spring at the output.

use super::spec::{TORQUE, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "spring",
    port: Port::Torque,
    title: "a spring at the output (cable, return spring)",
    equation: "f = -stiffness (x - x_start) - preload",
    source: "Hooke's law",
    signature: "residual torque against the output angle is a straight line; the shaft creeps back at zero voltage",
    parameters: &[
        strength("stiffness", "V/rad", "torque per angle", Scale::VoltPerTurn, [0.0, 0.15, 60.0]),
        shape("preload", "V", "torque at the start of the record", Scale::Volt, [-6.0, 0.05, 6.0]),
    ],
    probes: &[&[0.03, 0.0], &[0.15, 0.0], &[0.6, 0.0], &[3.0, 0.0]],
    search: Search::Retraced,
    laws: TORQUE,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[("constant_load", "preload")],
};

/// A linear spring from the record's first angle.
#[derive(Debug, Clone, Copy)]
pub struct Spring<S> {
    stiffness: S,
    preload: S,
    half_step: S,
}

impl<S: Scalar> Spring<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { stiffness: parameters[0], preload: parameters[1], half_step: setting.step * S::lit(0.5) }
    }
}

impl<S: Scalar> Effect<S> for Spring<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        // At the middle of the step: a spring that acts late gives back more than it took.
        let middle = now.state.load_speed.mul_add(self.half_step, now.state.load_angle);
        let stretch = middle - memory.origin;
        drive.load_torque -= self.stiffness.mul_add(stretch, self.preload);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn rests_where_the_spring_balances_the_voltage() {
        let (_, motion) = run(Kind::Spring, &[0.5, 0.0], &[2.0; 60_000]);
        close(motion.state.angle, 4.0, 1e-6);
    }

    #[test]
    fn the_spring_acts_at_the_middle_of_the_step() {
        let gain = gain_of_half_steps(Kind::Spring, &[2.0, 0.3]);
        assert!(gain > 3.0, "half the step leaves 1/{gain:.1} of the error");
    }
}
