//! For how long the sensor holds its readings: what the records agree on.

use super::grid::{Grid, Place, Quantity};
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
        if !contradicted {
            settle_on_ends(grid, time);
        }
    }
}

/// A stamp may be wrong by this share of the samples' interval.
const STAMP: f64 = 0.4;
/// A cell that ends within this share of itself of an update may show either reading.
const EITHER: f64 = 0.02;

/// Puts every sample on the end of a cell in the hold that its reading shows.
///
/// Within a hold a reading stays what it is, but between the ends of a cell with an update it would be taken for a blend of two;
/// and a stamp that is a little wrong may lie on the other side of an update than its reading.
fn settle_on_ends(grid: &mut Grid, time: f64) {
    let step = grid.step_s;
    let near = (STAMP * grid.interval_s / time).min(0.5);
    let changes = |k: usize| k > 0 && grid.measured.get(k).is_some_and(|y| *y != grid.measured[k - 1]);
    let hold_at = |at: f64| (at + grid.reading_age_s) / time;
    let mut last = 0;
    let mut places = grid.places.clone();
    for (k, place) in places.iter_mut().enumerate() {
        let at = grid.time_s[k] - grid.time_s[0];
        let position = hold_at(at);
        let mut hold = position.floor();
        if position - hold < near && !changes(k) && changes(k + 1) {
            hold -= 1.0;
        } else if hold + 1.0 - position < near && changes(k) && !changes(k + 1) {
            hold += 1.0;
        }
        let nearest = (at / step).round() as usize;
        let shows = |end: &usize| {
            let at = *end as f64 * step;
            let [early, late] = [-EITHER, EITHER].map(|share| hold_at(at + share * step).floor());
            early == hold && late == hold && *end >= last && *end < grid.voltages.len()
        };
        let ends = nearest.saturating_sub(2)..=nearest + 2;
        if let Some(end) = ends.filter(shows).min_by_key(|end| end.abs_diff(nearest)) {
            last = end;
            *place = if end == 0 { Place { cell: 0, part: 0.0 } } else { Place { cell: end - 1, part: 1.0 } };
        }
    }
    grid.places = places;
}

/// How old the first reading of `grid` is, from the crowd of its updates.
fn rough_age(grid: &Grid, time: f64) -> f64 {
    if beat::tells(&grid.time_s, time) {
        beat::age(&grid.time_s, &grid.measured, grid.quantum, time)
    } else {
        hold::age(&grid.time_s, &grid.measured, time)
    }
}

/// The updates that the samples of `grid` show, the hold being nearly `about` seconds and the first reading nearly `age` old.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::Record;

    /// Updates every 20.44 ms on stamps that are wrong by up to a tenth of a millisecond: whatever their stamps say, the
    /// samples of one reading lie in one hold, and no two readings share one.
    #[test]
    fn samples_of_a_held_record_lie_in_the_hold_whose_reading_they_show() {
        const HOLD_S: f64 = 0.020_44;
        let wrong = |k: u32| 1e-4 * (f64::from(k * 7919 % 201) / 100.0 - 1.0);
        let taken = |t: f64| (t / HOLD_S + 1e-9).floor();
        let true_times: Vec<f64> = (0..4000).map(|k| f64::from(k) * 1e-3).collect();
        let readings: Vec<f64> = true_times.iter().map(|t| 0.1 * taken(*t)).collect();
        let stamps = |k: u32| if k == 0 { 0.0 } else { true_times[k as usize] + wrong(k) };
        let record = Record {
            time_s: (0..4000).map(stamps).collect(),
            voltage_v: vec![6.0; 4000],
            angle_rad: Some(readings.clone()),
            ..Record::default()
        };
        let mut grid = Grid::new(&record, 0.1);
        let end = |place: &Place| grid.step_s * (place.cell as f64 + place.part);
        let belongs = |time: f64, reading: f64| (taken(time) - reading / 0.1).abs() < 0.5;
        let misplaced = grid.places.iter().zip(&readings).filter(|(p, y)| !belongs(end(p), **y)).count();
        assert!(misplaced > 5, "{misplaced}: some stamps are on the wrong side");
        settle_on_ends(&mut grid, HOLD_S);
        for (place, reading) in grid.places.iter().zip(&readings) {
            let end = grid.step_s * (place.cell as f64 + place.part);
            assert!(place.part == 1.0 || place.cell == 0);
            assert!(belongs(end, *reading), "{end} {reading}");
        }
        let cells: Vec<usize> = grid.places.iter().map(|place| place.cell).collect();
        assert!(cells.is_sorted());
    }
}
