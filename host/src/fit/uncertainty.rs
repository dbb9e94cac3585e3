//! How well the data determine each parameter.
//!
//! Residuals of a motor are anything but white, so J^T J alone promises far too narrow intervals. The
//! covariance here is the sandwich H^-1 M H^-1 (Huber 1967, White 1980) with M summed over blocks of half a
//! second, within which residuals may hang together as they like (the moving-block argument of Newey and West 1987).

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::cost::Objective;
use super::layout::{Layout, Values};
use super::search::{PRIOR_WEIGHT, Problem};
use super::simulate::LANES;

/// Residuals of one block may be correlated, s.
const BLOCK_S: f64 = 0.5;
/// Two-sided 95 % of the normal distribution.
const WIDTH: f64 = 1.96;
/// An interval of more than this share of the value either way identifies nothing.
const USEFUL: f64 = 0.5;
/// Where the data leave more than this share of the prior's width, the prior speaks.
const PRIOR_SPEAKS: f64 = 0.7;

/// A combination known to this share is known, whatever made it so.
const SHARP: f64 = 0.02;

/// A parameter with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// `gain`, or `coulomb.level`.
    pub name: String,
    /// Best value.
    pub value: f64,
    /// Unit of the three numbers.
    pub unit: String,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// The interval is finite, useful, and comes from these data and not from a belief.
    pub identifiable: bool,
}

/// A point in search numbers and its covariance.
#[derive(Debug, Clone)]
pub struct Spread {
    /// The axes.
    pub layout: Layout,
    /// Search numbers.
    pub x: Vec<f64>,
    /// Covariance over all axes; zero for fixed ones.
    pub covariance: DMatrix<f64>,
}

/// Every parameter of `values`, fitted on `problem`, with its interval.
pub fn estimates(problem: &Problem, values: &Values) -> Vec<Estimate> {
    let spread = Spread::of(problem, values);
    (0..spread.layout.len()).map(|k| spread.parameter(k)).collect()
}

impl Spread {
    /// The spread of `values` as `problem` determines them.
    pub fn of(problem: &Problem, values: &Values) -> Self {
        let layout = problem.layout(&values.kinds());
        let x = layout.pack(values);
        let free = layout.free();
        let n = free.len();
        let (mut h, mut m) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        problem.neighbours(&layout, Objective::Increments, &x, &free, &mut |grid, record, inverse| {
            let length = record[0].len();
            let span = grid.time_s[grid.len() - 1] - grid.time_s[0];
            let block = ((BLOCK_S / span.max(1e-9) * length as f64).round() as usize).max(1);
            for first in (0..length).step_by(block) {
                let mut gradient = DVector::zeros(n);
                for k in first..(first + block).min(length) {
                    let residual = record[0][k].0[0];
                    let row = DVector::from_fn(n, |f, _| {
                        let f = f + 1;
                        (record[f / LANES][k].0[f % LANES] - residual) * inverse[f]
                    });
                    gradient.axpy(residual, &row, 1.0);
                    h.ger(1.0, &row, &row, 1.0);
                }
                m.ger(1.0, &gradient, &gradient, 1.0);
            }
        });
        for (f, k) in free.iter().enumerate() {
            if let Some((_, width)) = layout.axes[*k].prior {
                let weight = PRIOR_WEIGHT / (width * width);
                h[(f, f)] += weight;
                // With no data at all, exactly the prior's width is left.
                m[(f, f)] += weight * PRIOR_WEIGHT;
            }
            h[(f, f)] *= 1.0 + 1e-12;
        }
        let inverse = h.try_inverse().unwrap_or_else(|| DMatrix::from_element(n, n, f64::INFINITY));
        let small = &inverse * m * &inverse;
        let mut covariance = DMatrix::zeros(layout.len(), layout.len());
        for (r, a) in free.iter().enumerate() {
            for (c, b) in free.iter().enumerate() {
                covariance[(*a, *b)] = small[(r, c)];
            }
        }
        Self { layout, x, covariance }
    }

    /// Standard deviation of search number `k`.
    pub fn deviation(&self, k: usize) -> f64 {
        let v = self.covariance[(k, k)];
        if v.is_finite() { v.max(0.0).sqrt() } else { f64::INFINITY }
    }

    /// Parameter `k` with its interval.
    pub fn parameter(&self, k: usize) -> Estimate {
        let a = &self.layout.axes[k];
        let half = WIDTH * self.deviation(k);
        let (x, value) = (self.x[k], self.layout.plain(k, self.x[k]));
        let end = |x: f64| self.layout.plain(k, x.clamp(a.low, a.high));
        let (low, high) = (end(x - half), end(x + half));
        let useful = (high - low) < 2.0 * USEFUL * value.abs() && half.is_finite();
        let from_data = a.prior.is_none_or(|(_, width)| half < WIDTH * PRIOR_SPEAKS * width);
        Estimate {
            name: a.name.clone(),
            value,
            unit: a.unit.into(),
            low,
            high,
            identifiable: a.fixed || useful && from_data,
        }
    }

    /// A positive function of the parameters with `slope` of its logarithm along the first axes.
    pub fn ratio(&self, name: &str, unit: &str, value: f64, slope: &[f64]) -> Estimate {
        let n = slope.len();
        let s = DVector::from_column_slice(slope);
        let variance = (s.transpose() * self.covariance.view((0, 0), (n, n)) * &s)[(0, 0)];
        let half = WIDTH * if variance.is_finite() { variance.max(0.0).sqrt() } else { f64::INFINITY };
        let believed: f64 = (0..n)
            .filter_map(|k| self.layout.axes[k].prior.map(|p| (slope[k] * p.1).powi(2)))
            .sum::<f64>()
            .sqrt();
        Estimate {
            name: name.into(),
            value,
            unit: unit.into(),
            low: value * (-half).exp(),
            high: value * half.min(700.0).exp(),
            identifiable: half < USEFUL
                && (half < SHARP || believed == 0.0 || half < WIDTH * PRIOR_SPEAKS * believed),
        }
    }
}
