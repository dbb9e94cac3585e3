//! Motion that begins up to a row before the row whose voltage causes it: the command was written between two rows, or after its row was logged.
//!
//! No effect acts before its cause, so one that does not belong there takes the place of what is missing. At each switch of the voltage
//! from one level to another a first-order motor is fitted to the rows around it, switched at the row that shows it and at instants up to
//! a row earlier. Where one earlier instant leaves far less in most switches, that is by how much the voltage is logged late.
//! Speeds count as those of their rows: a mean since the row before looks later, so nothing is told too often.

mod switch;

use super::motion::mean;
use super::suspicion::{BEFORE_ITS_VOLTAGE, place_of};
use super::timing::median;
use super::{Hold, Record, Warning};
use crate::search::golden::lowest;
use switch::{Switch, least_of};

/// Most switches that are fitted.
const MOST: usize = 24;
/// Instants that are tried in the row before.
const STEPS: usize = 10;
/// Told are instants this many rows early or more, in which the motor goes through this share of its time constant.
const EARLIEST: f64 = 0.15;
const MATTERS: f64 = 0.08;
/// They leave less than this share of the error, or this where the switches are few, ...
const LESS: f64 = 0.5;
const LESS_OF_FEW: f64 = 0.3;
const FEW: usize = 3;
/// ... and of the motion less than this share, as root mean squares.
const LEFT: f64 = 0.1;
/// Share of the switches of which each by itself says so, within so many rows.
const AGREEING: f64 = 0.6;
const TOGETHER: f64 = 0.25;
/// A voltage that runs straight from row to row is told where it leaves no more squares than this many times those of one instant.
const AS_GOOD: f64 = 1.2;

/// Motion that comes before its voltage by a part of a row.
pub(super) fn early(records: &[&Record]) -> Option<Warning> {
    // A voltage that runs straight from row to row acts before its row, and a lead was asked about.
    let is_asked = |record: &&Record| {
        record.hold == Hold::Zero && record.servo.is_none() && record.meta.voltage_lead_s().is_none()
    };
    let asked: Vec<&Record> = records.iter().copied().filter(is_asked).collect();
    let Early { rows, interval_s, left, agree, count, is_straight } = found(&asked)?;
    let what = format!(
        "shifted_samples: the motor moves {:.1} ms ({rows:.2} rows) {BEFORE_ITS_VOLTAGE}: switched that much earlier, a first-order motor leaves \
         {:.0} % of the error that it leaves when it is switched at the row, in {agree} of {count} switches of the voltage alike",
        1e3 * rows * interval_s,
        100.0 * left
    );
    let fix = if is_straight {
        "a voltage that runs straight from one row to the next, as behind an amplifier or a filter, explains it as well: read this log with \
         --hold first"
            .into()
    } else {
        format!("log in each row the voltage that acts from then on; {}", led_by(rows * interval_s))
    };
    Some(Warning { place: place_of(asked[0], "voltage_v"), what, fix })
}

/// The option that lets each voltage act that many seconds before its row, and what it does.
pub(super) fn led_by(seconds: f64) -> String {
    // To a microsecond.
    let lead = (1e6 * seconds).round() / 1e6;
    format!(
        "read this log with --voltage-lead {lead}, by which each voltage acts that many seconds before its row"
    )
}

/// By how much motion comes before its voltage.
struct Early {
    /// In rows of this many seconds.
    rows: f64,
    interval_s: f64,
    /// Share of the error that is left with it.
    left: f64,
    /// Switches that say so, each by itself, of how many.
    agree: usize,
    count: usize,
    /// Whether a voltage that runs straight from row to row explains it as well.
    is_straight: bool,
}

