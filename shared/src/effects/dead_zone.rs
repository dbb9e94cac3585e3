//! The driver gives nothing until the command passes a threshold.

use super::spec::{EXPLICIT, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "dead_zone",
    port: Port::Voltage,
    title: "the driver swallows small commands (dead zone)",
    equation: "v = v_log - clamp(v_log, -(width - offset), width + offset)",
    source: "driver dead time and gate thresholds; dead-zone block of control textbooks",
    signature: "residual is a constant voltage against the sign of the command, even while braking",
    parameters: &[
        strength("width", "V", "mean of the two thresholds", Scale::Volt, [0.0, 0.3, 10.0]),
        shape("offset", "V", "half of forward less backward threshold", Scale::Volt, [-5.0, 0.02, 5.0]),
    ],
    probes: &[&[0.1, 0.0], &[0.4, 0.0], &[1.0, 0.0], &[2.0, 0.0]],
    search: Search::Probes,
    laws: EXPLICIT,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Thresholds of the two directions.
#[derive(Debug, Clone, Copy)]
pub struct DeadZone<S> {
    forward: S,
    backward: S,
}

impl<S: Scalar> DeadZone<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        let (width, offset) = (parameters[0], parameters[1]);
        let zero = S::zero();
        Self { forward: (width + offset).max(zero), backward: (width - offset).max(zero) }
    }
}

impl<S: Scalar> Effect<S> for DeadZone<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.voltage -= drive.voltage.clamp(-self.backward, self.forward);
        drive.asked = drive.voltage;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn nothing_inside_and_the_excess_outside() {
        assert_eq!(steady_speed(Kind::DeadZone, &[1.0, 0.2], 1.19), 0.0);
        close(steady_speed(Kind::DeadZone, &[1.0, 0.2], 6.2), BASE.gain * 5.0, 1e-9);
        close(steady_speed(Kind::DeadZone, &[1.0, 0.2], -5.8), -BASE.gain * 5.0, 1e-9);
    }
}
