//! Dry friction at the motor shaft: Coulomb, asymmetric, Stribeck, load dependent.

use super::find;
use crate::effect::Effect;
use crate::motor::Motor;
use crate::table::Kind;

/// Magnitudes in N m at the motor shaft.
///
/// Kinetic and Coulomb levels add; the Stribeck excess is `exp(-|w/v_s|^delta)` with any exponent (Armstrong-Helouvry,
/// Dupont, Canudas de Wit 1994); the load-dependent part is a share of the motor's own torque, rounded below 2 % of
/// stall so that it has no corner at zero current.
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    forward: f64,
    backward: f64,
    excess: f64,
    per_speed: f64,
    exponent: f64,
    share: f64,
    rounding: f64,
}

impl Friction {
    pub fn new(motor: &Motor, effects: &[Effect]) -> Self {
        let [coulomb, ..] = find(effects, Kind::Coulomb).unwrap_or_default();
        let [mean, asymmetry, ..] = find(effects, Kind::CoulombAsymmetric).unwrap_or_default();
        let stribeck = find(effects, Kind::Stribeck);
        let [kinetic, excess, speed, exponent] = stribeck.unwrap_or([0.0, 0.0, 1.0, 1.0]);
        let [share, ..] = find(effects, Kind::LoadFriction).unwrap_or_default();
        let both = coulomb + kinetic;
        let no_load_motor_speed = motor.no_load_speed() * motor.gear_ratio;
        Self {
            forward: motor.torque_of_volts(both + mean * (1.0 + asymmetry)),
            backward: motor.torque_of_volts(both + mean * (1.0 - asymmetry)),
            excess: motor.torque_of_volts(excess),
            per_speed: 1.0 / (speed * no_load_motor_speed),
            exponent,
            share,
            rounding: 0.02 * motor.torque_of_volts(motor.nominal_v),
        }
    }

    /// Whether there is any dry friction, so that the motor can stick.
    pub fn sticks(&self) -> bool {
        self.forward > 0.0 || self.backward > 0.0 || self.excess > 0.0 || self.share > 0.0
    }

    /// Magnitude of the friction when sliding (or about to slide) in `direction` (1 or -1) at `speed` (rad/s of the
    /// motor), with `motor_torque` made by the current.
    #[inline]
    pub fn level(&self, direction: f64, speed: f64, motor_torque: f64) -> f64 {
        let mut level = if direction > 0.0 { self.forward } else { self.backward };
        if self.excess > 0.0 {
            level += self.excess * (-(speed.abs() * self.per_speed).powf(self.exponent)).exp();
        }
        if self.share > 0.0 {
            level += self.share * (motor_torque.hypot(self.rounding) - self.rounding);
        }
        level
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn level(text: &str, direction: f64, speed_share: f64, volts: f64) -> f64 {
        let motor = Motor::small();
        let friction = Friction::new(&motor, &[Effect::parse(text).unwrap()]);
        let speed = speed_share * motor.no_load_speed() * motor.gear_ratio;
        friction.level(direction, speed, motor.torque_of_volts(volts)) / motor.torque_of_volts(1.0)
    }

    #[test]
    fn levels_are_the_volt_equivalents_that_were_asked_for() {
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-9, "{a} {b}");
        close(level("coulomb=0.4", 1.0, 0.5, 0.0), 0.4);
        close(level("coulomb_asymmetric=0.4,asymmetry=0.25", 1.0, 0.5, 0.0), 0.5);
        close(level("coulomb_asymmetric=0.4,asymmetry=0.25", -1.0, 0.5, 0.0), 0.3);
        close(level("stribeck=0.4,excess=0.2", 1.0, 0.0, 0.0), 0.6);
        close(level("stribeck=0.4,excess=0.2,speed=0.1", 1.0, 0.1, 0.0), 0.4 + 0.2 * (-1f64).exp());
        close(level("load_friction=0.2", 1.0, 0.1, 0.0), 0.0);
        close(level("load_friction=0.2", 1.0, 0.1, 9.0), 0.2 * (9f64.hypot(0.24) - 0.24));
    }

    #[test]
    fn no_effect_means_no_sticking() {
        assert!(!Friction::new(&Motor::paper(), &[]).sticks());
    }
}
