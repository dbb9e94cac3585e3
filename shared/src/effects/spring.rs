//! A spring at the output.

use super::spec::{TORQUE, Port, Scale, Spec, shape, strength};
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
    laws: TORQUE,
    remembers: false,
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
        // A spring holds the model's own shaft, in guided runs too: what a reading lacks of a count would drive it away.
        let stretch = middle - now.ahead - memory.origin;
        drive.load_torque -= self.stiffness.mul_add(stretch, self.preload);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::simulator::Simulator;
    use crate::step::State;

    #[test]
    fn rests_where_the_spring_balances_the_voltage() {
        let (_, motion) = run(Kind::Spring, &[0.5, 0.0], &[2.0; 60_000]);
        close(motion.state.angle, 4.0, 1e-6);
    }

    /// A shaft that is read half a count ahead would else be driven away for as long as the run lasts.
    #[test]
    fn a_guided_run_leaves_the_spring_at_the_models_own_shaft() {
        let simulator = Simulator::new(&BASE, [(Kind::Spring, &[0.5, 0.1][..])], &RIG);
        let mut motions = [simulator.start(State::rest()); 2];
        for k in 1..2000 {
            simulator.advance(&mut motions[0], &[1.0; 2000], k);
            simulator.advance_guided(&mut motions[1], &[1.0; 2000], k, 0.01);
        }
        close(motions[1].state.angle, motions[0].state.angle, 1e-12);
    }

    #[test]
    fn the_spring_acts_at_the_middle_of_the_step() {
        let gain = gain_of_half_steps(Kind::Spring, &[2.0, 0.3]);
        assert!(gain > 3.0, "half the step leaves 1/{gain:.1} of the error");
    }
}
