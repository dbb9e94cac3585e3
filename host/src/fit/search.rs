//! Bounded Levenberg-Marquardt over the lanes.
//!
//! A Jacobian costs one pass of the lanes (centre and seven neighbours), and a step tries eight dampings in one
//! more pass. So an iteration is two passes, whatever the number of rejected steps.

use std::cell::Cell;

use motorlens_shared::effects::Rig;
use nalgebra::{DMatrix, DVector};

use super::cost::{Objective, accumulate, residuals};
use super::fixed::Fixed;
use super::grid::Grid;
use super::layout::{Layout, Prior};
use super::simulate::{Block, LANES, predict_block};

/// Records, rig and beliefs: everything a fit needs but the model.
#[derive(Debug)]
pub struct Problem {
    /// The records that are fitted.
    pub grids: Vec<Grid>,
    /// The rig they were made on.
    pub rig: Rig,
    /// Beliefs about the base.
    pub prior: Prior,
    /// Parameters that are known.
    pub fixed: Fixed,
    /// For how long a reading is held, s, where the records show that.
    pub hold_s: Option<f64>,
    /// Passes of one candidate through all records, so far.
    pub simulations: Cell<u64>,
}

/// A minimum, and the shape of the cost around it.
#[derive(Debug, Clone)]
pub struct Found {
    /// Search numbers.
    pub x: Vec<f64>,
    /// Sum of squared residuals, prior included.
    pub cost: f64,
    /// J^T J at `x`, prior included.
    pub curvature: DMatrix<f64>,
    /// Residuals that were summed.
    pub count: usize,
}

/// Weight of the prior against residuals of one noise unit.
pub(super) const PRIOR_WEIGHT: f64 = 9.0;

impl Problem {
    fn count_passes(&self, candidates: usize) {
        self.simulations.set(self.simulations.get() + candidates as u64);
    }

    fn prior_cost(&self, layout: &Layout, x: &[f64]) -> f64 {
        layout
            .axes
            .iter()
            .zip(x)
            .filter_map(|(a, x)| a.prior.map(|(centre, width)| ((x - centre) / width).powi(2)))
            .sum::<f64>()
            * PRIOR_WEIGHT
    }

    /// Sum of squared residuals of up to eight candidates.
    pub fn costs(&self, layout: &Layout, objective: Objective, xs: &[Vec<f64>]) -> Vec<f64> {
        let mut sums: Vec<f64> = xs.iter().map(|x| self.prior_cost(layout, x)).collect();
        let mut series = Vec::new();
        self.count_passes(xs.len());
        for grid in &self.grids {
            predict_block(layout, xs, &self.rig, grid, &mut series);
            residuals(grid, objective, &mut series);
            for r in &series {
                for (sum, v) in sums.iter_mut().zip(r.0) {
                    *sum += v * v;
                }
            }
        }
        sums.iter().map(|s| if s.is_finite() { *s } else { f64::MAX }).collect()
    }

    /// Sum of squared residuals of one candidate without the prior, and how many there are.
    pub fn sum_of_squares(&self, layout: &Layout, objective: Objective, x: &[f64]) -> (f64, usize) {
        let point = [x.to_vec()];
        let (mut sum, mut count) = (0.0, 0);
        let mut series = Vec::new();
        self.count_passes(1);
        for grid in &self.grids {
            predict_block(layout, &point, &self.rig, grid, &mut series);
            residuals(grid, objective, &mut series);
            sum += series.iter().map(|r| r.0[0] * r.0[0]).sum::<f64>();
            count += series.len();
        }
        (if sum.is_finite() { sum } else { f64::MAX }, count)
    }

    /// Axes that are searched.
    fn free(layout: &Layout) -> Vec<usize> {
        (0..layout.len()).filter(|k| !layout.axes[*k].fixed).collect()
    }

    /// Residual series of centre and neighbours, a vector of blocks per record.
    pub fn neighbours(
        &self,
        layout: &Layout,
        objective: Objective,
        x: &[f64],
        axes: &[usize],
    ) -> (Vec<Vec<Vec<Block>>>, Vec<f64>) {
        let mut points = vec![x.to_vec()];
        let mut inverse = vec![0.0];
        for &k in axes {
            let d = layout.step(k, x[k]);
            let mut moved = x.to_vec();
            moved[k] += d;
            points.push(moved);
            inverse.push(1.0 / d);
        }
        self.count_passes(points.len());
        let series = self
            .grids
            .iter()
            .map(|grid| {
                points
                    .chunks(LANES)
                    .map(|chunk| {
                        let mut series = Vec::with_capacity(grid.len());
                        predict_block(layout, chunk, &self.rig, grid, &mut series);
                        residuals(grid, objective, &mut series);
                        series
                    })
                    .collect()
            })
            .collect();
        (series, inverse)
    }

