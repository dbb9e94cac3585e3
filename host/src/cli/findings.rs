//! The document of `discover --json` and `diagnose --json`.

use std::path::Path;

use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::Programme;
use serde::Serialize;

use crate::diagnose::discover::{Discovery, Ranked, Rung, Verdict};
use crate::diagnose::plan::{Limits, Plan};
use crate::error::Error;
use crate::estimate::combinations;
use crate::fit::uncertainty::{Estimate, estimates};
use crate::log::{Record, Warning, faults, suspicions};

/// Everything found, in the order of the published layout.
#[derive(Debug, Serialize)]
pub struct Findings {
    schema: u32,
    /// Accepted effects in order.
    pub effects: Vec<Kind>,
    /// How it ended.
    pub verdict: Verdict,
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
    /// What is odd about the logs.
    pub data_faults: Vec<Warning>,
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
    /// What a discovery on `records` found.
    pub fn new(found: &Discovery, records: &[Record]) -> Self {
        let values = found.model.values();
        let parameters = estimates(&found.evidence.whole, &values);
        let mut faults = data_faults(records);
        faults.extend(too_little_excitation(&parameters));
        faults.extend(found.effects.iter().filter_map(|kind| of_the_sensor(*kind)));
        Self {
            schema: 1,
            effects: found.effects.clone(),
            verdict: found.verdict,
            noise_floor_rad: found.noise_floor,
            ladder: found.ladder.clone(),
            candidates: found.candidates.clone(),
            rivals: found.rivals.clone(),
            next_experiment: next_experiment(found),
            data_faults: faults,
            parameters,
            combinations: combinations(&found.evidence.whole, &values),
            seconds: found.seconds,
            simulations: found.simulations,
            error: None,
        }
    }

    /// Data that must be mended first.
    pub fn bad_data(error: &Error, records: &[Record]) -> Self {
        let mut faults = data_faults(records);
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
            noise_floor_rad: 0.0,
            ladder: Vec::new(),
            candidates: Vec::new(),
            rivals: Vec::new(),
            next_experiment: None,
            data_faults: faults,
            parameters: Vec::new(),
            combinations: Vec::new(),
            seconds: 0.0,
            simulations: 0,
            error: error.to_json().get("error").cloned(),
        }
    }
}

/// The programme for the rivals, within the voltages that the logs reached.
fn next_experiment(found: &Discovery) -> Option<NextExperiment> {
    let limits = Limits { volts: found.evidence.highest_voltage(), seconds: 8.0 };
    found.plan(limits).map(NextExperiment::from)
}

/// What reader and judge of the logs found odd.
pub fn data_faults(records: &[Record]) -> Vec<Warning> {
    records.iter().flat_map(faults).chain(suspicions(records)).collect()
}

/// Records from which even the plain motor cannot be had.
pub fn too_little_excitation(parameters: &[Estimate]) -> Option<Warning> {
    let open: Vec<&str> = parameters
        .iter()
        .filter(|p| matches!(p.name.as_str(), "gain" | "tau_m") && !p.identifiable)
        .map(|p| p.name.as_str())
        .collect();
    (!open.is_empty()).then(|| Warning {
        place: "all records together".into(),
        what: format!("too_little_excitation: they do not determine {}", open.join(" and ")),
        fix:
            "record a programme that accelerates, brakes and holds several speeds (motorlens plan writes one)"
                .into(),
    })
}

/// Effects that are faults of the measurement, and how to end them instead of modelling them.
fn of_the_sensor(kind: Kind) -> Option<Warning> {
    let (what, fix) = match kind {
        Kind::LostCounts => (
            "lost_counts: the angle falls behind at speed as if edges were missed",
            "read the encoder by hardware or faster, check its cable and filter, and log again",
        ),
        Kind::SensorLag => (
            "stale_samples: the reading trails the motion as if it were filtered or old",
            "log the raw reading at the instant of the voltage; else keep the effect",
        ),
        Kind::Delay => (
            "shifted_samples: the motion follows the logged voltage late",
            "check that the columns of a row belong to one instant; if the drive is that slow, keep the effect",
        ),
        _ => return None,
    };
    Some(Warning { place: "all records together".into(), what: what.into(), fix: fix.into() })
}
