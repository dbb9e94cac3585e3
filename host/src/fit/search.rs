//! Bounded Levenberg-Marquardt over the lanes.
//!
//! A Jacobian costs one pass of the lanes (centre and seven neighbours), and a step tries eight dampings in one
//! more pass. So an iteration is two passes, whatever the number of rejected steps.

use std::cell::{Cell, RefCell};
use std::collections::BTreeMap;

use motorlens_shared::effects::Rig;
use nalgebra::{DMatrix, DVector};

use super::cost::{Objective, accumulate};
use super::fixed::Fixed;
use super::grid::Grid;
use super::layout::{Layout, Prior};
use super::simulate::{Block, LANES};
use crate::stop;

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
    /// Room for runs, kept from pass to pass.
    pub(super) room: RefCell<Vec<Vec<Block>>>,
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

/// What one record adds to the cost, its gradient and its curvature at a point, as [`accumulate`] sums it, and the residuals in it.
type Added = (Vec<Vec<f64>>, usize);

/// What records add where several searches on some of them begin: each is run there once.
#[derive(Debug, Default)]
pub struct Beginning(BTreeMap<usize, Added>);

/// Weight of the prior against residuals of one noise unit.
pub(crate) const PRIOR_WEIGHT: f64 = 9.0;

impl Problem {
    /// Cost, gradient and curvature at `x` along `axes`.
    fn linearise(&self, layout: &Layout, objective: Objective, x: &[f64], axes: &[usize]) -> Slope {
        let added = self.added(layout, objective, x, axes, &self.grids);
        self.slope(layout, x, axes, added)
    }

    /// What `grids` add at `x`.
    fn added(
        &self,
        layout: &Layout,
        objective: Objective,
        x: &[f64],
        axes: &[usize],
        grids: &[Grid],
    ) -> Added {
        let n = axes.len();
        let mut sums = vec![vec![0.0; n + 1]; n + 1];
        let mut count = 0;
        self.neighbours_on(grids, layout, objective, x, axes, &mut |_, blocks, inverse| {
            accumulate(blocks, inverse, &mut sums);
            count += blocks[0].len();
        });
        (sums, count)
    }

    /// The slope that comes of what all records add, and the prior.
    fn slope(&self, layout: &Layout, x: &[f64], axes: &[usize], (sums, count): Added) -> Slope {
        let n = axes.len();
        let mut gradient = DVector::from_fn(n, |r, _| sums[0][r + 1]);
        let mut curvature = DMatrix::from_fn(n, n, |r, c| sums[r + 1][c + 1]);
        for (r, &k) in axes.iter().enumerate() {
            if let Some((centre, width)) = layout.axes[k].prior {
                let weight = PRIOR_WEIGHT / (width * width);
                gradient[r] += weight * (x[k] - centre);
                curvature[(r, r)] += weight;
            }
        }
        Slope { cost: sums[0][0] + self.prior_cost(layout, x), gradient, curvature, count }
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
        let (x, _, slope) = self.descend(layout, objective, start, iterations, tolerance, None);
        let slope = slope.unwrap_or_else(|| self.linearise(layout, objective, &x, &layout.free()));
        Found { x, cost: slope.cost, curvature: slope.curvature, count: slope.count }
    }

    /// Where so many steps of the search lead, and the cost there, without the shape of the cost around it: a pass less.
    pub fn race(
        &self,
        layout: &Layout,
        objective: Objective,
        start: &[f64],
        steps: usize,
        tolerance: f64,
    ) -> (f64, Vec<f64>) {
        let (x, cost, _) = self.descend(layout, objective, start, steps, tolerance, None);
        (cost, x)
    }

    /// The same for several searches from one `start`, each on some of the same records in the same order: `places` names those of this one,
    /// and `beginning` what is known of them.
    pub fn race_on(
        &self,
        layout: &Layout,
        objective: Objective,
        start: &[f64],
        steps: usize,
        tolerance: f64,
        places: &[usize],
        beginning: &mut Beginning,
    ) -> (f64, Vec<f64>) {
        let axes = layout.free();
        let x = within(layout, start);
        let mut all: Added = (vec![vec![0.0; axes.len() + 1]; axes.len() + 1], 0);
        for (grid, place) in self.grids.iter().zip(places) {
            let own = || self.added(layout, objective, &x, &axes, std::slice::from_ref(grid));
            let (sums, count) = beginning.0.entry(*place).or_insert_with(own);
            for (all, own) in all.0.iter_mut().flatten().zip(sums.iter().flatten()) {
                *all += own;
            }
            all.1 += *count;
        }
        let first = self.slope(layout, &x, &axes, all);
        let (x, cost, _) = self.descend(layout, objective, &x, steps, tolerance, Some(first));
        (cost, x)
    }

    /// The way down: where it ends, the cost there, and its shape unless the last step led elsewhere. `first` is the slope at the start,
    /// where that is known.
    fn descend(
        &self,
        layout: &Layout,
        objective: Objective,
        start: &[f64],
        iterations: usize,
        tolerance: f64,
        first: Option<Slope>,
    ) -> (Vec<f64>, f64, Option<Slope>) {
        let free = layout.free();
        let mut x = within(layout, start);
        let mut damping = 1e-3;
        let mut slope = first.unwrap_or_else(|| self.linearise(layout, objective, &x, &free));
        for round in 0..iterations {
            if stop::asked() {
                break;
            }
            let trials: Vec<Vec<f64>> =
                (0..LANES).map(|l| damped_step(layout, &x, &free, &slope, damping * DAMPINGS[l])).collect();
            let costs = self.costs(layout, objective, &trials);
            let best = (0..LANES).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
            if costs[best] >= slope.cost {
                damping *= 3e3;
                if damping > 1e9 {
                    break;
                }
                continue;
            }
            let gain = (slope.cost - costs[best]) / slope.cost;
            x.clone_from(&trials[best]);
            damping = (damping * DAMPINGS[best]).clamp(1e-9, 1e6);
            if gain < tolerance || round + 1 == iterations {
                return (x, costs[best], None);
            }
            slope = self.linearise(layout, objective, &x, &free);
        }
        (x, slope.cost, Some(slope))
    }
}

/// `x` within the bounds of its axes.
fn within(layout: &Layout, x: &[f64]) -> Vec<f64> {
    x.iter().zip(&layout.axes).map(|(x, a)| x.clamp(a.low, a.high)).collect()
}

/// The cost at a point, prior included, and its shape around it.
struct Slope {
    cost: f64,
    gradient: DVector<f64>,
    curvature: DMatrix<f64>,
    /// Residuals that were summed.
    count: usize,
}

/// Dampings tried side by side, against the last that worked.
const DAMPINGS: [f64; LANES] = [1e-3, 0.03, 0.3, 1.0, 5.0, 30.0, 300.0, 5e3];

/// Solves (H + damping diag H) dx = -g; axes pushed against a bound stand still.
fn damped_step(
    layout: &Layout,
    x: &[f64],
    free: &[usize],
    Slope { gradient, curvature, .. }: &Slope,
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
