//! How fast the motor turns when a record begins.
//!
//! Most records begin at rest, and then zero is exact. Whether one begins in motion shows in its first few
//! milliseconds: by how much it moved, against how far a motor at rest would have come. The speed itself is
//! fitted over the first time constants, in which it dies out; a fit moves it on with its parameters (`begun`).

use motorlens_shared::effects::Rig;

use super::begun::{APART, HIGHEST};
use super::grid::{Grid, Quantity};
use super::layout::{Layout, Values};
use super::search::Problem;
use super::simulate::{Block, LANES, predict_block};

/// The look at the first moments, s.
const FIRST_LOOK_S: f64 = 8e-3;
/// Displacements below this many counts are counting.
const COUNTS: f64 = 3.0;
/// Twice the time brings less than this times the way, if the motor was turning already ...
const STEADY: f64 = 2.6;
/// ... and less than this times what goes beyond the way of a motor at rest.
const STEADY_BEYOND: f64 = 2.2;
/// The model may be wrong by this share of its own displacement.
const MODEL_ERROR: f64 = 0.4;

/// How the shaft of a record begins.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Start {
    /// rad/s.
    speed: f64,
    /// rad.
    angle: f64,
}

impl Grid {
    fn start(&self) -> Start {
        Start { speed: self.start_speed, angle: self.start_angle }
    }

    /// Begins at `speed`, rad/s, as it turned before.
    #[cfg(test)]
    pub fn begin_with_speed(&mut self, speed: f64, rig: &Rig) {
        self.begin_at(speed, held(rig, speed));
    }

    fn set_start(&mut self, rig: &Rig, start: Start) {
        self.begin_at(start.speed, held(rig, start.speed));
        self.start_angle = start.angle;
    }
}

impl Problem {
    /// How its records begin.
    fn starts(&self) -> Vec<Start> {
        self.grids.iter().map(Grid::start).collect()
    }

    /// Lets its records begin so.
    fn set_starts(&mut self, starts: &[Start]) {
        for (grid, start) in self.grids.iter_mut().zip(starts) {
            grid.set_start(&self.rig, *start);
        }
    }

    /// Lets those of its records that begin in motion do so with these `speeds`, rad/s, at the angles that they have.
    pub fn begin_with(&mut self, speeds: &[f64]) {
        for (grid, speed) in self.grids.iter_mut().zip(speeds).filter(|(grid, _)| !grid.rests()) {
            // Zero would say that it rests.
            let speed = if *speed == 0.0 { f64::MIN_POSITIVE } else { *speed };
            grid.begin_at(speed, held(&self.rig, speed));
        }
    }

    /// Finds the records that begin in motion, and their first speeds under `model`.
    pub fn find_moving_starts(&mut self, model: &Values) {
        let layout = self.layout(&model.kinds());
        let x = layout.pack(model);
        let moving: Vec<Option<f64>> =
            self.grids.iter().map(|g| begins_in_motion(self, &layout, &x, g)).collect();
        for (grid, moving) in self.grids.iter_mut().zip(moving) {
            if grid.quantity == Quantity::Angle {
                let speed = moving.unwrap_or(0.0);
                grid.begin_at(speed, held(&self.rig, speed));
            }
        }
        self.refine_starts(model);
    }

    /// Fits the first speeds of the records that begin in motion anew, under `model`. Their first angles are those read: a fit compares angles
    /// about their mean, and a first angle that is free trades with speed and time constant.
    pub fn refine_starts(&mut self, model: &Values) {
        let layout = self.layout(&model.kinds());
        let x = layout.pack(model);
        for _ in 0..2 {
            let motion = |g: &Grid| first_motion(self, &layout, &x, &opening(&layout, &x, g), false);
            let starts: Vec<Start> =
                self.grids.iter().map(|g| if g.rests() { g.start() } else { motion(g) }).collect();
            self.set_starts(&starts);
        }
    }
}

/// A first speed is believed where the first moments of a record are this many times the noise off without it ...
const OFF: f64 = 3.0;
/// ... and no more than this with it: a reading, and the first one, are known to a count.
const AS_COUNTED: f64 = 2.0;

