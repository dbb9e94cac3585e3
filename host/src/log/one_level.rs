//! Records in which one voltage drives the motor: friction and gain are one number there, unless the motor runs out too.

use std::ops::Range;

use super::motion::{peak, speed, stretches};
use super::quantum::quantum;
use super::suspicion::place_of;
use super::timing::median_interval;
use super::voltages::{SAME_LEVEL, level};
use super::{Record, Warning};

/// A motor runs out between these shares of its highest speed: above it has hardly begun, below it has nearly ended.
const ENDS: f64 = 0.1;
const BEGINS: f64 = 0.9;
/// So many quantisation steps are a motion.
const STEPS: f64 = 1.5;
/// So many samples in which it runs out tell its friction.
const FEWEST: usize = 3;
/// An angle tells by how far it goes on in this time whether the shaft moves, s, or in so many intervals where these are slow.
const AHEAD_S: f64 = 0.05;
const INTERVALS: f64 = 2.0;

/// At one voltage friction and gain are one number.
pub(super) fn one_level(records: &[&Record]) -> Option<Warning> {
    let highest = records.iter().map(|record| peak(&record.voltage_v)).fold(0.0, f64::max);
    let near = SAME_LEVEL * highest;
    let volts = records.iter().flat_map(|record| record.voltage_v.iter().copied());
    let level = level(volts.filter(|v| v.abs() > near).collect(), near)?;
    let samples: usize = records.iter().map(|record| running_out(record, near)).sum();
    (samples < FEWEST).then(|| Warning {
        place: place_of(records[0], "voltage_v"),
        what: format!(
            "one_level: the only voltage that drives the motor is {level:.3} V, at which friction cannot be told from the gain and can be any share \
             of that voltage: a gain without friction is that of this one voltage, and a friction that is found rests on the start and the stop alone"
        ),
        fix: "add records at other voltages, or one in which the motor runs out over several samples (motorlens plan writes a programme)"
            .into(),
    })
}

/// In how many samples of `record` the motor runs out after its drive, at a voltage of no more than `near`: a motor that stands there tells
/// nothing.
fn running_out(record: &Record, near: f64) -> usize {
    let (time, fastest) = (&record.time_s, peak(&speed(record)));
    let ahead_s = AHEAD_S.max(INTERVALS * median_interval(time));
    // A slope over a window would smear a sudden stop over it.
    let ahead = |angle: &[f64], k: usize, end: usize| {
        let to = (k + 1..end).find(|i| time[*i] >= time[k] + ahead_s).unwrap_or(end - 1);
        if to > k { (angle[to] - angle[k]) / (time[to] - time[k]) } else { 0.0 }
    };
    let step = match (&record.speed_rad_s, &record.angle_rad) {
        (Some(speed), _) => quantum(speed).unwrap_or(0.0),
        (None, Some(angle)) => quantum(angle).unwrap_or(0.0) / ahead_s,
        (None, None) => return 0,
    };
    let moving = |k: usize, end: usize| match (&record.speed_rad_s, &record.angle_rad) {
        (Some(speed), _) => speed[k].abs(),
        (None, Some(angle)) => ahead(angle, k, end).abs(),
        (None, None) => 0.0,
    };
    let least = (ENDS * fastest).max(STEPS * step);
    let off = stretches(record.len(), |k| record.voltage_v[k].abs() <= near);
    // What stands before the first step is rest, and the reading at which a drive ends is still that drive's.
    let run_out = |off: Range<usize>| {
        let moved = (off.start + 1..off.end).map(|k| moving(k, off.end)).take_while(|w| *w > least);
        moved.filter(|w| *w < BEGINS * fastest).count()
    };
    off.into_iter().filter(|off| off.start > 0).map(run_out).sum()
}

#[cfg(test)]
mod tests {
    use super::super::voltages::is_level;
    use super::*;
    use crate::log::usable::tests::motor;

    /// One step of 6 V between two rests, 100 Hz, after which the motor stops with a time constant `stop_s`; by its speed and by its angle.
    fn step(stop_s: f64) -> [Record; 2] {
        let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let voltage_v: Vec<f64> =
            time_s.iter().map(|t| if (1.0..5.0).contains(t) { 6.0 } else { 0.0 }).collect();
        let (mut w, mut x) = (0.0_f64, 0.0_f64);
        let (mut speeds, mut angles) = (Vec::new(), Vec::new());
        for volts in &voltage_v {
            speeds.push(w);
            angles.push(x);
            let tau_s = if *volts > 0.0 { 0.05 } else { stop_s };
            let next = w + (1.0 - (-0.01_f64 / tau_s).exp()) * (8.0 * volts - w);
            x += 0.005 * (w + next);
            w = next;
        }
        let by_speed =
            Record { name: "run".into(), time_s, voltage_v, speed_rad_s: Some(speeds), ..Record::default() };
        let by_angle = Record { speed_rad_s: None, angle_rad: Some(angles), ..by_speed.clone() };
        [by_speed, by_angle]
    }

    #[test]
    fn a_motor_that_stands_at_once_after_its_only_step_does_not_run_out_however_long_it_rests() {
        for record in step(0.002) {
            let said = one_level(&[&record]).unwrap();
            assert!(said.what.starts_with("one_level") && said.what.contains("6.000 V"), "{said:?}");
        }
        let [mut noisy, _] = step(0.002);
        noisy.speed_rad_s.iter_mut().flatten().zip(0..).for_each(|(w, k)| *w += f64::from(k * k).sin());
        assert!(one_level(&[&noisy]).is_some());
    }

    #[test]
    fn a_motor_that_runs_out_over_several_samples_tells_its_friction() {
        for record in step(0.05) {
            assert_eq!(one_level(&[&record]), None);
            // Another record of the set does it for all.
            let [at_once, _] = step(0.002);
            assert_eq!(one_level(&[&at_once, &record]), None);
        }
    }

    #[test]
    fn two_levels_are_none_however_the_motor_stops() {
        for mut record in step(0.002) {
            record.voltage_v[300..500].fill(4.0);
            assert_eq!(one_level(&[&record]), None);
        }
    }

    #[test]
    fn one_level_that_was_measured_is_one_level() {
        let mut record = motor();
        assert_eq!(one_level(&[&record]), None);
        record.voltage_v = (0..record.len())
            .map(|k| 6.0 + 0.1 * ((k * k) as f64).sin() + if k < 10 { -3.0 } else { 0.0 })
            .collect();
        assert!(is_level(&record) && one_level(&[&record]).is_some());
    }
}
