//! How long a sensor holds its readings, and how old they are when a record begins.
//!
//! A reading that is updated every `time` seconds changes only in the samples that follow an update, whatever the motor
//! does. So the instants of its changes, turned around a circle once every `time`, crowd on one side of it: where, tells
//! the age; how sharply the crowd depends on `time`, its precision, which is a small part of a sample over a record.

use std::f64::consts::TAU;

use super::timing::mean_interval;

/// A sensor that holds its readings.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hold {
    /// For how long, s.
    pub time_s: f64,
    /// How old the reading of the first sample is, s.
    pub age_s: f64,
    /// Changes that tell it.
    pub changes: usize,
}

/// Changes that a record must show.
const FEWEST_CHANGES: usize = 60;
/// Longest hold that is fitted, samples.
pub(super) const LONGEST: f64 = 64.0;
/// A hold shorter than this many samples skips too few of them.
const SHORTEST: f64 = 1.03;
/// A change by this many of the smallest would have shown sooner, were the reading not held.
const FAST: f64 = 2.5;
/// Of the crowd that even updates make, at least this share; and so many times what chance makes.
const CROWD: f64 = 0.75;
const ABOVE_CHANCE: f64 = 5.0;
/// Of two changes in a row, this share may come early: stamps jitter.
const EARLY: f64 = 0.01;

/// The hold of the readings `values` at `time_s`; none where they are not held, or do not show it.
pub fn hold(time_s: &[f64], values: &[f64]) -> Option<Hold> {
    let changes = changes(time_s, values);
    if changes.len() < FEWEST_CHANGES {
        return None;
    }
    let interval = mean_interval(time_s);
    let (about, unsure) = coarse(&changes)?;
    let duration = changes[changes.len() - 1].middle - changes[0].middle;
    // A turn more or less over the record is another beat; a quarter of one blurs the crowd little.
    let per_turn = about * interval / duration;
    let steps = (4.0 * unsure / per_turn).ceil().min(4000.0);
    let spacing = if steps > 0.0 { unsure / steps } else { 0.0 };
    let rough = about * interval / most_crowded(&changes, 1.0 / (about * interval), spacing, steps as usize);
    let reach = 0.25 * per_turn * rough;
    let time_s = top([rough - reach, rough + reach], |time_s| crowd(&changes, time_s).0);
    let (size, phase) = crowd(&changes, time_s);
    let half = std::f64::consts::PI * interval / time_s;
    let chance = 1.0 / (changes.len() as f64).sqrt();
    (size > CROWD * half.sin().abs() / half && size > ABOVE_CHANCE * chance).then_some(Hold {
        time_s,
        age_s: (1.0 - phase) * time_s,
        changes: changes.len(),
    })
}

/// The age of the first reading where the hold is known to be `time_s`.
pub fn age(time_s: &[f64], values: &[f64], hold_s: f64) -> f64 {
    (1.0 - crowd(&changes(time_s, values), hold_s).1) * hold_s
}

/// The last time before every change of `values` and the first behind it, s after the first sample.
pub fn around_changes(time_s: &[f64], values: &[f64]) -> Vec<[f64; 2]> {
    let around = |c: Change| [time_s[c.sample - 1] - time_s[0], time_s[c.sample] - time_s[0]];
    changes(time_s, values).into_iter().map(around).collect()
}

/// A sample that differs from the one before.
struct Change {
    sample: usize,
    /// Half way between the two, s after the first sample.
    middle: f64,
    by: f64,
}

fn changes(time_s: &[f64], values: &[f64]) -> Vec<Change> {
    (1..values.len())
        .filter(|k| values[*k] != values[*k - 1])
        .map(|k| Change {
            sample: k,
            middle: 0.5 * (time_s[k - 1] + time_s[k]) - time_s[0],
            by: (values[k] - values[k - 1]).abs(),
        })
        .collect()
}

/// Mean distance of updates in fast motion, in samples, and the share of it by which that may be wrong.
fn coarse(changes: &[Change]) -> Option<(f64, f64)> {
    let smallest = changes.iter().map(|c| c.by).fold(f64::MAX, f64::min);
    let fast = |c: &Change| c.by > FAST * smallest;
    let distance = |pair: &[Change]| pair[1].sample - pair[0].sample;
    let pairs = || changes.windows(2).filter(|pair| pair.iter().all(fast)).map(distance);
    let mut sorted: Vec<usize> = pairs().collect();
    if sorted.len() < FEWEST_CHANGES {
        return None;
    }
    sorted.sort_unstable();
    // The shortest distances of fast motion are one hold each; a stop between two changes makes longer ones.
    let low = sorted[(EARLY * sorted.len() as f64) as usize];
    let whole: Vec<usize> = sorted.iter().copied().filter(|d| *d <= low + 1).collect();
    let about = whole.iter().sum::<usize>() as f64 / whole.len() as f64;
    // Every row of changes in fast motion is known to within a sample at its ends.
    let rows = changes.windows(2).filter(|pair| fast(&pair[1]) && !fast(&pair[0])).count() + 1;
    let all_early = changes.windows(2).filter(|pair| distance(pair) < low).count();
    let honest = (all_early as f64) < EARLY.max(1.5 / changes.len() as f64) * changes.len() as f64;
    let held = (SHORTEST..LONGEST).contains(&about) && 2 * whole.len() > sorted.len() && honest;
    held.then_some((about, 3.0 * (rows as f64).sqrt() / (about * whole.len() as f64)))
}

