//! How long a sensor holds its readings, from the instants at which they change.
//!
//! A reading that is renewed every `hold` seconds changes only in the samples that follow a multiple of it. Every change
//! narrows the interval in which `hold` must lie, in the end to a small part of a sample over the whole record.

use crate::fit::grid::{Grid, Quantity};
use crate::fit::search::Problem;

/// Changes that a record must show.
const FEWEST_CHANGES: usize = 60;
/// A hold shorter than this many samples does not show in their changes.
const SHORTEST: f64 = 1.3;
/// Stamps, and the instant of a renewal, are exact to this share of a sample.
const STAMPS: f64 = 0.15;

/// The time for which the readings of `problem` are held, s; none where they are not, or some records say otherwise.
pub fn time(problem: &Problem) -> Option<f64> {
    let mut range = (0.0_f64, f64::MAX);
    let mut seen = 0;
    for (low, high) in problem.grids.iter().filter_map(range_of) {
        range = (range.0.max(low), range.1.min(high));
        seen += 1;
    }
    (seen > 0 && range.0 <= range.1).then_some(0.5 * (range.0 + range.1))
}

/// Shortest and longest hold that one record allows.
fn range_of(grid: &Grid) -> Option<(f64, f64)> {
    if grid.quantity != Quantity::Angle {
        return None;
    }
    let dt = grid.interval_s;
    let (t, y) = (&grid.time_s, &grid.measured);
    let changes: Vec<usize> = (1..y.len()).filter(|k| y[*k] != y[*k - 1]).collect();
    if changes.len() < FEWEST_CHANGES {
        return None;
    }
    // In fast motion every renewal is a change: the commonest distance and its neighbours are whole holds.
    let mut count = [0_usize; 64];
    let gaps = || changes.windows(2).map(|w| w[1] - w[0]).filter(|g| *g < 64);
    gaps().for_each(|g| count[g] += 1);
    let common = (1..64).max_by_key(|g| count[*g])?;
    let near: Vec<usize> = gaps().filter(|g| g.abs_diff(common) <= 1).collect();
    let about = near.iter().sum::<usize>() as f64 / near.len() as f64;
    if about < SHORTEST || near.len() < FEWEST_CHANGES {
        return None;
    }
    // Whole holds in a row: only where a row of them breaks off a part of a sample is lost.
    let unsure = 6.0 / near.len() as f64;
    let (mut low, mut high) = ((about - unsure) * dt, (about + unsure) * dt);
    for k in changes {
        // The renewal lies between this sample and the one before; which it is must be clear.
        let (after, until) = (t[k - 1] - t[0] - STAMPS * dt, t[k] - t[0] + STAMPS * dt);
        let (fewest, most) = ((after / high).ceil().max(1.0), (until / low).floor());
        if most < fewest {
            return None;
        }
        if most == fewest {
            (low, high) = (low.max(after / most), high.min(until / most));
            if low > high {
                return None;
            }
        }
    }
    (high - low < 1e-3 * low).then_some((low, high))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;
    use motorlens_virtual_motor::Kind;

    #[test]
    fn a_held_reading_shows_its_time_and_others_show_none() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let mut held = 0;
        for seed in 0..24 {
            for kind in [Kind::SensorLag, Kind::Coulomb] {
                let case = Case::new(seed, &[kind], ideal);
                let (problem, _) = setup::problem(&case.records, &case.motor);
                let found = time(&problem);
                let truth = |name: &str| -> Option<f64> {
                    let text = case.sizes.split(name).nth(1)?;
                    text.split(',').next()?.parse().ok()
                };
                let is_held = case.sizes.contains("held=1");
                let hold = truth("sensor_lag=").filter(|_| is_held).map(|ms| 1e-3 * ms);
                match (found, hold) {
                    (Some(found), Some(hold)) => {
                        assert!((found / hold - 1.0).abs() < 2e-5, "seed {seed}: {found} for {hold}");
                        held += 1;
                    }
                    (Some(found), None) => panic!("seed {seed}, {}: {found}", case.sizes),
                    // A hold shorter than a sample or two hides behind the samples.
                    (None, Some(hold)) => {
                        assert!(hold < 2.0 * problem.grids[0].interval_s, "seed {seed}: {hold} missed");
                    }
                    (None, None) => {}
                }
            }
        }
        assert!(held > 3, "{held} held sensors among 24");
    }
}
