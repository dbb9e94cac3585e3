//! The loop by itself: fit, diagnose, add, until nothing is worth adding.

use std::time::Instant;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::candidate::Candidate;
use super::climb::{self, Climb};
use super::evidence::Evidence;
use super::ladder::{Ranked, Rung, rank, rung};
use super::plan::{self, Limits, Plan};
use super::rivals::{Rivals, better, rivals};
use crate::compare::problem_of;
use crate::error::Result;
use crate::fit::search::Problem;
use crate::fit::setup;
use crate::log::{Record, repeats};
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;
use crate::select;

/// What is going on, for a progress bar.
#[derive(Debug, Clone)]
pub enum Progress {
    /// An effect is being tried on the model of so many effects.
    Trying {
        /// Effects in the model so far.
        depth: usize,
        /// The effect on trial.
        effect: Kind,
    },
    /// A rung of the ladder is fitted.
    Rung(Rung),
}

/// By what an effect is accepted.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "snake_case")]
pub enum Criterion {
    /// Ratios of 50 ms differences of the simulation error, on records fitted and kept out.
    #[default]
    Increments,
    /// Held-out likelihood of the simulation error by time scale ([`crate::select`]).
    Likelihood,
}

/// What to look for.
#[derive(Debug, Clone)]
pub struct Options {
    /// By what an effect is accepted.
    pub criterion: Criterion,
    /// Effects that may be added.
    pub library: Vec<Kind>,
    /// Most effects.
    pub most: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { criterion: Criterion::default(), library: crate::formula::all(), most: 4 }
    }
}

/// Verdict of a discovery.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model leaves no more than noise.
    Explained,
    /// Something is left that the library does not explain.
    Unexplained,
    /// The data must be mended first.
    BadData,
}

/// Everything a discovery found.
#[derive(Debug)]
pub struct Discovery {
    /// Accepted effects in order.
    pub effects: Vec<Kind>,
    /// How it ends.
    pub verdict: Verdict,
    /// What a perfect model would leave, rms in the measured unit.
    pub noise_floor: f64,
    /// From the base model to the accepted one.
    pub ladder: Vec<Rung>,
    /// First diagnosis, best first.
    pub candidates: Vec<Ranked>,
    /// What this data cannot tell from the accepted effects, for each that has such.
    pub rivals: Vec<Rivals>,
    /// The model on all records.
    pub model: Model,
    /// Time taken, s.
    pub seconds: f64,
    /// Candidate passes through all records.
    pub simulations: u64,
    /// The search's own view, for whoever digs further.
    pub evidence: Evidence,
    /// The climb itself.
    pub climb: Climb,
}

