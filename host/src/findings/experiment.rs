//! The next experiment: whatever proposes one (`discover`, `diagnose`, `plan`, the page, the library) takes it from here.

use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::Programme;
use serde::Serialize;

use crate::diagnose::evidence::Evidence;
use crate::diagnose::plan::{self, Limits, Plan};
use crate::select::DetectionLimit;
use crate::select::fitted::Fitted;
use crate::select::limits::plan_hidden;

/// An experiment that would settle what these data leave open.
#[derive(Debug, Clone, Serialize)]
pub struct NextExperiment {
    /// What it would show.
    pub why: String,
    /// What to play.
    pub programme: Programme,
}

impl From<Plan> for NextExperiment {
    fn from(plan: Plan) -> Self {
        Self { why: plan.why(), programme: plan.programme }
    }
}

impl NextExperiment {
    /// That of `plan` where it would show anything; else what shows most of the effects that `limits` say are hidden.
    pub fn of(plan: Option<Plan>, limits: &[DetectionLimit]) -> Option<Self> {
        plan.filter(Plan::shows).map(Self::from).or_else(|| Self::to_show(limits))
    }

    /// The programme that most of the effects which the records cannot show ask for.
    fn to_show(limits: &[DetectionLimit]) -> Option<Self> {
        let asked = || limits.iter().filter_map(|limit| Some((limit, limit.programme.as_ref()?)));
        let votes = |programme: &Programme| asked().filter(|(_, other)| other.name == programme.name).count();
        let (_, programme) = asked().max_by_key(|(_, programme)| votes(programme))?;
        let shown: Vec<DetectionLimit> = asked()
            .filter(|(_, other)| other.name == programme.name)
            .map(|(limit, _)| limit.clone())
            .collect();
        let names = |kinds: Vec<Kind>| kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
        let hidden = names(DetectionLimit::hidden(&shown));
        let undecided = names(DetectionLimit::undecided(&shown));
        let what = [
            (!hidden.is_empty()).then(|| format!("these records cannot confirm {hidden} at any size")),
            (!undecided.is_empty()).then(|| format!("too much is left to confirm or to exclude {undecided}")),
        ];
        let what = what.into_iter().flatten().collect::<Vec<_>>().join("; ");
        let why = format!("{what}; {} would show most of it", programme.name);
        Some(Self { why, programme: programme.clone() })
    }
}

/// What to run after a diagnosis.
#[derive(Debug, Clone, Default)]
pub struct Experiment {
    /// The experiment, where one would show anything.
    pub next: Option<NextExperiment>,
    /// Why none would tell indistinguishable models apart, where there are some.
    pub none: Option<String>,
}

impl Experiment {
    /// What to run `within` the limits of the rig where a diagnosis of the records of `evidence` ended at `model`, left the models `open`
    /// indistinguishable, and the records show further effects from `limits` on.
    pub fn after(
        evidence: &Evidence,
        model: &Fitted,
        open: &[&Fitted],
        limits: &[DetectionLimit],
        within: Limits,
    ) -> Self {
        let plan = plan::choose(&evidence.whole, open, within);
        let none = plan.as_ref().and_then(Plan::why_none);
        let mut limits = limits.to_vec();
        if within != Limits::of(evidence) {
            plan_hidden(evidence, model, &mut limits, within);
        }
        Self { next: NextExperiment::of(plan, &limits), none }
    }
}

#[cfg(test)]
mod tests {
    use motorlens_shared::excitation::Shape;

    use super::*;

    #[test]
    fn what_no_size_shows_and_what_is_left_undecided_are_told_apart() {
        let programme = Programme::single("pulses", Shape::PulseAndCoast { amplitude_v: 5.0 }, 8.0);
        let limit = |effect, undecided| DetectionLimit {
            effect,
            parameter: "level",
            smallest: None,
            undecided,
            unit: "V",
            programme: Some(programme.clone()),
        };
        let [hidden, undecided] = [limit(Kind::Coast, false), limit(Kind::Gravity, true)];
        let why = |limits: &[DetectionLimit]| NextExperiment::to_show(limits).unwrap().why;
        let end = "; pulses would show most of it";
        let cannot = "these records cannot confirm coast at any size";
        let too_much = "too much is left to confirm or to exclude gravity";
        assert_eq!(why(std::slice::from_ref(&hidden)), format!("{cannot}{end}"));
        assert_eq!(why(std::slice::from_ref(&undecided)), format!("{too_much}{end}"));
        assert_eq!(why(&[undecided, hidden]), format!("{cannot}; {too_much}{end}"));
    }
}
