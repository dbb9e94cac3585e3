//! The criterion: held-out log-likelihood of a model, block by block.
//!
//! A model is scored with its own noise (the likelihood is concentrated in it: Whittle's, on wavelet scales instead of frequencies).
//! What a block would score had the fit not seen it follows from the block's influence on the parameters, g' H^-1 g (leave-one-out
//! by one Newton step: R. Cook and S. Weisberg, *Residuals and Influence in Regression*, 1982; A. Vehtari et al., *Statistics and
//! Computing* 27, 2017). Two models are compared by the paired differences of their blocks, whose scatter, with its
//! autocorrelation, says how sure the difference is.

use nalgebra::{DMatrix, DVector};

use super::noise::{Coefficients, FREEDOM, Noise};
use crate::fit::cost::Objective;
use crate::fit::grid::Grid;
use crate::fit::layout::Layout;
use crate::fit::scales::levels;
use crate::fit::search::{PRIOR_WEIGHT, Problem};
use crate::fit::simulate::LANES;

/// Length of a block, s: several mechanical time constants.
const BLOCK_S: f64 = 1.0;

/// Blocks of a record.
fn blocks(grid: &Grid) -> usize {
    let span = grid.time_s.last().unwrap_or(&0.0) - grid.time_s.first().unwrap_or(&0.0);
    ((span / BLOCK_S).round() as usize).max(1)
}

/// The blocks over which coefficient `k` of level `j` of a record spreads, of `count` blocks and `samples` samples.
fn spread(k: usize, j: usize, count: usize, samples: usize) -> std::ops::RangeInclusive<usize> {
    let span = 1usize << (j + 1).min(40);
    let block = |sample: usize| (sample * count / samples.max(1)).min(count - 1);
    let first = (k * span).min(samples.saturating_sub(1));
    block(first)..=block((first + span - 1).min(samples.saturating_sub(1)))
}

/// Score of every block of every record, natural logarithms; higher is better.
pub fn scores(
    problem: &Problem,
    layout: &Layout,
    x: &[f64],
    errors: &[Coefficients],
    noise: &Noise,
) -> Vec<f64> {
    let mut scores = likelihoods(problem, errors, noise);
    for (score, cost) in scores.iter_mut().zip(influences(problem, layout, x)) {
        // Far from the minimum one Newton step tells nothing: then the block's own score bounds what it can cost.
        *score -= cost.min(20.0 + 0.5 * score.abs());
    }
    scores
}

fn likelihoods(problem: &Problem, errors: &[Coefficients], noise: &Noise) -> Vec<f64> {
    let mut scores = Vec::new();
    for (grid, record) in problem.grids.iter().zip(errors) {
        let count = blocks(grid);
        let mut own = vec![0.0; count];
        for (j, (octave, level)) in record.octaves.iter().zip(&record.levels).enumerate() {
            let v = noise.variance(*octave);
            let offset = -0.5 * v.ln();
            for (k, d) in level.iter().enumerate() {
                let score = offset - 0.5 * (FREEDOM + 1.0) * (d * d / (FREEDOM * v)).ln_1p();
                let range = spread(k.min(level.len() - 1), j, count, grid.len());
                let share = score / range.clone().count() as f64;
                range.for_each(|b| own[b] += share);
            }
        }
        scores.extend(own);
    }
    scores
}

