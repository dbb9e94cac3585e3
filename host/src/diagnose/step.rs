//! One step up: what one more effect makes of a model, and the model that is left once the step is taken.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::contained;
use super::evidence::Evidence;
use super::stage::{self, Effort};
use super::teeth::settle_teeth;
use super::worth::{EQUAL, as_good, simplest};

/// Steps of the search of an accepted model.
pub const TO_THE_END: usize = 20;

/// Everything that one more effect of `library` makes of `model`.
pub fn look(
    evidence: &Evidence,
    model: &Candidate,
    library: &[Kind],
    effort: Effort,
    tick: &mut dyn FnMut(Kind),
) -> Vec<Candidate> {
    let model = contained::apart(evidence, model);
    let mut found = Vec::new();
    let mut others = Vec::new();
    for kind in library.iter().copied().filter(|kind| contained::may_join(model.kinds(), *kind)) {
        match contained::richer(evidence, &model, kind) {
            Some(richer) => found.push(richer),
            None => others.push(kind),
        }
    }
    found.extend(stage::run(evidence, &model, &others, effort, tick));
    found
}

/// An accepted model as it is believed: nothing in it that is superfluous, fitted to its end.
pub fn settled(evidence: &mut Evidence, next: Candidate, library: &[Kind]) -> Candidate {
    let mut next = contained::together(evidence, prune(evidence, next), library);
    if !next.explains() {
        // The stage's search may have ended early: gaps and teeth make a rough way down.
        let longer = evidence.fit(&next.values(), TO_THE_END);
        if longer.merit() < next.merit() {
            next = longer;
        }
    }
    let next = evidence.finish(settle_teeth(evidence, next));
    let next = evidence.settle_starts(next);
    // At its end a first effect may be down to nothing.
    prune(evidence, next)
}

/// Leaves out every effect that the others made superfluous, and of every effect what is more than a simpler one.
pub fn prune(evidence: &Evidence, model: Candidate) -> Candidate {
    let mut model = model;
    while model.kinds().len() > 1 {
        let mut fewer: Vec<Candidate> =
            model.kinds().iter().map(|k| evidence.fit(&model.values().without(*k), 10)).collect();
        fewer.extend(contained::simpler(evidence, &model));
        fewer.retain(|c| {
            c.merit() <= model.merit() + EQUAL * 0.5 && as_good(c, &model) && c.foretold >= model.foretold
        });
        match simplest(&fewer) {
            Some(c) => model = c.clone(),
            None => break,
        }
    }
    model
}
