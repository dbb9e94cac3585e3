//! What laws leave to chance, and how much of it each record shows.
//!
//! A repeated programme tells what a perfect model leaves of that programme. Where counts are lost, others lose more of them, and
//! nobody knows which: how many is foretold from the model, and then a record counts for as much as it can tell.
//!
//! A PWM that coasts leaves its phase to chance in the same way. Allowed for, that made a coasting bridge of what is none, as the
//! examination showed: its frequency is too free. It is found instead (`slow_pwm`).

use motorlens_shared::effects::Kind;

use super::candidate::Errors;
use crate::fit::cost::{SPAN_S, increments};
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::simulate::predict_one;

/// Variance, in noise units, of the error's increments that the laws of `values` leave to chance on each record of `problem`.
pub fn scatter(problem: &Problem, values: &Values) -> Vec<f64> {
    problem.grids.iter().map(|grid| on(problem, values, grid)).collect()
}

/// By how much a reading's noise must grow to cover the `scatter` of each record beyond what `floor` holds of it, which was
/// measured on records of the scatter `measured`.
pub fn allowances(scatter: &[f64], measured: f64, floor: &Errors) -> Vec<f64> {
    // What the floor holds besides chance: counting and disturbance.
    let steady = (floor.increments.powi(2) - measured).max(1.0);
    scatter.iter().map(|own| ((steady + own) / (steady + measured)).max(1.0).sqrt()).collect()
}

/// The same on one record.
fn on(problem: &Problem, values: &Values, grid: &Grid) -> f64 {
    let own = |(kind, p): &(Kind, Vec<f64>)| match kind {
        Kind::LostCounts => of_the_lost(problem, values, grid, [p[0], p[1]]),
        _ => 0.0,
    };
    values.effects.iter().map(own).sum()
}

/// Of edges that are lost one by one: as many more or fewer as chance has it.
fn of_the_lost(problem: &Problem, values: &Values, grid: &Grid, [share, threshold]: [f64; 2]) -> f64 {
    if grid.quantum <= 0.0 {
        return 0.0;
    }
    let moved = steps(grid, &run(problem, &values.without(Kind::LostCounts), grid));
    let span_s = if grid.quantity == Quantity::Angle { SPAN_S } else { grid.interval_s };
    let lost = |step: &f64| {
        let angle = step.abs() * grid.sigma;
        if angle > threshold * span_s { share * angle / grid.quantum } else { 0.0 }
    };
    let variance = moved.iter().map(lost).sum::<f64>() / moved.len().max(1) as f64;
    variance * (grid.quantum / grid.sigma).powi(2)
}

fn run(problem: &Problem, values: &Values, grid: &Grid) -> Vec<f64> {
    let layout = problem.layout(&values.kinds());
    predict_one(&layout.kinds, &layout.all_plain(&layout.pack(values)), &problem.rig, grid)
}

/// What a run adds to its readings in the span of an increment, in noise units; of speeds the readings themselves.
fn steps(grid: &Grid, run: &[f64]) -> Vec<f64> {
    let judged = &run[grid.skip..];
    if grid.quantity != Quantity::Angle {
        return judged.iter().map(|y| y / grid.sigma).collect();
    }
    increments(grid, judged)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::cost::span;
    use crate::log::repeats::differences;
    use motorlens_virtual_motor::Kind as Hidden;

    const CALM: Conditions = Conditions { disturbed: 0.0, spoilt: 0.0 };

    /// Of the multisine that was run twice: how far the two are apart, and how far they are foretold to be.
    fn measured_and_foretold(seed: u64, hidden: Hidden, kind: Kind, parameters: Vec<f64>) -> [f64; 2] {
        let case = Case::new(seed, &[hidden], CALM);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let values = base.values().with(kind, parameters);
        let (second, last) = (2, case.records.len() - 1);
        let apart = differences(&case.records[second], &case.records[last]).expect("one programme");
        let span = span(evidence.whole.grids[second].interval_s);
        let sigma = evidence.whole.grids[second].sigma;
        let square = |w: &[f64]| ((w[span] - w[0]) / sigma).powi(2) / 2.0;
        let n = (apart.len() - span) as f64;
        // Counting leaves two units of variance in an increment.
        let measured = (apart.windows(span + 1).map(square).sum::<f64>() / n - 2.0).max(0.0);
        [measured, scatter(&evidence.train, &values)[second]]
    }

    #[test]
    fn what_is_lost_by_chance_scatters_as_two_runs_differ() {
        let [measured, foretold] =
            measured_and_foretold(40_000_068, Hidden::LostCounts, Kind::LostCounts, vec![0.03, 2.0]);
        assert!(measured > 0.5 && (0.2..5.0).contains(&(foretold / measured)), "{measured} {foretold}");
    }

    #[test]
    fn laws_without_chance_need_no_allowance_and_chance_that_the_floor_holds_neither() {
        let case = Case::new(4, &[], CALM);
        let (evidence, base) = prepare(&case.records[..1], &case.held_out, &case.motor).unwrap();
        let values = base.values().with(Kind::Coulomb, vec![0.3]);
        assert_eq!(scatter(&evidence.train, &values), [0.0]);
        let floor = Errors { increments: 3.0, position: 3.0 };
        assert_eq!(allowances(&[0.0, 8.0], 8.0, &floor), [1.0, 1.0]);
        let [more] = allowances(&[35.0], 8.0, &floor)[..] else { panic!("one record") };
        assert!((more - 2.0).abs() < 1e-12, "1 besides 8 was measured, 1 besides 35 is expected: {more}");
    }
}
