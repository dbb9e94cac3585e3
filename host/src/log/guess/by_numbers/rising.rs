//! The clock among columns without names, or with few: what rises evenly and numbers no rows.

use super::FEWEST;
use crate::log::guess::clocks::RISES;
use crate::log::guess::{symbols, words};
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

/// Whether what rises evenly in column `k` may be an encoder's count: it stands at times, as no clock does, and another column numbers the
/// rows.
pub(super) fn stands_beside_row_numbers(columns: &[Vec<f64>], k: usize) -> bool {
    columns[k].windows(2).any(|pair| pair[1] == pair[0]) && columns.iter().any(|values| counts_rows(values))
}
