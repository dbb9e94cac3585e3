//! Brushes and transistors that take a fixed voltage from any current.

use super::spec::{BRUSH, Port, Scale, Spec, shape, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "voltage_drop",
    port: Port::Voltage,
    title: "brushes or transistors take a fixed voltage from any current",
    equation: "v_winding = v - drop u (|u| + rise knee) / (u^2 + rise knee |u| + knee^2)",
    source: "brush contact drop, saturation voltage of bipolar bridges (L298)",
    signature: "residual voltage steps with the sign of the current, not of the speed",
    parameters: &[
        strength("drop", "V", "voltage lost to a large current", Scale::Volt, [0.0, 0.3, 5.0]),
        shape("knee", "V", "current well above which all is lost, as a voltage", Scale::Volt, [0.01, 0.2, 3.0]),
        shape("rise", "1", "slope at no current, in drops per knee", Scale::One, [0.2, 0.8, 3.0]),
    ],
    probes: &[&[0.1, 0.2, 0.8], &[0.4, 0.2, 0.8], &[1.0, 0.2, 0.8], &[2.0, 0.2, 0.8]],
    laws: BRUSH,
    remembers: false,
    contains: &[],
};

/// A drop against the current, of fixed size where the current is well above `knee`.
#[derive(Debug, Clone, Copy)]
pub struct VoltageDrop<S> {
    drop: S,
    knee: S,
    rise: S,
}

impl<S: Scalar> VoltageDrop<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { drop: parameters[0], knee: parameters[1], rise: parameters[1] * parameters[2] }
    }
}

impl<S: Scalar> Effect<S> for VoltageDrop<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.brush = self.drop;
        drive.brush_knee = self.knee;
        drive.brush_rise = self.rise;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn steady_speed_loses_gain_times_drop() {
        close(steady_speed(Kind::VoltageDrop, &[0.8, 0.01, 1.0], 6.0), BASE.gain * 5.2, 1e-3);
    }

    /// With u the current at the end, v = k_e w + u + drop (1 + rise) / (2 + rise) where u is the knee.
    #[test]
    fn two_thirds_are_lost_at_the_knee_of_an_even_rise_and_more_of_a_steep_one() {
        for (drop, knee, rise) in [(0.6, 0.3, 1.0), (0.3, 0.3, 2.0)] {
            let viscous = BASE.viscous_share / BASE.gain;
            let speed = knee / viscous;
            let volts = (1.0 - BASE.viscous_share) / BASE.gain * speed + knee + drop * (1.0 + rise) / (2.0 + rise);
            close(steady_speed(Kind::VoltageDrop, &[drop, knee, rise], volts), speed, 0.01);
        }
    }

    #[test]
    fn below_the_drop_no_current_brakes_the_shaft() {
        let start = State::moving(0.0, 0.5, 0.0); // back-EMF 0.56 V
        let (_, motion) = run_from(start, Kind::VoltageDrop, &[0.8, 0.01, 1.0], &[0.0; 50]);
        close(motion.state.current, 0.0, 0.02);
        close(motion.state.speed, 0.5 * libm::exp(-0.05 * BASE.viscous_share / BASE.tau_m), 0.01);
    }
}
