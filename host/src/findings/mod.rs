//! The one public result of a diagnosis: what terminal, JSON, report and page tell.

mod experiment;
mod mend;
mod named;
mod next_step;
pub mod shown_by_fit;
mod standing;
mod supposed;
mod verdict;
mod yardstick;

use std::path::Path;

use motorlens_shared::effects::{Kind, Rig};
use serde::Serialize;

use crate::compare::measures::Measures;
use crate::diagnose::discover::Discovery;
use crate::diagnose::ladder::{Ranked, Rung};
use crate::diagnose::plan::Limits;
use crate::error::Error;
use crate::estimate::combinations;
use crate::fit::grid::Quantity;
use crate::fit::uncertainty::{Estimate, estimates};
use crate::log::{Record, Warning};
use crate::motor_file::MotorFile;
use crate::report::falls::judged;
use crate::select::DetectionLimit;
use crate::select::adequacy::Adequacy;

pub use experiment::{Experiment, NextExperiment};
pub use mend::Mend;
pub use named::named;
pub use next_step::{Action, NextStep};
pub use standing::{Doubted, Facts, Standing};
pub use supposed::Supposed;
pub use verdict::{Errors, MANY, Verdict, multiple};
pub use yardstick::Yardstick;

/// Everything found, in the order of the published layout.
#[derive(Debug, Serialize)]
pub struct Findings {
    schema: u32,
    /// Accepted effects in order.
    pub effects: Vec<Kind>,
    /// How it ended.
    pub verdict: Verdict,
    /// The verdict in one sentence.
    pub headline: String,
    /// What to do next.
    pub next_step: NextStep,
    #[serde(skip)]
    badge: &'static str,
    #[serde(skip)]
    also: Option<NextStep>,
    /// Error of the accepted model in multiples of the noise level.
    pub left_over: Option<f64>,
    /// Fraction of the error above the noise level that the effects explain.
    pub explained_share: Option<f64>,
    /// What each speed is; none of records of an angle.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub speed_reading: Option<String>,
    /// Noise level, rms.
    pub noise_floor_rad: f64,
    /// From the base model on.
    pub ladder: Vec<Rung>,
    /// First diagnosis, best first; what a diagnosis suggests stands before all others.
    pub candidates: Vec<Ranked>,
    /// Sets that the data cannot tell apart.
    pub rivals: Vec<Vec<Kind>>,
    /// What to run next.
    pub next_experiment: Option<NextExperiment>,
    /// Why no experiment would tell the rivals apart, where there are some and none would.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub no_experiment: Option<String>,
    /// For every effect that was not accepted, the smallest size that these records would have shown.
    pub detection_limits: Vec<DetectionLimit>,
    /// Data quality problems of the logs, and those that the fit shows.
    pub data_faults: Vec<Warning>,
    #[serde(skip)]
    of_logs: usize,
    /// With 95 % intervals.
    pub parameters: Vec<Estimate>,
    /// What voltage and motion alone determine.
    pub combinations: Vec<Estimate>,
    /// Time taken.
    pub seconds: f64,
    /// Candidates simulated over all records.
    pub simulations: u64,
    /// Why nothing could be found.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub error: Option<serde_json::Value>,
}

impl Findings {
    /// What a discovery found on logs with the faults `of_logs`.
    pub fn new(found: &Discovery, of_logs: &[Warning]) -> Self {
        Self::beside(found, None, of_logs)
    }

    /// What a diagnosis of a model with `own` effects found: the effect that it is missing, if any, is suggested and not yet in the model.
    pub fn of_diagnosis(found: &Discovery, own: usize, of_logs: &[Warning]) -> Self {
        Self::beside(found, Some(own), of_logs)
    }

    fn beside(found: &Discovery, own: Option<usize>, of_logs: &[Warning]) -> Self {
        let values = found.model.values();
        let parameters = estimates(&found.evidence.whole, &values);
        let suggested = own.and_then(|own| found.effects.get(own)).copied();
        let without = |count: usize| count - usize::from(suggested.is_some());
        let ladder = &found.ladder[..without(found.ladder.len())];
        let errors = errors_of(ladder, found.baseline.as_ref(), found.noise_floor);
        let in_model = &found.effects[..without(found.effects.len())];
        let experiment = found.experiment(Limits::of(&found.evidence));
        let accepted = found.selected.model();
        let mut later = shown_by_fit::of_model(&parameters, &found.effects, (&accepted.layout, &accepted.x));
        let ended = shown_by_fit::ended(&accepted.layout, &accepted.x);
        let standing = Standing::of(&Facts {
            errors,
            effects: &named(in_model, &parameters),
            left: Some(found.adequacy),
            suggested,
            doubted: None,
            // A base parameter that is open makes a model of no use as much as a rival does.
            experiment: experiment.next.is_some()
                && (found.effects.is_empty()
                    || !found.selected.rivals.is_empty()
                    || shown_by_fit::too_little_excitation(&parameters).is_some()),
            ended: &ended,
            hidden: &DetectionLimit::hidden(&found.limits),
            data_problems: !of_logs.is_empty() || !later.is_empty(),
            mend: Mend::first(of_logs),
            asked: None,
        });
        later.extend(shown_by_fit::doubted_by_validation(&found.ladder));
        later.extend(shown_by_fit::nearer_rival(&found.selected.rivals, &found.evidence));
        if suggested.is_none() {
            later.extend(shown_by_fit::worse_than_usual(&found.ladder, found.baseline.as_ref()));
        }
        // While an effect is suggested something is left.
        let open = || errors.verdict(in_model.len(), Adequacy::default());
        let rivals = found.open_sets();
        let rival = |kind: Kind| rivals.iter().any(|set| set.contains(&kind));
        Self {
            schema: 1,
            effects: found.effects[own.unwrap_or(0)..].to_vec(),
            verdict: standing.verdict.unwrap_or_else(open),
            headline: standing.headline,
            next_step: standing.next,
            badge: standing.badge,
            also: standing.also,
            left_over: errors.left_over(),
            explained_share: errors.explained_share(),
            speed_reading: found.evidence.whole.speeds().and_then(Quantity::speed_in_words),
            noise_floor_rad: found.noise_floor,
            ladder: found.ladder.clone(),
            candidates: first(&found.candidates, suggested),
            rivals: rivals.clone(),
            next_experiment: experiment.next,
            no_experiment: experiment.none,
            // What stands for an accepted effect is a rival, no further effect.
            detection_limits: found.limits.iter().filter(|limit| !rival(limit.effect)).cloned().collect(),
            data_faults: of_logs.iter().cloned().chain(later).collect(),
            of_logs: of_logs.len(),
            parameters,
            combinations: combinations(&found.evidence.whole, &values),
            seconds: found.seconds,
            simulations: found.simulations,
            error: None,
        }
    }

