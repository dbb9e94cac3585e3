//! Brushes and transistors that take a fixed voltage from any current.

use super::spec::{BRUSH, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "voltage_drop",
    port: Port::Voltage,
    title: "brushes or transistors take a fixed voltage from any current",
    equation: "v_winding = v - drop u / sqrt(u^2 + knee^2)",
    source: "brush contact drop, saturation voltage of bipolar bridges (L298)",
    signature: "residual voltage steps with the sign of the current, not of the speed",
    parameters: &[
        // An L298N loses 4.9 V at its highest current (its data sheet), other bridges less.
        strength("drop", "V", "voltage lost to a large current", Scale::Volt, [0.0, 0.3, 5.0]),
        shape("knee", "V", "current well above which all is lost, as a voltage", Scale::Volt, [0.01, 0.2, 3.0]),
    ],
    probes: &[&[0.1, 0.2], &[0.4, 0.2], &[1.0, 0.2], &[2.0, 0.2]],
    search: Search::Probes,
    laws: BRUSH,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// A drop against the current, of fixed size where the current is well above `knee`.
#[derive(Debug, Clone, Copy)]
pub struct VoltageDrop<S> {
    drop: S,
    knee: S,
}

impl<S: Scalar> VoltageDrop<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { drop: parameters[0], knee: parameters[1] }
    }
}

impl<S: Scalar> Effect<S> for VoltageDrop<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.brush = self.drop;
        drive.brush_knee = self.knee;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Rig, testing::*};
    use crate::simulator::Simulator;
    use crate::step::State;

    #[test]
    fn steady_speed_loses_gain_times_drop() {
        close(steady_speed(Kind::VoltageDrop, &[0.8, 0.01], 6.0), BASE.gain * 5.2, 1e-3);
    }

    /// With u the current at the end, v = k_e w + u + drop / sqrt(2) where u is the knee.
    #[test]
    fn seven_tenths_are_lost_at_the_knee() {
        for (drop, knee) in [(0.6, 0.3), (2.0, 0.1)] {
            let viscous = BASE.viscous_share / BASE.gain;
            let speed = knee / viscous;
            let emf = (1.0 - BASE.viscous_share) / BASE.gain * speed;
            let volts = emf + knee + drop * core::f64::consts::FRAC_1_SQRT_2;
            close(steady_speed(Kind::VoltageDrop, &[drop, knee], volts), speed, 1e-3);
        }
    }

    /// A PRBS drives the current from one side to the other within a step or two: at the end of it steps of 1 ms are where
    /// short ones are; a drop on the last current alone is off by 1/37 of what it does.
    #[test]
    fn a_current_that_changes_sides_loses_what_it_should_however_long_the_step() {
        let end = |drop: f64, per_step: usize| {
            let rig = Rig { step_s: per_step as f64 * 6.25e-5, ..RIG };
            let simulator = Simulator::new(&BASE, [(Kind::VoltageDrop, &[drop, 0.3][..])], &rig);
            let volts = |k: usize| if (k * per_step / 64 * 7 + 3) % 11 < 6 { 9.0 } else { -3.0 };
            let voltages: std::vec::Vec<f64> = (0..64 * 200 / per_step).map(volts).collect();
            let mut motion = simulator.start(State::rest());
            for k in 0..voltages.len() {
                simulator.advance(&mut motion, &voltages, k);
            }
            motion.state.angle
        };
        let truth = end(0.8, 1);
        let done = (truth - end(0.0, 1)).abs();
        let off = (end(0.8, 16) - truth).abs();
        assert!(off < done / 150.0, "off by 1/{:.0}", done / off);
    }

    /// Where the knee is wide the drop is a resistance, and a light shaft gains speed within a step.
    #[test]
    fn a_light_shaft_under_slow_voltages_is_where_short_steps_take_it() {
        use crate::base::Base;
        let base = Base { gain: 4.0, tau_m: 0.014, tau_e: 3.4e-4, viscous_share: 0.13 };
        let angles = |drop: f64, parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let simulator = Simulator::new(&base, [(Kind::VoltageDrop, &[drop, 0.36][..])], &rig);
            let volts: std::vec::Vec<f64> = (0..1000 * parts)
                .map(|k| (k / (5 * parts)) as f64 * 5e-3)
                .map(|t| 3.0 * (libm::sin(10.0 * t) + libm::sin(24.0 * t) + libm::sin(57.0 * t)))
                .collect();
            let mut motion = simulator.start(State::rest());
            let angle = |k: usize| {
                simulator.advance(&mut motion, &volts, k);
                motion.state.angle
            };
            (0..volts.len()).map(angle).skip(parts - 1).step_by(parts).collect::<std::vec::Vec<f64>>()
        };
        let apart = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| (a - b) * (a - b)).sum::<f64>().sqrt();
        let truth = angles(0.72, 32);
        let (done, off) = (apart(&angles(0.0, 32), &truth), apart(&angles(0.72, 1), &truth));
        assert!(off < done / 300.0, "off by 1/{:.0}", done / off);
    }

    #[test]
    fn below_the_drop_no_current_brakes_the_shaft() {
        let start = State::moving(0.0, 0.5, 0.0); // back-EMF 0.56 V
        let (_, motion) = run_from(start, Kind::VoltageDrop, &[0.8, 0.01], &[0.0; 50]);
        close(motion.state.current, 0.0, 0.02);
        close(motion.state.speed, 0.5 * libm::exp(-0.05 * BASE.viscous_share / BASE.tau_m), 0.01);
    }
}
