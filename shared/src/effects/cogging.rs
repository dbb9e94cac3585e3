//! Torque ripple of the slots, a fixed number of times per motor revolution.

use super::spec::{Port, Scale, Spec, TORQUE, shown, strength, Search};
use super::wave::Wave;
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "cogging",
    port: Port::Torque,
    title: "torque ripple locked to the motor's angle (slots, commutator)",
    equation: "f = -(sine sin(a) + cosine cos(a) + sine2 sin(2 a) + cosine2 cos(2 a)),  a = order n x",
    source: "slot ripple of permanent-magnet motors; n is the gear ratio",
    signature: "residual torque against the motor's angle repeats a whole number of times a revolution; slow motion is jerky",
    parameters: &[
        // A quarter of the stall torque at most, several times what poor motors have: what asks for more is something else.
        strength("sine", "V", "sine part of the ripple torque", Scale::Volt, [-3.0, 0.15, 3.0]),
        strength("cosine", "V", "cosine part of the ripple torque", Scale::Volt, [-3.0, 0.15, 3.0]),
        strength("sine2", "V", "sine part of its second harmonic", Scale::Volt, [-3.0, 0.15, 3.0]),
        strength("cosine2", "V", "cosine part of its second harmonic", Scale::Volt, [-3.0, 0.15, 3.0]),
        shown("order", "1", "periods per motor revolution", Scale::One, [1.0, 1.0, 64.0]),
    ],
    // The order and the phase come from the data; these stand in where there is no angle to take them from.
    probes: &[&[0.2, 0.0, 0.0, 0.0, 3.0], &[0.0, 0.2, 0.0, 0.0, 3.0], &[0.2, 0.0, 0.0, 0.0, 6.0], &[0.0, 0.2, 0.0, 0.0, 6.0]],
    search: Search::Orders,
    laws: TORQUE,
    remembers: true,
    periodic: true,
    by_duty: false,
    contains: &[],
};

/// Torque of `order` periods per motor revolution: cogging torque is no pure sine, so the second harmonic belongs to it. Memory holds
/// what the last step added to the speed.
#[derive(Debug, Clone, Copy)]
pub struct Cogging<S> {
    ripple: Wave<S>,
    harmonic: Wave<S>,
    turns: S,
    half_step: S,
}

impl<S: Scalar> Cogging<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self {
            ripple: Wave::new(parameters[0], parameters[1]),
            harmonic: Wave::new(parameters[2], parameters[3]),
            turns: parameters[4] * setting.motor_turns,
            half_step: setting.step * S::lit(0.5),
        }
    }
}

impl<S: Scalar> Effect<S> for Cogging<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        // The mean over the step: a good part of a period may pass in one, and more or less than at its first speed.
        let speed = memory.store.mul_add(S::lit(1.0 / 3.0), now.state.speed);
        let half = speed * self.half_step * self.turns;
        let turn = now.state.angle.mul_add(self.turns, half);
        drive.torque -= self.ripple.mean(turn, half) + self.harmonic.mean(turn + turn, half + half);
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        memory.store = after.speed - now.state.speed;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Rig, testing::*};
    use crate::simulator::Simulator;
    use crate::step::State;

    /// A quarter of a ripple period away from balance the slots hold the shaft against a small voltage.
    #[test]
    fn holds_the_shaft_where_the_ripple_balances_the_voltage() {
        let (_, motion) = run(Kind::Cogging, &[1.0, 0.0, 0.0, 0.0, 4.0], &[0.5; 4000]);
        close(motion.state.angle, libm::asin(0.5) / (4.0 * RIG.gear_ratio), 1e-6);
    }

    /// The harmonic alone has two balances where the whole torque has one.
    #[test]
    fn the_second_harmonic_goes_twice_as_often() {
        let (_, motion) = run(Kind::Cogging, &[0.0, 0.0, 1.0, 0.0, 4.0], &[0.5; 4000]);
        close(motion.state.angle, libm::asin(0.5) / (8.0 * RIG.gear_ratio), 1e-6);
    }

    #[test]
    fn at_speed_the_ripple_averages_out() {
        close(steady_speed(Kind::Cogging, &[0.3, 0.0, 0.1, 0.0, 4.0], 10.0), BASE.gain * 10.0, 0.05);
    }

    /// A shaft that gathers speed passes more of a tooth in a step than its first speed tells.
    #[test]
    fn a_shaft_that_gathers_speed_passes_the_teeth_as_in_short_steps() {
        let angles = |teeth: f64, per_step: usize| {
            let rig = Rig { step_s: per_step as f64 * 6.25e-5, ..RIG };
            let parameters = [teeth, 0.0, 0.0, 0.0, 6.0];
            let simulator = Simulator::new(&BASE, [(Kind::Cogging, &parameters[..])], &rig);
            let volts = |k: usize| if (k * per_step / 16 / 40 * 7 + 3) % 11 < 6 { 5.0 } else { -4.0 };
            let voltages: std::vec::Vec<f64> = (0..=16 * 2000 / per_step).map(|k| volts(k.max(1) - 1)).collect();
            let mut motion = simulator.start(State::rest());
            let step = |k: usize| {
                simulator.advance(&mut motion, &voltages, k);
                motion.state.angle
            };
            (1..voltages.len()).map(step).skip(16 / per_step - 1).step_by(16 / per_step).collect::<std::vec::Vec<f64>>()
        };
        let rms = |a: &[f64], b: &[f64]| {
            let off: std::vec::Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
            let n = off.len() as f64;
            let mean = off.iter().sum::<f64>() / n;
            (off.iter().map(|d| (d - mean) * (d - mean)).sum::<f64>() / n).sqrt()
        };
        let truth = angles(0.3, 1);
        let done = rms(&truth, &angles(0.0, 1));
        let off = rms(&angles(0.3, 16), &truth);
        assert!(off < done / 4000.0, "off by 1/{:.0}", done / off);
    }
}
