//! Torques of position and speed: gravity, constant load, spring, quadratic drag, cogging.

use super::find;
use crate::effect::Effect;
use crate::motor::Motor;
use crate::table::Kind;
use std::f64::consts::TAU;

/// Torques in N m; those of the load at the output shaft, drag and cogging at the motor shaft.
#[derive(Debug, Clone, PartialEq)]
pub struct Load {
    gravity: f64,
    gravity_phase: f64,
    constant: f64,
    spring: f64,
    drag: f64,
    cogging: f64,
    periods: f64,
    cogging_phase: f64,
    harmonic: f64,
}

impl Load {
    pub fn new(motor: &Motor, effects: &[Effect]) -> Self {
        let [gravity, gravity_phase, ..] = find(effects, Kind::Gravity).unwrap_or_default();
        let [constant, ..] = find(effects, Kind::ConstantLoad).unwrap_or_default();
        let [spring, ..] = find(effects, Kind::Spring).unwrap_or_default();
        let [drag, ..] = find(effects, Kind::QuadraticDrag).unwrap_or_default();
        let [cogging, periods, cogging_phase, harmonic] = find(effects, Kind::Cogging).unwrap_or_default();
        let at_output = motor.torque_of_volts(1.0) * motor.gear_ratio;
        let no_load_motor_speed = motor.no_load_speed() * motor.gear_ratio;
        Self {
            gravity: gravity * at_output,
            gravity_phase,
            constant: constant * at_output,
            spring: spring * at_output / TAU,
            drag: motor.torque_of_volts(drag) / (no_load_motor_speed * no_load_motor_speed),
            cogging: motor.torque_of_volts(cogging),
            periods,
            cogging_phase,
            harmonic,
        }
    }

    /// What the load asks of the output shaft at this angle, N m against forward motion.
    #[inline]
    pub fn at_output(&self, angle: f64) -> f64 {
        let mut torque = self.constant + self.spring * angle;
        if self.gravity != 0.0 {
            torque += self.gravity * (angle + self.gravity_phase).sin();
        }
        torque
    }

    /// What brakes the motor shaft at this angle and speed, N m against forward motion.
    #[inline]
    pub fn at_motor(&self, angle: f64, speed: f64) -> f64 {
        let mut torque = self.drag * speed * speed.abs();
        if self.cogging != 0.0 {
            // sin 2x = 2 sin x cos x, and the period of the slots is what the phase shifts.
            let (sine, cosine) = (self.periods * (angle + self.cogging_phase)).sin_cos();
            torque += self.cogging * sine * (1.0 + 2.0 * self.harmonic * cosine);
        }
        torque
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn load(text: &str) -> (Load, f64) {
        let motor = Motor::small();
        (Load::new(&motor, &[Effect::parse(text).unwrap()]), motor.torque_of_volts(1.0))
    }

    #[test]
    fn loads_at_the_output_are_volt_equivalents_through_the_gear() {
        let ratio = Motor::small().gear_ratio;
        for (text, angle, volts) in [
            ("constant_load=-0.3", 2.0, -0.3),
            ("spring=0.2", TAU, 0.2),
            ("gravity=0.5", 0.5, 0.5 * 0.5f64.sin()),
        ] {
            let (load, volt) = load(text);
            assert!((load.at_output(angle) / ratio / volt - volts).abs() < 1e-12, "{text}");
            assert_eq!(load.at_motor(1.0, 100.0), 0.0);
        }
    }

    #[test]
    fn drag_reaches_its_size_at_the_no_load_speed_and_opposes_both_directions() {
        let (load, volt) = load("quadratic_drag=0.8");
        let speed = Motor::small().no_load_speed() * Motor::small().gear_ratio;
        assert!((load.at_motor(0.0, speed) / volt - 0.8).abs() < 1e-12);
        assert!((load.at_motor(0.0, -speed / 2.0) / volt + 0.2).abs() < 1e-12);
    }

    #[test]
    fn cogging_repeats_with_its_periods_and_does_no_work_in_a_turn() {
        let (load, _) = load("cogging=0.5,periods=6");
        let torque = |angle: f64| load.at_motor(angle, 0.0);
        assert!((torque(0.3) - torque(0.3 + TAU / 6.0)).abs() < 1e-12);
        let work: f64 = (0..600).map(|k| torque(TAU * f64::from(k) / 600.0)).sum();
        assert!(work.abs() < 1e-12);
    }
}
