//! The clock among columns without names, or with few: what rises evenly and numbers no rows.

use super::FEWEST;
use crate::log::guess::clocks::RISES;
use crate::log::guess::{symbols, words};
use crate::log::motion::peak;
use crate::log::numbered::counts_rows;
use crate::log::timing::{jitter, median_interval};

/// Share of the steps of a clock that are about as long as the middle one.
const EVEN: f64 = 0.8;

/// The column that rises most evenly, of those that are called a time if any does, but for one that numbers the rows.
pub(super) fn clock(columns: &[Vec<f64>], names: &[String]) -> Option<usize> {
    let unevenness = |values: &Vec<f64>| {
        let middle = median_interval(values);
        let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
        let share = |holds: &dyn Fn(f64) -> bool| {
            steps().filter(|step| holds(*step)).count() as f64 / (values.len() - 1).max(1) as f64
        };
        let is_clock = middle > 0.0
            && share(&|step| step > 0.0) >= RISES
            && share(&|step| (0.5 * middle..=2.0 * middle).contains(&step)) >= EVEN;
        is_clock.then(|| jitter(values) / middle)
    };
    let is_called = |k: usize, so: &dyn Fn(&str) -> bool| names.get(k).is_some_and(|name| so(name));
    let may_be = |k: usize, values: &[f64]| {
        values.len() >= FEWEST && !counts_rows(values) && !is_called(k, &symbols::is_no_time)
    };
    let clocks = columns.iter().enumerate().filter(|(k, values)| may_be(*k, values));
    let clocks =
        clocks.filter_map(|(k, values)| Some((!is_called(k, &words::is_time), unevenness(values)?, k)));
    clocks.min_by(|one, other| one.0.cmp(&other.0).then(one.1.total_cmp(&other.1))).map(|(_, _, k)| k)
}

/// Seconds and, in the column behind them, the nanoseconds of those, as `ros2 topic echo --csv` prints a stamp: the place of the seconds.
pub(super) fn seconds_apart(columns: &[Vec<f64>]) -> Option<usize> {
    let is_whole = |values: &[f64]| values.iter().all(|value| value.fract() == 0.0 && *value >= 0.0);
    let are_apart = |seconds: &[f64], rest: &[f64]| {
        let steps = || seconds.windows(2).zip(rest.windows(2));
        let rises =
            |(one, other): &(&[f64], &[f64])| one[1] > one[0] || one[1] == one[0] && other[1] > other[0];
        let stays = steps().filter(|(one, _)| one[1] == one[0]).count();
        let long = peak(rest) >= LONG_NS || seconds.first().is_some_and(|first| *first >= EPOCH_S);
        seconds.len() >= FEWEST
            && is_whole(seconds)
            && is_whole(rest)
            && peak(rest) < NS
            && long
            && 2 * stays >= seconds.len() - 1
            && steps().filter(rises).count() as f64 >= RISES * (seconds.len() - 1) as f64
            && seconds.windows(2).all(|pair| pair[1] >= pair[0])
    };
    columns.windows(2).position(|pair| are_apart(&pair[0], &pair[1]))
}

/// The times of both, in the place of the seconds; what they are apart from them changes nowhere.
pub(super) fn joined(columns: &[Vec<f64>], seconds: usize) -> Vec<Vec<f64>> {
    let mut columns = columns.to_vec();
    let rest = std::mem::take(&mut columns[seconds + 1]);
    columns[seconds + 1] = vec![0.0; rest.len()];
    let begin = columns[seconds].first().copied().unwrap_or(0.0);
    for (time, rest) in columns[seconds].iter_mut().zip(rest) {
        *time = *time - begin + rest / NS;
    }
    columns
}

/// Nanoseconds of a second; those of a log reach this many at least, or stand beside seconds of the epoch (2001 and later).
const NS: f64 = 1e9;
const LONG_NS: f64 = 5e8;
const EPOCH_S: f64 = 1e9;

/// Whether what rises evenly in column `k` may be an encoder's count: it stands at times, as no clock does, and another column numbers the
/// rows.
pub(super) fn stands_beside_row_numbers(columns: &[Vec<f64>], k: usize) -> bool {
    columns[k].windows(2).any(|pair| pair[1] == pair[0]) && columns.iter().any(|values| counts_rows(values))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn seconds_and_their_nanoseconds_are_told_from_a_count_beside_another() {
        let columns = |row: &dyn Fn(f64) -> [f64; 2]| -> Vec<Vec<f64>> {
            let rows: Vec<[f64; 2]> = (0..300).map(|k| row(f64::from(k))).collect();
            (0..2).map(|k| rows.iter().map(|row| row[k]).collect()).collect()
        };
        let ros = columns(&|k: f64| [1.7e9 + (k / 100.0).floor(), 1e7 * (k % 100.0)]);
        assert_eq!(seconds_apart(&ros), Some(0));
        let times = joined(&ros, 0);
        assert!((times[0][299] - 2.99).abs() < 1e-9 && times[1].iter().all(|rest| *rest == 0.0));
        for row in [
            &(|k: f64| [10.0 * k, (20.0 * k) % 4096.0]) as &dyn Fn(f64) -> [f64; 2],
            &|k: f64| [(k / 10.0).floor(), 7.0 * k],
            &|k: f64| [5.0, 1e6 * k],
            &|k: f64| [(k / 100.0).floor(), 1e7 * (300.0 - k)],
        ] {
            assert_eq!(seconds_apart(&columns(row)), None);
        }
    }
}
