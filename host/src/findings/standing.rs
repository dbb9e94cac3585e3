//! What a person is told first: the verdict as a badge, one sentence, and what to do next.
//!
//! Terminal, report and page show the same standing, so that none of them praises what another one doubts.

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::mend::Mend;
use super::named::not_shown;
use super::next_step::{Action, NextStep};
use super::verdict::{Errors, Verdict};
use crate::compare::measures::Measures;
use crate::compare::rise::Rise;
use crate::select::adequacy::Adequacy;

/// Where the work stands.
#[derive(Debug, Clone, Serialize)]
pub struct Standing {
    /// None before effects were looked for.
    pub verdict: Option<Verdict>,
    /// The verdict in two words.
    pub badge: &'static str,
    /// The same in one sentence, with its numbers.
    pub headline: String,
    /// What to do next.
    pub next: NextStep,
    /// What would be next but for a data problem, which comes first.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub also: Option<NextStep>,
}

/// What is known when the standing is told.
#[derive(Debug, Clone, Copy)]
pub struct Facts<'a> {
    /// Of base model, model and noise.
    pub errors: Errors,
    /// Effects in the model, as a sentence names them.
    pub effects: &'a [String],
    /// What the model leaves after the search for further effects; none before a search.
    pub left: Option<Adequacy>,
    /// An effect that is worth adding.
    pub suggested: Option<Kind>,
    /// The effect added last, where held-out data do not confirm it.
    pub doubted: Option<Doubted<'a>>,
    /// Whether an experiment is known that would tell indistinguishable models apart.
    pub experiment: bool,
    /// What the sentence goes on with where a value of the model stands where its search ends; empty where none does.
    pub ended: &'a str,
    /// Effects that the records cannot show at any size.
    pub hidden: &'a [Kind],
    /// Whether the data have problems of their own.
    pub data_problems: bool,
    /// What the first of them that changes the answer is mended with, and where it is.
    pub mend: Option<(Mend, &'a str)>,
    /// Where a person is asked whether the columns were read as they are meant, and can say so: as `mend`, but nothing is doubted for it.
    pub asked: Option<(Mend, &'a str)>,
}

/// An effect that held-out data do not confirm.
#[derive(Debug, Clone, Copy)]
pub struct Doubted<'a> {
    /// The effect.
    pub effect: Kind,
    /// Whether the error rises with it.
    pub rises: bool,
    /// Where it rises most.
    pub most: Option<&'a Rise>,
}

impl Standing {
    /// What `facts` amount to.
    pub fn of(facts: &Facts) -> Self {
        // While an effect is to be added, how it ends is open.
        let searched = facts.left.filter(|_| facts.suggested.is_none());
        let verdict = searched.map(|left| facts.errors.verdict(facts.effects.len(), left));
        let left = searched.unwrap_or_default();
        let headline = match (verdict, facts.doubted) {
            (_, Some(doubted)) => facts.errors.doubt(&doubted),
            (Some(verdict @ Verdict::Explained), None) if facts.effects.is_empty() => {
                facts.errors.headline(facts.effects, verdict, left) + &not_shown(facts.hidden)
            }
            (Some(verdict), None) => facts.errors.headline(facts.effects, verdict, left),
            (None, None) => facts.errors.so_far(facts.effects, facts.suggested),
        };
        let (first, mut next) = (facts.mend.or(facts.asked), NextStep::after(facts, verdict));
        let mut also = None;
        if let Some((mend, place)) = first {
            let later = std::mem::replace(&mut next, NextStep::mending(mend, Some(place)));
            let goes_on = matches!(later.action, Action::Diagnose | Action::Add | Action::Remove);
            also = goes_on.then_some(later);
        }
        let before = facts.mend.map_or("", |(mend, _)| mend.first_of_all());
        let headline = format!("{headline}{}{before}.", facts.ended);
        let badge = match (facts.doubted, facts.suggested, verdict) {
            _ if facts.mend.is_some() => Verdict::BadData.badge(),
            (Some(_), ..) => "Not confirmed",
            (None, Some(_), _) => "An effect is missing",
            (None, None, Some(verdict)) => facts.errors.badge(verdict, left),
            (None, None, None) => "Not diagnosed yet",
        };
        // What follows a voltage that drove nothing follows the motor by chance.
        let is_driven = facts.mend.is_none_or(|(mend, _)| mend != Mend::Voltage);
        let verdict =
            verdict.map(|of| if of == Verdict::Explained && !is_driven { Verdict::BadData } else { of });
        Self { verdict, badge, headline, next, also }
    }