/// How closely the changes crowd when turned around once every `time_s` (0 ..= 1), and where (in turns, 0 .. 1).
fn crowd(changes: &[Change], time_s: f64) -> (f64, f64) {
    let (mut x, mut y) = (0.0, 0.0);
    for change in changes {
        let (sine, cosine) = (TAU * (change.middle / time_s).fract()).sin_cos();
        x += cosine;
        y += sine;
    }
    (x.hypot(y) / changes.len() as f64, (y.atan2(x) / TAU).rem_euclid(1.0))
}

/// Of the rates `rate` (1 + k `spacing`), k from -`steps` to `steps`, the one at which the changes crowd most, over `rate`.
///
/// Each change is turned on from rate to rate by a rotation, which costs a product in the place of a sine.
fn most_crowded(changes: &[Change], rate: f64, spacing: f64, steps: usize) -> f64 {
    let first = 1.0 - steps as f64 * spacing;
    let mut sums = vec![[0.0; 2]; 2 * steps + 1];
    for change in changes {
        let turns = change.middle * rate;
        let [(mut y, mut x), (up, along)] = [first, spacing].map(|by| (TAU * (turns * by).fract()).sin_cos());
        for sum in &mut sums {
            sum[0] += x;
            sum[1] += y;
            (x, y) = (x * along - y * up, y * along + x * up);
        }
    }
    let crowd = |[x, y]: &[f64; 2]| x.hypot(*y);
    let best = (0..sums.len()).max_by(|a, b| crowd(&sums[*a]).total_cmp(&crowd(&sums[*b]))).unwrap_or(steps);
    first + best as f64 * spacing
}

/// Where between two ends `of`, which rises to one top and falls again, is largest: by thirds.
pub(super) fn top([mut low, mut high]: [f64; 2], of: impl Fn(f64) -> f64) -> f64 {
    for _ in 0..40 {
        let (a, b) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
        if of(a) < of(b) { low = a } else { high = b }
    }
    0.5 * (low + high)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motion with stops and turns, counted, and read every `hold` seconds, `age` seconds before the first sample.
    fn readings(interval: f64, seconds: f64, hold: f64, age: f64) -> (Vec<f64>, Vec<f64>) {
        let time_s: Vec<f64> = (0..(seconds / interval) as usize).map(|k| k as f64 * interval).collect();
        let angle = |t: f64| (3.0 * (1.3 * t).sin() + 2.0 * (4.1 * t + 1.0).sin()).max(-2.0);
        let read = |t: &f64| if hold > 0.0 { ((t + age) / hold + 1e-9).floor() * hold - age } else { *t };
        let values = time_s.iter().map(|t| (angle(read(t)) / 1e-3).floor() * 1e-3).collect();
        (time_s, values)
    }

    #[test]
    fn time_and_age_of_held_readings_are_found_whatever_the_beat() {
        for (interval, hold_s, age_s) in
            [(1e-3, 3.557e-3, 1.2e-3), (2e-3, 2.288e-3, 0.3e-3), (1e-2, 3e-2, 0.0), (5e-3, 0.02, 0.011)]
        {
            let (time_s, values) = readings(interval, 12.0, hold_s, age_s);
            let found = hold(&time_s, &values).unwrap_or_else(|| panic!("{hold_s} s went unseen"));
            assert!((found.time_s / hold_s - 1.0).abs() < 3e-5, "{} for {hold_s}", found.time_s);
            let wrong = (found.age_s - age_s) / hold_s;
            let wrong = (wrong - wrong.round()).abs() * hold_s;
            // Updates at the samples themselves are known to within one of them.
            assert!(wrong < 0.51 * interval, "{} s old for {age_s}", found.age_s);
        }
    }

    /// Every change bounds them: together to a hundredth of what the crowd's mean makes of it.
    #[test]
    fn the_changes_of_a_long_hold_tell_it_to_a_millionth() {
        use crate::log::beat::{Numbers, hold_of};
        let (interval, hold_s, age_s) = (2e-3, 0.014_491_03, 0.004);
        let (time_s, values) = readings(interval, 12.0, hold_s, age_s);
        let rough = hold(&time_s, &values).unwrap();
        let around = around_changes(&time_s, &values);
        let numbers = |hold_s: f64| Numbers::of_changes(&around, hold_s, rough.age_s);
        let sharp = hold_of(&[numbers(rough.time_s)], rough.time_s);
        assert!((sharp / hold_s - 1.0).abs() < 1e-6, "{sharp} for {hold_s}");
        let known = numbers(sharp);
        assert!(known.agree(sharp) && !known.agree(1.001 * sharp));
        let age = known.age(sharp).unwrap();
        assert!((age - age_s).abs() < 0.01 * interval, "{age} for {age_s}");
    }

    #[test]
    fn readings_that_are_not_held_show_none() {
        for interval in [1e-3, 2e-3, 1e-2] {
            let (time_s, values) = readings(interval, 12.0, 0.0, 0.0);
            assert_eq!(hold(&time_s, &values), None);
        }
        // A steady speed makes even changes, of one count each.
        let time_s: Vec<f64> = (0..6000).map(|k| f64::from(k) * 1e-3).collect();
        let steady: Vec<f64> = time_s.iter().map(|t| (t * 0.31 / 1e-3).floor() * 1e-3).collect();
        assert_eq!(hold(&time_s, &steady), None);
    }
}
