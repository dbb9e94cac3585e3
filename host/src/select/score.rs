//! The criterion: held-out log-likelihood of a model, block by block.
//!
//! The likelihood is Whittle's, on wavelet scales instead of frequencies, under a noise that is told with the score. What a block would
//! score had the fit not seen it follows from the block's influence on the parameters, g' H^-1 g (leave-one-out by one Newton step:
//! R. Cook and S. Weisberg, *Residuals and Influence in Regression*, 1982; A. Vehtari et al., *Statistics and Computing* 27, 2017).
//! Two models are compared in [`super::gain`].

use std::collections::BTreeMap;

use nalgebra::{DMatrix, DVector};

use crate::fit::cost::Objective;
use crate::fit::grid::Grid;
use crate::fit::layout::Layout;
use crate::fit::noise::{Coefficients, FREEDOM, Noise, octave};
use crate::fit::scales::levels;
use crate::fit::search::{PRIOR_WEIGHT, Problem};
use crate::fit::simulate::LANES;

/// Length of a block, s: several mechanical time constants ...
const BLOCK_S: f64 = 1.0;
/// ... and less where so few blocks would be all: of four blocks nothing is sure.
const FEWEST: f64 = 16.0;

/// Duration of a record, s.
fn span(grid: &Grid) -> f64 {
    grid.time_s.last().unwrap_or(&0.0) - grid.time_s.first().unwrap_or(&0.0)
}

/// Blocks of each record of `problem`.
fn blocks(problem: &Problem) -> Vec<usize> {
    counts(&problem.grids.iter().map(span).collect::<Vec<_>>())
}

/// The same of records of so many seconds.
fn counts(spans: &[f64]) -> Vec<usize> {
    let length = BLOCK_S.min(spans.iter().sum::<f64>() / FEWEST);
    spans.iter().map(|span| ((span / length).round() as usize).max(1)).collect()
}

/// The block that coefficient `k` of level `j` of a record belongs to, of `count` blocks and `samples` samples: where its middle lies. It is one
/// observation, however long: shared among the blocks that it spans, what a disturbance did once would be seen many times.
fn holder(k: usize, j: usize, count: usize, samples: usize) -> usize {
    let span = 1usize << (j + 1).min(40);
    let middle = (k * span + span / 2).min(samples.saturating_sub(1));
    (middle * count / samples.max(1)).min(count - 1)
}

/// How well a model predicts: what it leaves of every record, and what its fit owes to each block.
#[derive(Debug, Clone)]
pub struct Scored {
    errors: Vec<Coefficients>,
    /// Blocks and samples of each record.
    shapes: Vec<(usize, usize)>,
    /// What leaving a block out of the fit would cost it, octave by octave, under a noise of variance one.
    influences: Vec<Vec<(i32, f64)>>,
}

impl Scored {
    /// The model of `layout` at `x`, which leaves `errors` of the records of `problem`, and was fitted to them weighed by `noise`.
    pub fn new(
        problem: &Problem,
        layout: &Layout,
        x: &[f64],
        errors: Vec<Coefficients>,
        noise: &Noise,
    ) -> Self {
        let mut influences = influences(problem, layout, x);
        for (octave, cost) in influences.iter_mut().flatten() {
            *cost *= noise.variance(*octave);
        }
        Self { influences, ..Self::unfitted(problem, errors) }
    }

    /// Of `errors` that no fit to the records of `problem` has made smaller.
    pub fn unfitted(problem: &Problem, errors: Vec<Coefficients>) -> Self {
        let shapes: Vec<(usize, usize)> =
            blocks(problem).into_iter().zip(problem.grids.iter().map(Grid::len)).collect();
        let influences = vec![Vec::new(); shapes.iter().map(|(blocks, _)| blocks).sum()];
        Self { errors, shapes, influences }
    }

    /// The same with `factor` times a `signal`, in units of `noise`, beside what is left of each record.
    #[must_use]
    pub fn with(&self, signal: &[Vec<f64>], factor: f64, noise: &Noise) -> Self {
        let errors = self.errors.iter().zip(signal).map(|(left, signal)| left.with(signal, factor, noise));
        Self { errors: errors.collect(), shapes: self.shapes.clone(), influences: self.influences.clone() }
    }

    /// Blocks of all records.
    pub fn blocks(&self) -> usize {
        self.shapes.iter().map(|(blocks, _)| blocks).sum()
    }

