//! The base model, the selection from it, and what is told of that.

use std::cell::RefCell;
use std::time::Instant;

use super::fitted::Fitted;
use super::limits::detection_limits;
use super::run::run;
use super::starts::straightened;
use crate::diagnose::discover::{Discovery, Options, Progress, Verdict, noise_floor};
use crate::diagnose::evidence::{EXPLAINS, Evidence};
use crate::diagnose::ladder::{rank, rung};
use crate::fit::layout::Values;
use crate::log::Record;
use crate::model_file::{Model, Origin};

/// Rounds of weighing of the base model, and steps of each.
const BASE: (usize, usize) = (3, 12);

/// The model of `values`' effects: from `values`, and from the usual time constants where these are far from them.
pub fn fitted_from(data: &Evidence, values: &Values) -> Fitted {
    let found = Fitted::of(data, values, BASE.0, BASE.1);
    let again =
        straightened(&data.train, &found.values()).map(|usual| Fitted::of(data, &usual, BASE.0, BASE.1));
    again.filter(|again| again.score() > found.score()).unwrap_or(found)
}

/// Selects from `base` on the `records` of `evidence`; the `validation` records are only scored.
pub fn discovery(
    begun: Instant,
    records: &[Record],
    validation: &[Record],
    evidence: Evidence,
    base: Fitted,
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Discovery {
    let told = RefCell::new(progress);
    let mut ladder = Vec::new();
    let selected = run(
        &evidence,
        base,
        &options.library,
        options.most,
        &mut |depth, effect| (told.borrow_mut())(Progress::Trying { depth, effect }),
        &mut |model| {
            let step = rung(&evidence, &model.values());
            (told.borrow_mut())(Progress::Rung(step.clone()));
            ladder.push(step);
        },
    );
    let origin = Origin {
        motorlens: env!("CARGO_PKG_VERSION").into(),
        records: records.iter().map(|r| r.name.clone()).collect(),
        method: "discover".into(),
        seed: None,
    };
    let (base, model) = (&selected.steps[0], selected.model());
    let values = model.values();
    // The accepted model was corrected once more.
    let last = rung(&evidence, &values);
    ladder.truncate(selected.steps.len() - 1);
    ladder.push(last.clone());
    let noise_floor = noise_floor(records, validation, &evidence.whole);
    let explained = evidence.is_explained_by(model) || last.train.rmse < EXPLAINS * noise_floor;
    Discovery {
        verdict: if explained { Verdict::Explained } else { Verdict::Unexplained },
        effects: values.kinds(),
        noise_floor,
        ladder,
        candidates: rank(base, &selected.first, &evidence.noise_under(model), &evidence),
        limits: detection_limits(&evidence, base, model, &options.library, evidence.highest_voltage()),
        model: Model::new(&values, &evidence.whole.rig, &evidence.whole.prior, origin),
        seconds: begun.elapsed().as_secs_f64(),
        simulations: evidence.simulations(),
        evidence,
        selected,
    }
}
