//! The winding: saturation, brush drop, heat.

use super::find;
use crate::effect::Effect;
use crate::motor::Motor;
use crate::table::Kind;

/// Immutable parameters of the winding's effects.
#[derive(Debug, Clone, PartialEq)]
pub struct Electric {
    per_saturation_current: f64,
    drop_v: f64,
    drop_current: f64,
    heating_rate: f64,
    per_stall_current: f64,
    per_housing_time: f64,
}

/// Relative rise of the resistance (copper: 0.39 % per kelvin) by the winding's and the housing's temperature.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Heat {
    /// Of the winding.
    pub winding: f64,
    /// Of the housing.
    pub housing: f64,
}

/// The housing holds this many times the winding's heat and loses it to the air over this many times its time.
const HOUSING: f64 = 8.0;

impl Electric {
    pub fn new(motor: &Motor, effects: &[Effect]) -> Self {
        let [loss, ..] = find(effects, Kind::Saturation).unwrap_or_default();
        let [drop_v, ..] = find(effects, Kind::VoltageDrop).unwrap_or_default();
        let [heating_rate, time, ..] = find(effects, Kind::WindingHeating).unwrap_or([0.0, 1.0, 0.0, 0.0]);
        let stall = motor.stall_current();
        Self {
            per_saturation_current: saturation_at(1.0 - loss) / stall,
            drop_v,
            drop_current: 0.03 * stall,
            heating_rate,
            per_stall_current: 1.0 / stall,
            per_housing_time: 1.0 / time,
        }
    }

    /// Share of the field that is left at this current: `tanh(x) / x`.
    #[inline]
    pub fn field(&self, current: f64) -> f64 {
        let x = current * self.per_saturation_current;
        if x.abs() < 1e-3 { 1.0 - x * x / 3.0 } else { x.tanh() / x }
    }

    /// Voltage lost at the brushes, V.
    #[inline]
    pub fn drop(&self, current: f64) -> f64 {
        if self.drop_v == 0.0 {
            return 0.0;
        }
        self.drop_v * self.direction(current)
    }

    /// The current's direction, -1 to 1, rounded at zero.
    #[inline]
    pub fn direction(&self, current: f64) -> f64 {
        current / current.hypot(self.drop_current)
    }

    /// The heat after `dt` seconds at this current: a winding that heats by its loss and a housing that cools it.
    #[inline]
    pub fn heat(&self, heat: &mut Heat, current: f64, dt: f64) {
        if self.heating_rate == 0.0 {
            return;
        }
        let stalls = current * self.per_stall_current;
        let passed = (heat.winding - heat.housing) * self.per_housing_time;
        heat.winding += dt * (self.heating_rate * stalls * stalls * (1.0 + heat.winding) - passed);
        heat.housing += dt * (passed - heat.housing * self.per_housing_time / HOUSING) / HOUSING;
    }
}

/// The `x` at which `tanh(x) / x` is `left`, by bisection (it falls monotonically from 1).
fn saturation_at(left: f64) -> f64 {
    let (mut low, mut high) = (0.0, 100.0);
    if left >= 1.0 {
        return 0.0;
    }
    for _ in 0..60 {
        let x: f64 = 0.5 * (low + high);
        if x.tanh() / x > left {
            low = x;
        } else {
            high = x;
        }
    }
    low
}

#[cfg(test)]
mod tests {
    use super::*;

    fn electric(text: &str) -> Electric {
        Electric::new(&Motor::paper(), &[Effect::parse(text).unwrap()])
    }

    #[test]
    fn saturation_loses_the_stated_share_at_stall_and_nothing_at_rest() {
        let stall = Motor::paper().stall_current();
        let part = electric("saturation=0.3");
        assert!((part.field(stall) - 0.7).abs() < 1e-9);
        assert!((part.field(-stall) - 0.7).abs() < 1e-9);
        assert_eq!(part.field(0.0), 1.0);
        assert_eq!(electric("coulomb").field(stall), 1.0);
    }

    #[test]
    fn the_drop_is_odd_and_reaches_its_size() {
        let part = electric("voltage_drop=0.6");
        let stall = Motor::paper().stall_current();
        assert!((part.drop(stall) - 0.6).abs() < 1e-3);
        assert_eq!(part.drop(stall), -part.drop(-stall));
        assert_eq!(part.drop(0.0), 0.0);
    }

    #[test]
    fn heat_rises_at_the_stated_rate_and_cools_into_the_housing() {
        let part = electric("winding_heating=0.1,time=20");
        let stall = Motor::paper().stall_current();
        let mut heat = Heat::default();
        for _ in 0..10_000 {
            part.heat(&mut heat, stall, 1e-5);
        }
        assert!((heat.winding - 0.01).abs() < 1e-4);
        for _ in 0..2_000_000 {
            part.heat(&mut heat, 0.0, 1e-4);
        }
        assert!(heat.winding < 0.002 && heat.housing > 0.0);
    }
}
