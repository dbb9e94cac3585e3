//! A search that shows each of its steps and can be stopped between any two.

use serde::Serialize;

use crate::diagnose::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::layout::Values;
use crate::fit::scales::CHOOSING;
use crate::select::fitted::{Fitted, SETTLED};

/// The state of a search after a step.
#[derive(Debug, Clone, Serialize)]
pub struct Step {
    /// 0 is the start.
    pub round: usize,
    /// Error on the records fitted, in multiples of the noise.
    pub error: f64,
    /// Every parameter.
    pub parameters: Vec<Moving>,
}

/// A parameter on its way.
#[derive(Debug, Clone, Serialize)]
pub struct Moving {
    /// Its name.
    pub name: String,
    /// Unit of both values.
    pub unit: &'static str,
    /// Before the search; none where the model did not have it.
    pub before: Option<f64>,
    /// Now.
    pub now: f64,
}

/// Most steps of a search.
const STEPS: usize = 24;
/// A step that gains less than this share of the cost is the last.
const ENOUGH: f64 = 1e-4;

/// Searches from `start` on the records fitted, telling each step beside the model `before`, by whose noise errors are weighed. `None`
/// once `stop` is true.
pub fn search(
    evidence: &Evidence,
    start: &Values,
    before: &Fitted,
    stop: &dyn Fn() -> bool,
    tell: &mut dyn FnMut(Step),
) -> Option<Fitted> {
    let mut problem = evidence.train.on(evidence.train.grids.clone());
    before.noise.weigh(&mut problem, CHOOSING);
    let layout = problem.layout(&start.kinds());
    let old = &before.layout;
    let was = |name: &str| old.axes.iter().position(|a| a.name == name).map(|k| old.plain(k, before.x[k]));
    let mut found = problem.search(&layout, Objective::Scales, &layout.pack(start), 0, ENOUGH);
    for round in 0..=STEPS {
        if stop() {
            return None;
        }
        let parameters = layout.axes.iter().enumerate().map(|(k, axis)| Moving {
            before: was(&axis.name),
            name: axis.name.clone(),
            unit: axis.unit,
            now: layout.plain(k, found.x[k]),
        });
        let error = (found.cost / found.count.max(1) as f64).sqrt();
        tell(Step { round, error, parameters: parameters.collect() });
        problem.begin_with(&found.speeds);
        let next = problem.search(&layout, Objective::Scales, &found.x, 1, ENOUGH);
        let gain = (found.cost - next.cost) / found.cost.max(1e-300);
        found = next;
        if gain < ENOUGH {
            break;
        }
    }
    // An accepted model is finished as the loop by itself finishes it.
    (!stop()).then(|| Fitted::of(evidence, &layout.unpack(&found.x), SETTLED.0, SETTLED.1))
}
