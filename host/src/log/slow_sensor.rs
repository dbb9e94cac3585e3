//! A sensor that is read far less often than the log is written: its readings are held for many rows.
//!
//! Between two readings the rows say nothing of the motion, and what looks like a delay is the age of the last one. Holds of up to some
//! dozen rows are part of the model, which knows when the voltage changed between two readings. Longer ones are taken out here: only the
//! rows in which a reading is new are kept, with the mean voltage until the next, so that no volt-second is lost.

use super::hold::{LONGEST, hold};
use super::repair::leave_out;
use super::samples::FEWEST_SAMPLES;
use super::suspicion::place_of;
use super::timing::median_interval;
use super::{Record, Warning};

/// Changes that show it.
const FEWEST_CHANGES: usize = 9;
/// Rows from one change to the next are as many as the hold has, within this share of it, ...
const EVEN: f64 = 0.25;
/// ... or so many times as many at most, where a reading is the one before; what lasts longer is a standstill.
const SAME_AGAIN: f64 = 4.0;
/// Share of the changes that come so, of those that come after one hold, and of those that may come too early.
const REGULAR: f64 = 0.85;
const AFTER_ONE: f64 = 0.5;
const EARLY: f64 = 0.05;
/// So many readings are new while the voltage stays.
const FEWEST_OWN: usize = 3;
/// Slow motion changes its reading by one step at a time, however often it is read; a held one goes further at once: so many of the
/// smallest changes, in so many of them.
const FURTHER: f64 = 1.5;
const GO_FURTHER: f64 = 0.5;

/// Keeps of a record with held readings the rows in which they are new, and says so.
pub(super) fn leave_out_held(record: &mut Record) {
    if record.servo.is_some() || record.len() < FEWEST_SAMPLES {
        return;
    }
    let (column, values) = match (&record.angle_rad, &record.speed_rad_s) {
        (Some(angle), None) => ("angle_rad", angle),
        (None, Some(speed)) => ("speed_rad_s", speed),
        // One of them may go on while the other is held.
        _ => return,
    };
    let Some(rows) = held_rows(values, &record.voltage_v) else { return };
    // An angle whose hold the model knows stays as it is.
    if record.angle_rad.is_some() && hold(&record.time_s, values).is_some() {
        return;
    }
    let kept = new_readings(values, rows);
    let enough = kept.len() >= FEWEST_SAMPLES;
    let (count, all) = (kept.len(), record.len());
    let done = if enough {
        format!(
            "the {count} rows in which it is new were kept of {all}, each with the mean voltage until the next"
        )
    } else {
        format!(
            "{count} readings in {all} rows are too few to be kept alone, and what looks like a delay is the age of the last one"
        )
    };
    let warning = Warning {
        place: place_of(record, column),
        what: format!(
            "stale_samples: a new reading comes only every {:.3} ms ({rows:.0} rows), and the last one stands still in between while the motor moves: {done}",
            1e3 * rows * median_interval(&record.time_s)
        ),
        fix: "log when the sensor is read, or read it more often: no delay and no time constant shorter than that shows in this log".into(),
    };
    record.warnings.push(warning);
    if !enough {
        return;
    }
    let means: Vec<f64> = kept.windows(2).map(|pair| mean(&record.time_s, &record.voltage_v, pair)).collect();
    for (k, mean) in kept.iter().zip(means) {
        record.voltage_v[*k] = mean;
    }
    let mut is_kept = vec![false; record.len()];
    kept.iter().for_each(|k| is_kept[*k] = true);
    leave_out(record, |k| !is_kept[k]);
}

