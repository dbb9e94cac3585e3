//! The fast method: each effect from its probes in turn, then all parameters together.

use motorlens_shared::effects::Kind;

use super::Searched;
use crate::diagnose::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::layout::{BaseValues, Values};
use crate::fit::search::Problem;
use crate::select;

/// Steps of the textbook's search.
const TEXTBOOK: usize = 60;

/// Adds `effects` to `base` one after the other on all records, as the diagnosis does.
pub(crate) fn search(problem: &Problem, base: &Values, effects: &[Kind]) -> Searched {
    let evidence = Evidence::of(problem.clone(), Vec::new());
    let mut model = select::fitted_from(&evidence, base);
    for kind in effects {
        model = select::with(&evidence, &model, *kind).unwrap_or(model);
    }
    let values = model.simulating(&evidence).values();
    Searched { values, history: Vec::new(), evaluations: evidence.simulations() }
}

/// Least squares on the error itself, once, from the ordinary size of everything: what a textbook would do.
pub(crate) fn textbook(problem: &Problem, effects: &[Kind]) -> Searched {
    let layout = problem.layout(effects);
    let rig = &problem.rig;
    let base = BaseValues {
        gain: rig.reference_speed / rig.nominal_v,
        tau_m: 0.05,
        tau_e: problem.prior.tau_e.0,
        viscous_share: problem.prior.viscous_share.0,
    };
    let ordinary = |k: &Kind| (*k, k.spec().typical(rig).collect());
    let start = Values { base, effects: effects.iter().map(ordinary).collect() };
    let found = problem.search(&layout, Objective::Position, &layout.pack(&start), TEXTBOOK, 1e-6);
    Searched { values: layout.unpack(&found.x), history: Vec::new(), evaluations: problem.simulations.get() }
}
