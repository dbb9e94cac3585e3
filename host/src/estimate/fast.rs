//! The fast method: each effect from its probes in turn, then all parameters together.

use motorlens_shared::effects::Kind;

use super::Searched;
use crate::diagnose::candidate::{Candidate, Evidence};
use crate::diagnose::stage::{self, Effort};
use crate::fit::layout::Values;
use crate::fit::search::Problem;

/// Steps of the last search.
const LAST: usize = 12;

/// Adds `effects` to `base` one after the other on all records.
pub(crate) fn search(problem: &Problem, base: &Values, effects: &[Kind]) -> Searched {
    let evidence = all_of(problem);
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

/// Evidence in which nothing is kept out.
pub(super) fn all_of(problem: &Problem) -> Evidence {
    Evidence {
        whole: problem.clone_without_count(),
        train: problem.clone_without_count(),
        unseen: problem.clone_without_count(),
    }
}
