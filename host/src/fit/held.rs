//! For how long the sensor holds its readings: what the records agree on.

use super::grid::{Grid, Quantity};
use crate::log::beat::{self, Numbers, Shown, hold_of};
use crate::log::hold::{self, Hold};

/// Holds are the same within this share.
const SAME: f64 = 2e-4;
/// With so many records that move otherwise than they should, and none that a hold explains, no more are asked.
const ENOUGH_OTHERWISE: usize = 3;

/// For how long the sensor holds its readings, s, where most records agree on it; each learns how old its first one is.
pub(super) fn held(grids: &mut [Grid]) -> Option<f64> {
    let angles = || grids.iter().filter(|grid| grid.quantity == Quantity::Angle);
    let long: Vec<Hold> = angles().filter_map(|grid| hold::hold(&grid.time_s, &grid.measured)).collect();
    let about = agreed(&long, angles().count().div_ceil(2)).or_else(|| {
        let (short, otherwise) = beats(angles());
        agreed(&short, otherwise + 1)
    })?;
    let numbers: Vec<Numbers> = angles().map(|grid| numbers(grid, about, rough_age(grid, about))).collect();
    let sharp = hold_of(&numbers, about);
    // Stamps that are wrong by more than the hold contradict one another: then the crowd of all changes knows better.
    let long = angles().all(|grid| !beat::tells(&grid.time_s, about));
    let time = if long && !numbers.iter().all(|n| n.agree(sharp)) { about } else { sharp };
    date(grids, time);
    Some(time)
}

/// Tells every record how old its first reading is where they are held for `time` seconds.
pub(super) fn date(grids: &mut [Grid], time: f64) {
    for grid in grids.iter_mut().filter(|grid| grid.quantity == Quantity::Angle) {
        let rough = rough_age(grid, time);
        let numbers = numbers(grid, time, rough);
        let contradicted = !beat::tells(&grid.time_s, time) && !numbers.agree(time);
        grid.reading_age_s = if contradicted { rough } else { numbers.age(time).unwrap_or(rough) };
    }
}

/// How old the first reading of `grid` is, from the crowd of its renewals.
fn rough_age(grid: &Grid, time: f64) -> f64 {
    if beat::tells(&grid.time_s, time) {
        beat::age(&grid.time_s, &grid.measured, grid.quantum, time)
    } else {
        hold::age(&grid.time_s, &grid.measured, time)
    }
}

/// The renewals that the samples of `grid` show, the hold being nearly `about` seconds and the first reading nearly `age` old.
fn numbers(grid: &Grid, about: f64, age: f64) -> Numbers {
    if beat::tells(&grid.time_s, about) {
        Numbers::new(&grid.time_s, &grid.measured, grid.quantum, about, age)
    } else {
        Numbers::of_changes(&hold::around_changes(&grid.time_s, &grid.measured), about, age)
    }
}

/// The holds that beats with the samples show, the first found being tried on the other records; and how many records
/// it does not explain.
fn beats<'a>(angles: impl Iterator<Item = &'a Grid>) -> (Vec<Hold>, usize) {
    let (mut found, mut otherwise) = (Vec::<Hold>::new(), 0);
    for grid in angles {
        let known = found.first().map(|hold| hold.time_s);
        match beat::beat(&grid.time_s, &grid.measured, grid.quantum, known) {
            Shown::Nothing => {}
            Shown::Otherwise => otherwise += 1,
            Shown::Held(hold) => found.push(hold),
        }
        if found.is_empty() && otherwise == ENOUGH_OTHERWISE {
            break;
        }
    }
    (found, otherwise)
}

/// The mean of holds that are all the same, where there are as many as it takes.
fn agreed(found: &[Hold], fewest: usize) -> Option<f64> {
    let weight: f64 = found.iter().map(|hold| hold.changes as f64).sum();
    let time = found.iter().map(|hold| hold.time_s * hold.changes as f64).sum::<f64>() / weight;
    let same = found.iter().all(|hold| (hold.time_s / time - 1.0).abs() < SAME);
    (found.len() >= fewest.max(1) && same).then_some(time)
}
