//! Supply and bridge: delay, dead zone, a PWM that floats or freewheels in its off part, sag.

use super::find;
use crate::effect::Effect;
use crate::motor::Motor;
use crate::table::Kind;
use crate::virtual_motor::Bridge;
use rand::{Rng, RngExt};
use std::collections::VecDeque;

/// Immutable parameters of supply and bridge.
#[derive(Debug, Clone, PartialEq)]
pub struct Driver {
    nominal_v: f64,
    delay_s: f64,
    dead_zone_v: f64,
    off: Option<Off>,
    source_resistance: f64,
}

/// What a PWM does in its off part, where it does not brake.
#[derive(Debug, Clone, PartialEq)]
struct Off {
    /// Share of it that is not braked.
    share: f64,
    /// A diode across the winding lets the current go on.
    freewheels: bool,
    period_s: f64,
}

/// What the bridge does, what it was told to do later, and the voltage behind it.
#[derive(Debug, Clone, PartialEq)]
pub struct DriverState {
    waiting: VecDeque<(f64, Bridge)>,
    last: Bridge,
    active: Bridge,
    /// Where in its period the PWM stood at time zero, 0 to 1: nothing ties it to the log's clock.
    phase: f64,
    /// Voltage behind the bridge, V.
    pub bus_v: f64,
}

/// Time constant of the capacitor behind the bridge, s.
const BUS_S: f64 = 0.002;

impl Driver {
    pub fn new(motor: &Motor, effects: &[Effect]) -> Self {
        let first = |kind| find(effects, kind).unwrap_or_default()[0];
        let off = |kind, freewheels, of: fn([f64; 4]) -> (f64, f64)| {
            find(effects, kind).map(of).map(|(share, pwm_hz)| Off {
                share,
                freewheels,
                period_s: 1.0 / pwm_hz,
            })
        };
        let coasts = off(Kind::Coast, false, |[share, pwm_hz, ..]| (share, pwm_hz));
        Self {
            nominal_v: motor.nominal_v,
            delay_s: 1e-3 * first(Kind::Delay),
            dead_zone_v: first(Kind::DeadZone),
            off: coasts.or_else(|| off(Kind::Freewheel, true, |[pwm_hz, ..]| (1.0, pwm_hz))),
            source_resistance: first(Kind::SupplySag) * motor.resistance_ohm,
        }
    }

    /// A driver at rest with a full supply, its PWM anywhere in a period.
    pub fn rest(&self, rng: &mut impl Rng) -> DriverState {
        DriverState {
            waiting: VecDeque::new(),
            last: Bridge::Volts(0.0),
            active: Bridge::Volts(0.0),
            phase: if self.off.is_some() { rng.random() } else { 0.0 },
            bus_v: self.nominal_v,
        }
    }

    /// Tells the bridge what to do from `now` (s) on; it does so after its delay.
    pub fn command(&self, state: &mut DriverState, now: f64, bridge: Bridge) {
        if bridge != state.last {
            state.last = bridge;
            state.waiting.push_back((now + self.delay_s, bridge));
        }
    }

    /// What the bridge does at `now`, and until when, at most until `end`.
    pub fn output(&self, state: &mut DriverState, now: f64, end: f64) -> (Bridge, f64) {
        while let Some(&(from, bridge)) = state.waiting.front()
            && from <= now + 1e-12
        {
            state.active = bridge;
            state.waiting.pop_front();
        }
        let mut until = state.waiting.front().map_or(end, |next| next.0.min(end));
        let Bridge::Volts(asked) = state.active else { return (Bridge::Floating, until) };
        let magnitude = (asked.abs().min(self.nominal_v) - self.dead_zone_v).max(0.0);
        let Some(off) = &self.off else {
            return (Bridge::Volts(magnitude.copysign(asked)), until);
        };
        // One period: driven fully for its duty, then floating for its share of the rest, then braked.
        let duty = magnitude / self.nominal_v;
        let floated = duty + (1.0 - duty) * off.share;
        let periods = now / off.period_s + state.phase + 1e-9;
        let (start, part) = ((periods.floor() - state.phase) * off.period_s, periods.fract());
        let (bridge, edge) = if part < duty {
            (Bridge::Volts(self.nominal_v.copysign(asked)), duty)
        } else if part < floated {
            // At zero duty no side is switched on.
            let freewheels = off.freewheels && duty > 0.0;
            (if freewheels { Bridge::Freewheeling(1f64.copysign(asked)) } else { Bridge::Floating }, floated)
        } else {
            (Bridge::Volts(0.0), 1.0)
        };
        until = until.min(start + edge * off.period_s);
        (bridge, until)
    }