    /// Of a model with `effects` that was simulated and not diagnosed: its errors on the records that count, their noise level, and what is said
    /// of values that stand where their search `ended`.
    pub fn simulated(errors: &Measures, noise: f64, effects: &[String], ended: &str) -> Self {
        Self::of(&Facts {
            errors: Errors::of(errors, errors, noise),
            effects,
            left: None,
            suggested: None,
            doubted: None,
            experiment: false,
            ended,
            hidden: &[],
            data_problems: false,
            mend: None,
            asked: None,
        })
    }

    /// The same where what the model is missing has been looked for before.
    pub fn compared(errors: &Measures, noise: f64, effects: &[String], ended: &str) -> Self {
        let enough = Errors::of(errors, errors, noise).is_close();
        let action = if enough { Action::Export } else { Action::Experiment };
        let next = NextStep::new(action, None);
        Self { badge: "Compared", next, ..Self::simulated(errors, noise, effects, ended) }
    }

    /// Of data that must be mended first.
    pub fn bad_data() -> Self {
        Self {
            verdict: Some(Verdict::BadData),
            badge: Verdict::BadData.badge(),
            headline: Errors::BAD_DATA.to_owned() + ".",
            next: NextStep::new(Action::Data, None),
            also: None,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: Adequacy = Adequacy::Noise;

    fn facts(effects: &[String], model: f64) -> Facts<'_> {
        let errors = Errors { base: 101.0, model, noise: 1.0, missed: 0.01, strayed: 0.01, beaten: 1.0 };
        Facts {
            errors,
            effects,
            left: Some(ALL),
            suggested: None,
            doubted: None,
            experiment: false,
            ended: "",
            hidden: &[],
            data_problems: false,
            mend: None,
            asked: None,
        }
    }

    #[test]
    fn a_data_problem_that_changes_the_answer_is_mended_before_anything_is_added_to_the_model() {
        let mend = Some((Mend::Columns, "run.csv, column voltage_v"));
        let told = Standing::of(&Facts { suggested: Some(Kind::Delay), mend, ..facts(&[], 101.0) });
        assert_eq!(
            (told.badge, told.next.action, told.next.mend),
            ("Data problem", Action::Data, Some(Mend::Columns))
        );
        assert!(told.headline.ends_with(
            "the best candidate is delay; mend the data first, for their problem may be what is found."
        ));
        let also = told.also.unwrap();
        assert_eq!((also.action, also.effect), (Action::Add, Some(Kind::Delay)));
        let told = Standing::of(&Facts { mend, ..facts(&["delay (2 ms)".to_owned()], 1.1) });
        assert_eq!((told.verdict, told.next.action), (Some(Verdict::Explained), Action::Data));
        let asked = Standing::of(&Facts { asked: mend, ..facts(&["delay (2 ms)".to_owned()], 1.1) });
        assert_eq!((asked.badge, asked.next.mend), ("Explained", Some(Mend::Columns)));
        assert!(!asked.headline.contains("mend"), "{asked:?}");
        assert!(told.also.is_none(), "a model of data that are to be mended is not to be used");
    }

    #[test]
    fn beside_a_voltage_that_drove_nothing_nothing_is_explained() {
        let mend = Some((Mend::Voltage, "run.csv, column voltage_v"));
        let effects = ["delay (2 ms)".to_owned()];
        let told = Standing::of(&Facts { mend, ..facts(&effects, 1.1) });
        assert_eq!(
            (told.verdict, told.badge, told.next.action),
            (Some(Verdict::BadData), "Data problem", Action::Data)
        );
        assert!(told.headline.contains("is not what drove the motor"), "{told:?}");
        assert!(told.also.is_none() && told.next.mend == Some(Mend::Voltage), "{told:?}");
        let told = Standing::of(&Facts { mend, left: Some(Adequacy::Something), ..facts(&effects, 40.0) });
        assert_eq!(told.verdict, Some(Verdict::PartlyExplained));
    }

    #[test]
    fn a_value_where_its_search_ended_is_told_in_the_same_sentence() {
        let effects = ["gravity (60 V)".to_owned()];
        let ended = "; gravity.sine = 60 V is where the search for it ends, and no motor is like that";
        let told = Standing::of(&Facts { left: Some(Adequacy::Something), ended, ..facts(&effects, 12.0) });
        assert!(told.headline.ends_with(&format!("what is left is 12 x the noise{ended}.")), "{told:?}");
        let told = Standing::of(&Facts { left: None, ended, ..facts(&effects, 12.0) });
        assert!(told.headline.ends_with(&format!("{ended}.")), "{told:?}");
    }

    #[test]
    fn a_model_that_is_not_diagnosed_is_not_praised() {
        let told = Standing::of(&Facts { left: None, ..facts(&[], 101.0) });
        assert_eq!((told.verdict, told.next.action), (None, Action::Diagnose));
        assert!(
            told.headline.contains("101 x the noise") && told.headline.contains("not enough"),
            "{told:?}"
        );
    }

    #[test]
    fn while_an_effect_is_to_be_added_nothing_is_said_to_have_failed() {
        let told = Standing::of(&Facts { suggested: Some(Kind::DeadZone), ..facts(&[], 101.0) });
        assert_eq!((told.verdict, told.next.effect), (None, Some(Kind::DeadZone)));
        assert!(told.headline.ends_with("the best candidate is dead zone."), "{told:?}");
    }

    #[test]
    fn who_proposes_an_effect_does_not_say_that_the_noise_leaves_none_to_find() {
        let effects = ["dead_zone (0.6 V)".to_owned()];
        let told = Standing::of(&Facts { suggested: Some(Kind::SensorLag), ..facts(&effects, 1.1) });
        assert!(told.headline.ends_with("1.1 x the noise; the best candidate is sensor lag."), "{told:?}");
        let told = Standing::of(&Facts { left: None, ..facts(&effects, 1.1) });
        assert!(told.headline.ends_with("about as little as the noise allows."), "{told:?}");
    }

    #[test]
    fn hundreds_of_times_the_noise_do_not_stand_beside_a_plain_explained() {
        let disturbed = |model| Facts { left: Some(Adequacy::Disturbance(0.06)), ..facts(&[], model) };
        let told = Standing::of(&disturbed(298.0));
        assert_eq!((told.verdict, told.badge), (Some(Verdict::Explained), "Explained but for a disturbance"));
        assert_eq!(Standing::of(&disturbed(2.0)).badge, "Explained");
    }

    #[test]
    fn an_effect_that_raises_the_error_is_to_be_removed() {
        let effects = ["delay (2 ms)".to_owned()];
        let most = Rise { record: "stairs".into(), at_s: 3.25, times: 2.0 };
        let doubted = Some(Doubted { effect: Kind::Delay, rises: true, most: Some(&most) });
        let told = Standing::of(&Facts { doubted, left: None, ..facts(&effects, 150.0) });
        assert_eq!(told.next.effect, Some(Kind::Delay));
        assert_eq!((told.badge, told.next.action), ("Not confirmed", Action::Remove));
        let said =
            "With delay the error rises, most on stairs around 3.2 s; what is left is 150 x the noise.";
        assert_eq!(told.headline, said);
        let doubted = Some(Doubted { effect: Kind::Delay, rises: false, most: None });
        let told = Standing::of(&Facts { doubted, left: None, ..facts(&effects, 90.0) });
        assert_eq!(told.headline, "Held-out data do not confirm delay; what is left is 90 x the noise.");
    }

    #[test]
    fn what_the_records_cannot_show_is_said_where_they_show_nothing_missing() {
        let hidden = [Kind::Backlash, Kind::Delay, Kind::Cogging];
        let told = Standing::of(&Facts { hidden: &hidden, experiment: true, ..facts(&[], 1.0) });
        assert!(told.headline.ends_with("they cannot confirm backlash, delay and 1 more."), "{told:?}");
        assert_eq!(told.next.action, Action::Experiment);
    }

    #[test]
    fn only_a_model_that_leaves_little_is_to_be_used() {
        let effects = ["coulomb (0.4 V)".to_owned()];
        assert_eq!(Standing::of(&facts(&effects, 1.1)).next.action, Action::Export);
        assert_eq!(Standing::of(&facts(&effects, 40.0)).next.action, Action::Look);
        let open = Facts { experiment: true, ..facts(&effects, 40.0) };
        assert_eq!(Standing::of(&open).next.action, Action::Experiment);
    }
}
