//! A torque that never changes.

use super::spec::{TORQUE, Port, Scale, Spec, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "constant_load",
    port: Port::Torque,
    title: "a constant torque (hoisted weight, constant-force spring, voltage offset)",
    equation: "f = -load",
    source: "winch",
    signature: "residual torque is the same at every speed and angle; the shaft drifts one way",
    parameters: &[strength("load", "V", "torque against forward motion, as a voltage", Scale::Volt, [-10.0, 0.1, 10.0])],
    probes: &[&[-0.8], &[-0.1], &[0.1], &[0.8]],
    search: Search::Probes,
    laws: TORQUE,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// A torque of `load` backwards.
#[derive(Debug, Clone, Copy)]
pub struct ConstantLoad<S> {
    load: S,
}

impl<S: Scalar> ConstantLoad<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { load: parameters[0] }
    }
}

impl<S: Scalar> Effect<S> for ConstantLoad<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.load_torque -= self.load;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn speed_shifts_by_the_same_amount_both_ways() {
        close(steady_speed(Kind::ConstantLoad, &[0.5], 6.0), BASE.gain * 5.5, 1e-9);
        close(steady_speed(Kind::ConstantLoad, &[0.5], -6.0), -BASE.gain * 6.5, 1e-9);
    }
}
