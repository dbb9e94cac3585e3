//! Rows that are missing while the voltage changed: nothing tells when it did, and a voltage that is held through them is wrong for as long.

use super::Record;
use super::motion::peak;
use super::samples::FEWEST_SAMPLES;
use super::timing::median_interval;

/// Rows are missing where so many intervals pass from one to the next, which they do in few places: this share of all.
const LONG: f64 = 3.5;
const RARE: f64 = 0.02;
/// The voltage changed by more than this share of the highest.
const CHANGED: f64 = 0.1;
/// A drive of steps of which more than this share come with missing rows is logged so: when a step comes the logger is late, or a row is
/// written for it.
const LATE: f64 = 0.3;
/// In missing rows a shaft goes no further than at so many times its highest speed.
const FASTER: f64 = 1.5;

/// Samples of `record` behind which rows are missing while its voltage changed, with enough for a record on either side.
pub(super) fn holes(record: &Record) -> Vec<usize> {
    let (time, volts) = (&record.time_s, &record.voltage_v);
    // The voltage of a position loop follows from what is logged.
    if record.servo.is_some() || volts.len() != time.len() {
        return Vec::new();
    }
    let (usual, least) = (median_interval(time), CHANGED * peak(volts));
    let last = time.len().saturating_sub(1);
    let long: Vec<usize> = (0..last).filter(|k| time[k + 1] - time[*k] > LONG * usual).collect();
    if long.len() as f64 > RARE * time.len() as f64 {
        return Vec::new();
    }
    let changes = |k: &usize| (volts[k + 1] - volts[*k]).abs() > least;
    let found: Vec<usize> = long.into_iter().filter(changes).collect();
    let stands = volts.windows(2).filter(|pair| pair[0] == pair[1]).count();
    let steps = (0..last).filter(changes).count();
    if 2 * stands > last && found.len() as f64 > LATE * steps as f64 {
        return Vec::new();
    }
    let is_inside = |k: &usize| *k + 1 >= FEWEST_SAMPLES && last - *k >= FEWEST_SAMPLES;
    found.into_iter().filter(is_inside).collect()
}

/// Takes those of the steps `far` (from sample k to k + 1) out that the shaft goes in missing rows at the speed that it has elsewhere.
pub(super) fn leave_out_passed(record: &Record, far: &mut Vec<usize>) {
    let (Some(angle), time) = (&record.angle_rad, &record.time_s) else { return };
    let usual = median_interval(time);
    let speed = |k: usize| (angle[k + 1] - angle[k]).abs() / (time[k + 1] - time[k]);
    let others = (0..time.len().saturating_sub(1)).filter(|k| far.binary_search(k).is_err());
    let highest = others.filter(|k| time[k + 1] > time[*k]).map(speed).fold(0.0, f64::max);
    far.retain(|k| time[k + 1] - time[*k] <= LONG * usual || speed(*k) > FASTER * highest);
}

#[cfg(test)]
mod tests {
    use super::super::repair::repaired;
    use super::super::repair::tests::{moving, swing};
    use super::*;

    /// A log of this voltage without six rows before each of these samples.
    fn without(voltage: impl Fn(f64) -> f64, at: &[usize]) -> Record {
        let mut record = moving(swing);
        record.voltage_v = record.time_s.iter().map(|t| voltage(*t)).collect();
        let is_there = |k: usize| !at.iter().any(|at| (at - 6..*at).contains(&k));
        let kept: Vec<usize> = (0..800).filter(|k| is_there(*k)).collect();
        let of = |values: &[f64]| kept.iter().map(|k| values[*k]).collect::<Vec<f64>>();
        let angle_rad = record.angle_rad.as_deref().map(of);
        Record { time_s: of(&record.time_s), voltage_v: of(&record.voltage_v), angle_rad, ..record }
    }

    fn steps(t: f64) -> f64 {
        if ((2.5 * t) as usize).is_multiple_of(2) { 6.0 } else { -4.0 }
    }

    #[test]
    fn a_record_is_cut_where_rows_are_missing_while_the_voltage_changed_and_not_where_it_stood() {
        // The second hole has a step in it, at 1.6 s.
        let parts = repaired(without(steps, &[120, 323, 700]));
        assert_eq!(parts.iter().map(Record::len).collect::<Vec<_>>(), [311, 471]);
        assert!(parts[0].warnings[0].what.contains("missing_rows"), "{:?}", parts[0].warnings);
        assert!(
            parts[0].warnings[0].what.contains("1 times, before sample 312 (1.615 s)"),
            "{:?}",
            parts[0].warnings
        );
        // At the second the sine turns round.
        let sine = |t: f64| 6.0 * (7.0 * t).sin();
        assert_eq!(repaired(without(sine, &[120, 323, 700])).len(), 3);
    }

    #[test]
    fn a_logger_that_is_late_at_every_step_and_one_of_uneven_rows_are_left_alone() {
        let at_steps: Vec<usize> = (1..10).map(|k| 80 * k + 3).collect();
        assert_eq!(repaired(without(steps, &at_steps)).len(), 1);
        let often: Vec<usize> = (1..40).map(|k| 20 * k).collect();
        assert!(holes(&without(|t| 6.0 * (7.0 * t).sin(), &often)).is_empty());
    }

    #[test]
    fn what_the_shaft_goes_in_missing_rows_is_no_jump() {
        let record = without(|_| 3.0, &[120, 323]);
        let mut far = vec![113, 310];
        leave_out_passed(&record, &mut far);
        assert!(far.is_empty(), "{far:?}");
        let mut reset = record;
        reset.angle_rad.as_mut().unwrap()[311..].iter_mut().for_each(|x| *x -= 30.0);
        let mut far = vec![113, 310];
        leave_out_passed(&reset, &mut far);
        assert_eq!(far, [310]);
    }
}