    /// Cost, gradient and curvature at `x` along `axes`.
    fn linearise(
        &self,
        layout: &Layout,
        objective: Objective,
        x: &[f64],
        axes: &[usize],
    ) -> (f64, DVector<f64>, DMatrix<f64>, usize) {
        let n = axes.len();
        let (series, inverse) = self.neighbours(layout, objective, x, axes);
        let mut sums = vec![vec![0.0; n + 1]; n + 1];
        for record in &series {
            accumulate(record, &inverse, &mut sums);
        }
        let mut gradient = DVector::from_fn(n, |r, _| sums[0][r + 1]);
        let mut curvature = DMatrix::from_fn(n, n, |r, c| sums[r + 1][c + 1]);
        for (r, &k) in axes.iter().enumerate() {
            if let Some((centre, width)) = layout.axes[k].prior {
                let weight = PRIOR_WEIGHT / (width * width);
                gradient[r] += weight * (x[k] - centre);
                curvature[(r, r)] += weight;
            }
        }
        let count = series.iter().map(|record| record[0].len()).sum();
        (sums[0][0] + self.prior_cost(layout, x), gradient, curvature, count)
    }

    /// Searches from `start` for at most `iterations` steps, until a step gains less than `tolerance` of the cost.
    pub fn search(
        &self,
        layout: &Layout,
        objective: Objective,
        start: &[f64],
        iterations: usize,
        tolerance: f64,
    ) -> Found {
        let free = Self::free(layout);
        let mut x: Vec<f64> = start.to_vec();
        for (x, a) in x.iter_mut().zip(&layout.axes) {
            *x = x.clamp(a.low, a.high);
        }
        let mut damping = 1e-3;
        let (mut cost, mut gradient, mut curvature, mut count) = self.linearise(layout, objective, &x, &free);
        for round in 0..iterations {
            let trials: Vec<Vec<f64>> = (0..LANES)
                .map(|l| damped_step(layout, &x, &free, &gradient, &curvature, damping * DAMPINGS[l]))
                .collect();
            let costs = self.costs(layout, objective, &trials);
            let best = (0..LANES).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
            if costs[best] >= cost {
                damping *= 3e3;
                if damping > 1e9 || round + 1 == iterations {
                    break;
                }
                continue;
            }
            let gain = (cost - costs[best]) / cost;
            x.clone_from(&trials[best]);
            damping = (damping * DAMPINGS[best]).clamp(1e-9, 1e6);
            (cost, gradient, curvature, count) = self.linearise(layout, objective, &x, &free);
            if gain < tolerance {
                break;
            }
        }
        Found { x, cost, curvature, count }
    }
}

/// Dampings tried side by side, against the last that worked.
const DAMPINGS: [f64; LANES] = [1e-3, 0.03, 0.3, 1.0, 5.0, 30.0, 300.0, 5e3];

/// Solves (H + damping diag H) dx = -g; axes pushed against a bound stand still.
fn damped_step(
    layout: &Layout,
    x: &[f64],
    free: &[usize],
    gradient: &DVector<f64>,
    curvature: &DMatrix<f64>,
    damping: f64,
) -> Vec<f64> {
    let moving: Vec<usize> = (0..free.len())
        .filter(|&r| {
            let (a, x) = (&layout.axes[free[r]], x[free[r]]);
            !(x <= a.low && gradient[r] > 0.0 || x >= a.high && gradient[r] < 0.0)
        })
        .collect();
    let n = moving.len();
    let mut h = DMatrix::from_fn(n, n, |r, c| curvature[(moving[r], moving[c])]);
    for r in 0..n {
        h[(r, r)] += damping * h[(r, r)].max(1e-9) + 1e-12;
    }
    let g = DVector::from_fn(n, |r, _| -gradient[moving[r]]);
    let mut moved = x.to_vec();
    if let Some(factor) = h.cholesky() {
        let dx = factor.solve(&g);
        for (r, &m) in moving.iter().enumerate() {
            let k = free[m];
            let a = &layout.axes[k];
            // A factor e a step is far enough for a logarithm.
            let d = if a.unit_value == 0.0 { dx[r].clamp(-1.0, 1.0) } else { dx[r] };
            moved[k] = (x[k] + d).clamp(a.low, a.high);
        }
    }
    moved
}