    /// Lets the supply sag or recover for `dt` seconds while the bridge draws `current` (A) from it.
    #[inline]
    pub fn draw(&self, state: &mut DriverState, current: f64, dt: f64) {
        if self.source_resistance > 0.0 {
            let steady = self.nominal_v - self.source_resistance * current;
            state.bus_v += (steady - state.bus_v) * dt / BUS_S;
            state.bus_v = state.bus_v.max(0.05 * self.nominal_v);
        }
    }

    /// Voltage of the unloaded supply, V.
    pub fn nominal_v(&self) -> f64 {
        self.nominal_v
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    fn driver(text: &str) -> (Driver, DriverState) {
        let driver = Driver::new(&Motor::paper(), &[Effect::parse(text).unwrap()]);
        let state = driver.rest(&mut ChaCha8Rng::seed_from_u64(3));
        (driver, state)
    }

    #[test]
    fn a_command_arrives_after_the_delay_and_not_before() {
        let (driver, mut state) = driver("delay=5");
        driver.command(&mut state, 0.0, Bridge::Volts(3.0));
        assert_eq!(driver.output(&mut state, 0.0, 1.0), (Bridge::Volts(0.0), 0.005));
        assert_eq!(driver.output(&mut state, 0.005, 1.0), (Bridge::Volts(3.0), 1.0));
    }

    #[test]
    fn the_dead_zone_is_taken_from_both_signs_and_the_supply_is_the_limit() {
        let (driver, mut state) = driver("dead_zone=0.5");
        for (asked, out) in [(2.0, 1.5), (-2.0, -1.5), (0.3, 0.0), (99.0, 11.5)] {
            driver.command(&mut state, 0.0, Bridge::Volts(asked));
            assert_eq!(driver.output(&mut state, 0.0, 1.0).0, Bridge::Volts(out));
        }
    }

    #[test]
    fn a_coasting_bridge_drives_brakes_and_floats_in_the_stated_parts() {
        let (driver, mut state) = driver("coast=0.5,pwm_hz=100");
        driver.command(&mut state, 0.0, Bridge::Volts(-6.0));
        let mut spent = [0.0; 3];
        let mut now = 0.0;
        while now < 0.0999 {
            let (bridge, until) = driver.output(&mut state, now, 0.1);
            let part = match bridge {
                Bridge::Volts(v) if v < 0.0 => 0,
                Bridge::Volts(_) => 1,
                Bridge::Floating | Bridge::Freewheeling(_) => 2,
            };
            spent[part] += until - now;
            now = until;
        }
        for (part, expected) in spent.into_iter().zip([0.05, 0.025, 0.025]) {
            assert!((part - expected).abs() < 1e-6, "{part}");
        }
    }

    #[test]
    fn a_pwm_stands_anywhere_in_its_period_when_a_log_begins() {
        let driver = Driver::new(&Motor::paper(), &[Effect::parse("coast=0.5,pwm_hz=100").unwrap()]);
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let phases: Vec<f64> = (0..200).map(|_| driver.rest(&mut rng).phase).collect();
        let mean = phases.iter().sum::<f64>() / 200.0;
        assert!((mean - 0.5).abs() < 0.1 && phases.iter().all(|phase| (0.0..1.0).contains(phase)), "{mean}");
    }

    #[test]
    fn the_bus_sags_by_source_resistance_times_current() {
        let (driver, mut state) = driver("supply_sag=0.5");
        for _ in 0..10_000 {
            driver.draw(&mut state, 1.0, 25e-6);
        }
        assert!((state.bus_v - (12.0 - 0.5 * Motor::paper().resistance_ohm)).abs() < 1e-6);
    }
}
