//! What a fit makes small.
//!
//! The error of a free run drifts: one lost count or one cog too many shifts everything after it. So candidates
//! are ranked by the error's *increments* over 50 ms, under a pseudo-Huber loss, and polished on the error itself.

use super::grid::{Grid, Quantity};
use super::simulate::{Block, LANES};
use motorlens_shared::lanes::Lanes;

/// Which error counts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Objective {
    /// Increments over 50 ms, robust: for finding effects.
    Increments,
    /// The error of the free run, its mean removed for angles: for final parameters.
    Position,
}

/// Span of an increment, s.
pub const SPAN_S: f64 = 0.05;
/// Samples nearer than this repeat each other's increments.
const STRIDE_S: f64 = 0.002;
/// Beyond this many noise units the loss grows linearly.
pub const HUBER: f64 = 6.0;

/// Every so many samples an increment begins, where samples come every `interval_s` seconds.
pub(super) fn stride(interval_s: f64) -> usize {
    ((STRIDE_S / interval_s).round() as usize).max(1)
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
    let scale = 1.0 / grid.sigma;
    series.drain(..grid.skip);
    for (prediction, y) in series.iter_mut().zip(&grid.measured[grid.skip..]) {
        for l in 0..LANES {
            prediction.0[l] = (y - prediction.0[l]) * scale;
        }
    }
    let stride = stride(grid.interval_s);
    match (objective, grid.quantity) {
        (Objective::Increments, Quantity::Angle) => {
            let span = ((SPAN_S / grid.interval_s).round() as usize).max(1);
            let n = series.len().saturating_sub(span) / stride;
            for k in 0..n {
                let (a, b) = (series[k * stride], series[k * stride + span]);
                series[k] = Lanes(std::array::from_fn(|l| robust(b.0[l] - a.0[l])));
            }
            series.truncate(n);
        }
        (Objective::Position, Quantity::Angle) => {
            let n = series.len();
            let mut mean = [0.0; LANES];
            for r in series.iter() {
                for l in 0..LANES {
                    mean[l] += r.0[l] / n as f64;
                }
            }
            thin(series, stride, |r, l| r - mean[l]);
        }
        (Objective::Increments, _) => thin(series, stride, |r, _| robust(r)),
        (Objective::Position, _) => thin(series, stride, |r, _| r),
    }
}

#[inline(always)]
fn thin(series: &mut Vec<Block>, stride: usize, map: impl Fn(f64, usize) -> f64) {
    let n = series.len() / stride;
    for k in 0..n {
        let r = series[k * stride];
        series[k] = Lanes(std::array::from_fn(|l| map(r.0[l], l)));
    }
    series.truncate(n);
}

/// Square root of the pseudo-Huber loss, with the sign of `d`: its square is d^2 for small d, linear for large.
///
/// d sqrt(2 / (1 + sqrt(1 + (d/D)^2))) is the same number without cancellation.
#[inline(always)]
pub fn robust(d: f64) -> f64 {
    let limited = d.clamp(-1e7, 1e7);
    let x = limited * (1.0 / HUBER);
    limited * (2.0 / (1.0 + (1.0 + x * x).sqrt())).sqrt()
}

/// Sums over a record's residuals of centre (lane 0 of the first block) and neighbours.
///
/// `blocks[b]` holds lanes 8 b ..; lane f > 0 is the neighbour along axis f - 1, `inverse_delta[f]` apart. The
/// result is the upper part of M = sum c c^T with c = (r, J): `M[0][0]` the cost, `M[0][k]` the gradient.
pub fn accumulate(blocks: &[Vec<Block>], inverse_delta: &[f64], sums: &mut [Vec<f64>]) {
    #[cfg(target_arch = "x86_64")]
    if motorlens_kernel::has_wide() {
        // SAFETY: the processor has the features that the function was compiled for.
        unsafe { accumulate_avx2(blocks, inverse_delta, sums) };
        return;
    }
    accumulate_body(blocks, inverse_delta, sums);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn accumulate_avx2(blocks: &[Vec<Block>], inverse_delta: &[f64], sums: &mut [Vec<f64>]) {
    accumulate_body(blocks, inverse_delta, sums);
}

/// Most blocks that a Jacobian takes: 23 axes.
pub const MOST_BLOCKS: usize = 3;

#[inline(always)]
fn accumulate_body(blocks: &[Vec<Block>], inverse_delta: &[f64], sums: &mut [Vec<f64>]) {
    let used = inverse_delta.len();
    let mut total = [[[0.0; LANES]; MOST_BLOCKS]; LANES * MOST_BLOCKS];
    let mut inverse = [[0.0; LANES]; MOST_BLOCKS];
    for (f, d) in inverse_delta.iter().enumerate() {
        inverse[f / LANES][f % LANES] = *d;
    }
    for k in 0..blocks[0].len() {
        let centre = blocks[0][k].0[0];
        let mut c = [[0.0; LANES]; MOST_BLOCKS];
        for (b, block) in blocks.iter().enumerate() {
            for l in 0..LANES {
                c[b][l] = (block[k].0[l] - centre) * inverse[b][l];
            }
        }
        c[0][0] = centre;
        for f in 0..used {
            let x = c[f / LANES][f % LANES];
            for b in 0..blocks.len() {
                for l in 0..LANES {
                    total[f][b][l] += x * c[b][l];
                }
            }
        }
    }
    for f in 0..used {
        for g in 0..used {
            sums[f][g] += total[f][g / LANES][g % LANES];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn small_errors_count_squared_and_large_ones_linearly() {
        assert!((robust(0.1) / 0.1 - 1.0).abs() < 1e-3);
        let (a, b) = (robust(1e3).powi(2), robust(2e3).powi(2));
        assert!((b / a - 2.0).abs() < 0.02);
        assert_eq!(robust(-3.0), -robust(3.0));
    }
}
