//! What a perfect model would leave, in noise units of one reading: the unit of every error of a candidate.
//!
//! Counting alone leaves 1. What disturbs the motor leaves more, and only a repeated programme shows how much.

use super::candidate::Errors;
use crate::fit::cost::{SPAN_S, robust};
use crate::fit::grid::Quantity;
use crate::fit::search::Problem;
use crate::log::Record;
use crate::log::repeats::{differences, find_repeats};

/// The floor under `records`, which `problem` has laid out; none where no programme was repeated.
pub fn floor(records: &[Record], problem: &Problem) -> Option<Errors> {
    let mut squares = Errors { increments: 0.0, position: 0.0 };
    let mut pairs = 0.0;
    for (first, second) in find_repeats(records) {
        let grid = &problem.grids[first];
        let Some(difference) = differences(&records[first], &records[second]) else { continue };
        // Half of the difference's variance is each run's.
        let scale = 1.0 / (grid.sigma * std::f64::consts::SQRT_2);
        let noise: Vec<f64> = difference.iter().map(|d| d * scale).collect();
        let span = ((SPAN_S * noise.len() as f64 / records[first].duration_s()).round() as usize).max(1);
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
            let (problem, _) = setup::problem(&case.records, &case.motor);
            let floor = floor(&case.records, &problem).expect("the multisine runs twice");
            assert!((low..high).contains(&floor.increments), "{disturbed}: {floor:?}");
        }
    }
}
