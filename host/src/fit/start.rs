//! How fast the motor turns when a record begins.
//!
//! Most records begin at rest, and then zero is exact. Whether one begins in motion shows in its first few
//! milliseconds: by how much it moved, against how far a motor at rest would have come. The speed itself is
//! fitted over the first time constants, in which it dies out.

use super::grid::Grid;
use super::layout::{Layout, Values};
use super::search::Problem;
use super::simulate::{Block, LANES, predict_block};

/// The look at the first moments, s.
const FIRST_LOOK_S: f64 = 8e-3;
/// Displacements below this many counts are counting.
const COUNTS: f64 = 3.0;
/// Twice the time brings less than this times the way, if the motor was turning already.
const STEADY: f64 = 2.6;
/// The model may be wrong by this share of its own displacement.
const MODEL_ERROR: f64 = 0.4;

impl Problem {
    /// Finds the records that begin in motion, and their first speeds under `model`.
    pub fn find_moving_starts(&mut self, model: &Values) {
        let layout = self.layout(&model.kinds());
        let x = layout.pack(model);
        let moving: Vec<bool> = self.grids.iter().map(|g| begins_in_motion(self, &layout, &x, g)).collect();
        for (grid, moving) in self.grids.iter_mut().zip(moving) {
            if grid.quantity == super::grid::Quantity::Angle {
                grid.begin_at(if moving { f64::MIN_POSITIVE } else { 0.0 });
            }
        }
        self.refine_starts(model);
    }

    /// Fits the first speeds of the records that begin in motion anew, under `model`.
    pub fn refine_starts(&mut self, model: &Values) {
        let layout = self.layout(&model.kinds());
        let x = layout.pack(model);
        for _ in 0..2 {
            let speeds: Vec<f64> = self
                .grids
                .iter()
                .map(|g| if g.rests() { 0.0 } else { first_speed(self, &layout, &x, g) })
                .collect();
            for (grid, speed) in self.grids.iter_mut().zip(speeds) {
                grid.begin_at(speed);
            }
        }
    }
}

fn begins_in_motion(problem: &Problem, layout: &Layout, x: &[f64], grid: &Grid) -> bool {
    let Some(k) = grid.time_s.iter().position(|t| t - grid.time_s[0] >= FIRST_LOOK_S) else { return false };
    let mut still = grid.first(k + 1);
    still.begin_at(0.0);
    let mut series = Vec::new();
    predict_block(layout, &[x.to_vec()], &problem.rig, &still, &mut series);
    let expected = series[k].0[0] - series[0].0[0];
    let moved = grid.measured[k] - grid.measured[0];
    let later = grid.measured.get(2 * k).map_or(moved, |y| y - grid.measured[0]);
    // From rest the way grows with the square of time and more, in motion in proportion to it.
    let steady = later.abs() < STEADY * moved.abs();
    steady && (moved - expected).abs() > COUNTS * grid.sigma * 12.0_f64.sqrt() + MODEL_ERROR * expected.abs()
}

/// Least squares over the first time constants. The first angle is known to within a count: how far the first speed
/// carries the shaft tells more of it than how.
fn first_speed(problem: &Problem, layout: &Layout, x: &[f64], grid: &Grid) -> f64 {
    let tau = layout.plain(1, x[1]);
    let until = grid.time_s[0] + (2.0 * tau).clamp(0.06, 0.6);
    let n = grid.time_s.iter().take_while(|t| **t <= until).count().max(4).min(grid.len());
    let part = grid.first(n);
    let delta = 0.02 * problem.rig.reference_speed;
    let run = |speed: f64| -> Vec<f64> {
        let mut series: Vec<Block> = Vec::new();
        let mut grid = part.clone();
        grid.begin_at(speed);
        predict_block(layout, &[x.to_vec()], &problem.rig, &grid, &mut series);
        series.iter().map(|b| b.0[LANES - 1]).collect()
    };
    let (here, there) = (run(grid.start_speed), run(grid.start_speed + delta));
    let residual: Vec<f64> = part.measured.iter().zip(&here).map(|(y, p)| y - p).collect();
    let slope: Vec<f64> = there.iter().zip(&here).map(|(a, b)| (a - b) / delta).collect();
    let (mut above, mut below) = (0.0, 0.0);
    for (r, s) in residual.iter().zip(&slope) {
        above += r * s;
        below += s * s;
    }
    let change = if below > 0.0 { above / below } else { 0.0 };
    let limit = 2.0 * problem.rig.reference_speed;
    (grid.start_speed + change).clamp(-limit, limit)
}

#[cfg(test)]
mod tests {
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;
    use motorlens_virtual_motor::Kind;

    /// A load pulls a resting motor at once, which is not a motion at the start.
    #[test]
    fn a_motor_pulled_from_rest_does_not_begin_in_motion() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        for seed in 0..6 {
            let case = Case::new(seed, &[Kind::ConstantLoad], ideal);
            let (problem, _) = setup::problem(&case.records, &case.motor);
            for grid in &problem.grids {
                assert_eq!(grid.start_speed, 0.0, "seed {seed}, {}", grid.name);
            }
        }
    }
}