    /// Score of every block of every record under `noise`, natural logarithms; higher is better.
    pub fn under(&self, noise: &Noise) -> Vec<f64> {
        let mut scores = self.likelihoods(noise);
        for (score, costs) in scores.iter_mut().zip(&self.influences) {
            // The Newton step stays that of the fit; what it costs is measured by `noise`.
            let cost: f64 = costs.iter().map(|(octave, cost)| cost / noise.variance(*octave)).sum();
            // Far from the minimum one Newton step tells nothing: then the block's own score bounds what it can cost.
            *score -= cost.max(0.0).min(20.0 + 0.5 * score.abs());
        }
        scores
    }

    fn likelihoods(&self, noise: &Noise) -> Vec<f64> {
        let mut scores = Vec::new();
        for ((count, samples), record) in self.shapes.iter().zip(&self.errors) {
            let mut own = vec![0.0; *count];
            for (j, (octave, level)) in record.octaves.iter().zip(&record.levels).enumerate() {
                let v = noise.variance(*octave);
                let offset = -0.5 * v.ln();
                for (k, d) in level.iter().enumerate() {
                    let score =
                        offset - 0.5 * (FREEDOM + 1.0) * (f64::from(*d).powi(2) / (FREEDOM * v)).ln_1p();
                    own[holder(k.min(level.len() - 1), j, *count, *samples)] += score;
                }
            }
            scores.extend(own);
        }
        scores
    }
}

/// What leaving a block out of the fit would cost it, octave by octave, under the noise that weighs `problem`.
fn influences(problem: &Problem, layout: &Layout, x: &[f64]) -> Vec<Vec<(i32, f64)>> {
    let free = layout.free();
    let n = free.len();
    let mut h = DMatrix::<f64>::zeros(n, n);
    let mut gradients: Vec<BTreeMap<i32, DVector<f64>>> = Vec::new();
    let mut counts = blocks(problem).into_iter();
    problem.neighbours(layout, Objective::Scales, x, &free, &mut |grid, record, inverse| {
        let count = counts.next().unwrap_or(1);
        let mut own = vec![BTreeMap::new(); count];
        let sizes = levels(grid.len());
        // The plain error stands before the coefficients.
        let mut at = grid.len();
        let mut row = DVector::zeros(n);
        for (j, size) in sizes.iter().enumerate() {
            let octave = octave(grid.interval_s, j);
            // The mean stands behind the last level.
            let size = if j + 1 == sizes.len() { size + 1 } else { *size };
            for k in 0..size.min(record[0].len() - at) {
                let centre = record[0][at + k].0[0];
                for f in 0..n {
                    row[f] = (record[(f + 1) / LANES][at + k].0[(f + 1) % LANES] - centre) * inverse[f + 1];
                }
                h.ger(1.0, &row, &row, 1.0);
                let block = &mut own[holder(k, j, count, grid.len())];
                block.entry(octave).or_insert_with(|| DVector::zeros(n)).axpy(centre, &row, 1.0);
            }
            at += size;
        }
        gradients.extend(own);
    });
    for (f, k) in free.iter().enumerate() {
        if let Some((_, slope)) = layout.axes[*k].doubt(x[*k]) {
            h[(f, f)] += PRIOR_WEIGHT * slope * slope;
        }
        h[(f, f)] = h[(f, f)] * (1.0 + 1e-9) + 1e-9;
    }
    // What the sum of gradients leaves is how far the search stopped short, no block's influence.
    let mut mean: BTreeMap<i32, DVector<f64>> = BTreeMap::new();
    for (octave, g) in gradients.iter().flatten() {
        mean.entry(*octave).or_insert_with(|| DVector::zeros(n)).axpy(1.0 / gradients.len() as f64, g, 1.0);
    }
    let Some(factor) = h.cholesky() else { return vec![Vec::new(); gradients.len()] };
    gradients
        .iter()
        .map(|block| {
            let own = |octave: &i32| block.get(octave).map_or(-&mean[octave], |g| g - &mean[octave]);
            let all = mean.keys().map(own).fold(DVector::zeros(n), |sum, g| sum + g);
            let step = factor.solve(&all);
            mean.keys().map(|octave| (*octave, own(octave).dot(&step))).collect()
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_coefficient_belongs_to_the_block_where_its_middle_lies() {
        assert_eq!(holder(0, 0, 4, 400), 0);
        assert_eq!(holder(199, 0, 4, 400), 3);
        assert_eq!(holder(0, 8, 4, 400), 2);
        assert_eq!(holder(1, 6, 4, 400), 1);
        assert_eq!(holder(0, 40, 4, 400), 3, "longer than the record");
    }

    #[test]
    fn blocks_last_a_second_and_less_where_the_records_are_short() {
        assert_eq!(counts(&[24.0, 12.4]), [24, 12]);
        assert_eq!(counts(&[4.0]), [16], "whatever clock a log of no stamps is given, it has as many");
        assert_eq!(counts(&[0.4, 0.4, 0.0]), [8, 8, 1]);
    }
}
