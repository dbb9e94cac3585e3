//! What the page shows: records, the model and how it came about.

use std::sync::Arc;

use motorlens_shared::effects::Kind;

use super::data::{Data, Role};
use super::diagnosis::Diagnosis;
use super::open::Open;
use super::scene::Scene;
use super::view::{Tracks, View};
use crate::compare::rise::Rise;
use crate::diagnose::discover::{self, prepare};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::{self, Rung};
use crate::error::Result;
use crate::findings::{Supposed, Yardstick};
use crate::fit::layout::Values;
use crate::fit::rig::highest_voltage;
use crate::log::{Loaded, ReadArgs, Record, Warning, data_faults};
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;
use crate::report::falls::judged;
use crate::report::title;
use crate::select::fitted::Fitted;
use crate::simulate::Answer;

/// A hidden effect to be found.
#[derive(Debug, Clone)]
pub struct Puzzle {
    /// What is hidden.
    pub answer: Answer,
    /// Whether it has been shown.
    pub revealed: bool,
}

/// A model that the page has come past.
#[derive(Debug, Clone)]
pub struct Passed {
    /// As it is offered for comparison.
    pub name: String,
    /// Its parameters.
    pub values: Values,
}

/// The effect added last, where held-out data do not confirm it.
#[derive(Debug, Clone, Copy)]
pub struct Doubt {
    /// The effect.
    pub effect: Kind,
    /// Whether the error rises with it.
    pub rises: bool,
}

/// Records and models of one page.
#[derive(Debug)]
pub struct Session {
    /// The records as they were read, their roles and cuts, and what is known of their motor.
    pub data: Data,
    /// The records as the search sees them.
    pub evidence: Evidence,
    /// The model without effects.
    pub base: Fitted,
    /// The model as effects are chosen by.
    pub chosen: Fitted,
    /// The same as it is shown and saved: fitted for simulating.
    pub current: Fitted,
    /// How it came about.
    pub ladder: Vec<Rung>,
    /// The models of the ladder, and before them the usual one of robotics, where the records give it.
    pub passed: Vec<Passed>,
    /// Where each step of the ladder raised the error most, if it did.
    pub rises: Vec<Option<Rise>>,
    /// Errors of kS-kV-kA, which users know.
    pub baseline: Option<Rung>,
    /// What is missing from the current model; none before the diagnosis.
    pub diagnosis: Option<Arc<Diagnosis>>,
    /// Whether the last step is believed.
    pub doubt: Option<Doubt>,
    /// What the effects of the model leave open.
    pub open: Vec<Arc<Open>>,
    /// Effects that were added to these records and removed again, as held-out data did not confirm them.
    pub refused: Vec<Kind>,
    /// What is hidden, where the records are a puzzle's.
    pub puzzle: Option<Puzzle>,
    /// Noise level, rms.
    pub floor: f64,
    /// Problems of the data.
    pub faults: Vec<Warning>,
    title: String,
    /// The highest voltage in what is fitted.
    peak_v: f64,
    view: Arc<View>,
}

impl Session {
    /// Lays out the records and fits the base model.
    ///
    /// # Errors
    /// Records that no fit can use.
    pub fn new(records: Vec<Record>, validation: Vec<Record>, motor: MotorFile) -> Result<Self> {
        Self::of(Data::new(records, validation, motor))
    }

    /// The same of the records of files that were `loaded` as `reading` says: their columns can be mapped anew on the page.
    ///
    /// # Errors
    /// Records that no fit can use, or a motor file that cannot be read.
    pub fn of_files(loaded: Loaded, reading: &ReadArgs) -> Result<Self> {
        let options = reading.options()?;
        let mut data = Data::new(loaded.records, loaded.validation, options.motor.clone());
        data.came_from(&options, &reading.division(), &reading.validate);
        Self::of(data)
    }

    /// The same with the roles and cuts of `data`.
    ///
    /// # Errors
    /// Records that no fit can use.
    pub fn of(data: Data) -> Result<Self> {
        let (records, validation) = (data.with(Role::Fit), data.with(Role::Validation));
        let (evidence, base) = prepare(&records, &validation, &data.motor)?;
        let current = base.simulating(&evidence);
        let floor = discover::noise_floor(&records, &validation, &evidence.whole);
        let tracks = Arc::new(Tracks::new(&evidence));
        let values = current.values();
        // Records on which it learns nothing have no baseline.
        let usual = evidence.usual.as_ref().map(|usual| usual.values.clone());
        let mut passed: Vec<Passed> =
            usual.iter().map(|v| Passed { name: USUAL.into(), values: v.clone() }).collect();
        passed.push(Passed { name: "base model".into(), values: values.clone() });
        Ok(Self {
            faults: data_faults(records.iter().chain(&validation)),
            title: title(&records),
            peak_v: highest_voltage(&records),
            ladder: vec![rung(&evidence, &current)],
            baseline: ladder::baseline(&evidence),
            view: Arc::new(View::new(tracks, passed[passed.len() - 1].clone(), values)),
            rises: vec![None],
            passed,
            diagnosis: None,
            doubt: None,
            open: Vec::new(),
            refused: Vec::new(),
            puzzle: None,
            data,
            evidence,
            chosen: base.clone(),
            base,
            current,
            floor,
        })
    }

