//! What a model's own parameters could still absorb, to first order.

use nalgebra::{DMatrix, DVector};

use super::candidate::Candidate;
use crate::fit::cost::{Objective, residuals};
use crate::fit::layout::Layout;
use crate::fit::search::Problem;
use crate::fit::simulate::{Block, LANES, predict_block};

/// The model's residuals and Jacobian on every record: what its own parameters could still absorb.
pub struct Tangent {
    /// The axes that may give way.
    pub axes: Vec<usize>,
    /// Per record, per residual: its value.
    centre: Vec<Vec<f64>>,
    /// ... and the derivatives along the model's axes.
    rows: Vec<Vec<Vec<f64>>>,
    /// The cost's slope along them.
    slope: DVector<f64>,
    inverse: DMatrix<f64>,
}

impl Tangent {
    /// At `model` on the records of `problem`.
    pub fn new(problem: &Problem, model: &Candidate) -> Self {
        let axes: Vec<usize> = (0..model.layout.len()).filter(|k| !model.layout.axes[*k].fixed).collect();
        let (series, inverse_delta) =
            problem.neighbours(&model.layout, Objective::Increments, &model.found.x, &axes);
        let centre: Vec<Vec<f64>> =
            series.iter().map(|blocks| blocks[0].iter().map(|r| r.0[0]).collect()).collect();
        let rows: Vec<Vec<Vec<f64>>> = series
            .iter()
            .map(|blocks| {
                (0..blocks[0].len())
                    .map(|k| {
                        let centre = blocks[0][k].0[0];
                        (1..=axes.len())
                            .map(|f| (blocks[f / LANES][k].0[f % LANES] - centre) * inverse_delta[f])
                            .collect()
                    })
                    .collect()
            })
            .collect();
        let mut slope = DVector::zeros(axes.len());
        for (row, c) in rows.iter().flatten().zip(centre.iter().flatten()) {
            for (total, d) in slope.iter_mut().zip(row) {
                *total += d * c;
            }
        }
        let mut h = model.found.curvature.clone();
        if h.nrows() != axes.len() {
            h = DMatrix::identity(axes.len(), axes.len());
        }
        for k in 0..h.nrows() {
            h[(k, k)] = h[(k, k)] * 1.001 + 1e-9;
        }
        let inverse = h.try_inverse().unwrap_or_else(|| DMatrix::identity(axes.len(), axes.len()));
        Self { axes, centre, rows, slope, inverse }
    }

    /// For each candidate: cost left after the model's parameters give way, and by how much they would.
    pub fn project(&self, problem: &Problem, layout: &Layout, xs: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
        let n = self.inverse.nrows();
        let mut cost = [0.0; LANES];
        let mut gradient = vec![[0.0; LANES]; n];
        let mut series: Vec<Block> = Vec::new();
        problem.simulations.set(problem.simulations.get() + xs.len() as u64);
        for (grid, rows) in problem.grids.iter().zip(&self.rows) {
            predict_block(layout, xs, &problem.rig, grid, &mut series);
            residuals(grid, Objective::Increments, &mut series);
            for (r, row) in series.iter().zip(rows) {
                for l in 0..LANES {
                    cost[l] += r.0[l] * r.0[l];
                }
                for (g, d) in gradient.iter_mut().zip(row) {
                    for l in 0..LANES {
                        g[l] += d * r.0[l];
                    }
                }
            }
        }
        (0..xs.len())
            .map(|l| {
                let g = DVector::from_fn(n, |k, _| gradient[k][l]);
                let step = -(&self.inverse * &g);
                let left = cost[l] + g.dot(&step);
                (if left.is_finite() { left } else { f64::MAX }, step.iter().copied().collect())
            })
            .collect()
    }

    /// For each pair of neighbouring lanes, a change of size one along two new directions: what the cost would lose
    /// were both free, and where along them.
    ///
    /// Straight lines only: right where the run answers linearly to the new directions.
    pub fn pairs(&self, problem: &Problem, layout: &Layout, xs: &[Vec<f64>]) -> Vec<(f64, [f64; 2])> {
        let n = self.inverse.nrows();
        let pairs = xs.len() / 2;
        let mut own = vec![[[0.0; 2]; 2]; pairs];
        let mut gradient = vec![[0.0; 2]; pairs];
        let mut cross = vec![[0.0; LANES]; n];
        let mut series: Vec<Block> = Vec::new();
        problem.simulations.set(problem.simulations.get() + xs.len() as u64);
        for ((grid, rows), centre) in problem.grids.iter().zip(&self.rows).zip(&self.centre) {
            predict_block(layout, xs, &problem.rig, grid, &mut series);
            residuals(grid, Objective::Increments, &mut series);
            for ((r, row), c) in series.iter().zip(rows).zip(centre) {
                let d: [f64; LANES] = std::array::from_fn(|l| r.0[l] - c);
                for p in 0..pairs {
                    for a in 0..2 {
                        gradient[p][a] += d[2 * p + a] * c;
                        for b in 0..2 {
                            own[p][a][b] += d[2 * p + a] * d[2 * p + b];
                        }
                    }
                }
                for (cross, slope) in cross.iter_mut().zip(row) {
                    for l in 0..LANES {
                        cross[l] += slope * d[l];
                    }
                }
            }
        }
        (0..pairs)
            .map(|p| {
                let side: [DVector<f64>; 2] =
                    std::array::from_fn(|a| DVector::from_fn(n, |k, _| cross[k][2 * p + a]));
                let absorbed = side.each_ref().map(|s| &self.inverse * s);
                let h = |a: usize, b: usize| own[p][a][b] - side[a].dot(&absorbed[b]);
                let g = |a: usize| gradient[p][a] - absorbed[a].dot(&self.slope);
                let determinant = h(0, 0) * h(1, 1) - h(0, 1) * h(1, 0);
                if determinant <= 1e-9 * own[p][0][0] * own[p][1][1] {
                    return (0.0, [0.0; 2]);
                }
                let step = [
                    -(g(0) * h(1, 1) - g(1) * h(0, 1)) / determinant,
                    -(g(1) * h(0, 0) - g(0) * h(1, 0)) / determinant,
                ];
                (-(g(0) * step[0] + g(1) * step[1]), step)
            })
            .collect()
    }
}
