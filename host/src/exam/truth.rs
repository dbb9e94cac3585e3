//! What the hidden equations themselves would leave: where they explain the records and fit them no better than the answer,
//! these data cannot tell.

use motorlens_shared::effects::Kind;

use crate::diagnose::discover::Discovery;
use crate::diagnose::evidence::Evidence;
use crate::select::adequacy::Adequacy;
use crate::select::fitted::Fitted;
use crate::select::with;

/// Whether the records of `found` tell the hidden equations, fitted as `truth`, from the accepted ones. They do not where `truth`
/// leaves no more than noise and does not beat the accepted one: no answer could know what does not show.
/// Where no search leads `truth` itself to the noise, nothing is excused.
pub fn is_told(found: &Discovery, truth: Option<&Fitted>) -> bool {
    // Both are fitted alike: the answer was fitted for simulating when it was found.
    let Some(truth) = truth.map(|truth| truth.simulating(&found.evidence)) else { return true };
    let (base, answer) = (&found.selected.steps[0], found.selected.model());
    !Adequacy::of(&found.evidence, base, &truth, found.noise_floor).is_explained()
        || truth.beats(answer, &found.evidence, base)
}

/// The best fit of the equations `truth`, in whatever order they are added to `base`.
pub fn fitted(evidence: &Evidence, base: &Fitted, truth: &[Kind]) -> Option<Fitted> {
    let in_order = |first: usize| {
        let mut order = (0..truth.len()).map(|k| truth[(first + k) % truth.len()]);
        order.try_fold(base.clone(), |model, kind| with(evidence, &model, kind))
    };
    (0..truth.len()).filter_map(in_order).max_by(|a, b| a.score().total_cmp(&b.score()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::{Options, discover};
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    /// Without the hidden equation in the library the answer is worse than it; with it, it is it. An equation that does not lead to
    /// the noise excuses nothing.
    #[test]
    fn only_laws_that_explain_and_fit_no_better_than_the_answer_are_not_told() {
        let calm = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(31, &[Hidden::QuadraticDrag], calm);
        let answer = |library: Vec<Kind>, truth: Kind| {
            let options = Options { library, ..Options::default() };
            let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap();
            is_told(&found, fitted(&found.evidence, &found.selected.steps[0], &[truth]).as_ref())
        };
        assert!(answer(vec![Kind::Delay, Kind::Cogging], Kind::QuadraticDrag));
        assert!(!answer(vec![Kind::Delay, Kind::QuadraticDrag], Kind::QuadraticDrag));
        assert!(answer(vec![Kind::Delay, Kind::QuadraticDrag], Kind::Cogging));
    }
}
