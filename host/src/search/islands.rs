//! Several populations side by side that exchange their best.

use super::genetic::{GaOptions, GaResult, Run, Start, finish};
use super::record::{Candidates, Records};
use crate::stop;
use motorlens_shared::motor::PARAMETERS;
use std::time::Instant;

/// Generations between two exchanges.
const EPOCH: u32 = 50;

/// Runs `options.islands` populations on `options.threads` threads. Within an epoch the islands know nothing
/// of each other, so the answer does not depend on who runs which. After it, each island's best takes the place
/// of the worst on the next.
pub(super) fn search(
    records: &Records,
    start: &Start,
    options: &GaOptions,
    progress: &mut dyn FnMut(u32, f64),
) -> GaResult {
    let began = Instant::now();
    let mut islands: Vec<Run> = (0..options.islands).map(|island| Run::new(start, options, island)).collect();
    let share = islands.len().div_ceil(options.threads.max(1));
    let mut history = Vec::with_capacity(options.generations as usize);
    let mut done = 0;
    while done < options.generations.max(1) && !(done > 0 && stop::asked()) {
        let epoch = EPOCH.min(options.generations.max(1) - done);
        let parts: Vec<Vec<f64>> = std::thread::scope(|scope| {
            let work = |part: &mut [Run]| best_of(records, start, part, epoch);
            let handles: Vec<_> =
                islands.chunks_mut(share).map(|part| scope.spawn(move || work(part))).collect();
            let join = |h: std::thread::ScopedJoinHandle<'_, Vec<f64>>| {
                h.join().unwrap_or_else(|panic| std::panic::resume_unwind(panic))
            };
            handles.into_iter().map(join).collect()
        });
        for generation in 0..epoch as usize {
            let best = parts.iter().map(|p| p[generation]).fold(f64::INFINITY, f64::min);
            history.push(best);
            progress(done + generation as u32 + 1, best);
        }
        done += epoch;
        exchange(&mut islands);
    }
    finish(records, start, &islands, history, began)
}

/// Advances some islands by `epoch` generations; returns the best objective of each generation.
fn best_of(records: &Records, start: &Start, islands: &mut [Run], epoch: u32) -> Vec<f64> {
    let mut candidates = Candidates::default();
    let mut motors = Vec::new();
    let mut objective = |genes: &[[f64; PARAMETERS]], iae: &mut [f64]| {
        motors.clear();
        motors.extend(genes.iter().map(|g| start.motor(g).combinations()));
        records.discretise(&motors, &mut candidates);
        records.iae_of(&candidates, iae);
    };
    let mut best = vec![f64::INFINITY; epoch as usize];
    for island in islands {
        for best in &mut best {
            island.advance(&mut objective);
            *best = best.min(island.best_objective());
        }
    }
    best
}

fn exchange(islands: &mut [Run]) {
    let bests: Vec<_> =
        islands.iter().map(|i| i.search.as_ref().map(|s| (*s.best(), s.best_objective()))).collect();
    let count = islands.len();
    for (k, best) in bests.into_iter().enumerate() {
        if let (Some(search), Some((genes, objective))) = (&mut islands[(k + 1) % count].search, best) {
            search.immigrate(genes, objective);
        }
    }
}
