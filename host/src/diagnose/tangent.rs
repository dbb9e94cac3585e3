//! What a model's own parameters could still absorb, to first order.

use nalgebra::{DMatrix, DVector};

use crate::fit::cost::{Objective, residuals};
use crate::fit::layout::Layout;
use crate::fit::search::{Found, Problem};
use crate::fit::simulate::{Block, LANES, predict_block};

/// A new effect is not tried at less than this share of a probe.
const LEAST_SHARE: f64 = 0.03;

/// Its place among a layout's axes.
const VISCOUS_SHARE: usize = 3;

/// What a change of the model would come to, to first order.
#[derive(Debug, Clone)]
pub struct Projected {
    /// Share of the new effect.
    pub share: f64,
    /// Cost left after the model's parameters gave way.
    pub left: f64,
    /// By how much they would, on the search's axes.
    pub give_way: Vec<f64>,
}

/// The model's residuals and Jacobian on every record: what its own parameters could still absorb.
pub struct Tangent {
    /// Which errors count.
    objective: Objective,
    /// The axes that are partialled out.
    pub axes: Vec<usize>,
    /// The model's own cost.
    pub own: f64,
    /// Per record, per residual: its value.
    centre: Vec<Vec<f64>>,
    /// ... and the derivatives along the model's axes.
    rows: Vec<Vec<Vec<f64>>>,
    /// The cost's slope along them.
    slope: DVector<f64>,
    inverse: DMatrix<f64>,
}

impl Tangent {
    /// At the fit `found` on the records of `problem`, for the errors that `objective` counts; the viscous share, which a plain motor
    /// hardly shows, is partialled out only where it is `loose`.
    pub fn of(problem: &Problem, layout: &Layout, found: &Found, loose: bool, objective: Objective) -> Self {
        let free = layout.free();
        let kept: Vec<usize> = (0..free.len()).filter(|k| loose || free[*k] != VISCOUS_SHARE).collect();
        let axes: Vec<usize> = kept.iter().map(|k| free[*k]).collect();
        let (mut centre, mut rows): (Vec<Vec<f64>>, Vec<Vec<Vec<f64>>>) = (Vec::new(), Vec::new());
        problem.neighbours(layout, objective, &found.x, &axes, &mut |_, blocks, inverse| {
            let row = |k: usize| {
                let own = blocks[0][k].0[0];
                (1..=axes.len()).map(|f| (blocks[f / LANES][k].0[f % LANES] - own) * inverse[f]).collect()
            };
            centre.push(blocks[0].iter().map(|r| r.0[0]).collect());
            rows.push((0..blocks[0].len()).map(row).collect());
        });
        let mut slope = DVector::zeros(axes.len());
        for (row, c) in rows.iter().flatten().zip(centre.iter().flatten()) {
            for (total, d) in slope.iter_mut().zip(row) {
                *total += d * c;
            }
        }
        let whole = &found.curvature;
        let mut h = if whole.nrows() == free.len() {
            whole.select_rows(&kept).select_columns(&kept)
        } else {
            DMatrix::identity(axes.len(), axes.len())
        };
        for k in 0..h.nrows() {
            h[(k, k)] = h[(k, k)] * 1.001 + 1e-9;
        }
        let inverse = h.try_inverse().unwrap_or_else(|| DMatrix::identity(axes.len(), axes.len()));
        let own = centre.iter().flatten().map(|c| c * c).sum();
        Self { objective, axes, own, centre, rows, slope, inverse }
    }

    /// For each candidate, as it is and at the share of its new effect that fits best: what would be left after the
    /// model's parameters are partialled out, and by how much they would move.
    ///
    /// The share is found along a straight line from the model: right where the run answers linearly to the new effect.
    pub fn project(&self, problem: &Problem, layout: &Layout, xs: &[Vec<f64>]) -> Vec<[Projected; 2]> {
        let n = self.inverse.nrows();
        let (mut cost, mut cross) = ([0.0; LANES], [0.0; LANES]);
        let mut gradient = vec![[0.0; LANES]; n];
        let mut series: Vec<Block> = Vec::new();
        problem.count_passes(xs.len());
        for ((grid, rows), centre) in problem.grids.iter().zip(&self.rows).zip(&self.centre) {
            predict_block(layout, xs, &problem.rig, grid, &mut series);
            residuals(grid, self.objective, &mut series);
            for ((r, row), c) in series.iter().zip(rows).zip(centre) {
                for l in 0..LANES {
                    cost[l] += r.0[l] * r.0[l];
                    cross[l] += r.0[l] * c;
                }
                add_slopes(&mut gradient, row, r);
            }
        }
        let at = |l: usize, share: f64| {
            let new = DVector::from_fn(n, |k, _| gradient[k][l]);
            let g = &new * share + &self.slope * (1.0 - share);
            let step = -(&self.inverse * &g);
            let (a, b) = (share, 1.0 - share);
            let left = a * a * cost[l] + 2.0 * a * b * cross[l] + b * b * self.own + g.dot(&step);
            let left = if left.is_finite() { left } else { f64::MAX };
            Projected { share, left, give_way: step.iter().copied().collect() }
        };
        let best = |l: usize| {
            // The cost along the line is a parabola: three points give its lowest.
            let [none, half, whole] = [0.0, 0.5, 1.0].map(|share| at(l, share).left);
            let bend = none - 2.0 * half + whole;
            let lowest = 0.5 + 0.25 * (none - whole) / bend;
            if bend > 0.0 && lowest.is_finite() { lowest.clamp(LEAST_SHARE, 1.0) } else { 1.0 }
        };
        (0..xs.len()).map(|l| [at(l, 1.0), at(l, best(l))]).collect()
    }

