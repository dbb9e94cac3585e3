//! What the page shows: records, the model and how it came about.

use std::collections::HashMap;

use motorlens_shared::effects::Kind;

use crate::compare::free_run::{free_runs, pooled};
use crate::compare::residual_torque::{ResidualTorque, residual_torque};
use crate::diagnose::candidate::{Candidate, Evidence};
use crate::diagnose::climb::Climb;
use crate::diagnose::discover::{self, Ranked, Rung, prepare};
use crate::error::Result;
use crate::estimate::combinations;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::uncertainty::estimates;
use crate::log::Record;
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;
use crate::report::{Shown, Story, Suspect, faults, shown, title, torques};
use crate::simulate::Answer;

/// A record with what is drawn of it.
pub type Drawn = (Shown, [ResidualTorque; 2]);

/// Effects that helped, tried on the current model.
#[derive(Debug, Clone, Default)]
pub struct Diagnosis {
    /// With their parameters, best first.
    pub candidates: Vec<Candidate>,
    /// The same in words.
    pub ranked: Vec<Ranked>,
    /// Sets that cannot be told apart.
    pub rivals: Vec<Vec<Kind>>,
}

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
    /// The base model of the first rung.
    pub base: Values,
    /// The model as it is.
    pub current: Candidate,
    /// How it came about.
    pub ladder: Vec<Rung>,
    /// What is missing from the current model; none before the diagnosis.
    pub diagnosis: Option<Diagnosis>,
    /// What is hidden, where the records are a puzzle's.
    pub puzzle: Option<Puzzle>,
    /// Error that a perfect model would leave.
    pub floor: f64,
    drawn: HashMap<usize, Drawn>,
    story: Option<Story>,
}

impl Session {
    /// Lays out the records and fits the base model.
    ///
    /// # Errors
    /// Records that no fit can use.
    pub fn new(records: Vec<Record>, validation: Vec<Record>, motor: MotorFile) -> Result<Self> {
        let (evidence, current) = prepare(&records, &validation, &motor)?;
        let floor = discover::noise_floor(&records, &validation, &evidence.whole);
        let mut session = Self {
            base: current.values(),
            ladder: Vec::new(),
            diagnosis: None,
            puzzle: None,
            drawn: HashMap::new(),
            story: None,
            records,
            validation,
            motor,
            evidence,
            current,
            floor,
        };
        session.ladder.push(session.rung());
        Ok(session)
    }

    /// Unit of what is compared.
    pub fn unit(&self) -> &'static str {
        self.evidence.whole.grids.first().map_or("rad", |g| g.quantity.unit())
    }

    /// The problem of the unseen records, where there are any.
    pub fn unseen(&self) -> Option<&Problem> {
        (!self.validation.is_empty()).then_some(&self.evidence.unseen)
    }

    /// The current model on all records.
    fn rung(&self) -> Rung {
        let values = self.current.values();
        Rung {
            effects: values.kinds(),
            train: pooled(&free_runs(&self.evidence.whole, &values)).unwrap_or_default(),
            validation: self.unseen().and_then(|u| pooled(&free_runs(u, &values))),
        }
    }

    /// Takes `model` as the current one.
    pub fn step_to(&mut self, model: Candidate) {
        self.current = model;
        self.diagnosis = None;
        self.forget_drawings();
        self.ladder.push(self.rung());
    }

    /// Keeps what a diagnosis of the current model found.
    pub fn diagnosed(&mut self, candidates: Vec<Candidate>) {
        let best = candidates.first().cloned();
        let rungs = std::iter::once(self.current.clone()).chain(best).collect();
        let climb = Climb { rungs, first: candidates, refused: Vec::new() };
        let ranked = discover::rank(&climb, self.unseen());
        let rivals = discover::rivals(&climb);
        self.diagnosis = Some(Diagnosis { candidates: climb.first, ranked, rivals });
        self.story = None;
    }

    fn forget_drawings(&mut self) {
        self.drawn.clear();
        self.story = None;
    }

    /// Record `number` (training first) with the runs of base model and model; none beyond the last.
    pub fn drawn(&mut self, number: usize) -> Option<&Drawn> {
        if !self.drawn.contains_key(&number) {
            let fitted = self.evidence.whole.grids.len();
            let (problem, place) = if number < fitted {
                (&self.evidence.whole, number)
            } else {
                (self.unseen()?, number - fitted)
            };
            let one = problem.on(vec![problem.grids.get(place)?.clone()]);
            let values = self.current.values();
            let mut pair = shown(&one, None, &self.base, &values);
            let mut record = pair.pop()?;
            record.unseen = number >= fitted;
            let torques = [
                residual_torque(&record.base, &self.base.base),
                residual_torque(&record.model, &values.base),
            ];
            self.drawn.insert(number, (record, torques));
        }
        self.drawn.get(&number)
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

    /// Everything that a report tells, made once for each model.
    pub fn story(&mut self) -> &Story {
        let told = match self.story.take() {
            Some(story) => story,
            None => self.tell(),
        };
        self.story.insert(told)
    }

    fn tell(&mut self) -> Story {
        let count = self.records.len() + self.validation.len();
        let mut story_records = Vec::new();
        let (mut base_torques, mut model_torques) = (Vec::new(), Vec::new());
        for number in 0..count {
            if let Some((record, [base, model])) = self.drawn(number) {
                story_records.push(record.clone());
                base_torques.push(base.clone());
                model_torques.push(model.clone());
            }
        }
        let values = self.current.values();
        let whole = &self.evidence.whole;
        let diagnosis = self.diagnosis.clone().unwrap_or_default();
        let suspects = diagnosis.ranked.into_iter().enumerate().map(|(place, ranked)| {
            let candidate = diagnosis.candidates.iter().find(|c| c.kinds().last() == Some(&ranked.effect));
            let runs = candidate.filter(|_| place < 3).map(|c| (free_runs(whole, &c.values()), c.values()));
            Suspect { torques: runs.map(|(runs, values)| torques(runs.iter(), &values)), ranked }
        });
        Story {
            title: title(&self.records),
            base: self.base.clone(),
            unit: self.unit(),
            floor: self.floor,
            ladder: self.ladder.clone(),
            suspects: suspects.collect(),
            diagnosed_model: true,
            rivals: diagnosis.rivals,
            verdict: None,
            faults: self.records.iter().chain(&self.validation).flat_map(faults).collect(),
            parameters: estimates(whole, &values),
            combinations: combinations(whole, &values),
            base_torques: crate::report::Torques { records: base_torques },
            model_torques: crate::report::Torques { records: model_torques },
            records: story_records,
            model: self.model(),
        }
    }
}
