//! Position-commanded servos: logs with a target and an angle, and no voltage.
//!
//! The controller is part of the model: `duty = clamp(gain * (target - angle) - damping * speed, -1, 1)`, and the voltage is the duty
//! times the supply. Gain (`--servo-gain`, duty per rad; of a servo whose register is in other units, that of its register) and
//! damping (`--servo-damping`, duty per rad/s) are known, or found (`identify`): where the controller saturates, and only there,
//! the motion tells its gain apart from the motor's. Its target or its voltage may be late (`late`). The loop of a servo is much faster than its
//! log: where the target moves on between two rows the voltage runs on there too (hold "first"); where it is held until the next, the
//! voltage of a row is its mean until then.

mod busiest;
mod driven;
mod identify;
mod late;
#[cfg(test)]
mod made;
mod simulated;
mod told;
mod trials;

use super::{Record, Warning};
use told::told_or_assumed;

/// The loop of a record.
#[derive(Debug, Clone, PartialEq)]
pub struct Servo {
    /// Where the shaft was told to be, rad.
    pub target_rad: Vec<f64>,
    /// Its proportional gain, duty per rad.
    pub gain: Option<f64>,
    /// Its damping, duty per rad/s.
    pub damping: Option<f64>,
}

/// A controller.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Controller {
    /// Duty per rad.
    pub gain: f64,
    /// Duty per rad/s.
    pub damping: f64,
}

/// Supply that is assumed where nothing tells it, V: the gain of the motor is then that of this supply.
pub const USUAL_SUPPLY: f64 = 12.0;

impl Controller {
    /// Full duty by the sign of the error: of a larger gain no encoder tells more.
    const RELAY: Self = Self { gain: 1e3, damping: 0.0 };

    /// Duty at an `error` of the angle, rad, and a `speed`, rad/s.
    fn duty(self, error: f64, speed: f64) -> f64 {
        (self.gain * error - self.damping * speed).clamp(-1.0, 1.0)
    }
}

/// Gives every servo of `records` its voltage, with one controller for all of which it is not known.
pub fn close_loops(records: &mut [Record]) {
    let open: Vec<Record> =
        records.iter().filter(|r| r.servo.as_ref().is_some_and(|s| s.gain.is_none())).cloned().collect();
    let found = if open.is_empty() { None } else { Some(identify::find(&open)) };
    let mut said = false;
    for record in records.iter_mut() {
        let Some(servo) = record.servo.clone() else { continue };
        let known = servo.gain.map(|gain| Controller { gain, damping: servo.damping.unwrap_or(0.0) });
        let known = known.map(|known| identify::known(record, known));
        let Some(run) = known.or(found.map(|found| found.run)) else { continue };
        run.drive(record);
        let Controller { gain, damping } = run.controller;
        for (key, value) in [
            ("servo_gain", gain.to_string()),
            ("servo_damping", damping.to_string()),
            ("voltage", "it follows from the servo's position loop".to_owned()),
        ] {
            // These keys take any text.
            let _ = record.meta.insert(key, &value);
        }
        let is_of_loop = |warning: &Warning| {
            ["servo_gain", "late_target", "late_voltage"].iter().any(|name| warning.what.starts_with(name))
        };
        record.warnings.retain(|warning| !is_of_loop(warning));
        if let (None, Some(found), false) = (known, found, said) {
            record.warnings.push(told_or_assumed(record, run.controller, found.told));
            said = true;
        }
        let or_gain = found.filter(|_| known.is_none()).and_then(|found| found.or_gain);
        record.warnings.extend(told::late(record, run.late, or_gain));
    }
}

#[cfg(test)]
mod tests {
    use super::super::Hold;
    use super::super::weak::Weak;
    use super::made::{Between, Made};
    use super::*;

    /// A servo whose target moves on between two rows.
    fn servo(gain: f64, damping: f64, size: f64) -> Record {
        Made { gain, damping, size, between: Between::Moves, ..Made::default() }.record()
    }

    fn gain_of(record: &Record) -> f64 {
        record.meta.get("servo_gain").unwrap().parse().unwrap()
    }

    /// What is said of the controller.
    fn said(record: &Record) -> &Warning {
        record.warnings.iter().find(|warning| warning.what.starts_with("servo_gain")).unwrap()
    }

    #[test]
    fn a_target_that_stands_between_two_rows_gives_each_row_its_mean_voltage() {
        for known in [None, Some(4.0)] {
            let (mut record, means) = Made { gain: 4.0, size: 1.0, ..Made::default() }.log();
            record.servo.as_mut().unwrap().gain = known;
            let mut records = [record];
            close_loops(&mut records);
            assert!(records[0].hold == Hold::Zero && (gain_of(&records[0]) / 4.0 - 1.0).abs() < 0.05);
            let off = records[0].voltage_v.iter().zip(&means).map(|(v, mean)| (v - mean).powi(2));
            let off = (off.sum::<f64>() / means.len() as f64).sqrt();
            assert!(off < 0.3, "{off} V with {known:?}");
            assert!(records[0].warnings.iter().all(|w| !w.what.starts_with("late_target")));
        }
    }

