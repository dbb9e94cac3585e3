//! Brushes and transistors that take a fixed voltage from any current.

use super::spec::{RESISTIVE, Port, Scale, Spec, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "voltage_drop",
    port: Port::Voltage,
    title: "brushes or transistors take a fixed voltage from any current",
    equation: "v_winding = v - drop sign(u); no current flows while |v - k_e w| < drop",
    source: "brush contact drop, saturation voltage of bipolar bridges (L298)",
    signature: "residual voltage steps with the sign of the current, not of the speed",
    parameters: &[strength("drop", "V", "voltage lost", Scale::Volt, [0.0, 0.3, 5.0])],
    probes: &[&[0.1], &[0.4], &[1.0], &[2.0]],
    laws: RESISTIVE,
    remembers: false,
    contains: &[],
};

/// A drop of fixed size against the current.
#[derive(Debug, Clone, Copy)]
pub struct VoltageDrop<S> {
    drop: S,
}

impl<S: Scalar> VoltageDrop<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { drop: parameters[0] }
    }
}

impl<S: Scalar> Effect<S> for VoltageDrop<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.drop += self.drop;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn steady_speed_loses_gain_times_drop() {
        close(steady_speed(Kind::VoltageDrop, &[0.8], 6.0), BASE.gain * 5.2, 1e-9);
    }

    #[test]
    fn below_the_drop_no_current_brakes_the_shaft() {
        let start = State::moving(0.0, 0.5, 0.0); // back-EMF 0.56 V
        let (_, motion) = run_from(start, Kind::VoltageDrop, &[0.8], &[0.0; 50]);
        close(motion.state.current, 0.0, 1e-12);
        close(motion.state.speed, 0.5 * libm::exp(-0.05 * BASE.viscous_share / BASE.tau_m), 3e-4);
    }
}
