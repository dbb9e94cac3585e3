//! What stays open of an accepted effect: others that the records cannot tell from it.

use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;

use crate::diagnose::evidence::Evidence;
use crate::findings::shown_by_fit::nearer_rival;
use crate::fit::layout::Values;
use crate::log::Warning;
use crate::select::fitted::{Fitted, SETTLED};
use crate::select::forward::lacks;
use crate::select::run::{Rivals, alike};

/// Models that the records cannot tell apart.
#[derive(Debug, Clone)]
pub struct Open {
    /// The accepted or suggested model, then the others.
    pub set: Rivals,
    /// The other one that runs much nearer to the records of the fit, as it is told.
    pub nearer: Option<Warning>,
}

impl Open {
    /// What `set` leaves open on the records of `evidence`.
    pub fn new(set: Rivals, evidence: &Evidence) -> Self {
        let nearer = nearer_rival(std::slice::from_ref(&set), evidence);
        Self { set, nearer }
    }

    /// The same where the model with `effect` is accepted; none where it is not among them.
    pub fn accepting(&self, effect: Kind, evidence: &Evidence) -> Option<Self> {
        let place = self.set.kinds().iter().position(|kind| *kind == effect)?;
        let mut set = self.set.clone();
        set.models[..=place].rotate_right(1);
        Some(Self::new(set, evidence))
    }

    /// The same beside all else that `model` has by now, judged anew: what came or went since may part them. None where it does, or where the
    /// `model` lacks the accepted effect; `base` is the model without effects.
    pub fn beside(&self, model: &Fitted, evidence: &Evidence, base: &Fitted) -> Option<Self> {
        let (before, others) = self.set.models.split_first()?;
        let kind = *before.kinds().last()?;
        let values = model.values();
        let own = values.parameters(kind)?.to_vec();
        let accepted = Fitted::of(evidence, &values.without(kind).with(kind, own), 1, 0);
        let refitted = |rival: &Fitted| {
            let rival = instead(&values, before.kinds(), &rival.values())?;
            Some(Fitted::of(evidence, &rival, SETTLED.0, SETTLED.1))
        };
        let mut others: Vec<Fitted> = others.iter().filter_map(refitted).collect();
        others.sort_by(|a, b| b.score().total_cmp(&a.score()));
        alike(evidence, &accepted, others, base).map(|set| Self::new(set, evidence))
    }

    /// Whether a model with `effects` has the accepted one and none of the others.
    pub fn is_of(&self, effects: &[Kind]) -> bool {
        let mut kinds = self.set.kinds().into_iter().enumerate();
        kinds.all(|(place, kind)| effects.contains(&kind) == (place == 0))
    }
}

/// `model` with the effects that a `rival` has and the `accepted` ones do not, in the place of those that it lacks of them; none where they do not
/// join what the model has besides.
fn instead(model: &Values, accepted: &[Kind], rival: &Values) -> Option<Values> {
    let kinds = rival.kinds();
    let gone = accepted.iter().filter(|kind| !kinds.contains(kind));
    let rest = gone.fold(model.clone(), |rest, kind| rest.without(*kind));
    let mut new = rival.effects.iter().filter(|(kind, _)| !accepted.contains(kind));
    let all = new.try_fold(rest, |rest, (kind, parameters)| {
        lacks(&rest.kinds(), *kind).then(|| rest.with(*kind, parameters.clone()))
    })?;
    (all.effects.len() <= MAX_EFFECTS).then_some(all)
}

#[cfg(test)]
mod tests {
    use super::super::session::Session;
    use super::*;
    use crate::select::forward::forward;

    #[test]
    fn a_rival_takes_the_place_of_the_accepted_effect_beside_what_was_added_since() {
        let session = Session::of_a_swing();
        let base = session.base.values();
        let of = |kinds: &[Kind]| {
            let one = |values: Values, kind: &Kind| {
                values.with(*kind, kind.spec().typical(&session.evidence.whole.rig).collect())
            };
            kinds.iter().fold(base.clone(), one)
        };
        let placed = |model: &[Kind], accepted: &[Kind], rival: &[Kind]| {
            instead(&of(model), accepted, &of(rival)).map(|values| values.kinds())
        };
        let [first, since, other, third] = [Kind::Coulomb, Kind::Delay, Kind::DeadZone, Kind::QuadraticDrag];
        assert_eq!(placed(&[first, since], &[first], &[other]), Some(vec![since, other]));
        // Beside effects that both have, which stay; of two in the place of one, both.
        assert_eq!(placed(&[third, first, since], &[third, first], &[third, other]).unwrap().len(), 3);
        assert_eq!(placed(&[first], &[first], &[third, other]), Some(vec![third, other]));
        assert_eq!(placed(&[first], &[third, first], &[third, other]), Some(vec![other]), "one was removed");
        let [gap, spring] = [Kind::Backlash, Kind::Compliance];
        assert_eq!(placed(&[first, spring], &[first], &[gap]), None, "two stand between rotor and load");
    }

    #[test]
    fn the_accepted_effect_stands_first_and_stays_open_while_no_other_of_the_set_is_in_the_model() {
        let session = Session::of_a_swing();
        let (evidence, base) = (&session.evidence, &session.base);
        let models = [Kind::Coulomb, Kind::DeadZone, Kind::QuadraticDrag]
            .map(|kind| forward(evidence, base, &[kind], 0.0, &mut |_| ()).remove(0));
        let open = Open::new(Rivals { models: models.to_vec() }, evidence);
        assert!(open.accepting(Kind::Delay, evidence).is_none());
        let open = open.accepting(Kind::DeadZone, evidence).unwrap();
        assert_eq!(open.set.kinds(), [Kind::DeadZone, Kind::Coulomb, Kind::QuadraticDrag]);
        assert!(open.is_of(&[Kind::Delay, Kind::DeadZone]));
        assert!(!open.is_of(&[Kind::Delay]) && !open.is_of(&[Kind::DeadZone, Kind::Coulomb]));
    }
}
