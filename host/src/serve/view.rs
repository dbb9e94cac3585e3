//! What is drawn of one model on all records: computed when it is first asked for, then kept.
//!
//! A view never changes, so pages read it without holding the session: a fit that steps on makes a new one.

use std::sync::{Arc, Mutex, OnceLock, PoisonError};

use super::session::Passed;
use crate::compare::free_run::{FreeRun, free_runs};
use crate::cores;
use crate::diagnose::evidence::Evidence;
use crate::estimate::combinations;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::uncertainty::{Estimate, estimates};
use crate::report::figure::Figure;
use crate::report::{Shown, Torques, evidence, torques};

/// The records as a model runs over them, training first.
#[derive(Debug)]
pub struct Tracks {
    each: Vec<Track>,
    /// All that is fitted, for the intervals.
    whole: Mutex<Problem>,
}

#[derive(Debug)]
struct Track {
    problem: Mutex<Problem>,
    unseen: bool,
}

impl Tracks {
    /// The records of `evidence`, those to judge by included where they are records of their own.
    pub fn new(evidence: &Evidence) -> Self {
        let of = |problem: &Problem, unseen: bool| {
            let one = |grid: &crate::fit::grid::Grid| problem.on(vec![grid.clone()]);
            let tracks = problem.grids.iter().map(one).map(|p| Track { problem: Mutex::new(p), unseen });
            tracks.collect::<Vec<_>>()
        };
        let mut each = of(&evidence.whole, false);
        each.extend(evidence.kept_out.iter().flat_map(|kept_out| of(kept_out, true)));
        Self { each, whole: Mutex::new(evidence.whole.clone()) }
    }

    /// How many records there are.
    pub fn len(&self) -> usize {
        self.each.len()
    }

    /// Whether record `number` was kept out of every fit.
    pub fn unseen(&self, number: usize) -> bool {
        self.each[number].unseen
    }

    /// The run of `values` over record `number`.
    fn run(&self, number: usize, values: &Values) -> Option<FreeRun> {
        let problem = self.each[number].problem.lock().unwrap_or_else(PoisonError::into_inner);
        free_runs(&problem, values).pop()
    }

    /// The runs of `values` over all records, on all cores.
    pub fn runs(&self, values: &Values) -> Vec<FreeRun> {
        let numbers: Vec<usize> = (0..self.len()).collect();
        cores::each(&numbers, |number| self.run(*number, values)).into_iter().flatten().collect()
    }
}

/// One model on all records, beside the base model.
#[derive(Debug)]
pub struct View {
    /// The records.
    pub tracks: Arc<Tracks>,
    /// The model beside it: the base model, or whichever was chosen.
    pub against: Passed,
    /// The model.
    pub model: Values,
    shown: Vec<OnceLock<Shown>>,
    torques: OnceLock<[Torques; 2]>,
    evidence: OnceLock<Vec<Vec<Figure>>>,
    estimates: OnceLock<[Vec<Estimate>; 2]>,
}

impl View {
    /// Nothing is computed yet.
    pub fn new(tracks: Arc<Tracks>, against: Passed, model: Values) -> Self {
        let shown = (0..tracks.len()).map(|_| OnceLock::new()).collect();
        let (torques, evidence, estimates) = (OnceLock::new(), OnceLock::new(), OnceLock::new());
        Self { tracks, against, model, shown, torques, evidence, estimates }
    }

    /// Record `number` with the runs of base model and model; none beyond the last.
    pub fn shown(&self, number: usize) -> Option<&Shown> {
        let place = self.shown.get(number)?;
        if place.get().is_none() {
            let base = self.tracks.run(number, &self.against.values)?;
            let model = self.tracks.run(number, &self.model)?;
            // Another page may have been faster; its run is the same.
            let _ = place.set(Shown {
                unseen: self.tracks.unseen(number),
                against: self.against.name.clone(),
                base,
                model,
            });
        }
        place.get()
    }

    /// All records.
    pub fn all_shown(&self) -> Vec<&Shown> {
        (0..self.shown.len()).filter_map(|k| self.shown(k)).collect()
    }

    /// Residual torques of base model and model.
    pub fn torques(&self) -> &[Torques; 2] {
        self.torques.get_or_init(|| {
            let shown = self.all_shown();
            [
                torques(shown.iter().map(|s| &s.base), &self.against.values),
                torques(shown.iter().map(|s| &s.model), &self.model),
            ]
        })
    }

    /// What shows each effect of the model, in order.
    pub fn evidence(&self) -> &[Vec<Figure>] {
        self.evidence.get_or_init(|| {
            let rig = self.tracks.whole.lock().unwrap_or_else(PoisonError::into_inner).rig;
            let with: Vec<FreeRun> = self.all_shown().into_iter().map(|s| s.model.clone()).collect();
            let drawn = self.model.kinds().into_iter().map(|kind| {
                let without = self.tracks.runs(&self.model.without(kind));
                evidence::figures(kind, &self.model, &rig, [&with, &without])
            });
            drawn.collect()
        })
    }

    /// Parameters, and what voltage and motion alone determine, each with its interval.
    pub fn estimates(&self) -> &[Vec<Estimate>; 2] {
        self.estimates.get_or_init(|| {
            let whole = self.tracks.whole.lock().unwrap_or_else(PoisonError::into_inner);
            [estimates(&whole, &self.model), combinations(&whole, &self.model)]
        })
    }
}
