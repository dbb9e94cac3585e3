//! What a perfect model would leave, in noise units of one reading: the unit of every error of a candidate.
//!
//! Counting alone leaves 1. What disturbs the motor leaves more, and only a repeated programme shows how much.

use super::candidate::Errors;
use crate::fit::cost::{robust, span};
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::simulate::predict_one;
use crate::log::Record;
use crate::log::repeats::{differences, find_repeats};

/// Two runs of one programme.
#[derive(Debug, Clone)]
pub struct Repeat {
    /// Their places among the records, the earlier first.
    pub places: [usize; 2],
    /// What was recorded.
    pub runs: [Record; 2],
}

impl Repeat {
    /// The place of the later run.
    pub fn second(&self) -> usize {
        self.places[1]
    }
}

/// Every two of `records` that run one programme.
pub fn repeats_of(records: &[Record]) -> Vec<Repeat> {
    let repeat = |(first, second): (usize, usize)| Repeat {
        places: [first, second],
        runs: [records[first].clone(), records[second].clone()],
    };
    find_repeats(records).into_iter().map(repeat).collect()
}

/// The floor under the records that `problem` has laid out, by those that repeat a programme; none without.
///
/// The same command may be logged as different voltages, by a noisy measurement or a tired battery, and a PWM stands elsewhere
/// in its period when it comes. So the runs of the model `values` are taken off both first: what it lacks, it lacks in both.
pub fn floor(repeats: &[Repeat], problem: &Problem, values: &Values) -> Option<Errors> {
    let mut squares = Errors { increments: 0.0, position: 0.0 };
    let mut pairs = 0.0;
    for Repeat { places, runs } in repeats {
        let grid = &problem.grids[places[0]];
        let left = |k: usize| left_by(problem, values, &problem.grids[places[k]], &runs[k]);
        let Some(difference) = differences(&left(0), &left(1)) else { continue };
        // Half of the difference's variance is each run's.
        let scale = 1.0 / (grid.sigma * std::f64::consts::SQRT_2);
        let noise: Vec<f64> = difference.iter().map(|d| d * scale).collect();
        let span = span(runs[0].duration_s() / noise.len() as f64);
        let angle = grid.quantity == Quantity::Angle;
        let mean = if angle { noise.iter().sum::<f64>() / noise.len().max(1) as f64 } else { 0.0 };
        let steps: Vec<f64> = if angle {
            noise.windows(span + 1).map(|w| robust(w[span] - w[0])).collect()
        } else {
            noise.iter().map(|d| robust(*d)).collect()
        };
        squares.increments += mean_square(&steps, 0.0) / 2.0;
        squares.position += mean_square(&noise, mean);
        pairs += 1.0;
    }
    // Counting leaves 1 at least.
    let rms = |sum: f64| (sum / pairs).sqrt().max(1.0);
    (pairs > 0.0).then(|| Errors { increments: rms(squares.increments), position: rms(squares.position) })
}

/// `record` less the run of `values`, where it was laid out sample by sample; else as it is.
fn left_by(problem: &Problem, values: &Values, grid: &Grid, record: &Record) -> Record {
    let mut left = record.clone();
    let column = if record.angle_rad.is_some() { &mut left.angle_rad } else { &mut left.speed_rad_s };
    if let Some(column) = column.as_mut().filter(|column| column.len() == grid.len()) {
        let layout = problem.layout(&values.kinds());
        let plain = layout.all_plain(&layout.pack(values));
        let run = predict_one(&layout.kinds, &plain, &problem.rig, grid);
        column.iter_mut().zip(run).for_each(|(y, p)| *y -= p);
    }
    left
}

fn mean_square(values: &[f64], mean: f64) -> f64 {
    values.iter().map(|x| (x - mean).powi(2)).sum::<f64>() / values.len().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;

    /// A disturbance lifts the floor of the increments to what the true model leaves; without one it is counting's.
    #[test]
    fn a_disturbance_lifts_the_floor_and_counting_alone_does_not() {
        for (disturbed, low, high) in [(0.0, 1.0, 1.1), (1.0, 1.2, 1e3)] {
            let case = Case::new(12, &[], Conditions { disturbed, spoilt: 0.0 });
            let (problem, start) = setup::problem(&case.records, &case.motor);
            let floor =
                floor(&repeats_of(&case.records), &problem, &start).expect("the multisine runs twice");
            assert!((low..high).contains(&floor.increments), "{disturbed}: {floor:?}");
        }
    }
}
