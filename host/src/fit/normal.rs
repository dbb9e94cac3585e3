//! The normal equations of a least-squares step, summed over a record's residuals.

#![allow(unsafe_code, reason = "compiled for vector units that are asked for before they are used")]

use super::simulate::{Block, LANES};

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
const MOST_BLOCKS: usize = 3;

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