impl Problem {
    /// Looks again at the records that seem to begin at rest, under a `model` that explains what it sees: a slow motion hides
    /// within the first counts, and shows in how far it carries the shaft. Whether there is one.
    pub fn find_slow_starts(&mut self, model: &Values) -> bool {
        let layout = self.layout(&model.kinds());
        let x = layout.pack(model);
        let slow = |grid: &Grid| {
            let mut opening = opening(&layout, &x, grid);
            let still = distance(self, &layout, &x, &opening);
            if still < OFF {
                return None;
            }
            for _ in 0..2 {
                let start = first_motion(self, &layout, &x, &opening, true);
                opening.set_start(&self.rig, start);
            }
            let moving = distance(self, &layout, &x, &opening);
            (moving < AS_COUNTED).then(|| opening.start())
        };
        // Of a record's rest the beginning is not at hand.
        let rests =
            |grid: &&Grid| grid.rests() && grid.quantity == Quantity::Angle && grid.places[0].part == 0.0;
        let found: Vec<Option<Start>> =
            self.grids.iter().map(|grid| Some(grid).filter(rests).and_then(slow)).collect();
        let starts: Vec<Start> =
            self.starts().into_iter().zip(&found).map(|(old, new)| new.unwrap_or(old)).collect();
        self.set_starts(&starts);
        found.iter().any(Option::is_some)
    }
}

/// The speed with which a record begins in motion, as its first moments have it, rad/s: near enough for a search among equations that are
/// straight nowhere near rest. None where it begins at rest.
fn begins_in_motion(problem: &Problem, layout: &Layout, x: &[f64], grid: &Grid) -> Option<f64> {
    let k = grid.time_s.iter().position(|t| t - grid.time_s[0] >= FIRST_LOOK_S)?;
    let mut still = grid.first((2 * k + 1).min(grid.len()));
    still.begin_at(0.0, 0.0);
    let mut series = Vec::new();
    predict_block(layout, &[x.to_vec()], &problem.rig, &still, &mut series);
    let expected = series[k].0[0] - series[0].0[0];
    let moved = grid.measured[k] - grid.measured[0];
    let later = grid.measured.get(2 * k).map_or(moved, |y| y - grid.measured[0]);
    let beyond = moved - expected;
    let later_beyond = later - series.get(2 * k).map_or(expected, |block| block.0[0] - series[0].0[0]);
    // From rest the way grows with the square of time and more, in motion in proportion to it. Where the voltage moves the motor
    // on, what goes beyond that does so; what falls short of it is a friction's, or a delay's.
    let steady = later.abs() < STEADY * moved.abs()
        || beyond * moved > 0.0 && later_beyond.abs() < STEADY_BEYOND * beyond.abs();
    let moves = steady && beyond.abs() > COUNTS * grid.sigma * 12.0_f64.sqrt() + MODEL_ERROR * expected.abs();
    moves.then(|| moved / (grid.time_s[k] - grid.time_s[0]))
}

/// The voltage under which a motor turns at `speed`: most that turn already have done so for a while.
pub(crate) fn held(rig: &Rig, speed: f64) -> f64 {
    speed * rig.nominal_v / rig.reference_speed
}

/// The first time constants of a record.
fn opening(layout: &Layout, x: &[f64], grid: &Grid) -> Grid {
    let until = grid.time_s[0] + (2.0 * layout.plain(1, x[1])).clamp(0.06, 0.6);
    grid.first(grid.time_s.iter().take_while(|t| **t <= until).count().max(4).min(grid.len()))
}

/// How far `x` runs from `grid`: root mean square, multiples of the noise.
fn distance(problem: &Problem, layout: &Layout, x: &[f64], grid: &Grid) -> f64 {
    let mut series: Vec<Block> = Vec::new();
    predict_block(layout, &[x.to_vec()], &problem.rig, grid, &mut series);
    let squares: f64 = series.iter().zip(&grid.measured).map(|(run, y)| (y - run.0[0]).powi(2)).sum();
    (squares / grid.len() as f64).sqrt() / grid.sigma
}

/// A moving shaft may be ahead of its first reading by the way of this long, s, and a count: the reading is filtered, or held.
const LATE_S: f64 = 0.2;

