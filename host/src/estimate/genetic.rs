//! The genetic algorithm on the full model: the objective is the IAE of the open-loop simulations, summed over the records.

use std::thread;

use motorlens_shared::ga::{Genetic, Settings, Space};
use motorlens_shared::random::Stream;

use super::{Options, Searched};
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::{Block, LANES, predict_block};
use crate::stop;
use motorlens_shared::effects::Rig;

/// Largest population.
const MOST: usize = 1024;
/// A first generation spans this factor either way of the base fit.
const FACTOR: f64 = 4.0;

/// Searches the parameters of `options.effects`.
pub(crate) fn search(
    problem: &Problem,
    base: &Values,
    options: &Options,
    progress: &mut dyn FnMut(u32, f64),
) -> Searched {
    let layout = problem.layout(&options.effects);
    // Genes beyond the layout's have equal limits and stay where they are.
    match layout.len() {
        0..=4 => run::<4>(problem, &layout, base, options, progress),
        5..=6 => run::<6>(problem, &layout, base, options, progress),
        7..=8 => run::<8>(problem, &layout, base, options, progress),
        9..=12 => run::<12>(problem, &layout, base, options, progress),
        13..=18 => run::<18>(problem, &layout, base, options, progress),
        _ => run::<28>(problem, &layout, base, options, progress),
    }
}

fn run<const G: usize>(
    problem: &Problem,
    layout: &Layout,
    base: &Values,
    options: &Options,
    progress: &mut dyn FnMut(u32, f64),
) -> Searched {
    let space = space::<G>(layout, base);
    let settings = Settings { generations: options.generations, seed: options.seed, ..Settings::default() };
    let n = layout.len();
    let (grids, rig) = (&problem.grids, &problem.rig);
    let mut objective = |genes: &[[f64; G]], iae: &mut [f64]| {
        let xs: Vec<Vec<f64>> = genes.iter().map(|g| g[..n].to_vec()).collect();
        iae_of(layout, rig, grids, &xs, iae);
    };
    let first = |stream: &mut Stream| core::array::from_fn(|k| stream.between(space.low[k], space.high[k]));
    let mut search: Box<Genetic<MOST, G>> =
        Box::new(Genetic::start(&settings, &space, options.population, first, &mut objective));
    let mut history = vec![search.best_objective()];
    progress(1, search.best_objective());
    while search.generation() < settings.generations && !stop::asked() {
        search.advance(&settings, &space, &mut objective);
        history.push(search.best_objective());
        progress(search.generation(), search.best_objective());
    }
    let values = layout.unpack(&search.best()[..n]);
    Searched { values, history, evaluations: u64::from(search.evaluations()) }
}

/// The base within a factor of its own fit, effects between their bounds.
fn space<const G: usize>(layout: &Layout, base: &Values) -> Space<G> {
    let (mut low, mut high) = ([0.0; G], [0.0; G]);
    let at = layout.pack(&Values { base: base.base, effects: Vec::new() });
    for (k, a) in layout.axes.iter().enumerate() {
        let logarithm = a.unit_value == 0.0;
        (low[k], high[k]) = match at.get(k) {
            Some(x) if logarithm => ((x - FACTOR.ln()).max(a.low), (x + FACTOR.ln()).min(a.high)),
            _ => (a.low, a.high),
        };
    }
    Space::within(low, high)
}

/// IAE of every candidate, summed over the records; angles may shift within their first count.
fn iae_of(layout: &Layout, rig: &Rig, grids: &[Grid], xs: &[Vec<f64>], iae: &mut [f64]) {
    let threads = thread::available_parallelism().map_or(1, usize::from);
    let blocks = xs.len().div_ceil(LANES);
    let share = blocks.div_ceil(threads).max(1) * LANES;
    thread::scope(|scope| {
        for (xs, iae) in xs.chunks(share).zip(iae.chunks_mut(share)) {
            scope.spawn(move || {
                let mut series: Vec<Block> = Vec::new();
                for (xs, iae) in xs.chunks(LANES).zip(iae.chunks_mut(LANES)) {
                    iae.fill(0.0);
                    for grid in grids {
                        predict_block(layout, xs, rig, grid, &mut series);
                        for (l, iae) in iae.iter_mut().enumerate() {
                            *iae += lane_iae(grid, &series, l);
                        }
                    }
                }
            });
        }
    });
}

/// IAE of lane `l`, by the trapezium rule, as the measures compute it.
fn lane_iae(grid: &Grid, series: &[Block], l: usize) -> f64 {
    let error = |k: usize| grid.measured[k] - series[k].0[l];
    let n = grid.len();
    let offset = if grid.quantity == Quantity::Angle {
        ((0..n).map(error).sum::<f64>() / n as f64).clamp(-grid.quantum, grid.quantum)
    } else {
        0.0
    };
    let mut before = (error(0) - offset).abs();
    let mut sum = 0.0;
    for k in 1..n {
        let now = (error(k) - offset).abs();
        sum += 0.5 * (now + before) * (grid.time_s[k] - grid.time_s[k - 1]);
        before = now;
    }
    sum
}
