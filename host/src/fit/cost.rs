//! What a fit makes small.
//!
//! The error of an open-loop simulation drifts: one lost count or one cog too many shifts everything after it. So candidates
//! are ranked by the error's 50 ms differences, under a pseudo-Huber loss, and polished on the error itself.

#![allow(unsafe_code, reason = "compiled for vector units that are asked for before they are used")]

use super::grid::{Grid, Quantity};
use super::loss::{MOST, bounded, loss, robust};
use super::scales::{append_coefficients, levels};
use super::simulate::{Block, LANES};
use motorlens_shared::lanes::Lanes;

/// Which error counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Differences over 50 ms, robust: for finding effects.
    Increments,
    /// The error of the open-loop simulation, less what its mean may be off for angles: for final parameters.
    Position,
    /// The error of the open-loop simulation by time scale ([`super::scales`]), each weighted by its own noise, robust.
    Scales,
}

/// Time that an increment takes, s.
const SPAN_S: f64 = 0.05;
/// Samples nearer than this repeat each other's differences.
const STRIDE_S: f64 = 0.002;

/// Every so many samples an increment begins, where samples come every `interval_s` seconds.
pub(super) fn stride(interval_s: f64) -> usize {
    ((STRIDE_S / interval_s).round() as usize).max(1)
}

/// Samples between the two of an increment, where they come every `interval_s` seconds.
fn span(interval_s: f64) -> usize {
    ((SPAN_S / interval_s).round() as usize).max(1)
}

/// What a record's predictions are wrong by, as an objective counts it.
struct Misfit<'a> {
    measured: &'a [f64],
    /// Samples that only lead in.
    skip: usize,
    scale: f64,
    stride: usize,
    /// Samples between the two of an increment; 0 where the error itself counts.
    span: usize,
    robust: bool,
    mean: [f64; LANES],
}

impl<'a> Misfit<'a> {
    #[inline(always)]
    fn new(grid: &'a Grid, objective: Objective, predictions: &[Block]) -> Self {
        let angle = grid.quantity == Quantity::Angle;
        let robust = objective == Objective::Increments;
        let mut misfit = Self {
            measured: &grid.measured,
            skip: grid.skip,
            scale: 1.0 / grid.sigma,
            stride: stride(grid.interval_s),
            span: if robust && angle { span(grid.interval_s) } else { 0 },
            robust,
            mean: [0.0; LANES],
        };
        if angle && !robust {
            let mut mean = [0.0; LANES];
            for k in grid.skip..predictions.len() {
                let error = misfit.error(predictions, k);
                for l in 0..LANES {
                    mean[l] += error[l] / (predictions.len() - grid.skip) as f64;
                }
            }
            let most = grid.offset() * misfit.scale;
            misfit.mean = mean.map(|mean| bounded(mean, most));
        }
        misfit
    }

    /// Residuals of so many samples.
    fn len(&self, samples: usize) -> usize {
        samples.saturating_sub(self.skip + self.span) / self.stride
    }

    /// The error of a sample in units of the record's noise.
    #[inline(always)]
    fn error(&self, predictions: &[Block], k: usize) -> [f64; LANES] {
        let (y, p) = (self.measured[k], &predictions[k].0);
        std::array::from_fn(|l| bounded((y - p[l]) * self.scale - self.mean[l], MOST))
    }

    /// Residual `k`, before the loss.
    #[inline(always)]
    fn residual(&self, predictions: &[Block], k: usize) -> [f64; LANES] {
        let first = self.skip + k * self.stride;
        let end = self.error(predictions, first + self.span);
        if self.span == 0 {
            return end;
        }
        let start = self.error(predictions, first);
        std::array::from_fn(|l| end[l] - start[l])
    }
}