/// By how much the motion of `records` surely comes before its voltage; none where it does not.
fn found(records: &[&Record]) -> Option<Early> {
    let all: Vec<Switch> = records.iter().flat_map(|record| Switch::all(record)).collect();
    let every = all.len().div_ceil(MOST).max(1);
    let switches: Vec<Switch> = all.into_iter().step_by(every).collect();
    let count = switches.len();
    let at = |step: usize| step as f64 / STEPS as f64;
    let of_switch =
        |switch: &Switch| (0..=STEPS).map(|step| switch.left(&[-at(step)]).0).collect::<Vec<f64>>();
    let each: Vec<Vec<f64>> = switches.iter().map(of_switch).collect();
    let sum = |step: usize| each.iter().map(|left| left[step]).sum::<f64>();
    let best = least_of((0..=STEPS).map(sum));
    if count == 0 || at(best) < EARLIEST {
        return None;
    }
    let around = [at(best.saturating_sub(1)), at((best + 1).min(STEPS))];
    let all_left = |instants: &[f64]| switches.iter().map(|switch| switch.left(instants).0).sum::<f64>();
    let (left, rows) = lowest(around, |rows| all_left(&[-rows]));
    let less = if count < FEW { LESS_OF_FEW } else { LESS };
    let says = |left: &&Vec<f64>| {
        let own = least_of(left.iter().copied());
        (at(own) - rows).abs() < TOGETHER && left[own] < less * less * left[0]
    };
    let agree = each.iter().filter(says).count();
    let mut times: Vec<f64> = switches.iter().map(|switch| switch.left(&[-rows]).1).collect();
    let is_sure = rows > EARLIEST.max(MATTERS * median(&mut times))
        && left < less * less * sum(0)
        && left < LEFT * LEFT * count as f64
        && agree as f64 >= AGREEING * count as f64;
    // A voltage that runs straight is as one that is switched a little at each of these instants.
    let straight: Vec<f64> = (0..STEPS).map(|step| -(step as f64 + 0.5) / STEPS as f64).collect();
    let intervals: Vec<f64> = switches.iter().map(|switch| switch.interval_s).collect();
    is_sure.then(|| Early {
        rows,
        interval_s: mean(&intervals),
        left: (left / sum(0)).sqrt(),
        agree,
        count,
        is_straight: all_left(&straight) < AS_GOOD * left,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ROW_S: f64 = 0.02;

    /// Rest, 6 V from 0.6 s on, and rest again from 1.2 s on.
    fn there_and_back(t: f64) -> f64 {
        if (0.6..1.2).contains(&(t + 1e-6)) { 6.0 } else { 0.0 }
    }

    /// The one step.
    fn there(t: f64) -> f64 {
        if t + 1e-6 < 0.6 { 0.0 } else { 6.0 }
    }

    /// The voltages of the rows, and speeds, mean speeds since the row before and angles of a motor of 50 ms and 20 rad/s a volt that has
    /// `drive` at each time.
    fn logged(volts: impl Fn(f64) -> f64, drive: impl Fn(f64) -> f64) -> (Record, [Vec<f64>; 3]) {
        let (step, steps) = (1e-4, 200);
        let (mut speed, mut angle, mut before) = (0.0_f64, 0.0_f64, 0.0_f64);
        let mut motions: [Vec<f64>; 3] = Default::default();
        let time_s: Vec<f64> = (0..121).map(|k| f64::from(k) * ROW_S).collect();
        for (k, t) in time_s.iter().enumerate() {
            // What a meter scatters by.
            let noise = 0.3 * ((k * k) as f64).sin();
            motions[0].push(speed + noise);
            motions[1].push((angle - before) / ROW_S + noise);
            motions[2].push((angle / 0.01).round() * 0.01);
            before = angle;
            for part in 0..steps {
                let v = drive(t + (f64::from(part) + 0.5) * step);
                speed += step / 0.05 * (20.0 * v - speed);
                angle += step * speed;
            }
        }
        let voltage_v = time_s.iter().map(|t| volts(*t)).collect();
        (Record { time_s, voltage_v, ..Record::default() }, motions)
    }

    fn with_speed(record: &Record, speed: &[f64]) -> Record {
        Record { speed_rad_s: Some(speed.to_vec()), ..record.clone() }
    }

    fn with_angle(record: &Record, angle: &[f64]) -> Record {
        Record { angle_rad: Some(angle.to_vec()), ..record.clone() }
    }

    #[test]
    fn a_switch_between_two_rows_is_found_to_a_twentieth_of_a_row_and_of_one_step_too() {
        let two = logged(there_and_back, |t| there_and_back(t + 0.012));
        let one = logged(there, |t| there(t + 0.012));
        for (record, [speed, _, angle]) in [two, one] {
            for record in [with_speed(&record, &speed), with_angle(&record, &angle)] {
                let early = found(&[&record]).unwrap();
                assert!((early.rows - 0.6).abs() < 0.05 && early.agree == early.count, "{}", early.rows);
                assert!(!early.is_straight && (early.interval_s - ROW_S).abs() < 1e-9);
            }
        }
    }

    #[test]
    fn the_remedy_is_an_option_with_which_nothing_is_told_any_more() {
        let (record, [speed, ..]) = logged(there_and_back, |t| there_and_back(t + 0.012));
        let mut record = with_speed(&record, &speed);
        let told = early(&[&record]).unwrap();
        assert!(told.what.contains(" ms (0.6") && told.what.contains("2 of 2 switches"), "{}", told.what);
        let option = told.fix.split("--voltage-lead ").nth(1).unwrap();
        let lead = option.split(',').next().unwrap();
        assert!((lead.parse::<f64>().unwrap() - 0.012).abs() < 1e-3, "{}", told.fix);
        record.meta.insert("voltage_lead_s", lead).unwrap();
        assert_eq!(early(&[&record]), None);
    }

    #[test]
    fn a_voltage_that_runs_straight_from_row_to_row_is_told_as_one() {
        let straight = |t: f64| {
            let row = (t / ROW_S).floor() * ROW_S;
            let (from, to) = (there_and_back(row), there_and_back(row + ROW_S));
            from + (to - from) * (t - row) / ROW_S
        };
        let (record, [speed, ..]) = logged(there_and_back, straight);
        let mut record = with_speed(&record, &speed);
        let told = early(&[&record]).unwrap();
        assert!(told.fix.contains("--hold first"), "{}", told.fix);
        record.hold = Hold::First;
        assert_eq!(early(&[&record]), None);
    }

    #[test]
    fn a_voltage_that_holds_from_its_row_on_is_right_of_speeds_that_are_means_late_or_filtered_too() {
        for late_s in [0.0, 0.005, 0.03] {
            let (record, [speed, means, angle]) = logged(there_and_back, |t| there_and_back(t - late_s));
            let mut smooth = 0.0;
            let filtered: Vec<f64> = speed
                .iter()
                .map(|w| {
                    smooth += 0.5 * (w - smooth);
                    smooth
                })
                .collect();
            for speed in [&speed, &means, &filtered] {
                assert_eq!(early(&[&with_speed(&record, speed)]), None, "{late_s}");
            }
            assert_eq!(early(&[&with_angle(&record, &angle)]), None, "{late_s}");
        }
    }

    #[test]
    fn a_shift_that_is_another_at_each_switch_is_no_lead() {
        // Written whenever the other loop came round: 2 ms before the row and 18 ms.
        let drive = |t: f64| if (0.598..1.182).contains(&t) { 6.0 } else { 0.0 };
        let (record, [speed, ..]) = logged(there_and_back, drive);
        assert_eq!(early(&[&with_speed(&record, &speed)]), None);
    }
}
