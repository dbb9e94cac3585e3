//! The one public result of a diagnosis: what terminal, JSON, report and page tell.

mod verdict;

use std::path::Path;

use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::Programme;
use serde::Serialize;

use crate::diagnose::discover::{self, Discovery};
use crate::diagnose::ladder::{Ranked, Rung};
use crate::diagnose::plan::{Limits, Plan};
use crate::error::Error;
use crate::estimate::combinations;
use crate::fit::uncertainty::{Estimate, estimates};
use crate::log::Warning;
use crate::report::{falls::judged, shown_by_fit};

pub use verdict::{Errors, Verdict};

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
    /// Error of the accepted model in multiples of the noise level.
    pub left_over: Option<f64>,
    /// Fraction of the error above the noise level that the effects explain.
    pub explained_share: Option<f64>,
    /// rms that a perfect model would leave.
    pub noise_floor_rad: f64,
    /// From the base model on.
    pub ladder: Vec<Rung>,
    /// First diagnosis, best first.
    pub candidates: Vec<Ranked>,
    /// Sets that the data cannot tell apart.
    pub rivals: Vec<Vec<Kind>>,
    /// What to run next.
    pub next_experiment: Option<NextExperiment>,
    /// What is odd about the logs, and what the fit shows of it.
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

impl Findings {
    /// What a discovery found on logs with the faults `of_logs`.
    pub fn new(found: &Discovery, of_logs: &[Warning]) -> Self {
        let values = found.model.values();
        let parameters = estimates(&found.evidence.whole, &values);
        let error = |rung: Option<&Rung>| rung.map_or(0.0, |rung| judged(rung).rmse);
        let errors = Errors {
            base: error(found.ladder.first()),
            model: error(found.ladder.last()),
            noise: found.noise_floor,
        };
        let clean = found.verdict == discover::Verdict::Explained;
        let verdict = errors.verdict(found.effects.len(), clean);
        let names: Vec<&str> = found.effects.iter().map(|k| k.name()).collect();
        let later = shown_by_fit::faults(&parameters, &found.effects);
        Self {
            schema: 1,
            effects: found.effects.clone(),
            verdict,
            headline: errors.headline(&names, verdict),
            left_over: errors.left_over(),
            explained_share: errors.explained_share(),
            noise_floor_rad: found.noise_floor,
            ladder: found.ladder.clone(),
            candidates: found.candidates.clone(),
            rivals: found.open_sets(),
            next_experiment: next_experiment(found),
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
        Self {
            schema: 1,
            effects: Vec::new(),
            verdict: Verdict::BadData,
            headline: "The data must be mended before a model can be judged".into(),
            left_over: None,
            explained_share: None,
            noise_floor_rad: 0.0,
            ladder: Vec::new(),
            candidates: Vec::new(),
            rivals: Vec::new(),
            next_experiment: None,
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
    /// Faults that only the fit has shown; those of the logs were told before it.
    pub fn later_faults(&self) -> &[Warning] {
        &self.data_faults[self.of_logs..]
    }
}

/// The programme for the rivals, within the voltages that the logs reached.
fn next_experiment(found: &Discovery) -> Option<NextExperiment> {
    let limits = Limits { volts: found.evidence.highest_voltage(), seconds: 8.0 };
    found.plan(limits).map(NextExperiment::from)
}
