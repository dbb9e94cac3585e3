//! What the hidden laws themselves would leave: where they fit no better than the answer, these data cannot tell.

use motorlens_shared::effects::Kind;

use crate::diagnose::candidate::Candidate;
use crate::diagnose::discover::Discovery;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::stage::{self, Effort};
use crate::diagnose::worth::as_good;

/// Steps of the last search.
const TO_THE_END: usize = 30;

/// Whether a model of the laws `truth` is plainly better on the records of `found` than the accepted one: no answer could
/// know what it does not show.
pub fn is_told(found: &Discovery, truth: &[Kind]) -> bool {
    let best = fitted(&found.evidence, &found.climb.rungs[0], truth);
    best.is_some_and(|truth| !as_good(found.climb.model(), &truth))
}

/// The best fit of the laws `truth`, in whatever order they are added to `base`.
fn fitted(evidence: &Evidence, base: &Candidate, truth: &[Kind]) -> Option<Candidate> {
    let with = |first: usize| {
        let mut model = base.clone();
        for k in 0..truth.len() {
            let kind = truth[(first + k) % truth.len()];
            model = stage::run(evidence, &model, &[kind], Effort::LATER, &mut |_| ()).into_iter().next()?;
        }
        let longer = evidence.fit(&model.values(), TO_THE_END);
        Some(evidence.finish(if longer.merit() < model.merit() { longer } else { model }))
    };
    (0..truth.len()).filter_map(with).min_by(|a, b| a.merit().total_cmp(&b.merit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::{Options, discover};
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    /// Without the hidden law in the library the answer is worse than it; with it, it is it.
    #[test]
    fn a_law_that_the_library_lacks_is_told_and_one_that_was_found_is_not_better_than_itself() {
        let calm = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(31, &[Hidden::QuadraticDrag], calm);
        let answer = |library: Vec<Kind>| {
            let options = Options { library, ..Options::default() };
            let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap();
            is_told(&found, &[Kind::QuadraticDrag])
        };
        assert!(answer(vec![Kind::Delay, Kind::Cogging]));
        assert!(!answer(vec![Kind::Delay, Kind::QuadraticDrag]));
    }
}
