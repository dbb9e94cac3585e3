//! The winding warms up and its resistance rises.

use super::decay::decay;
use super::spec::{SERIES, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "winding_heating",
    port: Port::Voltage,
    title: "the winding warms up: resistance rises while the motor works",
    equation: "dq/dt = rate (u / nominal)^2 (1 + q) - q / cooling;  resistance (1 + q)",
    source: "one thermal capacity heated by R i^2, R as it has become; copper gains 0.39 % a kelvin",
    signature: "the model fits the beginning of a record and drifts off towards its end",
    parameters: &[
        // Half more in a second would burn the winding within a few.
        strength("rate", "1/s", "rise of resistance per second at stall", Scale::One, [0.0, 0.05, 0.5]),
        shape("cooling", "s", "thermal time constant", Scale::One, [2.0, 30.0, 300.0]),
    ],
    probes: &[&[0.02, 30.0], &[0.1, 30.0], &[0.3, 30.0], &[0.3, 8.0]],
    search: Search::Probes,
    laws: SERIES,
    remembers: true,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Heating by the mean square of the current; memory holds the relative rise of resistance.
///
/// In a step the current goes to its last value u2 by what a jump of the voltage leaves, which dies away as the winding's
/// exponential s(t), and by what the back-EMF changes, evenly: u2 + jump s(t) + ramp (1 - t / step).
#[derive(Debug, Clone, Copy)]
pub struct WindingHeating<S> {
    gain: S,
    loss: S,
    back_emf: S,
    /// Means over a step: of s, of its square, and of s (1 - t / step).
    jump: S,
    jump_square: S,
    jump_ramp: S,
}

impl<S: Scalar> WindingHeating<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let (one, half) = (S::one(), S::lit(0.5));
        let z = setting.step / setting.tau_e;
        let kept = decay(z);
        let gone = one - kept;
        let mean = gone / z;
        let square = (half * (one + kept) * mean - kept * (mean + mean - kept)) / (gone * gone);
        // Short steps, in which s is even too, round off: there lie the bounds.
        let at_most = |x: S, bound: f64| x.clamp(S::zero(), S::lit(bound));
        Self {
            gain: parameters[0] * setting.step * setting.per_nominal * setting.per_nominal,
            loss: setting.step / parameters[1],
            back_emf: setting.back_emf,
            jump: at_most((mean - kept) / gone, 1.0 / 2.0),
            jump_square: at_most(square, 1.0 / 3.0),
            jump_ramp: at_most(((one - mean) / z - half * kept) / gone, 1.0 / 3.0),
        }
    }

    /// Mean square of the current of a step.
    #[inline(always)]
    fn mean_square(&self, before: &State<S>, after: &State<S>) -> S {
        let last = after.current;
        let ramp = self.back_emf * (after.speed - before.speed);
        let jump = before.current - last - ramp;
        let cross = (last + last).mul_add(self.jump, (self.jump_ramp + self.jump_ramp) * ramp);
        self.jump_square.mul_add(jump, cross).mul_add(jump, last * (last + ramp))
    }
}

impl<S: Scalar> Effect<S> for WindingHeating<S> {
    /// Half of a step's heat is in its mean resistance: about that of its first current.
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        let first = now.state.current;
        drive.series += (S::lit(0.5) * self.gain * first).mul_add(first, memory.store);
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        let heat = self.gain * self.mean_square(&now.state, after);
        memory.store = (heat - self.loss).mul_add(memory.store, heat + memory.store);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::effects::Rig;
    use crate::simulator::Simulator;
    use crate::step::State;

    /// A gap makes the simulator take parts of a cell; heat knows nothing of that.
    #[test]
    fn a_gap_in_the_gear_does_not_make_the_winding_heat_faster() {
        let (heat, gap) = ([0.1, 30.0], [1e-6, 0.3, 0.0, 400.0, 0.5]);
        let rise = |effects: &[(Kind, &[f64])]| {
            let s = Simulator::new(&BASE, effects.iter().copied(), &RIG);
            let mut motion = s.start(State::rest());
            let volts: [f64; 3000] = core::array::from_fn(|k| if k / 20 % 2 == 0 { 12.0 } else { -12.0 });
            for k in 0..volts.len() {
                s.advance(&mut motion, &volts, k);
            }
            s.current(&motion)
        };
        let alone = rise(&[(Kind::WindingHeating, &heat)]);
        let cold = rise(&[]);
        let with_gap = rise(&[(Kind::WindingHeating, &heat), (Kind::Backlash, &gap)]);
        let cold_gap = rise(&[(Kind::Backlash, &gap)]);
        close(with_gap / cold_gap, alone / cold, 0.01);
        assert!(alone.abs() < 0.95 * cold.abs());
    }

    /// A PRBS drives a current to and fro within its electrical time constant or two: what the heat does to the shaft in steps
    /// of 1 ms is what it does in short ones.
    #[test]
    fn a_reversing_current_heats_as_in_short_steps() {
        let end = |rate: f64, parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let base = crate::base::Base { tau_e: 4.6e-4, ..BASE };
            let simulator = Simulator::new(&base, [(Kind::WindingHeating, &[rate, 20.0][..])], &rig);
            let volts: std::vec::Vec<f64> =
                (0..2000 * parts).map(|k| if k / (10 * parts) * 7 % 11 < 7 { 9.0 } else { -9.0 }).collect();
            let mut motion = simulator.start(State::rest());
            (0..volts.len()).for_each(|k| simulator.advance(&mut motion, &volts, k));
            motion.state.angle
        };
        let truth = end(0.2, 32);
        let done = (truth - end(0.0, 32)).abs();
        let off = (end(0.2, 1) - truth).abs();
        assert!(off < done / 100.0, "off by 1/{:.0}", done / off);
    }

    /// Stalled by friction, the current falls as 1 / (1 + q) with dq/dt = rate (v / nominal)^2 / (1 + q).
    #[test]
    fn stall_current_falls_as_the_winding_warms() {
        let rig = Rig { ..RIG };
        let heat = [0.1, 1e9];
        let stall = [50.0];
        let s = Simulator::new(&BASE, [(Kind::WindingHeating, &heat[..]), (Kind::Coulomb, &stall[..])], &rig);
        let mut motion = s.start(State::rest());
        let volts = [12.0; 5000];
        for k in 0..volts.len() {
            s.advance(&mut motion, &volts, k);
        }
        // (1 + q)^2 = 1 + 2 rate t
        let truth = 12.0 / libm::sqrt(1.0 + 2.0 * 0.1 * 5.0);
        close(s.current(&motion), truth, 0.03);
    }
}
