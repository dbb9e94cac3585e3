//! Whether the shaft comes back to where it was.
//!
//! A torque that depends on where the shaft is, and does not repeat with its turns, is told from one that changes with time only by what it
//! does where the shaft is for the second time: on a way that is gone once and one way, angle and time are the same thing.

use crate::fit::grid::{Grid, Quantity};
use crate::fit::search::Problem;
use crate::log::motion::ends;

/// What goes less than this share of a record's range is noise, and no way back.
const NOISE: f64 = 0.02;
/// The ways of all records together are so many times what they cover where a part of it is passed again.
const AGAIN: f64 = 1.2;

/// Whether the records of `problem` pass places that they have passed before.
pub fn retraces(problem: &Problem) -> bool {
    let angles: Vec<Vec<f64>> = problem.grids.iter().map(angles).collect();
    let ways: f64 = angles.iter().map(|angles| way(angles)).sum();
    // Where a record of speeds begins is not known, and no other's place is passed in it.
    let (placed, loose): (Vec<_>, Vec<_>) =
        problem.grids.iter().zip(&angles).partition(|(grid, _)| grid.quantity == Quantity::Angle);
    let of = |(_, angles): &(&Grid, &Vec<f64>)| ends(angles);
    let covered = union(placed.iter().map(of).collect())
        + loose.iter().map(of).map(|(low, high)| high - low).sum::<f64>();
    ways > AGAIN * covered
}

/// The angle of the shaft at each sample, rad; of speeds, from where it began.
fn angles(grid: &Grid) -> Vec<f64> {
    if grid.quantity == Quantity::Angle {
        return grid.measured.clone();
    }
    let mut angle = 0.0;
    let steps = grid.time_s.windows(2).zip(&grid.measured).map(|(pair, speed)| speed * (pair[1] - pair[0]));
    std::iter::once(0.0)
        .chain(steps.map(|step| {
            angle += step;
            angle
        }))
        .collect()
}

/// How far the shaft goes, there and back, rad.
fn way(angles: &[f64]) -> f64 {
    let (low, high) = ends(angles);
    let (mut at, mut way) = (angles.first().copied().unwrap_or(0.0), 0.0);
    for x in angles {
        if (x - at).abs() > NOISE * (high - low) {
            way += (x - at).abs();
            at = *x;
        }
    }
    way
}

/// The length that ranges cover together.
fn union(mut ranges: Vec<(f64, f64)>) -> f64 {
    ranges.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (mut covered, mut end) = (0.0, f64::NEG_INFINITY);
    for (low, high) in ranges {
        covered += (high - low.max(end)).max(0.0);
        end = end.max(high);
    }
    covered
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ways_there_and_back_are_longer_than_what_they_cover() {
        let there: Vec<f64> = (0..=100).map(|k| 0.1 * f64::from(k) + 0.01 * f64::from(k % 2)).collect();
        let back: Vec<f64> = there.iter().chain(there.iter().rev()).copied().collect();
        assert!((way(&there) / 10.0 - 1.0).abs() < 0.05 && (way(&back) / 20.0 - 1.0).abs() < 0.05);
        assert_eq!(union(vec![(3.0, 5.0), (0.0, 1.0), (0.5, 2.0), (4.0, 4.5)]), 4.0);
    }
}