/// Turns predictions into residuals in units of the record's noise, in place.
pub fn residuals(grid: &Grid, objective: Objective, series: &mut Vec<Block>) {
    #[cfg(target_arch = "x86_64")]
    if motorlens_kernel::has_wide() {
        // SAFETY: the processor has the features that the function was compiled for.
        unsafe { residuals_avx2(grid, objective, series) };
        return;
    }
    residuals_body(grid, objective, series);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn residuals_avx2(grid: &Grid, objective: Objective, series: &mut Vec<Block>) {
    residuals_body(grid, objective, series);
}

#[inline(always)]
fn residuals_body(grid: &Grid, objective: Objective, series: &mut Vec<Block>) {
    if objective == Objective::Scales {
        scaled(grid, series);
        return;
    }
    let misfit = Misfit::new(grid, objective, series);
    let n = misfit.len(series.len());
    for k in 0..n {
        let d = misfit.residual(series, k);
        series[k] = Lanes(if misfit.robust { d.map(robust) } else { d });
    }
    series.truncate(n);
}

/// The plain error, an angle's less what its mean may be off, since an encoder starts anywhere within a count: it is the one that an open-loop simulation has
/// ([`crate::compare::free_run`]); behind it the error by time scale ([`super::scales`]),
/// robust and in units of the noise at each scale.
#[inline(always)]
fn scaled(grid: &Grid, series: &mut Vec<Block>) {
    for (p, y) in series.iter_mut().zip(&grid.measured) {
        for l in 0..LANES {
            p.0[l] = bounded(y - p.0[l], MOST);
        }
    }
    let samples = series.len();
    append_coefficients(series);
    let even = grid.even_weight();
    let mean = if grid.mean_counts() { [0.0; LANES] } else { mean(&series[..samples]) };
    let mean = mean.map(|mean| bounded(mean, grid.even_offset));
    for e in &mut series[..samples] {
        for l in 0..LANES {
            e.0[l] = (e.0[l] - mean[l]) * even;
        }
    }
    let mut first = samples;
    let mut weight = 0.0;
    for (size, own) in levels(samples).into_iter().zip(grid.weights()) {
        for d in &mut series[first..first + size] {
            weigh(d, own);
        }
        first += size;
        weight = own;
    }
    // The mean is known from the longest scale's noise at best.
    if let Some(last) = series.last_mut() {
        if !grid.mean_counts() {
            let free = grid.offset() * (samples as f64).sqrt();
            for l in 0..LANES {
                last.0[l] -= bounded(last.0[l], free);
            }
        }
        weigh(last, weight);
    }
}

/// Robust errors in units of `1 / weight`.
///
/// A loop instead of a closure: one that is not inlined is compiled without the vector unit of its caller.
#[inline(always)]
fn weigh(errors: &mut Block, weight: f64) {
    for l in 0..LANES {
        errors.0[l] = robust(errors.0[l] * weight);
    }
}

/// Mean of each lane.
#[inline(always)]
fn mean(errors: &[Block]) -> [f64; LANES] {
    let mut mean = [0.0; LANES];
    for e in errors {
        for l in 0..LANES {
            mean[l] += e.0[l] / errors.len() as f64;
        }
    }
    mean
}

/// Sums of the squares of the same residuals, and how many they are; what is left of `predictions` has no meaning.
pub fn squares(grid: &Grid, objective: Objective, predictions: &mut Vec<Block>) -> ([f64; LANES], usize) {
    #[cfg(target_arch = "x86_64")]
    if motorlens_kernel::has_wide() {
        // SAFETY: the processor has the features that the function was compiled for.
        return unsafe { squares_avx2(grid, objective, predictions) };
    }
    squares_body(grid, objective, predictions)
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn squares_avx2(grid: &Grid, objective: Objective, predictions: &mut Vec<Block>) -> ([f64; LANES], usize) {
    squares_body(grid, objective, predictions)
}

#[inline(always)]
fn squares_body(grid: &Grid, objective: Objective, predictions: &mut Vec<Block>) -> ([f64; LANES], usize) {
    if objective == Objective::Scales {
        scaled(grid, predictions);
        let mut sums = [0.0; LANES];
        for d in predictions.iter() {
            for l in 0..LANES {
                sums[l] += d.0[l] * d.0[l];
            }
        }
        return (sums, predictions.len());
    }
    let misfit = Misfit::new(grid, objective, predictions);
    let n = misfit.len(predictions.len());
    let mut sums = [0.0; LANES];
    for k in 0..n {
        let d = misfit.residual(predictions, k);
        for l in 0..LANES {
            sums[l] += if misfit.robust { loss(d[l]) } else { d[l] * d[l] };
        }
    }
    (sums, n)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::tests::record;
    use crate::fit::normal::accumulate;

    /// A simulation that runs away ends in infinities and then in no number at all.
    #[test]
    fn a_run_that_is_lost_is_as_wrong_as_can_be_and_leaves_slopes_that_are_numbers() {
        let times: Vec<f64> = (0..300).map(|k| f64::from(k) * 1e-3).collect();
        let angle = Grid::new(&record(times, vec![1.0; 300]), 0.01);
        let lost = |k: usize, l: usize| {
            if k > 100 && l > 0 { [f64::INFINITY, f64::NAN, -f64::NAN][l % 3] } else { 0.1 }
        };
        for grid in [Grid { quantity: Quantity::Speed, ..angle.clone() }, angle] {
            for objective in [Objective::Increments, Objective::Position, Objective::Scales] {
                let at = |k: usize| Lanes(std::array::from_fn(|l| lost(k, l)));
                let mut series: Vec<Block> = (0..grid.len()).map(at).collect();
                let (costs, _) = squares(&grid, objective, &mut series.clone());
                assert!(
                    (1..LANES).all(|l| costs[l] > costs[0] && costs[l].is_finite()),
                    "{objective:?} {costs:?}"
                );
                residuals(&grid, objective, &mut series);
                let mut sums = vec![vec![0.0; 3]; 3];
                accumulate(&[series], &[0.0, 1e3, 1e3], &mut sums);
                assert!(sums.iter().flatten().all(|sum| sum.is_finite()), "{objective:?} {sums:?}");
            }
        }
    }

    /// As an open-loop simulation may be moved by a count and no further, a fit that ends further beside the measurement is wrong by that.
    #[test]
    fn what_an_angle_is_off_beyond_a_count_is_an_error() {
        let times: Vec<f64> = (0..256).map(|k| f64::from(k) * 1e-3).collect();
        let mut grid = Grid::new(&record(times, vec![1.0; 256]), 0.01);
        (grid.measured, grid.even, grid.even_offset) = (vec![0.0; 256], 1.0, grid.offset());
        let off = [0.0, 0.5, 1.0, 3.0, -3.0, 0.0, 0.0, 0.0].map(|counts| 0.01 * counts);
        let run = vec![Lanes(off); grid.len()];
        let (sums, count) = squares(&grid, Objective::Position, &mut run.clone());
        let root = sums.map(|sum| (sum / count as f64).sqrt() * grid.sigma);
        let beyond: [f64; 5] = [0.0, 0.0, 0.0, 0.02, 0.02];
        assert!(root.iter().zip(beyond).all(|(root, x)| (root - x).abs() < 1e-9), "{root:?}");
        let (sums, _) = squares(&grid, Objective::Scales, &mut run.clone());
        assert!(sums[..3].iter().all(|sum| *sum < 1e-12) && sums[3] > 256.0 * 0.02_f64.powi(2), "{sums:?}");
        // While effects are chosen a run may be anywhere but for the one coefficient that is its mean.
        grid.even_offset = f64::INFINITY;
        let (chosen, _) = squares(&grid, Objective::Scales, &mut run.clone());
        assert!(((sums[3] - chosen[3]) / (256.0 * 0.02_f64.powi(2)) - 1.0).abs() < 1e-9, "{chosen:?}");
    }

    /// With samples that only lead in, at 1 kHz where every second one counts, of an angle and of a speed.
    #[test]
    fn sums_of_squares_are_those_of_the_residuals() {
        let times: Vec<f64> = (0..3000).map(|k| f64::from(k) * 1e-3).collect();
        let angle = Grid::new(&record(times, vec![1.0; 3000]), 0.01).rest(0.1);
        let speed = Grid { quantity: Quantity::Speed, ..angle.clone() };
        for grid in [angle, speed] {
            assert!(grid.skip > 0);
            let lane = |t: f64, l: usize| 3.0 * t + 0.2 * (t * (7.0 + l as f64)).sin();
            let at = |t: &f64| Lanes(std::array::from_fn(|l| lane(*t, l)));
            let predictions: Vec<Block> = grid.time_s.iter().map(at).collect();
            for objective in [Objective::Increments, Objective::Position] {
                let mut series = predictions.clone();
                residuals(&grid, objective, &mut series);
                let (sums, count) = squares(&grid, objective, &mut predictions.clone());
                assert_eq!(count, series.len());
                for (l, sum) in sums.into_iter().enumerate() {
                    let expected: f64 = series.iter().map(|r| r.0[l].powi(2)).sum();
                    assert!((sum / expected - 1.0).abs() < 1e-12, "{objective:?} {sum} {expected}");
                }
            }
        }
    }
}