/// Runs the loop on `records`, judged by `validation` (or, without any, by the ends of the records).
///
/// # Errors
/// Records that no fit can use.
pub fn discover(
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Result<Discovery> {
    let begun = Instant::now();
    if options.criterion == Criterion::Increments {
        let (evidence, base) = prepare(records, validation, motor)?;
        return Ok(explore(begun, records, validation, evidence, base, options, progress));
    }
    // The records kept out are laid out only once the base model is fitted: they must not touch it.
    validation.iter().try_for_each(crate::log::check_usable)?;
    let (mut evidence, base) = prepare(records, &[], motor)?;
    if !validation.is_empty() {
        evidence.kept_out = Some(evidence.whole.on(evidence.whole.lay_out(validation, motor)));
    }
    Ok(explore(begun, records, validation, evidence, base, options, progress))
}

/// One step up from `model`, refitted to `records`: what it is missing.
///
/// # Errors
/// Records that no fit can use.
pub fn diagnose(
    model: &Model,
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
    progress: &mut dyn FnMut(Progress),
) -> Result<Discovery> {
    let begun = Instant::now();
    for record in validation {
        crate::log::check_usable(record)?;
    }
    let values = model.values();
    let evidence = Evidence::new(problem_of(model, records, motor)?, &values, records, validation, motor);
    let base = evidence.fit(&values, 12);
    let options = Options { most: 1, ..Options::default() };
    Ok(explore(begun, records, validation, evidence, base, &options, progress))
}

/// The climb from `base`, and everything that is told about it.
fn explore(
    begun: Instant,
    records: &[Record],
    validation: &[Record],
    mut evidence: Evidence,
    base: Candidate,
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Discovery {
    let mut ladder: Vec<Rung> = Vec::new();
    if options.criterion == Criterion::Likelihood {
        return select::discovery(begun, records, validation, evidence, base, options, progress);
    }
    let told = std::cell::RefCell::new(progress);
    let mut climb = climb::run(
        &mut evidence,
        base,
        &options.library,
        options.most,
        &mut |depth, effect| (told.borrow_mut())(Progress::Trying { depth, effect }),
        &mut |evidence, candidate| {
            let rung = rung(evidence, &candidate.values());
            (told.borrow_mut())(Progress::Rung(rung.clone()));
            ladder.push(rung);
        },
    );
    ladder.truncate(climb.rungs.len());
    let mut found = rivals(&evidence, &climb, &options.library);
    if let Some(better) = better(&evidence, &climb, &found) {
        let rung = rung(&evidence, &better.values());
        (told.borrow_mut())(Progress::Rung(rung.clone()));
        ladder.pop();
        ladder.push(rung);
        climb.believe(better);
        climb.withdraw(&evidence, options.most);
        ladder.truncate(climb.rungs.len());
        found = rivals(&evidence, &climb, &options.library);
    }
    let effects = climb.model().kinds().to_vec();
    let candidates = rank(&climb, &evidence);
    let noise_floor = noise_floor(records, validation, &evidence.whole);
    let origin = Origin {
        motorlens: env!("CARGO_PKG_VERSION").into(),
        records: records.iter().map(|r| r.name.clone()).collect(),
        method: "discover".into(),
        seed: None,
    };
    let model = Model::new(&climb.model().values(), &evidence.whole.rig, &evidence.whole.prior, origin);
    Discovery {
        verdict: verdict(&climb),
        rivals: found,
        effects,
        noise_floor,
        ladder,
        candidates,
        model,
        seconds: begun.elapsed().as_secs_f64(),
        simulations: evidence.simulations(),
        evidence,
        climb,
    }
}

/// Lays out the records and fits the base model.
///
/// # Errors
/// Records that no fit can use.
pub fn prepare(
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
) -> Result<(Evidence, Candidate)> {
    for record in records.iter().chain(validation) {
        crate::log::check_usable(record)?;
    }
    let (whole, start) = setup::problem(records, motor);
    let mut evidence = Evidence::new(whole, &start, records, validation, motor);
    let (layout, x) = evidence.train.fit_base(&start);
    let base = evidence.fit(&layout.unpack(&x), 4);
    // The first speeds were those of a rough model: what they are wrong by would look like an effect.
    let base = evidence.settle_starts(base);
    let base = evidence.settle_slow_starts(base);
    Ok((evidence, base))
}

impl Discovery {
    /// The programme that would best tell the rivals of the first effect that has any apart.
    pub fn plan(&self, limits: Limits) -> Option<Plan> {
        let models: Vec<&Candidate> = self.rivals.first()?.models.iter().collect();
        plan::choose(&self.evidence.whole, &models, limits)
    }

    /// Sets of effects that this data cannot tell apart, the accepted one of each first.
    pub fn open_sets(&self) -> Vec<Vec<Kind>> {
        self.rivals.iter().map(Rivals::kinds).collect()
    }
}

fn verdict(climb: &Climb) -> Verdict {
    if climb.explains_all() { Verdict::Explained } else { Verdict::Unexplained }
}

/// What a perfect model would leave: from a repeated programme where there is one, else from the counting.
pub fn noise_floor(records: &[Record], validation: &[Record], problem: &Problem) -> f64 {
    let all: Vec<Record> = records.iter().chain(validation).cloned().collect();
    let floors: Vec<f64> = repeats::find_repeats(&all)
        .into_iter()
        .filter_map(|(a, b)| repeats::noise_floor(&all[a], &all[b]))
        .collect();
    let square = |x: &[f64]| (x.iter().map(|f| f * f).sum::<f64>() / x.len() as f64).sqrt();
    let counting = square(&problem.grids.iter().map(|g| g.sigma).collect::<Vec<_>>());
    if floors.is_empty() { counting } else { square(&floors).max(counting) }
}
