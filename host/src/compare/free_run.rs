//! The model on its own over a whole record.
//!
//! Only the state at the start is taken from the measurement: the first angle, which is known to within one
//! encoder count and is placed within that count, and the first speed where the record begins in motion. From there
//! on the run is never tied to the measurement again.

use motorlens_kernel::Reading;

use super::measures::{Measures, Sums};
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::{predict_one, samples};
use crate::log::Record;

/// A measured record and the run beside it.
#[derive(Debug, Clone)]
pub struct FreeRun {
    /// Name of the record.
    pub record: String,
    /// Sample times, s.
    pub time_s: Vec<f64>,
    /// Measured values.
    pub measured: Vec<f64>,
    /// Simulated values.
    pub simulated: Vec<f64>,
    /// Voltage held at each sample, V.
    pub voltage_v: Vec<f64>,
    /// What both are.
    pub quantity: Quantity,
    /// The speed at which the run begins, rad/s: 0 from rest, else found for the model.
    pub first_speed_rad_s: f64,
}

impl FreeRun {
    /// Errors of this record.
    pub fn measures(&self) -> Measures {
        let mut sums = Sums::default();
        sums.add(&self.time_s, &self.measured, &self.simulated);
        sums.measures().unwrap_or_default()
    }
}

/// The part of the mean of `errors`, rad, that no open-loop simulation is to blame for: an encoder begins anywhere within a count of `quantum`. An angle
/// that walks further away keeps its mean.
pub fn within_a_count(errors: impl ExactSizeIterator<Item = f64>, quantum: f64) -> f64 {
    let n = errors.len() as f64;
    (errors.sum::<f64>() / n).clamp(-quantum, quantum)
}

/// Runs `values` over every record of `problem`. Records that begin in motion do so at the speeds that this model finds for them, whatever
/// model they were laid out under: so a model has one error, whoever asks for it. They are those of a fit, which has them by the whole run,
/// unless that straight line from the first time constants leads astray.
pub fn free_runs(problem: &Problem, values: &Values) -> Vec<FreeRun> {
    begun_runs(problem, values).into_iter().map(|(run, _)| run).collect()
}

/// The same, each beside its record as the run begins it.
pub(crate) fn begun_runs(problem: &Problem, values: &Values) -> Vec<(FreeRun, Grid)> {
    let mut problem = problem.clone();
    problem.find_moving_starts(values);
    let kinds = values.kinds();
    let layout: Layout = problem.layout(&kinds);
    let x = layout.pack(values);
    let plain = layout.all_plain(&x);
    let run =
        |problem: &Problem, grid: &Grid| free_run(grid, predict_one(&kinds, &plain, &problem.rig, grid));
    let mut runs: Vec<(FreeRun, Grid)> =
        problem.grids.iter().map(|grid| (run(&problem, grid), grid.clone())).collect();
    problem.begin_under(&layout, &x);
    for (opening, grid) in runs.iter_mut().zip(&problem.grids).filter(|(_, grid)| !grid.rests()) {
        let whole = run(&problem, grid);
        if whole.measures().rmse < opening.0.measures().rmse {
            *opening = (whole, grid.clone());
        }
    }
    runs
}

/// `values` over each of `records` as a program runs them that has steps of its own of `step_s`, s, and begins as the records are `begun`.
pub(crate) fn runs_in_steps(
    problem: &Problem,
    values: &Values,
    begun: &[Grid],
    records: &[Record],
    step_s: f64,
) -> Vec<FreeRun> {
    let kinds = values.kinds();
    let layout = problem.layout(&kinds);
    let plain = layout.all_plain(&layout.pack(values));
    let run = |(grid, record): (&Grid, &Record)| {
        let grid = grid.in_steps_of(record, step_s);
        let simulated = predict_one(&kinds, &plain, &problem.rig, &grid);
        free_run(&grid, simulated)
    };
    begun.iter().zip(records).map(run).collect()
}

/// What another simulator, `run`, makes of each of `records`, begun as they are `begun`: under a voltage, V, for each of its steps of `step_s`, s,
/// from an angle, rad, and a speed, rad/s, on, it shows something at the start and after each.
pub(crate) fn runs_elsewhere<E>(
    begun: &[Grid],
    records: &[Record],
    step_s: f64,
    mut run: impl FnMut(&[f64], [f64; 2]) -> Result<Vec<Reading<f64>>, E>,
) -> Result<Vec<FreeRun>, E> {
    let one = |(grid, record): (&Grid, &Record)| {
        let grid = grid.in_steps_of(record, step_s);
        let steps = grid.places.last().map_or(0, |place| place.cell + 1).min(grid.cells().len());
        let shown = run(&grid.cells()[..steps], [grid.start_angle, grid.first_speed_rad_s()])?;
        Ok(free_run(&grid, samples(&grid, &shown)))
    };
    begun.iter().zip(records).map(one).collect()
}

/// What `simulated` is beside the record of `grid`, an angle moved within a count.
fn free_run(grid: &Grid, mut simulated: Vec<f64>) -> FreeRun {
    if grid.quantity == Quantity::Angle {
        let errors = grid.measured.iter().zip(&simulated).map(|(y, p)| y - p);
        let within = within_a_count(errors, grid.offset());
        simulated.iter_mut().for_each(|p| *p += within);
    }
    let last = grid.cells().len() - 1;
    let held = |k: usize| {
        let p = &grid.places[k];
        grid.cells()[(if p.part == 1.0 { p.cell + 1 } else { p.cell }).min(last)]
    };
    FreeRun {
        record: grid.name.clone(),
        time_s: grid.time_s.clone(),
        measured: grid.measured.clone(),
        voltage_v: (0..grid.len()).map(held).collect(),
        simulated,
        quantity: grid.quantity,
        first_speed_rad_s: grid.first_speed_rad_s(),
    }
}

/// Errors over all of `runs` together.
pub fn pooled(runs: &[FreeRun]) -> Option<Measures> {
    let mut sums = Sums::default();
    for run in runs {
        sums.add(&run.time_s, &run.measured, &run.simulated);
    }
    sums.measures()
}

/// The errors of `values` on the records of `problem` together; none where there are no samples.
pub fn simulated(problem: &Problem, values: &Values) -> Option<Measures> {
    pooled(&free_runs(problem, values))
}

#[cfg(test)]
mod tests {
    use motorlens_shared::effects::Kind;

    use super::*;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;

    /// Friction holds a shaft at rest, and a late voltage moves it later: no search for a first speed may begin there.
    #[test]
    fn a_model_that_is_right_runs_like_a_record_that_begins_in_motion() {
        let case = Case::new(8, &[], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (mut problem, start) = setup::problem(&case.records, &case.motor);
        let model = start.with(Kind::Coulomb, vec![0.8]).with(Kind::Delay, vec![0.02]);
        let layout = problem.layout(&model.kinds());
        let plain = layout.all_plain(&layout.pack(&model));
        let speed = 0.6 * problem.rig.reference_speed;
        for grid in &mut problem.grids {
            grid.begin_with_speed(speed, &problem.rig);
            grid.measured = predict_one(&layout.kinds, &plain, &problem.rig, grid);
        }
        for run in free_runs(&problem, &model) {
            let error = run.measures().rmse;
            assert!(error < 2.0 * problem.grids[0].quantum, "{}: {error} rad", run.record);
        }
    }
}
