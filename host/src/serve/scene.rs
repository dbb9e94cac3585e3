//! A session at one moment: what the page, the report and the verdict tell of it.

use std::sync::Arc;

use motorlens_shared::effects::Kind;

use super::diagnosis::Diagnosis;
use super::open::Open;
use super::session::Doubt;
use super::view::View;
use crate::compare::rise::Rise;
use crate::diagnose::ladder::Rung;
use crate::findings::{Doubted, Facts, Mend, Standing, Supposed, errors_of, named, shown_by_fit};
use crate::log::Warning;
use crate::model_file::Model;
use crate::report::{Story, Suspect, missing};
use crate::select::DetectionLimit;
use crate::select::fitted::Fitted;

/// A session at one moment, to be told without holding it up.
#[derive(Debug, Clone)]
pub struct Scene {
    /// The model on the records.
    pub view: Arc<View>,
    /// How the model came about.
    pub ladder: Vec<Rung>,
    /// Where each of its steps raised the error most.
    pub rises: Vec<Option<Rise>>,
    /// Errors of kS-kV-kA.
    pub baseline: Option<Rung>,
    /// What is missing from it.
    pub diagnosis: Option<Arc<Diagnosis>>,
    /// Noise level.
    pub floor: f64,
    /// Unit of what is compared.
    pub unit: &'static str,
    /// Problems of the data.
    pub faults: Vec<Warning>,
    /// The model as a file.
    pub model: Model,
    pub(super) chosen: Fitted,
    pub(super) doubt: Option<Doubt>,
    pub(super) open: Vec<Arc<Open>>,
    pub(super) title: String,
    /// Whether a person looked once more at the columns of all files.
    pub(super) confirmed: bool,
    /// What the model supposes that no file tells.
    pub(super) supposed: Supposed,
}

impl Scene {
    /// Motor turns per turn of the output shaft.
    pub fn gear_ratio(&self) -> f64 {
        self.model.rig.gear_ratio
    }

    /// Heading of the page.
    pub fn title(&self) -> &str {
        &self.title
    }

    /// Effects in the model.
    pub fn effects(&self) -> Vec<Kind> {
        self.view.model.kinds()
    }

    /// The verdict and what to do next.
    pub fn standing(&self) -> Standing {
        let diagnosis = self.diagnosis.as_deref();
        let mut standing = Standing::of(&Facts {
            errors: errors_of(&self.ladder, self.baseline.as_ref(), self.floor),
            effects: &named(&self.effects(), &self.view.estimates()[0]),
            left: diagnosis.map(|d| d.left),
            suggested: diagnosis.and_then(|d| d.suggested),
            doubted: self.doubt.map(|d| Doubted {
                effect: d.effect,
                rises: d.rises,
                most: self.rises.last().and_then(Option::as_ref),
            }),
            experiment: diagnosis.is_some_and(|d| {
                d.next.is_some() && (self.effects().is_empty() || self.open().next().is_some())
            }),
            ended: &shown_by_fit::ended(&self.chosen.layout, &self.chosen.x),
            hidden: &diagnosis.map_or_else(Vec::new, |d| DetectionLimit::hidden(&d.limits)),
            data_problems: !self.faults.is_empty() || !self.later_faults().is_empty(),
            mend: Mend::first(&self.faults),
            asked: Mend::asked(&self.faults).filter(|_| !self.confirmed),
        });
        // Before anything was found there is no answer.
        if diagnosis.is_some() || !self.effects().is_empty() {
            standing.headline += &self.supposed.text;
            if !self.confirmed {
                standing.next = standing.next.once_told(&self.supposed);
            }
        }
        standing
    }

