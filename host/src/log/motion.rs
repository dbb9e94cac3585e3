//! Signals derived from a record for judging its plausibility; no fit uses them.

use std::ops::Range;

use super::Record;
use super::timing::median_interval;

/// Window over which an angle is turned into a speed, s: long enough to cover several encoder counts.
const WINDOW_S: f64 = 0.05;

/// A motor stands up to this share of its highest speed.
pub const STANDS: f64 = 0.02;

/// The measured speed, or the slope of the measured angle over a window, rad/s, one value per sample.
pub fn speed(record: &Record) -> Vec<f64> {
    match (&record.speed_rad_s, &record.angle_rad) {
        (Some(speed), _) => speed.clone(),
        (None, Some(angle)) => slope(&record.time_s, angle),
        (None, None) => Vec::new(),
    }
}

/// Central difference quotient of `values` over about [`WINDOW_S`].
pub fn slope(time_s: &[f64], values: &[f64]) -> Vec<f64> {
    let last = values.len().saturating_sub(1);
    let reach = ((0.5 * WINDOW_S / median_interval(time_s)).round() as usize).clamp(1, last.max(1));
    (0..values.len())
        .map(|i| {
            let (from, to) = (i.saturating_sub(reach), (i + reach).min(last));
            if to == from { 0.0 } else { (values[to] - values[from]) / (time_s[to] - time_s[from]) }
        })
        .collect()
}

/// The measured angle, or the way of the measured speed, rad, one value per sample.
pub fn angle(record: &Record) -> Vec<f64> {
    match (&record.angle_rad, &record.speed_rad_s) {
        (Some(angle), _) => angle.clone(),
        (None, Some(speed)) => integral(&record.time_s, speed),
        (None, None) => Vec::new(),
    }
}

/// The way that a speed goes, from 0 at the first sample.
fn integral(time_s: &[f64], speed: &[f64]) -> Vec<f64> {
    let mut way = 0.0;
    let steps = time_s.windows(2).zip(speed).map(|(pair, w)| {
        way += w * (pair[1] - pair[0]);
        way
    });
    std::iter::once(0.0).chain(steps).collect()
}

/// First-order low-pass of `values` with time constant `tau_s`, starting at its first value.
pub fn low_pass(time_s: &[f64], values: &[f64], tau_s: f64) -> Vec<f64> {
    let mut state = values.first().copied().unwrap_or_default();
    let mut before = time_s.first().copied().unwrap_or_default();
    time_s
        .iter()
        .zip(values)
        .map(|(&time, &value)| {
            let share = 1.0 - (-(time - before) / tau_s).exp();
            before = time;
            state += share * (value - state);
            state
        })
        .collect()
}

/// Mean value; 0 of none.
pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

/// Correlation coefficient of two signals, -1 to 1; 0 if either does not change.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    cosine(a, b, mean(a), mean(b))
}

/// As [`correlation`], about zero instead of the means: negative where the signals mostly have opposite signs.
pub fn alignment(a: &[f64], b: &[f64]) -> f64 {
    cosine(a, b, 0.0, 0.0)
}

fn cosine(a: &[f64], b: &[f64], origin_a: f64, origin_b: f64) -> f64 {
    let (mut ab, mut aa, mut bb) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - origin_a, y - origin_b);
        ab += x * y;
        aa += x * x;
        bb += y * y;
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

/// The stretches of `count` samples in which something `holds`.
pub fn stretches(count: usize, holds: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
    let mut found = Vec::new();
    let mut begin = 0;
    for k in 0..=count {
        if k < count && holds(k) {
            continue;
        }
        if k > begin {
            found.push(begin..k);
        }
        begin = k + 1;
    }
    found
}

/// The runs of equal numbers in `values`.
pub fn runs(values: &[f64]) -> Vec<Range<usize>> {
    let mut end = 0;
    let run = |same: &[f64]| {
        end += same.len();
        end - same.len()..end
    };
    values.chunk_by(|one, next| one == next).map(run).collect()
}

/// The different ones of some values, in order.
pub fn different(values: impl IntoIterator<Item = f64>) -> Vec<f64> {
    let mut sorted: Vec<f64> = values.into_iter().collect();
    sorted.sort_unstable_by(f64::total_cmp);
    sorted.dedup();
    sorted
}

/// Smallest and largest value.
pub fn ends(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), v| (low.min(*v), high.max(*v)))
}

/// Largest minus smallest value.
pub fn span(values: &[f64]) -> f64 {
    let (low, high) = ends(values);
    if low <= high { high - low } else { 0.0 }
}

/// Largest magnitude.
pub fn peak(values: &[f64]) -> f64 {
    values.iter().fold(0.0, |peak: f64, v| peak.max(v.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn different_values_come_once_each_and_in_order() {
        assert_eq!(different([2.0, -1.0, 2.0, 0.0, -1.0]), [-1.0, 0.0, 2.0]);
    }

    #[test]
    fn stretches_end_where_something_no_longer_holds_and_where_the_samples_end() {
        let holds = [true, true, false, false, true, false, true];
        assert_eq!(stretches(holds.len(), |k| holds[k]), [0..2, 4..5, 6..7]);
        assert_eq!(stretches(0, |_| true), Vec::<Range<usize>>::new());
    }
}
