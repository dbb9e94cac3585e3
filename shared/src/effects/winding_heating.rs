//! The winding warms up and its resistance rises.

use super::spec::{SERIES, Port, Scale, Spec, shape, strength};
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
        strength("rate", "1/s", "rise of resistance per second at stall", Scale::One, [0.0, 0.05, 2.0]),
        shape("cooling", "s", "thermal time constant", Scale::One, [2.0, 30.0, 300.0]),
    ],
    probes: &[&[0.02, 30.0], &[0.1, 30.0], &[0.3, 30.0], &[0.3, 8.0]],
    laws: SERIES,
    remembers: true,
    contains: &[],
};

/// Heating by the square of the current; memory holds the relative rise of resistance.
#[derive(Debug, Clone, Copy)]
pub struct WindingHeating<S> {
    gain: S,
    loss: S,
}

impl<S: Scalar> WindingHeating<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self {
            gain: parameters[0] * setting.step * setting.per_nominal * setting.per_nominal,
            loss: setting.step / parameters[1],
        }
    }
}

impl<S: Scalar> Effect<S> for WindingHeating<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.series += memory.store;
    }
    #[inline(always)]
    fn settle(&self, _now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        let heat = self.gain * after.current * after.current;
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
