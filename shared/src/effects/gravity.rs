//! A weight on an arm.

use super::spec::{TORQUE, Port, Scale, Spec, strength, Search};
use super::wave::Wave;
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "gravity",
    port: Port::Torque,
    title: "a weight on an arm: torque once per output revolution",
    equation: "f = -(sine sin(x) + cosine cos(x)) at the load",
    source: "pendulum; two components because the log's zero is not the hanging position",
    signature: "residual torque against the output angle, folded once a revolution, is a sine",
    parameters: &[
        strength("sine", "V", "torque at a quarter turn", Scale::Volt, [-12.0, 0.15, 12.0]),
        strength("cosine", "V", "torque at the log's zero", Scale::Volt, [-12.0, 0.15, 12.0]),
    ],
    probes: &[
        &[0.1, 0.0], &[0.0, 0.1], &[-0.1, 0.0], &[0.0, -0.1],
        &[0.4, 0.0], &[0.0, 0.4], &[-0.4, 0.0], &[0.0, -0.4],
        &[1.2, 0.0], &[0.0, 1.2], &[-1.2, 0.0], &[0.0, -1.2],
    ],
    search: Search::Probes,
    laws: TORQUE,
    remembers: false,
    periodic: true,
    by_duty: false,
    contains: &[],
};

/// Torque of a pendulum in two components.
#[derive(Debug, Clone, Copy)]
pub struct Gravity<S> {
    weight: Wave<S>,
    turns: S,
    half_step: S,
}

impl<S: Scalar> Gravity<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self {
            weight: Wave::new(parameters[0], parameters[1]),
            turns: setting.output_turns,
            half_step: setting.step * S::lit(0.5),
        }
    }
}

impl<S: Scalar> Effect<S> for Gravity<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        // At the middle of the step: a weight that acts late drives an arm that it should only swing.
        let middle = now.state.load_speed.mul_add(self.half_step, now.state.load_angle);
        drive.load_torque -= self.weight.at(middle * self.turns);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    /// Held at a small voltage, the arm comes to rest where the weight balances it.
    #[test]
    fn rests_where_the_weight_balances_the_voltage() {
        let (_, motion) = run(Kind::Gravity, &[1.0, 0.0], &[0.5; 40_000]);
        close(motion.state.angle, libm::asin(0.5), 1e-6);
    }

    #[test]
    fn the_weight_acts_at_the_middle_of_the_step() {
        let gain = gain_of_half_steps(Kind::Gravity, &[1.5, 0.4]);
        assert!(gain > 3.0, "half the step leaves 1/{gain:.1} of the error");
    }
}