    /// Data that must be mended first.
    pub fn bad_data(error: &Error, of_logs: &[Warning]) -> Self {
        let mut faults = of_logs.to_vec();
        if let (Error::BadInput(fault), true) = (error, faults.is_empty()) {
            let line = fault.line.map_or(String::new(), |l| format!(", line {l}"));
            let column = fault.column.as_ref().map_or(String::new(), |c| format!(", column {c}"));
            faults.push(Warning {
                place: format!("{}{line}{column}", Path::new(&fault.file).display()),
                what: fault.why.clone(),
                fix: fault.remedy.clone(),
            });
        }
        let standing = Standing::bad_data();
        Self {
            schema: 1,
            effects: Vec::new(),
            verdict: Verdict::BadData,
            headline: standing.headline,
            next_step: standing.next,
            badge: standing.badge,
            also: standing.also,
            left_over: None,
            explained_share: None,
            speed_reading: None,
            noise_floor_rad: 0.0,
            ladder: Vec::new(),
            candidates: Vec::new(),
            rivals: Vec::new(),
            next_experiment: None,
            no_experiment: None,
            detection_limits: Vec::new(),
            data_faults: faults,
            of_logs: of_logs.len(),
            parameters: Vec::new(),
            combinations: Vec::new(),
            seconds: 0.0,
            simulations: 0,
            error: error.to_json().get("error").cloned(),
        }
    }
}

impl Findings {
    /// The same, found on `records` of a `motor` on `rig`: the headline says what the effects suppose that no file tells, which is to be told
    /// before the model is used.
    #[must_use]
    pub fn supposing(mut self, records: &[Record], motor: &MotorFile, rig: &Rig) -> Self {
        let supposed = Supposed::by(&self.effects, records, motor, rig);
        self.next_step = self.next_step.once_told(&supposed);
        self.headline += &supposed.text;
        self
    }

    /// What a person is told first.
    pub fn standing(&self) -> Standing {
        let (verdict, headline) = (Some(self.verdict), self.headline.clone());
        let (next, also) = (self.next_step.clone(), self.also.clone());
        Standing { verdict, badge: self.badge, headline, next, also }
    }

    /// Faults that only the fit has shown; those of the logs were told before it.
    pub fn later_faults(&self) -> &[Warning] {
        &self.data_faults[self.of_logs..]
    }
}

/// `ranked` with the effect that is suggested in front: searched to its end, another one may have failed.
fn first(ranked: &[Ranked], suggested: Option<Kind>) -> Vec<Ranked> {
    let (mut all, others): (Vec<Ranked>, Vec<Ranked>) =
        ranked.iter().cloned().partition(|c| Some(c.effect) == suggested);
    all.extend(others);
    all
}

/// The verdict on what a discovery found, as [`Findings`] tell it.
pub fn verdict_of(found: &Discovery) -> Verdict {
    errors_of(&found.ladder, found.baseline.as_ref(), found.noise_floor)
        .verdict(found.effects.len(), found.adequacy)
}

/// The errors of a ladder's first and last model beside the simpler ones and the `usual` one, with the noise level.
pub fn errors_of(ladder: &[Rung], usual: Option<&Rung>, noise: f64) -> Errors {
    let of = |rung: Option<&Rung>| rung.map_or_else(Measures::default, judged);
    let (base, model) = (of(ladder.first()), of(ladder.last()));
    Errors { beaten: shown_by_fit::beaten(ladder, usual), ..Errors::of(&base, &model, noise) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_suggested_stands_before_the_others_which_keep_their_order() {
        let ranked = |effect| Ranked { effect, score: 0.5, validation: None, evidence: String::new() };
        let all = [Kind::Coulomb, Kind::Delay, Kind::Compliance].map(ranked);
        let order = |suggested| first(&all, suggested).iter().map(|c| c.effect).collect::<Vec<_>>();
        assert_eq!(order(Some(Kind::Compliance)), [Kind::Compliance, Kind::Coulomb, Kind::Delay]);
        assert_eq!(order(None), [Kind::Coulomb, Kind::Delay, Kind::Compliance]);
    }
}