/// For how many rows `values` are held in motion under `volts`; none where they are not, or do not show it.
fn held_rows(values: &[f64], volts: &[f64]) -> Option<f64> {
    let changes: Vec<usize> = (1..values.len()).filter(|k| values[*k] != values[*k - 1]).collect();
    let mut runs: Vec<usize> = changes.windows(2).map(|pair| pair[1] - pair[0]).collect();
    if changes.len() < FEWEST_CHANGES {
        return None;
    }
    runs.sort_unstable();
    let shortest = runs[runs.len() / 4] as f64;
    let ones: Vec<f64> =
        runs.iter().map(|run| *run as f64).filter(|run| (run / shortest - 1.0).abs() <= EVEN).collect();
    let rows = ones.iter().sum::<f64>() / ones.len() as f64;
    let moving: Vec<f64> =
        runs.iter().map(|run| *run as f64 / rows).filter(|holds| *holds < SAME_AGAIN + EVEN).collect();
    let share = |is: &dyn Fn(f64) -> bool| {
        moving.iter().filter(|holds| is(**holds)).count() as f64 / moving.len().max(1) as f64
    };
    let is_even = |holds: f64| holds > 1.0 - EVEN && (holds - holds.round()).abs() <= EVEN;
    let is_held = rows > LONGEST
        && moving.len() + 1 >= FEWEST_CHANGES
        && share(&is_even) >= REGULAR
        && share(&|holds| holds.round() == 1.0) >= AFTER_ONE
        && share(&|holds| holds < 1.0 - EVEN) <= EARLY;
    // A motor that keeps a steady speed at each voltage changes it with the voltage only.
    let is_own = |k: &&usize| volts[**k] == volts[k.saturating_sub(rows as usize)];
    let is_read = changes.iter().filter(is_own).count() >= FEWEST_OWN;
    let by: Vec<f64> = changes.iter().map(|k| (values[*k] - values[*k - 1]).abs()).collect();
    let smallest = by.iter().copied().fold(f64::INFINITY, f64::min);
    let further = by.iter().filter(|by| **by > FURTHER * smallest).count() as f64;
    (is_held && is_read && further >= GO_FURTHER * by.len() as f64).then_some(rows)
}

/// The first row, those in which `values` change, and of a time without changes one in every `rows`.
fn new_readings(values: &[f64], rows: f64) -> Vec<usize> {
    let changes = (1..values.len()).filter(|k| values[*k] != values[*k - 1]).chain([values.len()]);
    let (mut kept, mut last) = (Vec::new(), 0);
    for change in changes {
        let holds = (((change - last) as f64 / rows).round() as usize).max(1);
        kept.extend((0..holds).map(|hold| last + (hold as f64 * rows) as usize).filter(|row| *row < change));
        last = change;
    }
    kept
}

/// The mean of `volts` by time, from one row to another; that of the first where the clock begins anew between them.
fn mean(time_s: &[f64], volts: &[f64], rows: &[usize]) -> f64 {
    let (from, to) = (rows[0], rows[1]);
    let steps = || (from..to).map(|k| time_s[k + 1] - time_s[k]);
    if steps().any(|step| step <= 0.0) {
        return volts[from];
    }
    steps().zip(&volts[from..to]).map(|(step, volts)| step * volts).sum::<f64>() / (time_s[to] - time_s[from])
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor under steps, whose speed is read every `hold` rows of 1 ms in whole `quantum`s.
    fn logged(hold: usize, quantum: f64) -> Record {
        let time_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        let voltage_v: Vec<f64> = (0..4000).map(|k| [6.0, -3.0, 9.0, 1.0][k / 500 % 4]).collect();
        let mut speed = 0.0_f64;
        let speeds: Vec<f64> = voltage_v
            .iter()
            .map(|volts| {
                speed += 1e-3 / 0.2 * (2.0 * volts - speed);
                (speed / quantum).round() * quantum
            })
            .collect();
        let held = (0..4000).map(|k| speeds[k - k % hold]).collect();
        Record { time_s, voltage_v, speed_rad_s: Some(held), ..Record::default() }
    }

    #[test]
    fn the_new_readings_of_a_slow_sensor_are_kept_with_the_voltage_between() {
        let mut record = logged(80, 0.1);
        leave_out_held(&mut record);
        assert_eq!(record.len(), 50);
        assert!(record.time_s.iter().enumerate().all(|(k, t)| (t - 0.08 * k as f64).abs() < 1e-9));
        // The step from 6 V to -3 V at 0.5 s, a quarter through the hold from 0.48 s on.
        assert!((record.voltage_v[6] + 0.75).abs() < 1e-9, "{}", record.voltage_v[6]);
        let what = &record.warnings[0].what;
        assert!(what.contains("stale_samples") && what.contains("80.000 ms (80 rows)"), "{what}");
    }

    #[test]
    fn a_speed_of_each_row_stays_however_coarse_it_is() {
        for quantum in [1e-6, 0.1, 0.5] {
            let before = logged(1, quantum);
            let mut record = before.clone();
            leave_out_held(&mut record);
            assert_eq!(record, before, "{quantum}");
        }
        // A ramp in coarse steps: even, and of one step each.
        let mut ramp = logged(1, 1.0);
        ramp.speed_rad_s = Some((0..4000).map(|k| (f64::from(k) / 50.0).floor()).collect());
        let before = ramp.clone();
        leave_out_held(&mut ramp);
        assert_eq!(ramp, before);
    }
}
