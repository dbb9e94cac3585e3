//! One stage of the diagnosis: every effect that the model lacks is tried on it.
//!
//! 1. *Probe*: each effect at a few finite sizes, old parameters free to give way to first order. Derivatives at
//!    zero rank wrongly, because friction, gaps and dead zones have none there.
//! 2. *Race*: the two best starts of each effect are searched for a few steps.
//! 3. *Final*: the best effects are searched to the end and judged on records kept out.

use motorlens_shared::effects::Kind;
use nalgebra::{DMatrix, DVector};

use super::candidate::{Candidate, Evidence};
use super::{hold, ripple};
use crate::fit::cost::{Objective, residuals};
use crate::fit::layout::{Layout, Values};
use crate::fit::search::{Found, Problem};
use crate::fit::simulate::{Block, LANES, predict_block};

/// How much work a stage does.
#[derive(Debug, Clone, Copy)]
pub struct Effort {
    /// Effects that leave the probing.
    pub starters: usize,
    /// Starts of each effect that are searched.
    pub starts: usize,
    /// Steps of the race.
    pub race: usize,
    /// Effects that reach the final.
    pub finalists: usize,
    /// Steps of the final.
    pub last: usize,
}

impl Effort {
    /// On the base model.
    pub const FIRST: Self = Self { starters: 14, starts: 2, race: 3, finalists: 6, last: 12 };
    /// On a model with effects.
    pub const LATER: Self = Self { starters: 9, starts: 2, race: 3, finalists: 4, last: 10 };
}

/// Tries every effect of `library` that `model` lacks; best first.
pub fn run(
    evidence: &Evidence,
    model: &Candidate,
    library: &[Kind],
    effort: Effort,
    tick: &mut dyn FnMut(Kind),
) -> Vec<Candidate> {
    let lacking = |kind: &&Kind| {
        let has = model.kinds();
        let two_masses = has.iter().any(|k| k.spec().load_share().is_some());
        let second_gap = two_masses && kind.spec().load_share().is_some();
        !(has.contains(kind) || second_gap)
    };
    let tangent = Tangent::new(&evidence.train, model);
    let mut probed: Vec<(Kind, Vec<Start>)> = Vec::new();
    for kind in library.iter().filter(lacking) {
        tick(*kind);
        probed.push((*kind, probe(&evidence.train, model, &tangent, *kind)));
    }
    let left = |starts: &[Start]| starts.first().map_or(f64::MAX, |s| s.0);
    probed.sort_by(|a, b| left(&a.1).total_cmp(&left(&b.1)));
    let mut raced: Vec<(Layout, Found)> = Vec::new();
    for (kind, starts) in probed.into_iter().take(effort.starters) {
        let layout = evidence.train.layout(&[model.kinds(), &[kind]].concat());
        let best = starts
            .iter()
            .take(effort.starts)
            .map(|(_, x)| evidence.train.search(&layout, Objective::Increments, x, effort.race, 1e-3))
            .min_by(|a, b| a.cost.total_cmp(&b.cost));
        raced.extend(best.map(|found| (layout, found)));
    }
    raced.sort_by(|a, b| a.1.cost.total_cmp(&b.1.cost));
    let mut finals: Vec<Candidate> = Vec::new();
    for (layout, found) in raced.into_iter().take(effort.finalists) {
        let found = evidence.train.search(&layout, Objective::Increments, &found.x, effort.last, 3e-4);
        finals.push(evidence.polish(layout, found));
    }
    finals.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
    finals
}

/// Cost left after the old parameters gave way, and the search vector.
type Start = (f64, Vec<f64>);

/// Starts for `model` with `kind` added, most promising first.
fn probe(problem: &Problem, model: &Candidate, tangent: &Tangent, kind: Kind) -> Vec<Start> {
    let spec = kind.spec();
    let values = model.values();
    let layout = problem.layout(&[model.kinds(), &[kind]].concat());
    let scaled = |probe: &[f64]| -> Vec<f64> {
        probe.iter().zip(spec.parameters).map(|(x, p)| x * p.scale.unit(&problem.rig)).collect()
    };
    let mut tries: Vec<Values> = spec.probes.iter().map(|p| values.with(kind, scaled(p))).collect();
    if kind == Kind::Cogging {
        // The order cannot be searched downhill: it comes from a periodogram over the measured angle.
        tries.extend(ripple::starts(problem, &values.base).into_iter().map(|p| values.with(kind, p)));
    }
    if kind == Kind::SensorLag
        && let Some(time) = hold::time(problem)
    {
        tries.push(values.with(kind, vec![0.0, time]));
    }
    let xs: Vec<Vec<f64>> = tries.iter().map(|v| layout.pack(v)).collect();
    let mut ranked: Vec<Start> = Vec::new();
    for chunk in xs.chunks(LANES) {
        for (x, (left, give_way)) in chunk.iter().zip(tangent.project(problem, &layout, chunk)) {
            let mut moved = x.clone();
            for (&k, d) in tangent.axes.iter().zip(&give_way) {
                let a = &layout.axes[k];
                moved[k] = (x[k] + d.clamp(-0.5, 0.5)).clamp(a.low, a.high);
            }
            ranked.push((left, moved));
        }
    }
    ranked.sort_by(|a, b| a.0.total_cmp(&b.0));
    ranked
}

/// The model's residuals and Jacobian on every record: what its own parameters could still absorb.
struct Tangent {
    /// The axes that may give way.
    axes: Vec<usize>,
    /// Per record, per residual: the derivatives along the model's axes.
    rows: Vec<Vec<Vec<f64>>>,
    inverse: DMatrix<f64>,
}

impl Tangent {
    fn new(problem: &Problem, model: &Candidate) -> Self {
        let axes: Vec<usize> = (0..model.layout.len()).filter(|k| !model.layout.axes[*k].fixed).collect();
        let (series, inverse_delta) =
            problem.neighbours(&model.layout, Objective::Increments, &model.found.x, &axes);
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
        let mut h = model.found.curvature.clone();
        if h.nrows() != axes.len() {
            h = DMatrix::identity(axes.len(), axes.len());
        }
        for k in 0..h.nrows() {
            h[(k, k)] = h[(k, k)] * 1.001 + 1e-9;
        }
        let inverse = h.try_inverse().unwrap_or_else(|| DMatrix::identity(axes.len(), axes.len()));
        Self { axes, rows, inverse }
    }

    /// For each candidate: cost left after the model's parameters give way, and by how much they would.
    fn project(&self, problem: &Problem, layout: &Layout, xs: &[Vec<f64>]) -> Vec<(f64, Vec<f64>)> {
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
}
