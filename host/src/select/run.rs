//! The selection: effects are added while records that no fit has seen speak for them, and taken out when they no longer do.

use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;

use super::dataset::Dataset;
use super::fitted::Fitted;
use super::forward::{forward, simplest};
use super::noise::Noise;
use crate::diagnose::contained::covers;

/// What was selected.
#[derive(Debug)]
pub struct Selected {
    /// The model after each step, the base model first.
    pub steps: Vec<Fitted>,
    /// The first step's candidates, best first.
    pub first: Vec<Fitted>,
    /// For each accepted effect that has such: the accepted model, then models with another effect in its place that the records
    /// cannot tell from it.
    pub rivals: Vec<Vec<Fitted>>,
    /// What a perfect model would leave.
    pub floor: Noise,
    /// Whether a repeated programme measured that.
    pub repeated: bool,
}

impl Selected {
    /// The accepted model.
    pub fn model(&self) -> &Fitted {
        &self.steps[self.steps.len() - 1]
    }

    /// What `model` leaves, in multiples of the noise.
    pub fn left_over(&self, model: &Fitted) -> f64 {
        model.noise.over(&self.floor)
    }
}

/// Rounds of weighing of a model that is kept, and steps of each.
const SETTLED: (usize, usize) = (3, 12);

/// An effect may raise the simulation error by no more than this.
const NO_RISE: f64 = 1.02;

/// Selects from `base`, adding at most `most` effects of `library`.
pub fn run(
    data: &Dataset,
    base: Fitted,
    library: &[Kind],
    most: usize,
    tick: &mut dyn FnMut(usize, Kind),
    step: &mut dyn FnMut(&Fitted),
) -> Selected {
    step(&base);
    let given = base.kinds().to_vec();
    let mut steps = vec![base];
    let mut first = Vec::new();
    while steps.len() <= most && steps[steps.len() - 1].kinds().len() < MAX_EFFECTS {
        let model = &steps[steps.len() - 1];
        let depth = steps.len() - 1;
        let mut candidates = forward(data, model, library, &mut |kind| tick(depth, kind));
        if let Some(chosen) = simplest(&candidates) {
            let chosen = candidates.remove(chosen);
            candidates.insert(0, chosen);
        }
        let next = candidates.first().filter(|c| c.beats(model)).cloned();
        if steps.len() == 1 {
            first = candidates;
        }
        let Some(next) = next else { break };
        let settled = Fitted::of(data, &next.values(), SETTLED.0, SETTLED.1);
        let next = if settled.score() > next.score() { settled } else { next };
        let next = pruned(data, next, &given);
        // A model that predicts better and simulates worse has learnt a disturbance.
        if next.simulation_error(data) > NO_RISE * steps[steps.len() - 1].simulation_error(data) {
            break;
        }
        step(&next);
        steps.push(next);
    }
    let rivals = rivals(data, &steps, &first, library, &given);
    let model = &steps[steps.len() - 1];
    let measured = data.repeat_noise(&model.values());
    let repeated = measured.is_some();
    let floor = measured.unwrap_or_else(|| model.noise.white());
    Selected { steps, first, rivals, floor, repeated }
}

/// `model` without the effects that it does as well without (backward elimination); never without those `given`.
fn pruned(data: &Dataset, model: Fitted, given: &[Kind]) -> Fitted {
    let mut model = model;
    if model.kinds().len() < given.len() + 2 {
        return model;
    }
    let last = model.kinds().last().copied();
    for kind in model.kinds().to_vec() {
        if given.contains(&kind) || Some(kind) == last {
            continue;
        }
        let fewer = Fitted::of(data, &model.values().without(kind), 2, 8);
        if !model.beats(&fewer) {
            model = fewer;
        }
    }
    model
}

/// What could stand in an accepted effect's place: every other one is tried there, and those that the accepted model does not beat
/// are its rivals.
fn rivals(
    data: &Dataset,
    steps: &[Fitted],
    first: &[Fitted],
    library: &[Kind],
    given: &[Kind],
) -> Vec<Vec<Fitted>> {
    let model = &steps[steps.len() - 1];
    let accepted: Vec<Kind> = model.kinds().iter().copied().filter(|kind| !given.contains(kind)).collect();
    let single = accepted.len() == 1;
    let of = |kind: Kind| {
        let tried = if single {
            first.to_vec()
        } else {
            let without = Fitted::of(data, &model.values().without(kind), 2, 8);
            forward(data, &without, library, &mut |_| ())
        };
        let other = |c: &Fitted| !c.kinds().iter().all(|k| covers(model.kinds(), *k));
        let near: Vec<Fitted> = tried.into_iter().filter(|c| other(c) && !model.beats(c)).collect();
        (!near.is_empty()).then(|| std::iter::once(model.clone()).chain(near).collect())
    };
    accepted.into_iter().filter_map(of).collect()
}
