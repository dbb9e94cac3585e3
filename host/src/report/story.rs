//! What a report tells: records, runs and findings, gathered once.

use motorlens_shared::effects::Kind;

use super::figure::Figure;
use super::{evidence, missing};
use crate::compare::free_run::{FreeRun, free_runs};
use crate::compare::residual_torque::{ResidualTorque, residual_torque};
use crate::compare::rise::{Rise, worst_rise};
use crate::diagnose::discover::Discovery;
use crate::diagnose::ladder::{Ranked, Rung};
use crate::findings::{Findings, Standing};
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::uncertainty::Estimate;
use crate::log::{Record, Warning};
use crate::model_file::Model;

/// A record with the runs of two models.
#[derive(Debug, Clone)]
pub struct Shown {
    /// Whether the fit never saw it.
    pub unseen: bool,
    /// What the model beside it is called.
    pub against: String,
    /// The base model alone, or another one to compare with.
    pub base: FreeRun,
    /// The model with its effects.
    pub model: FreeRun,
}

/// Residual torques of one model on all records that are looked at.
#[derive(Debug, Clone, Default)]
pub struct Torques {
    /// One a record.
    pub records: Vec<ResidualTorque>,
}

/// A candidate of the first diagnosis, or an accepted effect.
#[derive(Debug, Clone)]
pub struct Suspect {
    /// What the diagnosis says.
    pub ranked: Ranked,
    /// Its equation over the records; only the first few and the accepted have it.
    pub figures: Vec<Figure>,
}

/// Everything a report shows.
#[derive(Debug, Clone)]
pub struct Story {
    /// Heading.
    pub title: String,
    /// The model with its effects.
    pub model: Model,
    /// The base model, the first of the sequence.
    pub base: Values,
    /// Records, training first.
    pub records: Vec<Shown>,
    /// Unit of everything compared.
    pub unit: &'static str,
    /// Noise level, rms.
    pub floor: f64,
    /// From the base model to the accepted one.
    pub ladder: Vec<Rung>,
    /// Where each step of it raised the error most.
    pub rises: Vec<Option<Rise>>,
    /// Errors of kS-kV-kA, which users know.
    pub baseline: Option<Rung>,
    /// First diagnosis, best first.
    pub suspects: Vec<Suspect>,
    /// Sets that these records cannot tell apart.
    pub rivals: Vec<Vec<Kind>>,
    /// The experiment that would tell them apart, in words.
    pub next: Option<String>,
    /// The verdict and what to do next.
    pub standing: Standing,
    /// Data quality problems.
    pub faults: Vec<Warning>,
    /// Parameters of the model.
    pub parameters: Vec<Estimate>,
    /// What voltage and motion alone determine.
    pub combinations: Vec<Estimate>,
    /// Residual torques of the base model.
    pub base_torques: Torques,
    /// Residual torques of the model.
    pub model_torques: Torques,
}

/// Candidates whose evidence is drawn, whether they were accepted or not.
pub const DRAWN: usize = 4;

impl Story {
    /// The story of a discovery on `records`, as its `findings` tell it.
    pub fn of(discovery: &Discovery, findings: &Findings, records: &[Record]) -> Self {
        let base = discovery.shown[0].clone();
        let values = discovery.model.values();
        let whole = &discovery.evidence.whole;
        let shown = shown(whole, discovery.evidence.kept_out.as_ref(), &base, &values);
        Self {
            title: title(records),
            base_torques: torques(shown.iter().map(|s| &s.base), &base),
            model_torques: torques(shown.iter().map(|s| &s.model), &values),
            unit: shown.first().map_or("rad", |s| s.base.quantity.unit()),
            records: shown,
            floor: discovery.noise_floor,
            rises: rises(discovery),
            baseline: discovery.baseline.clone(),
            ladder: discovery.ladder.clone(),
            suspects: suspects(discovery),
            rivals: discovery.open_sets(),
            next: findings.next_experiment.as_ref().map(|next| next.why.clone()),
            standing: findings.standing(),
            faults: findings.data_faults.clone(),
            parameters: findings.parameters.clone(),
            combinations: findings.combinations.clone(),
            model: discovery.model.clone(),
            base,
        }
    }
}

/// Where each step of the ladder raised the error most, on the records that judge.
fn rises(discovery: &Discovery) -> Vec<Option<Rise>> {
    if discovery.shown.len() != discovery.ladder.len() {
        return vec![None; discovery.ladder.len()];
    }
    let problem = discovery.evidence.kept_out.as_ref().unwrap_or(&discovery.evidence.whole);
    let runs: Vec<Vec<FreeRun>> = discovery.shown.iter().map(|values| free_runs(problem, values)).collect();
    let steps = runs.windows(2).map(|pair| worst_rise(&pair[0], &pair[1]));
    std::iter::once(None).chain(steps).collect()
}

/// The candidates in order, and after them what only a later diagnosis brought.
fn suspects(discovery: &Discovery) -> Vec<Suspect> {
    let model = discovery.selected.model();
    let drawn = |kind: Kind, values: &Values| evidence::of(&discovery.evidence, kind, values);
    let candidates = discovery.candidates.iter().enumerate().map(|(place, ranked)| {
        let kind = ranked.effect;
        let tried = discovery.selected.first.iter().find(|c| c.kinds().last() == Some(&kind));
        let shown = if model.kinds().contains(&kind) { Some(model) } else { tried.filter(|_| place < DRAWN) };
        let figures = shown.map_or_else(Vec::new, |c| drawn(kind, &c.values()));
        Suspect { ranked: ranked.clone(), figures }
    });
    let later = |kind: &&Kind| !discovery.candidates.iter().any(|c| c.effect == **kind);
    let unit = discovery.evidence.whole.grids.first().map_or("rad", |g| g.quantity.unit());
    let later = model
        .kinds()
        .iter()
        .filter(later)
        .map(|kind| missing::accepted(*kind, &discovery.ladder, unit, drawn(*kind, &model.values())));
    candidates.chain(later).collect()
}

/// Runs of both models on all records, training first.
fn shown(whole: &Problem, unseen: Option<&Problem>, base: &Values, values: &Values) -> Vec<Shown> {
    let pairs = |problem: &Problem, unseen| {
        let runs = free_runs(problem, base).into_iter().zip(free_runs(problem, values));
        runs.map(move |(base, model)| Shown { unseen, against: "base model".into(), base, model })
            .collect::<Vec<_>>()
    };
    let mut all = pairs(whole, false);
    all.extend(unseen.into_iter().flat_map(|u| pairs(u, true)));
    all
}

/// Residual torques of `runs` under the base of `values`.
pub fn torques<'a>(runs: impl Iterator<Item = &'a FreeRun>, values: &Values) -> Torques {
    Torques { records: runs.map(|run| residual_torque(run, &values.base)).collect() }
}

/// A heading for `records`.
pub fn title(records: &[Record]) -> String {
    match records {
        [one] => one.name.clone(),
        [first, .., last] => format!("{} … {} ({} records)", first.name, last.name, records.len()),
        [] => "no records".into(),
    }
}
