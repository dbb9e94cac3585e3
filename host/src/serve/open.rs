//! What stays open of an accepted effect: others that the records cannot tell from it.

use motorlens_shared::effects::Kind;

use crate::diagnose::evidence::Evidence;
use crate::log::Warning;
use crate::report::shown_by_fit::nearer_rival;
use crate::select::run::Rivals;

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

    /// Whether a model with `effects` has the accepted one and none of the others.
    pub fn is_of(&self, effects: &[Kind]) -> bool {
        let mut kinds = self.set.kinds().into_iter().enumerate();
        kinds.all(|(place, kind)| effects.contains(&kind) == (place == 0))
    }
}

#[cfg(test)]
mod tests {
    use super::super::session::Session;
    use super::*;
    use crate::select::forward::forward;

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