/// What leaving a block out of the fit would cost it.
fn influences(problem: &Problem, layout: &Layout, x: &[f64]) -> Vec<f64> {
    let free = layout.free();
    let n = free.len();
    let mut h = DMatrix::<f64>::zeros(n, n);
    let mut gradients: Vec<DVector<f64>> = Vec::new();
    problem.neighbours(layout, Objective::Scales, x, &free, &mut |grid, record, inverse| {
        let count = blocks(grid);
        let mut own = vec![DVector::zeros(n); count];
        let sizes = levels(grid.len());
        let mut at = 0;
        let mut row = DVector::zeros(n);
        for (j, size) in sizes.iter().enumerate() {
            // The mean stands behind the last level.
            let size = if j + 1 == sizes.len() { size + 1 } else { *size };
            for k in 0..size.min(record[0].len() - at) {
                let centre = record[0][at + k].0[0];
                for f in 0..n {
                    row[f] = (record[(f + 1) / LANES][at + k].0[(f + 1) % LANES] - centre) * inverse[f + 1];
                }
                h.ger(1.0, &row, &row, 1.0);
                let range = spread(k, j, count, grid.len());
                let share = centre / range.clone().count() as f64;
                range.for_each(|b| own[b].axpy(share, &row, 1.0));
            }
            at += size;
        }
        gradients.extend(own);
    });
    for (f, k) in free.iter().enumerate() {
        if let Some((_, width)) = layout.axes[*k].prior {
            h[(f, f)] += PRIOR_WEIGHT / (width * width);
        }
        h[(f, f)] = h[(f, f)] * (1.0 + 1e-9) + 1e-9;
    }
    // What the sum of gradients leaves is how far the search stopped short, no block's influence.
    let mean = gradients.iter().sum::<DVector<f64>>() / gradients.len().max(1) as f64;
    let Some(factor) = h.cholesky() else { return vec![0.0; gradients.len()] };
    gradients
        .iter()
        .map(|g| {
            let g = g - &mean;
            g.dot(&factor.solve(&g)).max(0.0)
        })
        .collect()
}

/// One block speaks for at most so much, natural logarithms, when it is asked how sure a gain is: a few blocks in which a wrong law goes
/// astray are no proof, and must not hide what all others say.
const MOST_OF_A_BLOCK: f64 = 5.0;

/// How much better one model is than another on blocks that neither was fitted to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Gain {
    /// Sum of the differences, natural logarithms.
    pub total: f64,
    /// The same with every block's part bounded, over its standard error.
    pub sure: f64,
}

impl Gain {
    /// Of `new` over `old`, scores block by block.
    pub fn of(new: &[f64], old: &[f64]) -> Self {
        let differences: Vec<f64> = new.iter().zip(old).map(|(a, b)| a - b).collect();
        let n = differences.len().max(2) as f64;
        let total = differences.iter().sum::<f64>();
        let bounded: Vec<f64> =
            differences.iter().map(|d| d.clamp(-MOST_OF_A_BLOCK, MOST_OF_A_BLOCK)).collect();
        let mean = bounded.iter().sum::<f64>() / n;
        let off: Vec<f64> = bounded.iter().map(|d| d - mean).collect();
        let variance = off.iter().map(|d| d * d).sum::<f64>() / (n - 1.0);
        let lagged = off.windows(2).map(|w| w[0] * w[1]).sum::<f64>() / (n - 1.0);
        let long_run = (variance + 2.0 * lagged.max(0.0)).max(1e-12);
        // Where every block says the same, a block's own bound is all the doubt there is.
        let error = (n * long_run.max(0.25)).sqrt();
        Self { total, sure: mean * n / error }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_that_every_block_shares_is_sure_and_one_of_a_single_block_is_not() {
        let old = vec![0.0; 40];
        let even: Vec<f64> = (0..40).map(|k| 1.0 + 0.1 * f64::from(k % 3)).collect();
        let mut single = vec![0.0; 40];
        single[7] = 44.0;
        let (even, single) = (Gain::of(&even, &old), Gain::of(&single, &old));
        assert!(even.total > 40.0 && even.sure > 10.0, "{even:?}");
        assert!(single.total > 40.0 && single.sure < 1.7, "{single:?}");
    }

    #[test]
    fn a_coefficient_spreads_over_the_blocks_that_its_samples_lie_in() {
        assert_eq!(spread(0, 0, 4, 400), 0..=0);
        assert_eq!(spread(199, 0, 4, 400), 3..=3);
        assert_eq!(spread(0, 8, 4, 400), 0..=3);
        assert_eq!(spread(1, 6, 4, 400), 1..=2);
    }
}
