//! What the page shows: records, the model and how it came about.

use std::sync::Arc;

use motorlens_shared::effects::Kind;

use super::diagnosis::Diagnosis;
use super::view::{Tracks, View};
use crate::diagnose::candidate::Candidate;
use crate::diagnose::discover::{self, prepare};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::{self, Rung};
use crate::error::Result;
use crate::log::{Record, Warning, data_faults};
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;
use crate::report::{Story, Suspect, missing, shown_by_fit, title};
use crate::simulate::Answer;

/// A hidden effect to be found.
#[derive(Debug, Clone)]
pub struct Puzzle {
    /// What is hidden.
    pub answer: Answer,
    /// Whether it has been shown.
    pub revealed: bool,
}

/// Records and models of one page.
#[derive(Debug)]
pub struct Session {
    /// Fitted.
    pub records: Vec<Record>,
    /// Kept out.
    pub validation: Vec<Record>,
    /// What is known of the motor.
    pub motor: MotorFile,
    /// The records as the search sees them.
    pub evidence: Evidence,
    /// The model as it is.
    pub current: Candidate,
    /// How it came about.
    pub ladder: Vec<Rung>,
    /// What is missing from the current model; none before the diagnosis.
    pub diagnosis: Option<Arc<Diagnosis>>,
    /// What is hidden, where the records are a puzzle's.
    pub puzzle: Option<Puzzle>,
    /// Error that a perfect model would leave.
    pub floor: f64,
    /// What is odd about the records.
    pub faults: Vec<Warning>,
    view: Arc<View>,
}

/// A session at one moment, to be told without holding it up.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The model on the records.
    pub view: Arc<View>,
    /// How the model came about.
    pub ladder: Vec<Rung>,
    /// What is missing from it.
    pub diagnosis: Option<Arc<Diagnosis>>,
    /// Error that a perfect model would leave.
    pub floor: f64,
    /// Unit of what is compared.
    pub unit: &'static str,
    /// What is odd about the records.
    pub faults: Vec<Warning>,
    /// The model as a file.
    pub model: Model,
    title: String,
}

impl Session {
    /// Lays out the records and fits the base model.
    ///
    /// # Errors
    /// Records that no fit can use.
    pub fn new(records: Vec<Record>, validation: Vec<Record>, motor: MotorFile) -> Result<Self> {
        let (evidence, current) = prepare(&records, &validation, &motor)?;
        let floor = discover::noise_floor(&records, &validation, &evidence.whole);
        let tracks = Arc::new(Tracks::new(&evidence));
        let base = current.values();
        Ok(Self {
            faults: data_faults(records.iter().chain(&validation)),
            ladder: vec![rung(&evidence, &current)],
            view: Arc::new(View::new(tracks, base.clone(), base)),
            diagnosis: None,
            puzzle: None,
            records,
            validation,
            motor,
            evidence,
            current,
            floor,
        })
    }

    /// Unit of what is compared.
    pub fn unit(&self) -> &'static str {
        self.evidence.whole.grids.first().map_or("rad", |g| g.quantity.unit())
    }

    /// Takes `model` as the current one, whose errors are `rung`.
    pub fn step_to(&mut self, model: Candidate, rung: Rung) {
        let (tracks, base) = (Arc::clone(&self.view.tracks), self.view.base.clone());
        self.view = Arc::new(View::new(tracks, base, model.values()));
        self.current = model;
        self.diagnosis = None;
        self.ladder.push(rung);
    }

    /// The model on the records.
    pub fn view(&self) -> Arc<View> {
        Arc::clone(&self.view)
    }

    /// The model as a file.
    pub fn model(&self) -> Model {
        let origin = Origin {
            motorlens: env!("CARGO_PKG_VERSION").into(),
            records: self.records.iter().map(|r| r.name.clone()).collect(),
            method: "live page".into(),
            seed: None,
        };
        Model::new(&self.current.values(), &self.evidence.whole.rig, &self.evidence.whole.prior, origin)
    }

    /// How things stand.
    pub fn scene(&self) -> Scene {
        Scene {
            view: self.view(),
            ladder: self.ladder.clone(),
            diagnosis: self.diagnosis.clone(),
            floor: self.floor,
            unit: self.unit(),
            faults: self.faults.clone(),
            model: self.model(),
            title: title(&self.records),
        }
    }
}

/// `model` on all records of `evidence`.
pub fn rung(evidence: &Evidence, model: &Candidate) -> Rung {
    ladder::rung(evidence, &model.values())
}

impl Scene {
    /// Motor turns per turn of the output shaft.
    pub fn gear_ratio(&self) -> f64 {
        self.model.rig.gear_ratio
    }

    /// Effects in the model.
    pub fn effects(&self) -> Vec<Kind> {
        self.view.model.kinds()
    }

    /// Faults of the data that only the fit shows.
    pub fn later_faults(&self) -> Vec<Warning> {
        shown_by_fit::faults(&self.view.estimates()[0], &self.effects())
    }

    /// What is suspected, and after it what is in the model already.
    pub fn suspects(&self) -> Vec<Suspect> {
        let mut all = self.diagnosis.as_deref().map_or_else(Vec::new, |d| d.suspects.clone());
        let drawn = self.view.evidence();
        all.extend(
            self.effects()
                .into_iter()
                .zip(drawn)
                .map(|(kind, figures)| missing::accepted(kind, &self.ladder, self.unit, figures.clone())),
        );
        all
    }

    /// Everything that a report tells.
    pub fn story(&self) -> Story {
        let [base_torques, model_torques] = self.view.torques().clone();
        let [parameters, combinations] = self.view.estimates().clone();
        let diagnosis = self.diagnosis.as_deref().cloned().unwrap_or_default();
        Story {
            title: self.title.clone(),
            base: self.view.base.clone(),
            unit: self.unit,
            floor: self.floor,
            ladder: self.ladder.clone(),
            suspects: self.suspects(),
            rivals: diagnosis.rivals,
            next: diagnosis.next.map(|next| next.why),
            withdrawn: Vec::new(),
            verdict: None,
            faults: self.faults.iter().cloned().chain(self.later_faults()).collect(),
            parameters,
            combinations,
            base_torques,
            model_torques,
            records: self.view.all_shown().into_iter().cloned().collect(),
            model: self.model.clone(),
        }
    }
}
