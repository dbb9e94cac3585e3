//! Bounded Levenberg-Marquardt over the lanes.
//!
//! A Jacobian costs one pass of the lanes (centre and seven neighbours), and a step tries eight dampings in one
//! more pass. So an iteration is two passes, whatever the number of rejected steps. First speeds of records that begin in motion are fitted with
//! the parameters (`begun`).

use std::cell::Cell;
use std::collections::BTreeMap;

use motorlens_shared::effects::Rig;
use nalgebra::{DMatrix, DVector};

use super::begun::Begun;
use super::cost::Objective;
use super::fixed::Fixed;
use super::grid::Grid;
use super::layout::{Layout, Prior};
use super::normal::accumulate;
use super::simulate::LANES;
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
}

/// A minimum, and the shape of the cost around it.
#[derive(Debug, Clone)]
pub struct Found {
    /// Search numbers.
    pub x: Vec<f64>,
    /// First speeds of the records there, rad/s.
    pub speeds: Vec<f64>,
    /// Sum of squared residuals, prior included.
    pub cost: f64,
    /// J^T J at `x`, prior included.
    pub curvature: DMatrix<f64>,
    /// Residuals that were summed.
    pub count: usize,
}

/// What records add to the cost, its gradient and its curvature at a point.
#[derive(Debug, Clone)]
struct Added {
    /// As [`accumulate`] sums it.
    sums: Vec<Vec<f64>>,
    /// Residuals in it.
    count: usize,
    /// Of each record that begins in motion, what its first speed has to do with that.
    begun: Vec<Option<Begun>>,
}

impl Added {
    fn nothing(axes: usize) -> Self {
        Self { sums: vec![vec![0.0; axes + 1]; axes + 1], count: 0, begun: Vec::new() }
    }

    fn add(&mut self, more: &Self) {
        for (all, own) in self.sums.iter_mut().flatten().zip(more.sums.iter().flatten()) {
            *all += own;
        }
        self.count += more.count;
        self.begun.extend_from_slice(&more.begun);
    }
}

/// What records add where several searches on some of them begin: each is run there once.
#[derive(Debug, Default)]
pub struct Beginning(BTreeMap<usize, Added>);

/// Weight of the prior against residuals of the size of the noise.
pub(crate) const PRIOR_WEIGHT: f64 = 9.0;

impl Problem {
    /// Cost, gradient and curvature along the free axes at `x`, where the records begin with these `speeds`.
    fn linearise(&self, layout: &Layout, objective: Objective, x: &[f64], speeds: &[f64]) -> Slope {
        let added = self.added(layout, objective, x, &self.grids, speeds);
        self.slope(layout, x, added)
    }

    /// What `grids` add at `x`.
    fn added(
        &self,
        layout: &Layout,
        objective: Objective,
        x: &[f64],
        grids: &[Grid],
        speeds: &[f64],
    ) -> Added {
        let axes = layout.free();
        let mut all = Added::nothing(axes.len());
        self.neighbours_on(grids, speeds, layout, objective, x, &axes, &mut |_, blocks, inverse, begun| {
            accumulate(blocks, inverse, &mut all.sums);
            all.count += blocks[0].len();
            all.begun.push(begun);
        });
        all
    }

    /// The slope that comes of what all records add, and the prior.
    fn slope(&self, layout: &Layout, x: &[f64], Added { sums, count, begun }: Added) -> Slope {
        let n = sums.len() - 1;
        let mut gradient = DVector::from_fn(n, |r, _| sums[0][r + 1]);
        let mut curvature = DMatrix::from_fn(n, n, |r, c| sums[r + 1][c + 1]);
        for (r, k) in layout.free().into_iter().enumerate() {
            if let Some((doubt, slope)) = layout.axes[k].doubt(x[k]) {
                gradient[r] += PRIOR_WEIGHT * doubt * slope;
                curvature[(r, r)] += PRIOR_WEIGHT * slope * slope;
            }
        }
        Slope { cost: sums[0][0] + self.prior_cost(layout, x), gradient, curvature, count, begun }
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
        let Descent { x, speeds, slope, .. } =
            self.descend(layout, objective, start, iterations, tolerance, None);
        let slope = slope.unwrap_or_else(|| self.linearise(layout, objective, &x, &speeds));
        Found { x, speeds, cost: slope.cost, curvature: slope.curvature, count: slope.count }
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
        let found = self.descend(layout, objective, start, steps, tolerance, None);
        (found.cost, found.x)
    }

    /// The same, and the records that begin in motion do so from now on as they do there.
    pub fn settle(
        &mut self,
        layout: &Layout,
        objective: Objective,
        start: &[f64],
        steps: usize,
        tolerance: f64,
    ) -> Vec<f64> {
        let found = self.descend(layout, objective, start, steps, tolerance, None);
        self.begin_with(&found.speeds);
        found.x
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
        let x = within(layout, start);
        let mut all = Added::nothing(layout.free().len());
        for (grid, place) in self.grids.iter().zip(places) {
            let own = || self.added(layout, objective, &x, std::slice::from_ref(grid), &[grid.start_speed]);
            all.add(beginning.0.entry(*place).or_insert_with(own));
        }
        let first = self.slope(layout, &x, all);
        let found = self.descend(layout, objective, &x, steps, tolerance, Some(first));
        (found.cost, found.x)
    }

    /// The way down. `first` is the slope at the start, where that is known.
    fn descend(
        &self,
        layout: &Layout,
        objective: Objective,
        start: &[f64],
        iterations: usize,
        tolerance: f64,
        first: Option<Slope>,
    ) -> Descent {
        let free = layout.free();
        let mut x = within(layout, start);
        let mut speeds = self.first_speeds();
        let mut damping = 1e-3;
        let mut slope = first.unwrap_or_else(|| self.linearise(layout, objective, &x, &speeds));
        for round in 0..iterations {
            if stop::asked() {
                break;
            }
            let trials: Vec<Vec<f64>> =
                (0..LANES).map(|l| damped_step(layout, &x, &free, &slope, damping * DAMPINGS[l])).collect();
            let steps: Vec<Vec<f64>> =
                trials.iter().map(|trial| free.iter().map(|&k| trial[k] - x[k]).collect()).collect();
            let begun = self.follow(&speeds, &slope.begun, &steps);
            let costs = self.costs_from(layout, objective, &trials, &begun);
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
            speeds = begun.iter().map(|speeds| speeds[best]).collect();
            damping = (damping * DAMPINGS[best]).clamp(1e-9, 1e6);
            if gain < tolerance || round + 1 == iterations {
                return Descent { x, speeds, cost: costs[best], slope: None };
            }
            slope = self.linearise(layout, objective, &x, &speeds);
        }
        Descent { x, speeds, cost: slope.cost, slope: Some(slope) }
    }
}

/// Where a way down ended.
struct Descent {
    x: Vec<f64>,
    /// First speeds of the records, rad/s.
    speeds: Vec<f64>,
    cost: f64,
    /// The cost's shape there, unless the last step led elsewhere.
    slope: Option<Slope>,
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
    /// Of each record that begins in motion, what its first speed has to do with that.
    begun: Vec<Option<Begun>>,
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
