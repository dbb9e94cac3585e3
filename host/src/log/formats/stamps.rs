//! The stamps of a table of values that were logged each at its own time.
//!
//! A motion is known at its own stamps and nowhere between them; what drives the motor holds from its own stamps on. So the rows are those of
//! the motion, and of the drive where it changes between them.

use super::events::Series;
use crate::log::robot_loop::{held_at, turn_of};
use crate::log::timing::median_interval;

/// Stamps of one clock are this share of an interval or less off an even spacing, of at least this share of the stamps.
const OFF_BEAT: f64 = 0.25;
const ON_BEAT: f64 = 0.9;
/// Of a longer pause nothing is known of the interval.
const LONGEST_COUNTED: f64 = 10.0;
/// A motion that stood still meanwhile goes on by no more than this many times what it did around the pause, ...
const GOES_ON: f64 = 1.5;
/// ... or by one step of its sensor. Where more than this share of the pauses is otherwise, readings were lost.
const ONE_STEP: f64 = 1.5;
const MOST_LOST: f64 = 0.25;
/// More readings than this are not filled in.
const MOST_FILLED: f64 = 4e6;
/// Between readings further apart than this many intervals another motion is not known.
const FURTHEST: f64 = 3.0;

/// Values with their times.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Readings {
    /// Times, s.
    pub times: Vec<f64>,
    /// As many values.
    pub values: Vec<f64>,
}

impl Readings {
    /// Those of a motion, with those that its logger left out because they repeat the one before.
    ///
    /// Such a logger writes no value twice in a row, keeps to an even interval, and what it left out is a motion that stood still: it goes on after
    /// a pause as slowly as it stopped, or as fast as a motor may that was driven then. Where readings were lost on the way, it does not.
    pub fn of_motion(series: &Series) -> Readings {
        let count = series.numbers.len().min(series.times.len());
        let plain =
            Readings { times: series.times[..count].to_vec(), values: series.numbers[..count].to_vec() };
        let interval = median_interval(&plain.times);
        let repeats = plain.values.windows(2).any(|pair| pair[0] == pair[1]);
        if count < 3 || interval <= 0.0 || repeats || !plain.keeps_to(interval) {
            return plain;
        }
        let change = |k: usize| (plain.values[k + 1] - plain.values[k]).abs();
        let turns = |k: usize| ((plain.times[k + 1] - plain.times[k]) / interval).round();
        let places = || 0..count - 1;
        let step = places().map(change).fold(f64::MAX, f64::min);
        let fastest = places().filter(|k| turns(*k) < 2.0).map(change).fold(0.0, f64::max);
        let stood = |k: &usize| {
            let around = [k.checked_sub(1), (k + 2 < count).then_some(k + 1)];
            let usual = around.into_iter().flatten().map(change).fold(0.0, f64::max);
            change(*k) <= (ONE_STEP * step).max(GOES_ON * usual)
        };
        let pauses = places().filter(|k| turns(*k) >= 2.0);
        let (still, lost): (Vec<usize>, Vec<usize>) = pauses.partition(stood);
        if (lost.len() as f64) > MOST_LOST * (still.len() + lost.len()) as f64 {
            return plain;
        }
        let mut filled = Readings::default();
        let mut room = MOST_FILLED;
        for k in 0..count {
            filled.times.push(plain.times[k]);
            filled.values.push(plain.values[k]);
            if k + 1 == count
                || turns(k) < 2.0
                || lost.binary_search(&k).is_ok() && change(k) > GOES_ON * fastest
            {
                continue;
            }
            room -= turns(k);
            if room < 0.0 {
                continue;
            }
            let (begin, pause) = (plain.times[k], plain.times[k + 1] - plain.times[k]);
            for turn in 1..turns(k) as usize {
                filled.times.push(begin + pause * turn as f64 / turns(k));
                filled.values.push(plain.values[k]);
            }
        }
        filled
    }

    /// Whether the pauses between the readings are whole numbers of `interval`.
    fn keeps_to(&self, interval: f64) -> bool {
        let turns = self.times.windows(2).map(|pair| (pair[1] - pair[0]) / interval);
        let counted: Vec<f64> = turns.filter(|turns| *turns < LONGEST_COUNTED).collect();
        let on = counted.iter().filter(|turns| (*turns - turns.round()).abs() <= OFF_BEAT).count();
        on as f64 >= ON_BEAT * counted.len() as f64
    }

