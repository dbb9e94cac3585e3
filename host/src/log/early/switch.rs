//! One switch of the voltage from a level to another, and what a first-order motor leaves of the motion around it, switched at any instant.

use crate::log::Record;
use crate::log::motion::{mean, peak};
use crate::log::timing::median_interval;
use crate::search::golden::lowest;

/// Rows before a switch and from it on that are looked at, and the fewest that tell.
const BEFORE: usize = 4;
const FEWEST_BEFORE: usize = 3;
const AFTER: usize = 16;
const FEWEST_AFTER: usize = 7;
/// A switch changes the voltage by more than this share of the highest one; a level stays within this share of it.
const SWITCHES: f64 = 0.3;
const STAYS: f64 = 0.02;
/// Rows this many usual intervals apart have a gap between them.
const GAP: f64 = 1.5;
/// Time constants that are tried, rows: the shortest, each so many times the one before, and how many.
const SHORTEST: f64 = 0.15;
const RATIO: f64 = 1.3;
const TIMES: i32 = 22;

/// The rows around one switch of the voltage.
pub(super) struct Switch {
    /// Times after the row that shows it, in rows.
    times: Vec<f64>,
    /// What was measured then, from the first of them on.
    values: Vec<f64>,
    /// Whether that is an angle.
    is_angle: bool,
    /// Sum of its squares about its mean.
    variation: f64,
    /// By how much the voltage changes, V.
    step_v: f64,
    /// Time from row to row, s.
    pub interval_s: f64,
}

impl Switch {
    /// All switches of `record` from one level to another that moved the motor.
    pub fn all(record: &Record) -> Vec<Self> {
        let (time, volts) = (&record.time_s, &record.voltage_v);
        let (measured, is_angle) = match (&record.angle_rad, &record.speed_rad_s) {
            (Some(angle), _) => (angle, true),
            (None, Some(speed)) => (speed, false),
            (None, None) => return Vec::new(),
        };
        let (interval_s, highest) = (median_interval(time), peak(volts));
        let near = STAYS * highest;
        let around = |row: usize| {
            let step_v = volts[row] - volts[row - 1];
            if step_v.abs() <= SWITCHES * highest {
                return None;
            }
            let before = level(volts[..row].iter().rev().take(BEFORE), near);
            let after = level(volts[row..].iter().take(AFTER + 1), near);
            // The last row of a level may show the next switch already.
            let after = if row + after == volts.len() { after } else { after - 1 };
            let rows = row - before..row + after;
            let is_even = time[rows.clone()].windows(2).all(|pair| pair[1] - pair[0] < GAP * interval_s);
            if before < FEWEST_BEFORE || after < FEWEST_AFTER || !is_even {
                return None;
            }
            let values: Vec<f64> = measured[rows.clone()].iter().map(|x| x - measured[rows.start]).collect();
            let mean = mean(&values);
            let variation: f64 = values.iter().map(|x| (x - mean).powi(2)).sum();
            let times = time[rows].iter().map(|t| (t - time[row]) / interval_s).collect();
            (variation > 0.0).then_some(Self { times, values, is_angle, variation, step_v, interval_s })
        };
        (1..volts.len()).filter_map(around).collect()
    }

    /// Share of the motion's variation that a first-order motor leaves which is switched at `instants`, a part of the step at each, and its time
    /// constant in rows: that which leaves least.
    pub fn left(&self, instants: &[f64]) -> (f64, f64) {
        let time = |k: i32| SHORTEST * RATIO.powi(k);
        let best = least_of((0..TIMES).map(|k| self.left_by(time(k), instants))) as i32;
        lowest([time(best - 1), time(best + 1)], |tau| self.left_by(tau, instants))
    }

    /// The same of one time constant; all of it where the motor would turn against its voltage.
    fn left_by(&self, tau: f64, instants: &[f64]) -> f64 {
        // A step of one at a motor at rest, so many rows ago.
        let answer = |since: f64| {
            let since = since.max(0.0);
            let speed = 1.0 - (-since / tau).exp();
            if self.is_angle { since - tau * speed } else { speed }
        };
        let first = self.times[0];
        let column = |of: &dyn Fn(f64) -> f64| self.times.iter().map(|t| of(*t)).collect::<Vec<f64>>();
        // From where the motor was and however fast it turned, under the voltage and the load that it had.
        let mut columns = vec![column(&|_| 1.0)];
        if self.is_angle {
            columns.push(column(&|t| t - first));
        }
        columns.push(column(&|t| answer(t - first)));
        columns.push(column(&|t| instants.iter().map(|at| answer(t - at)).sum::<f64>()));
        let (squares, change) = unexplained(columns, self.values.clone());
        if change * self.step_v > 0.0 { squares / self.variation } else { 1.0 }
    }
}

/// How many of `volts`, from the first on, are one level within `near`.
fn level<'a>(volts: impl Iterator<Item = &'a f64>, near: f64) -> usize {
    let mut first = None;
    volts.take_while(|v| (**v - *first.get_or_insert(**v)).abs() <= near).count()
}

/// What no sum of `columns` explains of `values`: its sum of squares, and the factor of the last column (Gram-Schmidt).
fn unexplained(mut columns: Vec<Vec<f64>>, mut values: Vec<f64>) -> (f64, f64) {
    let mut factor = 0.0;
    for k in 0..columns.len() {
        let axis = std::mem::take(&mut columns[k]);
        let size = product(&axis, &axis);
        if size < 1e-18 {
            factor = 0.0;
            continue;
        }
        for column in &mut columns[k + 1..] {
            let along = product(column, &axis) / size;
            column.iter_mut().zip(&axis).for_each(|(x, a)| *x -= along * a);
        }
        factor = product(&values, &axis) / size;
        values.iter_mut().zip(&axis).for_each(|(x, a)| *x -= factor * a);
    }
    (product(&values, &values), factor)
}

fn product(one: &[f64], other: &[f64]) -> f64 {
    one.iter().zip(other).map(|(a, b)| a * b).sum()
}

/// Which of `values` is lowest.
pub(super) fn least_of(values: impl Iterator<Item = f64>) -> usize {
    values.enumerate().min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0, |(place, _)| place)
}