    #[test]
    fn the_controller_of_an_arm_that_lifts_a_weight_is_found() {
        let mut records = [Made { weight_v: 2.0, ..Made::default() }.record()];
        close_loops(&mut records);
        assert!((gain_of(&records[0]) / 2.5 - 1.0).abs() < 0.1, "{}", gain_of(&records[0]));
        assert!(said(&records[0]).what.contains("tells a gain"), "{:?}", said(&records[0]));
    }

    #[test]
    fn a_target_that_arrives_some_rows_late_is_told_once_and_taken_so() {
        for known in [None, Some(2.5)] {
            let mut record = Made { between: Between::Stands(3), ..Made::default() }.record();
            record.servo.as_mut().unwrap().gain = known;
            let mut records = [record];
            close_loops(&mut records);
            close_loops(&mut records);
            let late: Vec<&Warning> =
                records[0].warnings.iter().filter(|w| w.what.starts_with("late_target")).collect();
            assert!(late.len() == 1 && late[0].what.contains("3 rows (30 ms)"), "{late:?}");
            assert!((gain_of(&records[0]) / 2.5 - 1.0).abs() < 0.1, "{}", gain_of(&records[0]));
            assert!(
                known.is_some() || said(&records[0]).what.contains("tells a gain"),
                "{:?}",
                records[0].warnings
            );
        }
    }

    #[test]
    fn a_late_voltage_is_told_once_and_left_to_the_fit() {
        for known in [None, Some(2.5)] {
            let (mut record, means) = Made { dead_s: 0.02, ..Made::default() }.log();
            record.servo.as_mut().unwrap().gain = known;
            let mut records = [record];
            close_loops(&mut records);
            close_loops(&mut records);
            let late: Vec<&Warning> =
                records[0].warnings.iter().filter(|w| w.what.starts_with("late_")).collect();
            assert!(late.len() == 1 && late[0].what.starts_with("late_voltage"), "{late:?}");
            assert!(late[0].what.contains("2 rows (20 ms)"), "{late:?}");
            // What acts two rows later is what was asked for.
            let off = records[0].voltage_v.iter().zip(&means[2..]).map(|(v, mean)| (v - mean).powi(2));
            let off = (off.sum::<f64>() / means.len() as f64).sqrt();
            assert!(off < 0.4, "{off} V with {known:?}");
        }
    }

    #[test]
    fn a_controller_that_saturates_is_found_from_target_and_angle() {
        for (gain, damping) in [(2.0, 0.0), (5.0, 0.1)] {
            let mut records = [servo(gain, damping, 1.5)];
            close_loops(&mut records);
            let found: f64 = records[0].meta.get("servo_gain").unwrap().parse().unwrap();
            assert!((found / gain - 1.0).abs() < 0.05, "{found} for {gain}");
            assert!(records[0].warnings[0].what.contains("tells a gain"), "{:?}", records[0].warnings);
            let seen = Weak::new(&records[0]).unwrap().regress(0.0, |v| v).unwrap();
            assert!((seen.gain - 0.5).abs() < 0.08, "{seen:?} for {gain}");
        }
    }

    #[test]
    fn a_controller_that_never_saturates_is_assumed_and_that_is_said() {
        let mut records = [servo(1.0, 0.0, 0.2)];
        close_loops(&mut records);
        assert!(records[0].warnings[0].what.contains("only the product"), "{:?}", records[0].warnings);
    }

    #[test]
    fn full_duty_by_the_sign_of_the_error_is_a_relay_without_damping() {
        let mut records = [servo(1e6, 0.0, 1.5)];
        close_loops(&mut records);
        let damping: f64 = records[0].meta.get("servo_damping").unwrap().parse().unwrap();
        assert!(damping < 0.005 * gain_of(&records[0]), "{:?}", said(&records[0]));
        assert!(said(&records[0]).what.contains("the motion tells a relay"), "{:?}", said(&records[0]));
    }

    #[test]
    fn where_no_loop_follows_the_motion_a_controller_is_assumed_and_not_told() {
        let mut record = servo(2.0, 0.0, 1.5);
        // Turned by something else.
        let angle = |t: &f64| (3.1 * t).sin() + 0.3 * (7.7 * t).sin();
        record.angle_rad = Some(record.time_s.iter().map(angle).collect());
        let mut records = [record];
        close_loops(&mut records);
        let said = said(&records[0]);
        assert!(
            said.what.contains("the motion does not tell it") && said.what.contains("assumed"),
            "{said:?}"
        );
    }

    #[test]
    fn a_known_controller_is_used_as_it_is() {
        let mut record = servo(4.0, 0.0, 1.0);
        record.servo.as_mut().unwrap().gain = Some(4.0);
        let mut records = [record];
        close_loops(&mut records);
        let (target, angle) =
            (records[0].servo.as_ref().unwrap().target_rad[300], records[0].angle_rad.as_ref().unwrap()[300]);
        assert_eq!(records[0].voltage_v[300], 12.0 * (4.0 * (target - angle)).clamp(-1.0, 1.0));
        assert!(records[0].warnings.is_empty() && records[0].hold == Hold::First);
    }
}
