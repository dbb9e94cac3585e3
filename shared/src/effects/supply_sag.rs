//! A weak supply: its voltage falls as the motor draws from it.

use super::spec::{SERIES, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "supply_sag",
    port: Port::Voltage,
    title: "a weak supply: the voltage falls with the current drawn",
    equation: "v = v_told (1 - q / supply),  buffer dq/dt = resistance (v_told / supply) u - q; \
               v_told: v_log, late and less a dead zone",
    source: "a bridge at duty d draws d i from a source of resistance R_s behind a capacitor, and passes on d of what is left",
    signature: "too little torque at full duty and high current, none missing at low duty",
    parameters: &[
        // A source that weak gives less than half of its voltage at stall.
        strength("resistance", "1", "source resistance per winding resistance", Scale::One, [0.0, 0.2, 1.5]),
        shape("buffer", "s", "time constant of source and capacitor", Scale::Millisecond, [0.0, 2.0, 50.0]),
    ],
    probes: &[&[0.1, 1.5], &[0.35, 1.5], &[0.8, 1.5]],
    search: Search::Probes,
    laws: SERIES,
    remembers: true,
    periodic: false,
    by_duty: true,
    contains: &[],
};

/// Source resistance as a share of the winding's; memory holds the volts that the supply lacks.
#[derive(Debug, Clone, Copy)]
pub struct SupplySag<S> {
    resistance: S,
    per_supply: S,
    /// What a step's first sag has in its mean ...
    first: S,
    /// ... and in its last one.
    kept: S,
    /// What the first and the last current have in the last sag, where the current changes evenly.
    added: [S; 2],
}

impl<S: Scalar> SupplySag<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let steps = setting.step / parameters[1].max(setting.step * S::lit(1e-3));
        let kept = (-steps).map(libm::exp);
        let first = (S::one() - kept) / steps;
        Self {
            resistance: parameters[0],
            per_supply: setting.per_supply,
            first,
            kept,
            added: [first - kept, S::one() - first],
        }
    }
}

impl<S: Scalar> Effect<S> for SupplySag<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        let duty = drive.asked * self.per_supply;
        // What the step's own current adds to the mean sag is solved with it: no buffer is too small.
        drive.series += (S::one() - self.first) * self.resistance * duty * duty;
        drive.voltage -= duty * self.first * memory.store;
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        let drawn = self.added[0].mul_add(now.state.current, self.added[1] * after.current);
        let sag = self.resistance * now.command * self.per_supply * drawn;
        memory.store = self.kept.mul_add(memory.store, sag);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::simulator::Simulator;
    use crate::step::State;

    /// Steady: u = b w / c, so w (1 / gain + s b / c) = v with s the resistance at this duty.
    #[test]
    fn steady_speed_solves_the_balance() {
        let v = 6.0;
        let s = 0.8 * (v / RIG.supply_v) * (v / RIG.supply_v);
        let truth = v * BASE.gain / (1.0 + s * BASE.viscous_share);
        close(steady_speed(Kind::SupplySag, &[0.8, 0.0], v), truth, 1e-9);
        close(steady_speed(Kind::SupplySag, &[0.8, 0.01], v), truth, 1e-9);
    }

    /// A bridge that swallows 1 V draws the current of what is left, with a buffer or without.
    #[test]
    fn the_duty_is_that_of_what_the_bridge_is_told() {
        for buffer in [0.0, 0.01] {
            let (swallowed, sag) = ([1.0, 0.0], [0.8, buffer]);
            let both = [(Kind::DeadZone, &swallowed[..]), (Kind::SupplySag, &sag[..])];
            let simulator = Simulator::new(&BASE, both, &RIG);
            let mut motion = simulator.start(State::rest());
            for k in 0..8000 {
                simulator.advance(&mut motion, &[7.0; 8000], k);
            }
            close(motion.state.speed, steady_speed(Kind::SupplySag, &sag, 6.0), 1e-9);
        }
    }

    /// Stalled by friction at full duty, with s the source resistance and T its time constant: u = v - q and
    /// T q' = s u - q give q = v s / (1 + s) (1 - e^(-(1 + s) t / T)).
    #[test]
    fn the_supply_sags_with_its_capacitor() {
        let (s, buffer, v) = (0.8, 0.02, RIG.supply_v);
        let (sag, stall) = ([s, buffer], [50.0]);
        let simulator = Simulator::new(&BASE, [(Kind::SupplySag, &sag[..]), (Kind::Coulomb, &stall[..])], &RIG);
        let mut motion = simulator.start(State::rest());
        for k in 1..60 {
            simulator.advance(&mut motion, &[v; 60], k);
            // The winding follows within its own time constant, and a step's current is that of its middle.
            let t = (f64::from(k as u32) - 0.5) * 1e-3 - BASE.tau_e;
            let truth = v - v * s / (1.0 + s) * (1.0 - libm::exp(-(1.0 + s) * t / buffer));
            if k > 8 {
                close(simulator.current(&motion), truth, 0.1);
            }
        }
    }
}