    /// For each candidate, what it leaves of every residual of every record once the model's parameters gave way.
    pub fn leaves(&self, problem: &Problem, layout: &Layout, xs: &[Vec<f64>]) -> Vec<Vec<Vec<f64>>> {
        let n = self.inverse.nrows();
        let mut gradient = vec![[0.0; LANES]; n];
        let mut left: Vec<Vec<Vec<f64>>> = vec![Vec::new(); xs.len()];
        let mut series: Vec<Block> = Vec::new();
        problem.count_passes(xs.len());
        for (grid, rows) in problem.grids.iter().zip(&self.rows) {
            predict_block(layout, xs, &problem.rig, grid, &mut series);
            residuals(grid, self.objective, &mut series);
            for (r, row) in series.iter().zip(rows) {
                add_slopes(&mut gradient, row, r);
            }
            for (l, left) in left.iter_mut().enumerate() {
                left.push(series.iter().map(|r| r.0[l]).collect());
            }
        }
        for (l, left) in left.iter_mut().enumerate() {
            let step = -(&self.inverse * &DVector::from_fn(n, |k, _| gradient[k][l]));
            for (r, row) in left.iter_mut().flatten().zip(self.rows.iter().flatten()) {
                *r += row.iter().zip(&step).map(|(d, s)| d * s).sum::<f64>();
            }
        }
        left
    }

    /// `x` with the share of its new effect and the model's parameters where `projected` foresees them.
    pub fn moved(&self, layout: &Layout, x: &[f64], projected: &Projected) -> Vec<f64> {
        let mut moved = x.to_vec();
        for (&k, d) in self.axes.iter().zip(&projected.give_way) {
            let a = &layout.axes[k];
            moved[k] = (x[k] + d.clamp(-0.5, 0.5)).clamp(a.low, a.high);
        }
        let new = layout.kinds.last().map_or(&[][..], |kind| kind.spec().parameters);
        let first = layout.len() - new.len();
        for (k, _) in new.iter().enumerate().filter(|(_, p)| p.strength) {
            moved[first + k] *= projected.share;
        }
        moved
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
        problem.count_passes(xs.len());
        for ((grid, rows), centre) in problem.grids.iter().zip(&self.rows).zip(&self.centre) {
            predict_block(layout, xs, &problem.rig, grid, &mut series);
            residuals(grid, self.objective, &mut series);
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

/// Adds what a residual of each lane pulls at the axes whose derivatives are `row`.
fn add_slopes(gradient: &mut [[f64; LANES]], row: &[f64], residual: &Block) {
    for (g, d) in gradient.iter_mut().zip(row) {
        for l in 0..LANES {
            g[l] += d * residual.0[l];
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::scales::CHOOSING;
    use crate::select::fitted::Fitted;
    use motorlens_shared::effects::Kind;
    use motorlens_virtual_motor::Kind as Hidden;

    /// A drag four times as large as the one that is there is found to be four times too large.
    #[test]
    fn the_best_share_of_a_probe_is_near_what_a_search_finds() {
        let calm = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(31, &[Hidden::QuadraticDrag], calm);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let reference = evidence.train.rig.reference_speed;
        let start = base.values().with(Kind::QuadraticDrag, vec![0.1 / reference.powi(2)]);
        let fitted = Fitted::of(&evidence, &start, 2, 12);
        let found = fitted.values().effects[0].1[0];
        let layout = evidence.train.layout(&[Kind::QuadraticDrag]);
        let probe = layout.pack(&base.values().with(Kind::QuadraticDrag, vec![4.0 * found]));
        let mut problem = evidence.train.clone();
        base.noise.weigh(&mut problem, CHOOSING);
        let at_base = problem.search(&base.layout, Objective::Scales, &base.x, 0, 1e-3);
        let tangent = Tangent::of(&problem, &base.layout, &at_base, true, Objective::Scales);
        let [whole, best] = &tangent.project(&problem, &layout, std::slice::from_ref(&probe))[0];
        assert!((0.15..0.4).contains(&best.share), "{best:?}");
        assert!(whole.share == 1.0 && best.left < whole.left, "{whole:?} {best:?}");
        let moved = layout.unpack(&tangent.moved(&layout, &probe, best)).effects[0].1[0];
        assert!((moved / (4.0 * found * best.share) - 1.0).abs() < 1e-9);
    }
}
