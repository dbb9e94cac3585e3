//! Orders of torque ripple, from the data alone.
//!
//! A weak form of the base equation needs neither simulation nor differentiation: multiplied by a smooth bump and
//! integrated by parts, it is linear in its parameters. What it leaves over, projected on sines of the measured
//! motor angle, shows how many periods a revolution has.

use nalgebra::{DMatrix, DVector};

use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::BaseValues;
use crate::fit::search::Problem;

/// Highest order looked for, periods per motor revolution.
const HIGHEST_ORDER: usize = 24;
/// Width of the bump, s.
const WIDTH_S: f64 = 0.05;
/// ... or in samples, where these are slow.
const FEWEST_SAMPLES: usize = 9;

/// Starting parameters (sine, cosine, order) of the strongest orders.
pub fn starts(problem: &Problem, base: &BaseValues) -> Vec<Vec<f64>> {
    let left: Vec<Leftover> = problem.grids.iter().filter_map(|g| Leftover::new(g, base)).collect();
    if left.is_empty() {
        return Vec::new();
    }
    let per_order = problem.rig.gear_ratio;
    let mut found: Vec<(f64, Vec<f64>)> = (1..=HIGHEST_ORDER)
        .filter_map(|order| {
            let (gain, sine, cosine) = explained(&left, order as f64 * per_order)?;
            Some((gain, vec![sine, cosine, order as f64]))
        })
        .collect();
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    found.truncate(3);
    // The weak form smooths a little: try the amplitude found and somewhat more.
    found.into_iter().flat_map(|(_, p)| [1.0, 1.6].map(|f| vec![-f * p[0], -f * p[1], p[2]])).collect()
}

/// Torque that the base leaves over in windows of one record, and the angles measured there.
struct Leftover {
    bump: [Vec<f64>; 4],
    stride: usize,
    angles: Vec<f64>,
    torque: Vec<f64>,
}

impl Leftover {
    fn new(grid: &Grid, base: &BaseValues) -> Option<Self> {
        let n = ((WIDTH_S / grid.interval_s) as usize).max(FEWEST_SAMPLES) | 1;
        if grid.quantity != Quantity::Angle || grid.len() < 4 * n {
            return None;
        }
        let bump = bump_and_derivatives(n, grid.interval_s);
        let stride = (n / 6).max(1);
        let per_sample = (grid.interval_s / grid.step_s).round().max(1.0) as usize;
        let volts: Vec<f64> =
            (0..grid.len()).map(|k| grid.cells().get(k * per_sample).copied().unwrap_or(0.0)).collect();
        let windows = |x: &[f64], b: &[f64]| correlate(x, b, stride);
        // v = (tau_m / gain) w' + w / gain + (tau_m tau_e / gain) w'' + friction sign(w) + rest
        let y = &grid.measured;
        let v = windows(&volts, &bump[0]);
        let w: Vec<f64> = windows(y, &bump[1]).iter().map(|x| -x).collect();
        let a = windows(y, &bump[2]);
        let jerk: Vec<f64> = windows(y, &bump[3]).iter().map(|x| -x).collect();
        let area: f64 = bump[0].iter().sum();
        let still = 0.004 * base.gain * v.iter().fold(0.0_f64, |m, x| m.max(x.abs())) / area;
        let sign: Vec<f64> =
            w.iter().map(|x| if x.abs() / area < still { 0.0 } else { x.signum() * area }).collect();
        let columns = [&w, &a, &jerk, &sign];
        let design = DMatrix::from_fn(v.len(), columns.len(), |r, c| columns[c][r]);
        let right = DVector::from_vec(v);
        let solution = design.clone().svd(true, true).solve(&right, 1e-10).ok()?;
        let torque = (&right - &design * solution).iter().copied().collect();
        Some(Self { bump, stride, angles: y.clone(), torque })
    }
}

/// Share of the leftover that sine and cosine of `per_rad` x explain, and their amplitudes.
fn explained(left: &[Leftover], per_rad: f64) -> Option<(f64, f64, f64)> {
    let (mut ss, mut cc, mut sc, mut ys, mut yc) = (0.0, 0.0, 0.0, 0.0, 0.0);
    for record in left {
        let wave = |f: fn(f64) -> f64| {
            let x: Vec<f64> = record.angles.iter().map(|a| f(a * per_rad)).collect();
            correlate(&x, &record.bump[0], record.stride)
        };
        let (sine, cosine) = (wave(f64::sin), wave(f64::cos));
        for ((y, s), c) in record.torque.iter().zip(&sine).zip(&cosine) {
            ss += s * s;
            cc += c * c;
            sc += s * c;
            ys += y * s;
            yc += y * c;
        }
    }
    let determinant = ss * cc - sc * sc;
    if determinant <= 1e-12 * ss * cc {
        return None;
    }
    let sine = (ys * cc - yc * sc) / determinant;
    let cosine = (yc * ss - ys * sc) / determinant;
    Some((sine * ys + cosine * yc, sine, cosine))
}

/// Sums of `x` under the bump, every `stride` samples.
fn correlate(x: &[f64], bump: &[f64], stride: usize) -> Vec<f64> {
    x.windows(bump.len()).step_by(stride).map(|w| w.iter().zip(bump).map(|(a, b)| a * b).sum()).collect()
}

/// (1 - s^2)^4 over `n` samples and its first three derivatives in time, each times the sampling interval.
fn bump_and_derivatives(n: usize, interval: f64) -> [Vec<f64>; 4] {
    let half = interval * (n - 1) as f64 / 2.0;
    let at = |f: fn(f64) -> f64, power: i32| -> Vec<f64> {
        (0..n).map(|k| f(2.0 * k as f64 / (n - 1) as f64 - 1.0) * interval / half.powi(power)).collect()
    };
    [
        at(|s| (1.0 - s * s).powi(4), 0),
        at(|s| -8.0 * s * (1.0 - s * s).powi(3), 1),
        at(|s| (1.0 - s * s).powi(2) * (56.0 * s * s - 8.0), 2),
        at(|s| (1.0 - s * s) * (144.0 * s - 336.0 * s * s * s), 3),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn derivatives_of_the_bump_match_differences() {
        let [b, d1, d2, d3] = bump_and_derivatives(2001, 1e-3);
        for (f, d) in [(&b, &d1), (&d1, &d2), (&d2, &d3)] {
            let peak = d.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            for k in 10..1990 {
                let slope = (f[k + 1] - f[k - 1]) / 2e-3;
                assert!((slope - d[k]).abs() < 1e-4 * peak, "at {k}");
            }
        }
    }
}
