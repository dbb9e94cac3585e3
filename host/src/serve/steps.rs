//! A search that shows each of its steps and can be stopped between any two.

use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use crate::diagnose::candidate::{Candidate, Evidence};
use crate::fit::cost::Objective;
use crate::fit::layout::Values;

/// The state of a search after a step.
#[derive(Debug, Clone, Serialize)]
pub struct Step {
    /// 0 is the start.
    pub round: usize,
    /// Error on the records fitted, in noise units.
    pub error: f64,
    /// Every parameter: its name, unit, value at the start and now.
    pub parameters: Vec<(String, &'static str, f64, f64)>,
}

/// Most steps of a search.
const STEPS: usize = 24;
/// A step that gains less than this share of the cost is the last.
const ENOUGH: f64 = 1e-4;

/// Searches from `start` on the records fitted, telling each step. `None` if `stop` was raised.
pub fn search(
    evidence: &Evidence,
    start: &Values,
    stop: &AtomicBool,
    tell: &mut dyn FnMut(Step),
) -> Option<Candidate> {
    let problem = &evidence.train;
    let layout = problem.layout(&start.kinds());
    let begin = layout.pack(start);
    let mut found = problem.search(&layout, Objective::Increments, &begin, 0, ENOUGH);
    for round in 0..=STEPS {
        if stop.load(Ordering::Relaxed) {
            return None;
        }
        let parameters = layout.axes.iter().enumerate().map(|(k, axis)| {
            (axis.name.clone(), axis.unit, layout.plain(k, begin[k]), layout.plain(k, found.x[k]))
        });
        let error = (found.cost / found.count.max(1) as f64).sqrt();
        tell(Step { round, error, parameters: parameters.collect() });
        let next = problem.search(&layout, Objective::Increments, &found.x, 1, ENOUGH);
        let gain = (found.cost - next.cost) / found.cost.max(1e-300);
        found = next;
        if gain < ENOUGH {
            break;
        }
    }
    (!stop.load(Ordering::Relaxed)).then(|| evidence.polish(layout, found))
}
