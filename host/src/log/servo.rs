//! Position-commanded servos: logs with a target and an angle, and no voltage.
//!
//! The controller is part of the model: `duty = clamp(gain * (target - angle) - damping * speed, -1, 1)`, and the voltage is the duty
//! times the supply. Gain (`--servo-gain`, duty per rad; of a servo whose register is in other units, that of its register) and
//! damping (`--servo-damping`, duty per rad/s) are known, or found here: where the controller saturates, and only there, the motion
//! tells its gain apart from the motor's. The loop of a servo is much faster than its log, so the voltage runs on between samples
//! (hold "first").

use super::motion::{low_pass, slope, speed};
use super::timing::median_interval;
use super::weak::{Regression, Weak};
use super::{Hold, Record, Warning, servo_loop};

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
/// Gains that are tried, duty per rad: full duty at 1.5 rad to full duty at 0.01 rad.
const GAINS: (f64, f64, usize) = (0.7, 100.0, 40);
/// Damping that is tried, seconds of the gain.
const DAMPING_S: [f64; 5] = [0.0, 0.01, 0.02, 0.04, 0.08];
/// A gain is told where so many of the samples would be at full duty ...
const SATURATED: f64 = 0.02;
/// ... and a tenth of the gain leaves this much more.
const WORSE: f64 = 1.1;

impl Controller {
    /// Duty at each sample of `record`, whose loop is `servo`.
    fn duty(self, record: &Record, servo: &Servo, speed: &[f64]) -> Vec<f64> {
        let angle = record.angle_rad.as_deref().unwrap_or_default();
        let error = servo.target_rad.iter().zip(angle).zip(speed);
        error
            .map(|((target, angle), w)| (self.gain * (target - angle) - self.damping * w).clamp(-1.0, 1.0))
            .collect()
    }

    /// Gives `record` the voltage that this makes of its loop.
    fn drive(self, record: &mut Record) {
        let Some(servo) = record.servo.clone() else { return };
        let speed = filtered_speed(record);
        let duty = self.duty(record, &servo, &speed);
        record.voltage_v = match &record.supply_v {
            Some(supply) => duty.iter().zip(supply).map(|(duty, supply)| duty * supply).collect(),
            None => duty.iter().map(|duty| duty * USUAL_SUPPLY).collect(),
        };
    }
}

/// The speed as a servo's loop sees it, and not as noisy as a difference of two samples.
fn filtered_speed(record: &Record) -> Vec<f64> {
    match (&record.angle_rad, &record.speed_rad_s) {
        (_, Some(_)) => speed(record),
        (Some(angle), None) => {
            low_pass(&record.time_s, &slope(&record.time_s, angle), 0.5 * median_interval(&record.time_s))
        }
        (None, None) => Vec::new(),
    }
}

/// Gives every servo of `records` its voltage, with one controller for all of which it is not known.
pub fn close_loops(records: &mut [Record]) {
    let open: Vec<Record> =
        records.iter().filter(|r| r.servo.as_ref().is_some_and(|s| s.gain.is_none())).cloned().collect();
    let found = if open.is_empty() { None } else { Some(find(&open)) };
    let mut said = false;
    for record in records.iter_mut() {
        let Some(servo) = record.servo.clone() else { continue };
        let known = servo.gain.map(|gain| Controller { gain, damping: servo.damping.unwrap_or(0.0) });
        let Some(controller) = known.or(found.map(|(controller, _)| controller)) else { continue };
        controller.drive(record);
        record.hold = Hold::First;
        let Controller { gain, damping } = controller;
        for (key, value) in [
            ("servo_gain", gain.to_string()),
            ("servo_damping", damping.to_string()),
            ("voltage", "it follows from the servo's position loop".to_owned()),
        ] {
            // These keys take any text.
            let _ = record.meta.insert(key, &value);
        }
        record.warnings.retain(|warning| !warning.what.starts_with("servo_gain"));
        if let (None, Some((_, told)), false) = (known, found, said) {
            record.warnings.push(told_or_assumed(record, controller, told));
            said = true;
        }
    }
}

fn told_or_assumed(record: &Record, Controller { gain, damping }: Controller, told: bool) -> Warning {
    let what = if told {
        format!(
            "servo_gain: the controller is not logged; the motion tells a gain of {gain:.3} duty per rad and a damping of {damping:.3} duty per rad/s"
        )
    } else {
        format!(
            "servo_gain: the controller is not logged and never at full duty, so that its gain cannot be told from the motor's: {gain:.3} duty \
             per rad is assumed, and only the product of both gains is right"
        )
    };
    Warning {
        place: format!("{}, column target", record.path.display()),
        what,
        fix: "give what is known: --servo-gain DUTY_PER_RAD, --servo-damping DUTY_PER_RAD_S, and the supply (--supply-volts, --map supply=...); \
              or log the duty (--map duty=...); large steps of the target saturate the controller and tell its gain"
            .into(),
    }
}

