//! The fast method: each effect from its probes in turn, then all parameters together.

use motorlens_shared::effects::Kind;

use super::Searched;
use crate::diagnose::candidate::Candidate;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::stage::{self, Effort};
use crate::fit::cost::Objective;
use crate::fit::layout::{BaseValues, Values};
use crate::fit::search::Problem;

/// Steps of the last search.
const LAST: usize = 12;
/// Steps of the textbook's search.
const TEXTBOOK: usize = 60;

/// Adds `effects` to `base` one after the other on all records.
pub(crate) fn search(problem: &Problem, base: &Values, effects: &[Kind]) -> Searched {
    let evidence = Evidence::all_of(problem);
    let mut model: Candidate = evidence.fit(base, LAST);
    for kind in effects {
        let found = stage::run(&evidence, &model, &[*kind], Effort::FIRST, &mut |_| ());
        model = found.into_iter().next().unwrap_or(model);
    }
    if !effects.is_empty() {
        model = evidence.fit(&model.values(), LAST);
    }
    Searched { values: model.values(), history: Vec::new(), evaluations: evidence.simulations() }
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
    let ordinary = |k: &Kind| -> Vec<f64> {
        k.spec().parameters.iter().map(|p| p.typical * p.scale.unit(rig)).collect()
    };
    let start = Values { base, effects: effects.iter().map(|k| (*k, ordinary(k))).collect() };
    let found = problem.search(&layout, Objective::Position, &layout.pack(&start), TEXTBOOK, 1e-6);
    Searched { values: layout.unpack(&found.x), history: Vec::new(), evaluations: problem.simulations.get() }
}
