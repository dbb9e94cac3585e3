//! The one thing to do next, as a button and as a command.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::mend::Mend;
use super::standing::Facts;
use super::supposed::Supposed;
use super::verdict::Verdict;

/// What can be done next.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Action {
    /// Try every effect on the model.
    Diagnose,
    /// Add the effect.
    Add,
    /// Remove the effect.
    Remove,
    /// Run the experiment that tells indistinguishable models apart.
    Experiment,
    /// Correct the data and read them again.
    Data,
    /// Look at where the error is made.
    Look,
    /// Use the model.
    Export,
}

/// The one thing to do next.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct NextStep {
    /// What.
    pub action: Action,
    /// With which effect.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effect: Option<Kind>,
    /// As a button says it.
    pub label: String,
    /// As the terminal does it; MODEL and LOG... stand for the files.
    pub command: String,
    /// What mends the data, where that comes first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mend: Option<Mend>,
    /// Where the data problem is.
    #[serde(rename = "where", skip_serializing_if = "Option::is_none")]
    pub place: Option<String>,
}

impl NextStep {
    /// `action`, with `effect` where it needs one.
    pub fn new(action: Action, effect: Option<Kind>) -> Self {
        let name = effect.map_or("the effect", Kind::name);
        let (label, command) = match action {
            Action::Diagnose => ("Find what is missing".into(), "motorlens diagnose MODEL LOG...".into()),
            Action::Add => {
                (format!("Add {name}"), format!("motorlens add MODEL {name} LOG... --out with-{name}.json"))
            }
            Action::Remove => (format!("Remove {name}"), "motorlens discover LOG... --out model.json".into()),
            Action::Experiment => {
                ("Run the next experiment".into(), "motorlens plan LOG... --out programme.json".into())
            }
            Action::Data => ("See the data problems".into(), "motorlens serve LOG...".into()),
            Action::Look => ("See where it fails".into(), "motorlens compare MODEL LOG...".into()),
            Action::Export => {
                ("Use the model".into(), "motorlens export MODEL --format c --out motor.c".into())
            }
        };
        Self { action, effect, label, command, mend: None, place: None }
    }

    /// To mend the data problem at `place`, where it is at one.
    pub(super) fn mending(mend: Mend, place: Option<&str>) -> Self {
        let place = place.map(str::to_owned);
        Self { label: mend.label().into(), mend: Some(mend), place, ..Self::new(Action::Data, None) }
    }

    /// The same, but that a model whose sizes rest on what is `supposed`, if anything is, is not used before that is told.
    #[must_use]
    pub(crate) fn once_told(self, supposed: &Supposed) -> Self {
        if supposed.text.is_empty() || self.action != Action::Export {
            return self;
        }
        Self::mending(Mend::Columns, supposed.place.as_deref())
    }

    /// What follows `facts` that amount to `verdict`.
    pub(super) fn after(facts: &Facts, verdict: Option<Verdict>) -> Self {
        let action = match verdict {
            _ if facts.doubted.is_some() => {
                return Self::new(Action::Remove, facts.doubted.map(|d| d.effect));
            }
            _ if facts.suggested.is_some() => return Self::new(Action::Add, facts.suggested),
            None => Action::Diagnose,
            Some(Verdict::BadData) => Action::Data,
            Some(Verdict::Explained) if !facts.experiment => Action::Export,
            Some(Verdict::Unexplained | Verdict::PartlyExplained) if facts.data_problems => Action::Data,
            Some(_) if facts.experiment => Action::Experiment,
            Some(_) => Action::Look,
        };
        Self::new(action, None)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_model_that_rests_on_what_nobody_told_is_used_after_that_is_told() {
        let supposed = Supposed {
            text: " The size supposes that \"2\" is in rad a second.".into(),
            place: Some("b.csv, column 2".into()),
        };
        let next = NextStep::new(Action::Export, None).once_told(&supposed);
        assert_eq!((next.action, next.mend), (Action::Data, Some(Mend::Columns)));
        assert_eq!(next.place, supposed.place, "of several files the one to be looked at is opened");
        let export = NextStep::new(Action::Export, None);
        assert_eq!(export.clone().once_told(&Supposed::default()), export);
        let look = NextStep::new(Action::Look, None);
        assert_eq!(look.clone().once_told(&supposed), look);
    }
}
