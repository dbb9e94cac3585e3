//! What the hidden laws themselves would leave: where they explain the records and fit them no better than the answer,
//! these data cannot tell.

use motorlens_shared::effects::Kind;

use crate::diagnose::candidate::Candidate;
use crate::diagnose::discover::Discovery;
use crate::diagnose::evidence::Evidence;
use crate::diagnose::stage::{self, Effort};
use crate::diagnose::worth::as_good;

/// Steps of the last search.
const TO_THE_END: usize = 30;

/// Whether the records of `found` tell the hidden laws, fitted as `truth`, from the accepted ones. They do not where `truth`
/// leaves no more than noise and is not plainly better than the accepted one: no answer could know what does not show.
/// Where no search leads `truth` itself to the noise, nothing is excused. What `truth` leaves to chance counts as it does in the
/// diagnosis.
pub fn is_told(found: &Discovery, truth: Option<&Candidate>) -> bool {
    let Some(truth) = truth else { return true };
    let mut evidence = found.evidence.clone();
    // Both are run again only where their units change: pulses of a PWM that were timed for `truth` are not in this evidence.
    let other_units = evidence.allow_for_chance(&truth.values());
    let judged = |model: &Candidate| if other_units { evidence.again(model) } else { model.clone() };
    let [truth, answer] = [truth, found.climb.model()].map(judged);
    !(truth.explains_all() && as_good(&answer, &truth))
}

/// The best fit of the laws `truth`, in whatever order they are added to `base`.
pub fn fitted(evidence: &Evidence, base: &Candidate, truth: &[Kind]) -> Option<Candidate> {
    let with = |first: usize| {
        let mut model = base.clone();
        for k in 0..truth.len() {
            let kind = truth[(first + k) % truth.len()];
            model = stage::run(evidence, &model, &[kind], Effort::LATER, &mut |_| ()).into_iter().next()?;
        }
        let longer = evidence.fit(&model.values(), TO_THE_END);
        let best = evidence.finish(if longer.merit() < model.merit() { longer } else { model });
        let mut timed = evidence.clone();
        let best =
            timed.time_pulses(&best).map(|best| best.over(&timed.floor, &evidence.floor)).unwrap_or(best);
        Some(best)
    };
    (0..truth.len()).filter_map(with).min_by(|a, b| a.merit().total_cmp(&b.merit()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::{Options, discover};
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    /// Without the hidden law in the library the answer is worse than it; with it, it is it. A law that does not lead to
    /// the noise excuses nothing.
    #[test]
    fn only_laws_that_explain_and_fit_no_better_than_the_answer_are_not_told() {
        let calm = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(31, &[Hidden::QuadraticDrag], calm);
        let answer = |library: Vec<Kind>, truth: Kind| {
            let options = Options { library, ..Options::default() };
            let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap();
            is_told(&found, fitted(&found.evidence, &found.climb.rungs[0], &[truth]).as_ref())
        };
        assert!(answer(vec![Kind::Delay, Kind::Cogging], Kind::QuadraticDrag));
        assert!(!answer(vec![Kind::Delay, Kind::QuadraticDrag], Kind::QuadraticDrag));
        assert!(answer(vec![Kind::Delay, Kind::QuadraticDrag], Kind::Cogging));
    }
}