    /// What was read at each of `stamps`: in the same turn of a loop, or on the straight way between two readings; NaN where those are too far
    /// apart.
    pub fn at(&self, stamps: &[f64], turn_s: f64) -> Vec<f64> {
        let furthest = FURTHEST * median_interval(&self.times);
        let value = |stamp: &f64| {
            let Some(before) = held_at(&self.times, stamp + turn_s) else { return f64::NAN };
            let (time, value) = (self.times[before], self.values[before]);
            if (stamp - time).abs() <= turn_s {
                return value;
            }
            match (self.times.get(before + 1), self.values.get(before + 1)) {
                (Some(next), Some(then)) if next - time <= furthest => {
                    value + (then - value) * (stamp - time) / (next - time)
                }
                _ => f64::NAN,
            }
        };
        stamps.iter().map(value).collect()
    }
}

/// The stamps of `motion` and those of what drives the motor that are in no turn of its loop, in order, and whether each is one of the motion.
pub fn joined<'v>(motion: &[f64], drives: impl Iterator<Item = &'v [f64]>) -> Vec<(f64, bool)> {
    let turn_s = turn_of(median_interval(motion));
    let mut all: Vec<(f64, bool)> = motion.iter().map(|time| (*time, true)).collect();
    for times in drives {
        let is_between = |time: &&f64| {
            held_at(motion, **time + turn_s).is_none_or(|k| (**time - motion[k]).abs() > turn_s)
        };
        all.extend(times.iter().filter(is_between).map(|time| (*time, false)));
    }
    all.sort_by(|a, b| a.0.total_cmp(&b.0).then(b.1.cmp(&a.1)));
    all.dedup_by(|later, earlier| later.0 == earlier.0);
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn series(times: &[f64], numbers: &[f64]) -> Series {
        Series { times: times.to_vec(), numbers: numbers.to_vec(), ..Series::default() }
    }

    #[test]
    fn a_motion_that_stood_still_is_known_and_one_that_was_lost_on_the_way_is_not() {
        // At rest, off it goes and comes to rest three times; then it goes on at 1 a turn, and three turns are lost.
        let stops = [0.0, 0.25, 1.0, 1.75, 2.5, 3.0];
        let mut all: Vec<(f64, f64)> = (0..3)
            .flat_map(|stop| stops.map(|value| 3.25 * f64::from(stop) + value))
            .enumerate()
            .map(|(k, value)| (k as f64 + 4.0 * (k / 6) as f64, value))
            .collect();
        let lost = [(30.0, 9.75), (31.0, 10.5), (32.0, 11.5), (36.0, 15.5), (37.0, 16.5)];
        all.extend(lost);
        let of = |all: &[(f64, f64)]| {
            let (times, values): (Vec<f64>, Vec<f64>) = all.iter().copied().unzip();
            Readings::of_motion(&series(&times, &values))
        };
        let read = of(&all);
        assert_eq!(read.times[4..12], [4.0, 5.0, 6.0, 7.0, 8.0, 9.0, 10.0, 11.0]);
        assert_eq!(read.values[5..12], [3.0, 3.0, 3.0, 3.0, 3.0, 3.25, 3.5]);
        assert_eq!(read.times[read.times.len() - 3..], [32.0, 36.0, 37.0]);
        // One who writes a value twice leaves nothing out, and one who loses readings here and there does not stand still.
        all[8].1 = all[7].1;
        assert_eq!(of(&all).times.len(), all.len());
        let lossy: Vec<(f64, f64)> = (0..90)
            .filter(|k| k % 7 != 3)
            .map(|k| (f64::from(k), f64::from(k) + 0.1 * f64::from(k % 3)))
            .collect();
        assert_eq!(of(&lossy).times.len(), lossy.len());
    }

    #[test]
    fn the_drive_has_rows_of_its_own_where_it_changes_between_two_readings() {
        let rows = joined(&[0.0, 0.02, 0.04], [[0.001, 0.0195, 0.03].as_slice()].into_iter());
        assert_eq!(rows, [(0.0, true), (0.02, true), (0.03, false), (0.04, true)]);
    }

    #[test]
    fn another_motion_is_read_between_its_own_stamps_and_not_beyond_them() {
        let read = Readings { times: vec![0.0, 1.0, 2.0, 9.0], values: vec![0.0, 2.0, 4.0, 5.0] };
        let at = read.at(&[0.5, 1.001, 5.0, 9.5], 0.002);
        assert_eq!(at[..2], [1.0, 2.0]);
        assert!(at[2].is_nan() && at[3].is_nan());
    }
}