    /// One of a speed that swings after its voltage.
    #[cfg(test)]
    pub(super) fn of_a_swing() -> Self {
        let time_s: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        let record = Record {
            name: "run".into(),
            voltage_v: time_s.iter().map(|t| 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin()).collect(),
            speed_rad_s: Some(time_s.iter().map(|t| 30.0 * (1.3 * t - 0.1).sin()).collect()),
            time_s,
            ..Record::default()
        };
        Self::new(vec![record], Vec::new(), MotorFile::default()).expect("a fit takes it")
    }

    /// Unit of what is compared.
    pub fn unit(&self) -> &'static str {
        self.evidence.whole.grids.first().map_or("rad", |g| g.quantity.unit())
    }

    /// What errors on these records are measured by.
    pub fn yardstick(&self) -> Yardstick {
        Yardstick::new(self.floor, &judged(&self.ladder[0]), self.unit())
    }

    /// Takes the model of `step` as the current one.
    pub fn step_to(&mut self, step: NextModel) {
        let NextModel { chosen, shown, rung, rise, doubt, open } = step;
        let values = shown.values();
        let name = prose(&values.kinds());
        let (tracks, against) = (Arc::clone(&self.view.tracks), self.view.against.clone());
        self.view = Arc::new(View::new(tracks, against, values.clone()));
        self.passed.retain(|p| p.name != name);
        self.passed.push(Passed { name, values });
        (self.chosen, self.current, self.diagnosis, self.doubt) = (chosen, shown, None, doubt);
        self.open = open;
        self.ladder.push(rung);
        self.rises.push(rise);
    }

    /// The model with these effects that the page has come past, if there is one.
    pub fn passed_with(&self, effects: &[Kind]) -> Option<Values> {
        let same = |values: &Values| {
            let kinds = values.kinds();
            kinds.len() == effects.len() && kinds.iter().all(|kind| effects.contains(kind))
        };
        let own = self.passed.iter().filter(|passed| passed.name != USUAL);
        own.map(|passed| &passed.values).find(|values| same(values)).cloned()
    }

    /// Draws the model beside number `place` of those passed.
    pub fn compare_with(&mut self, place: usize) -> bool {
        let Some(against) = self.passed.get(place).cloned() else { return false };
        self.view = Arc::new(View::new(Arc::clone(&self.view.tracks), against, self.current.values()));
        true
    }

    /// The model on the records.
    pub fn view(&self) -> Arc<View> {
        Arc::clone(&self.view)
    }

    /// The model as a file.
    pub fn model(&self) -> Model {
        let fitted = self.data.entries.iter().filter(|e| e.role == Role::Fit);
        let origin = Origin {
            motorlens: env!("CARGO_PKG_VERSION").into(),
            records: fitted.map(|e| e.record.name.clone()).collect(),
            method: "live page".into(),
            seed: None,
        };
        Model::fitted(&self.current.values(), &self.evidence.whole, origin)
    }

    /// How things stand.
    pub fn scene(&self) -> Scene {
        let view = self.view();
        let fitted = self.data.entries.iter().filter(|entry| entry.role == Role::Fit);
        let (motor, rig) = (&self.data.motor, &self.evidence.whole.rig);
        let records = fitted.map(|entry| &*entry.record);
        Scene {
            supposed: Supposed::by_parts(&view.model.kinds(), records, motor, rig, self.peak_v),
            view,
            ladder: self.ladder.clone(),
            rises: self.rises.clone(),
            baseline: self.baseline.clone(),
            diagnosis: self.diagnosis.clone(),
            floor: self.floor,
            unit: self.unit(),
            faults: self.faults.clone(),
            model: self.model(),
            chosen: self.chosen.clone(),
            doubt: self.doubt,
            open: self.open.clone(),
            title: self.title.clone(),
            confirmed: self.data.is_confirmed(),
        }
    }
}

/// What a step of the page leads to.
#[derive(Debug)]
pub struct NextModel {
    /// The model as effects are chosen by.
    pub chosen: Fitted,
    /// The same, fitted for simulating.
    pub shown: Fitted,
    /// Its errors.
    pub rung: Rung,
    /// Where it raised the error most.
    pub rise: Option<Rise>,
    /// Whether its last effect is believed.
    pub doubt: Option<Doubt>,
    /// What its effects leave open.
    pub open: Vec<Arc<Open>>,
}

/// The usual model of robotics, as the page names it.
const USUAL: &str = "kS-kV-kA";

/// A set of effects as a model is offered.
fn prose(kinds: &[Kind]) -> String {
    if kinds.is_empty() {
        return "base model, fitted again".into();
    }
    kinds.iter().map(ToString::to_string).collect::<Vec<_>>().join(" + ")
}

/// `model` on all records of `evidence`.
pub fn rung(evidence: &Evidence, model: &Fitted) -> Rung {
    ladder::rung(evidence, &model.values())
}