    /// Faults of the data that only the fit shows.
    pub fn later_faults(&self) -> Vec<Warning> {
        // An effect that the data do not confirm shows nothing about them.
        let believed = |kind: &Kind| self.doubt.is_none_or(|doubt| doubt.effect != *kind);
        let effects: Vec<Kind> = self.effects().into_iter().filter(believed).collect();
        let mut all = shown_by_fit::of_model(
            &self.view.estimates()[0],
            &effects,
            (&self.chosen.layout, &self.chosen.x),
        );
        if self.diagnosis.as_ref().is_some_and(|diagnosis| diagnosis.suggested.is_none()) {
            all.extend(shown_by_fit::worse_than_usual(&self.ladder, self.baseline.as_ref()));
        }
        all
    }

    /// All that only the fit and the search show, as it is told.
    pub fn shown_by_the_fit(&self) -> Vec<Warning> {
        let nearer = self.open().find_map(|open| open.nearer.clone());
        self.later_faults().into_iter().chain(nearer).collect()
    }

    /// What the effects of the model leave open, and what is suggested.
    fn open(&self) -> impl Iterator<Item = &Arc<Open>> {
        self.open.iter().chain(self.diagnosis.as_deref().and_then(|diagnosis| diagnosis.open.as_ref()))
    }

    /// Sets of effects that the records cannot tell apart, the accepted or suggested one of each first.
    pub fn rivals(&self) -> Vec<Vec<Kind>> {
        self.open().map(|open| open.set.kinds()).collect()
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
            base: self.view.against.values.clone(),
            unit: self.unit,
            floor: self.floor,
            ladder: self.ladder.clone(),
            suspects: self.suspects(),
            rivals: self.rivals(),
            next: diagnosis.next.map(|next| next.why),
            standing: self.standing(),
            rises: self.rises.clone(),
            baseline: self.baseline.clone(),
            faults: self.faults.iter().cloned().chain(self.shown_by_the_fit()).collect(),
            parameters,
            combinations,
            base_torques,
            model_torques,
            records: self.view.all_shown().into_iter().cloned().collect(),
            model: self.model.clone(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::session::Session;
    use super::*;
    use crate::findings::Action;
    use crate::log::Record;
    use crate::motor_file::MotorFile;

    #[test]
    fn a_unit_that_only_the_mapping_says_is_told_on_the_page_once_there_is_an_answer() {
        let mut session = Session::of_a_swing();
        let told = |session: &Session| {
            let supposed = Supposed { text: " It is in degrees.".into(), place: None };
            Scene { supposed, ..session.scene() }.standing().headline
        };
        assert!(!told(&session).contains("degrees"));
        session.diagnosis = Some(Arc::new(Diagnosis::default()));
        assert!(told(&session).ends_with(". It is in degrees."), "{}", told(&session));
    }

    #[test]
    fn what_the_fit_shows_of_the_data_is_told_before_where_the_model_fails() {
        // A fifth of a second in which the motor only gathers speed tells no top speed.
        let time_s: Vec<f64> = (0..20).map(|k| 0.01 * f64::from(k)).collect();
        let bent = |k: usize, t: f64| 60.0 * t.powi(3) + if k.is_multiple_of(3) { 2e-3 } else { 0.0 };
        let record = Record {
            name: "short".into(),
            voltage_v: time_s.iter().map(|t| 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin()).collect(),
            angle_rad: Some(time_s.iter().enumerate().map(|(k, t)| bent(k, *t)).collect()),
            time_s,
            ..Record::default()
        };
        let mut session = Session::new(vec![record], Vec::new(), MotorFile::default()).unwrap();
        session.diagnosis = Some(Arc::new(Diagnosis::default()));
        let scene = session.scene();
        assert!(scene.faults.is_empty(), "{:?}", scene.faults);
        let told = scene.later_faults();
        assert!(told.iter().any(|fault| fault.what.starts_with("too_little_excitation")), "{told:?}");
        assert_eq!(scene.standing().next.action, Action::Data);
        let story = scene.story();
        assert_eq!((story.standing.next.action, story.faults.len()), (Action::Data, told.len()));
    }
}
