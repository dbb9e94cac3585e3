//! The base model, the selection from it, and what is told of that.

use std::cell::RefCell;
use std::time::Instant;

use super::adequacy::Adequacy;
use super::fitted::Fitted;
use super::limits::detection_limits;
use super::run::run;
use super::starts::straightened;
use crate::diagnose::discover::{Discovery, Options, Progress, noise_floor};
use crate::diagnose::evidence::Evidence;
use crate::diagnose::ladder::{baseline, rank, rung};
use crate::fit::layout::Values;
use crate::log::Record;
use crate::model_file::{DISCOVERED, Model, Origin};

/// Rounds of weighing of the base model, and steps of each.
const BASE: (usize, usize) = (3, 12);

/// The model of `values`' effects: from `values`, and from the usual time constants where these are far from them.
pub fn fitted_from(data: &Evidence, values: &Values) -> Fitted {
    let found = Fitted::of(data, values, BASE.0, BASE.1);
    let again =
        straightened(&data.train, &found.values()).map(|usual| Fitted::of(data, &usual, BASE.0, BASE.1));
    found.or_better(again)
}

/// Where a selection begins.
pub struct Begin {
    /// When the fits began.
    pub at: Instant,
    /// The records.
    pub evidence: Evidence,
    /// The plain motor fitted to them, where the model has effects already.
    pub plain: Option<Fitted>,
    /// The model to select from.
    pub model: Fitted,
}

/// Selects from the model of `begin` on its `records`; the `validation` records are only scored.
pub fn discovery(
    begin: Begin,
    records: &[Record],
    validation: &[Record],
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Discovery {
    let Begin { at: begun, mut evidence, plain, model } = begin;
    let told = RefCell::new(progress);
    let (mut ladder, mut shown) = (Vec::new(), Vec::new());
    let selected = run(
        &evidence,
        model,
        &options.library,
        options.most,
        &mut |depth, effect| (told.borrow_mut())(Progress::Trying { depth, effect }),
        &mut |model| {
            // Errors are those of the model as it would be used, so that `fit` and `compare` tell the same.
            let values = model.values();
            let step = rung(&evidence, &values);
            (told.borrow_mut())(Progress::Rung(step.clone()));
            ladder.push(step);
            shown.push(values);
        },
    );
    let origin = Origin {
        motorlens: env!("CARGO_PKG_VERSION").into(),
        records: records.iter().map(|r| r.name.clone()).collect(),
        method: DISCOVERED.into(),
        seed: None,
    };
    let (base, model) = (&selected.steps[0], selected.model());
    evidence.begin_as(model);
    let values = model.values();
    // The accepted model was corrected once more.
    ladder.truncate(selected.steps.len() - 1);
    ladder.push(rung(&evidence, &values));
    shown.truncate(selected.steps.len() - 1);
    shown.push(values.clone());
    let noise_floor = noise_floor(records, validation, &evidence.whole);
    if let Some(plain) = &plain {
        ladder.insert(0, rung(&evidence, &plain.values()));
    }
    let plain = plain.as_ref().unwrap_or(base);
    let adequacy = Adequacy::of(&evidence, plain, model, noise_floor);
    Discovery {
        adequacy,
        effects: values.kinds(),
        noise_floor,
        ladder,
        baseline: baseline(&evidence),
        shown,
        candidates: rank(base, &selected.first, &evidence.noise_under(model), &evidence),
        limits: detection_limits(&evidence, base, model, &options.library, adequacy),
        model: Model::fitted(&values, &evidence.whole, origin),
        seconds: begun.elapsed().as_secs_f64(),
        simulations: evidence.simulations(),
        evidence,
        selected,
    }
}
