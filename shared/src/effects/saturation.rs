//! Iron that saturates: less torque per ampere at high current.

use super::spec::{FIELD, Port, Scale, Spec, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "saturation",
    port: Port::Voltage,
    title: "the iron saturates: torque per ampere falls at high current",
    equation: "K_t and k_e scale with 1 / (1 + strength (u / nominal)^2)",
    source: "armature reaction; even in the current, so the first term is its square",
    signature: "jumps of the voltage accelerate less than the model says; slow motion fits",
    parameters: &[strength("strength", "1", "loss at stall", Scale::One, [0.0, 0.3, 8.0])],
    probes: &[&[0.15], &[0.6], &[2.0]],
    laws: FIELD,
    remembers: false,
    contains: &[],
};

/// Field weakening with the square of the current.
#[derive(Debug, Clone, Copy)]
pub struct Saturation<S> {
    strength: S,
    per_nominal: S,
}

impl<S: Scalar> Saturation<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { strength: parameters[0], per_nominal: setting.per_nominal }
    }
}

impl<S: Scalar> Effect<S> for Saturation<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        let x = now.state.current * self.per_nominal;
        drive.field = drive.field / (self.strength * x).mul_add(x, S::one());
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    /// A motor held by a spring ends where the weakened torque balances it: u = v.
    #[test]
    fn stalled_torque_is_weakened_as_stated() {
        use crate::simulator::Simulator;
        let (weak, spring) = ([0.6], [2.0, 0.0]);
        let s = Simulator::new(&BASE, [(Kind::Saturation, &weak[..]), (Kind::Spring, &spring[..])], &RIG);
        let mut motion = s.start(crate::step::State::rest());
        let volts = [6.0; 8000];
        for k in 0..volts.len() {
            s.advance(&mut motion, &volts, k);
        }
        close(motion.state.angle, 6.0 / (1.0 + 0.6 * 0.25) / 2.0, 1e-6);
    }
}