/// Least squares over the `opening` of a record: speed and angle of the shaft at its start. The first reading is a count wide,
/// and late where the sensor is. Under a model that is not `near` the truth the angle would take up what it is wrong by: there the
/// first reading is met, which a late sensor takes from behind the shaft.
fn first_motion(problem: &Problem, layout: &Layout, x: &[f64], opening: &Grid, near: bool) -> Start {
    let delta = APART * problem.rig.reference_speed;
    let run = |speed: f64| -> Vec<f64> {
        let mut series: Vec<Block> = Vec::new();
        let mut grid = opening.clone();
        grid.begin_at(speed, held(&problem.rig, speed));
        predict_block(layout, &[x.to_vec()], &problem.rig, &grid, &mut series);
        series.iter().map(|b| b.0[LANES - 1]).collect()
    };
    let (here, there) = (run(opening.start_speed), run(opening.start_speed + delta));
    let residual: Vec<f64> = opening.measured.iter().zip(&here).map(|(y, p)| y - p).collect();
    let slope: Vec<f64> = there.iter().zip(&here).map(|(a, b)| (a - b) / delta).collect();
    let angle = opening.quantity == Quantity::Angle;
    let anchor = |of: &[f64]| match (angle, near) {
        (false, _) => 0.0,
        (true, false) => of[0],
        (true, true) => of.iter().sum::<f64>() / of.len() as f64,
    };
    let (r0, s0) = (anchor(&residual), anchor(&slope));
    let (mut above, mut below) = (0.0, 0.0);
    for (r, s) in residual.iter().zip(&slope) {
        above += (r - r0) * (s - s0);
        below += (s - s0).powi(2);
    }
    let change = if below > 0.0 { above / below } else { 0.0 };
    let limit = HIGHEST * problem.rig.reference_speed;
    let speed = (opening.start_speed + change).clamp(-limit, limit);
    let read = opening.measured[0];
    let late = LATE_S * speed.abs() + opening.quantum;
    let ahead = opening.start_angle + r0 - s0 * (speed - opening.start_speed);
    Start { speed, angle: if angle { ahead.clamp(read - late, read + late) } else { opening.start_angle } }
}

#[cfg(test)]
mod tests {
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;
    use crate::fit::simulate::predict_one;
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

    /// Two counts in the first look, and the counts that they carry the shaft further: found once the model is right.
    #[test]
    fn a_slow_start_shows_under_a_model_that_explains_the_rest() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(8, &[], ideal);
        let (mut problem, start) = setup::problem(&case.records, &case.motor);
        let (layout, x) = problem.fit_base(&start);
        let values = layout.unpack(&x);
        assert!(!problem.find_slow_starts(&values), "all begin at rest");
        let speed = 0.03 * problem.rig.reference_speed;
        for grid in &mut problem.grids {
            grid.begin_at(speed, super::held(&problem.rig, speed));
            grid.measured = predict_one(&[], &layout.all_plain(&x), &problem.rig, grid);
            grid.begin_at(0.0, 0.0);
        }
        assert!(problem.find_slow_starts(&values));
        for grid in &problem.grids {
            assert!((grid.start_speed / speed - 1.0).abs() < 0.05, "{}: {}", grid.name, grid.start_speed);
        }
    }

    #[test]
    fn a_moving_shaft_is_put_where_it_was_read_with_the_speed_that_it_had() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(8, &[], ideal);
        let (mut problem, start) = setup::problem(&case.records, &case.motor);
        let (layout, x) = problem.fit_base(&start);
        let values = layout.unpack(&x);
        let speed = 0.4 * problem.rig.reference_speed;
        let first = problem.grids[0].start_angle;
        let ahead = 40.0 * problem.grids[0].quantum;
        for grid in &mut problem.grids {
            grid.begin_at(speed, super::held(&problem.rig, speed));
            let run = predict_one(&[], &layout.all_plain(&x), &problem.rig, grid);
            grid.measured = run.iter().map(|y| y + ahead).collect();
        }
        let put = |problem: &crate::fit::search::Problem| problem.grids[0].start_angle - first;
        problem.refine_starts(&values);
        assert!((put(&problem) / ahead - 1.0).abs() < 1e-6, "the first reading is met: {}", put(&problem));
        assert!((problem.grids[0].start_speed / speed - 1.0).abs() < 0.02);
    }

    /// A bridge that is late still brings the voltage under which the motor turned.
    #[test]
    fn a_late_voltage_keeps_a_motor_turning_as_it_did() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(8, &[], ideal);
        let (problem, start) = setup::problem(&case.records, &case.motor);
        let late = start.with(motorlens_shared::effects::Kind::Delay, vec![0.05]);
        let layout = problem.layout(&late.kinds());
        let mut grid = problem.grids[0].clone();
        let speed = 0.5 * problem.rig.reference_speed;
        grid.begin_at(speed, super::held(&problem.rig, speed));
        let run = predict_one(&late.kinds(), &layout.all_plain(&layout.pack(&late)), &problem.rig, &grid);
        let last = grid.time_s.iter().take_while(|t| **t - grid.time_s[0] < 0.045).count() - 1;
        let way = speed * (grid.time_s[last] - grid.time_s[0]);
        assert!(((run[last] - run[0]) / way - 1.0).abs() < 0.01, "{} {way}", run[last] - run[0]);
    }
}
