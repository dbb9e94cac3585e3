//! What the selection found, in the form that terminal, page and report read.

use std::cell::RefCell;
use std::time::Instant;

use super::dataset::Dataset;
use super::fitted::Fitted;
use super::run::{Selected, run};
use crate::diagnose::candidate::{Candidate, Errors};
use crate::diagnose::climb::Climb;
use crate::diagnose::discover::{Discovery, Options, Progress, Verdict, noise_floor};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::{rank, rung};
use crate::diagnose::rivals::Rivals;
use crate::log::Record;
use crate::model_file::{Model, Origin};

/// A model that leaves less than so many times the noise, every time scale alike, leaves nothing that these records show.
const EXPLAINS: f64 = 1.25;
/// Rounds of weighing of the base model, and steps of each.
const BASE: (usize, usize) = (3, 12);

/// Selects from `base` on `records`; the `validation` records are only scored.
pub fn discovery(
    begun: Instant,
    records: &[Record],
    validation: &[Record],
    evidence: Evidence,
    base: Candidate,
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Discovery {
    let data = Dataset::new(&evidence.whole, records);
    let start = Fitted::of(&data, &base.values(), BASE.0, BASE.1);
    let told = RefCell::new(progress);
    let mut ladder = Vec::new();
    let selected = run(
        &data,
        start,
        &options.library,
        options.most,
        &mut |depth, effect| (told.borrow_mut())(Progress::Trying { depth, effect }),
        &mut |model| {
            let step = rung(&evidence, &model.values());
            (told.borrow_mut())(Progress::Rung(step.clone()));
            ladder.push(step);
        },
    );
    let all = |models: &[Fitted]| models.iter().map(|model| candidate(&selected, model)).collect();
    let climb = Climb {
        rungs: all(&selected.steps),
        first: all(&selected.first),
        refused: Vec::new(),
        withdrawn: Vec::new(),
    };
    let explained = selected.left_over(selected.model()) < EXPLAINS;
    let origin = Origin {
        motorlens: env!("CARGO_PKG_VERSION").into(),
        records: records.iter().map(|r| r.name.clone()).collect(),
        method: "discover".into(),
        seed: None,
    };
    let values = selected.model().values();
    Discovery {
        verdict: if explained { Verdict::Explained } else { Verdict::Unexplained },
        rivals: selected.rivals.iter().map(|models| Rivals { models: all(models) }).collect(),
        effects: values.kinds(),
        noise_floor: noise_floor(records, validation, &evidence.whole),
        ladder,
        candidates: rank(&climb, &evidence),
        model: Model::new(&values, &evidence.whole.rig, &evidence.whole.prior, origin),
        seconds: begun.elapsed().as_secs_f64(),
        simulations: evidence.simulations() + data.train.simulations.get(),
        evidence,
        climb,
    }
}

/// `model` with what it leaves, in multiples of the noise, in the place of both errors.
fn candidate(selected: &Selected, model: &Fitted) -> Candidate {
    let left = selected.left_over(model);
    let errors = Errors { increments: left, position: left };
    Candidate {
        layout: model.layout.clone(),
        found: model.found.clone(),
        train: errors,
        unseen: errors,
        records: vec![left],
        calm: None,
        foretold: false,
    }
}