/// The controller that explains the motion of `records` best, and whether they tell its gain.
fn find(records: &[Record]) -> (Controller, bool) {
    let (low, high, count) = GAINS;
    let trials: Vec<Trial> = (0..count)
        .flat_map(|k| {
            let gain = low * (high / low).powf(k as f64 / (count - 1) as f64);
            DAMPING_S.map(|seconds| Trial::new(records, Controller { gain, damping: gain * seconds }))
        })
        .collect();
    let best = trials.iter().min_by(|a, b| a.left.total_cmp(&b.left));
    let Some(best) = best.filter(|best| best.left.is_finite()) else {
        return (Controller { gain: assumed(records), damping: 0.0 }, false);
    };
    let linear =
        trials.iter().filter(|trial| trial.saturated == 0.0).map(|trial| trial.left).fold(f64::MAX, f64::min);
    let told = best.saturated > SATURATED && linear > WORSE * best.left;
    if !told {
        let damping = best.controller.damping / best.controller.gain;
        let gain = assumed(records);
        return (Controller { gain, damping: gain * damping }, false);
    }
    // Between the gains tried, by thirds.
    let seconds = best.controller.damping / best.controller.gain;
    let step = (high / low).powf(1.0 / (count - 1) as f64);
    let centre = best.controller.gain;
    let left = |gain: f64| Trial::new(records, Controller { gain, damping: gain * seconds }).left;
    let (mut a, mut b) = (centre / step, centre * step);
    for _ in 0..12 {
        let (c, d) = (a * (b / a).powf(1.0 / 3.0), a * (b / a).powf(2.0 / 3.0));
        if left(c) < left(d) { b = d } else { a = c }
    }
    let gain = (a * b).sqrt();
    let rough = Trial::new(records, Controller { gain, damping: gain * seconds });
    let refined = rough.motor.and_then(|motor| servo_loop::refined(records, rough.controller, motor));
    (refined.unwrap_or(rough.controller), true)
}

/// A gain that just does not saturate: nothing is known, and nothing is lost.
fn assumed(records: &[Record]) -> f64 {
    let errors = records.iter().flat_map(|record| {
        let target = record.servo.iter().flat_map(|servo| &servo.target_rad);
        target.zip(record.angle_rad.iter().flatten()).map(|(target, angle)| (target - angle).abs())
    });
    let largest = errors.fold(0.0, f64::max);
    if largest > 0.0 { 1.0 / largest } else { 1.0 }
}

/// What a controller leaves unexplained of its own voltage, and how much of the time it is at full duty.
struct Trial {
    controller: Controller,
    /// The motor as one of the records shows it.
    motor: Option<Regression>,
    left: f64,
    saturated: f64,
}

impl Trial {
    fn new(records: &[Record], controller: Controller) -> Self {
        let (mut left, mut weight, mut full, mut all) = (0.0, 0.0, 0, 0);
        let mut motor = None;
        for record in records {
            let mut record = record.clone();
            controller.drive(&mut record);
            let volts = record.supply_v.as_ref().map_or(USUAL_SUPPLY, |supply| supply[0]);
            full += record.voltage_v.iter().filter(|v| v.abs() > 0.98 * volts).count();
            all += record.len();
            let seen = Weak::new(&record).and_then(|weak| weak.regress(0.0, |v| v));
            if let Some(seen) = seen.filter(|seen| seen.gain > 0.0) {
                motor = motor.or(Some(seen));
                left += seen.left * record.len() as f64;
                weight += record.len() as f64;
            }
        }
        let left = if weight > 0.5 * all as f64 { left / weight } else { f64::INFINITY };
        Self { controller, motor, left, saturated: full as f64 / all.max(1) as f64 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor in a position loop that runs a hundred times as often as it is logged.
    pub(super) fn servo(gain: f64, damping: f64, size: f64) -> Record {
        let (supply, dt) = (12.0, 2e-4);
        let (mut w, mut x) = (0.0_f64, 0.0_f64);
        let mut record = Record { name: "servo".into(), angle_rad: Some(Vec::new()), ..Record::default() };
        let mut targets = Vec::new();
        for k in 0..60_000 {
            let t = f64::from(k) * dt;
            let target = size * ((0.9 * t).sin().signum() * 0.6 + 0.4 * (2.3 * t).sin());
            if k % 50 == 0 {
                record.time_s.push(t);
                record.angle_rad.as_mut().unwrap().push(x);
                targets.push(target);
            }
            let v = supply * (gain * (target - x) - damping * w).clamp(-1.0, 1.0);
            let friction = if w == 0.0 { v.clamp(-0.3, 0.3) } else { 0.3 * w.signum() };
            w += dt / 0.05 * (0.5 * (v - friction) - w);
            x += dt * w;
        }
        record.supply_v = Some(vec![supply; record.len()]);
        record.servo = Some(Servo { target_rad: targets, gain: None, damping: None });
        record.voltage_v = vec![0.0; record.len()];
        record
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
