//! The selection: effects are added while records that no fit has seen speak for them, and taken out when they no longer do.

use std::cell::LazyCell;

use motorlens_shared::effects::{Kind, Search};
use motorlens_shared::simulator::MAX_EFFECTS;

use super::criterion::WORTH;
use super::fitted::{Fitted, SETTLED};
use super::forward::{forward, lacks, pairs, simplest, tried, with};
use crate::diagnose::contained::{covers, parts};
use crate::diagnose::evidence::Evidence;
use crate::fit::instants::usual;
use crate::fit::uncertainty::Spread;

/// What was selected.
#[derive(Debug)]
pub struct Selected {
    /// The model after each step, the base model first.
    pub steps: Vec<Fitted>,
    /// The first step's candidates, best first.
    pub first: Vec<Fitted>,
    /// For each accepted effect that has such, its rivals.
    pub rivals: Vec<Rivals>,
}

/// Models that the records cannot tell apart: each has another effect, its last, in the place of the first one's last.
#[derive(Debug, Clone)]
pub struct Rivals {
    /// The accepted model, then the others by score; two at least.
    pub models: Vec<Fitted>,
}

impl Rivals {
    /// The effects that stand for one another, the accepted one first.
    pub fn kinds(&self) -> Vec<Kind> {
        self.models.iter().filter_map(|model| model.kinds().last().copied()).collect()
    }

    /// The other model that runs nearest to the records that all were fitted to, where that is much nearer than the accepted one. Records kept apart
    /// do not confirm it: what is seen once, they do not hold.
    pub fn nearer(&self, data: &Evidence) -> Option<&Fitted> {
        let (accepted, others) = self.models.split_first()?;
        let best = others.iter().min_by(|a, b| a.error(data).total_cmp(&b.error(data)))?;
        accepted.strays(best, data).then_some(best)
    }
}

impl Selected {
    /// The accepted model.
    pub fn model(&self) -> &Fitted {
        &self.steps[self.steps.len() - 1]
    }
}

/// Candidates of a step that are searched to the end, best first, until one is believed; and as many more of other equations where none is: in the
/// place of one kind of friction that is not believed the others are tried, and nothing else.
const TRIED: usize = 3;

/// The model of which what is left counts as all that is to be explained: the first one, or the one that knows how long its readings are
/// held. That is read off the records, and no idealised equation; beside a reading that is 20 ms old nothing else would be worth a word.
fn reference(steps: &[Fitted]) -> &Fitted {
    let held = |model: &&Fitted| {
        let values = model.values();
        let added = values.effects.get(steps[0].kinds().len()..).unwrap_or_default();
        let is_held = |(kind, parameters): &(Kind, Vec<f64>)| match kind.spec().search {
            Search::Hold(name) => kind.spec().place(name).is_some_and(|place| parameters[place] > 0.0),
            _ => false,
        };
        added.iter().all(is_held)
    };
    steps.iter().take_while(held).last().unwrap_or(&steps[0])
}

/// Selects from `base`, adding at most `most` effects of `library`. Each `step` is told of the model as it would be used ([`Fitted::simulating`]), which
/// the last one of those returned is.
pub fn run(
    data: &Evidence,
    base: Fitted,
    library: &[Kind],
    most: usize,
    tick: &mut dyn FnMut(usize, Kind),
    step: &mut dyn FnMut(&Fitted),
) -> Selected {
    let mut used = base.simulating(data);
    step(&used);
    let library: Vec<Kind> = library.iter().copied().filter(|kind| data.may_show(*kind)).collect();
    let library = library.as_slice();
    let given = base.kinds().to_vec();
    let mut steps = vec![base];
    let mut all: Vec<Vec<Fitted>> = Vec::new();
    let mut came_near = Vec::new();
    while steps.len() <= most && steps[steps.len() - 1].kinds().len() < MAX_EFFECTS {
        let (base, model) = (reference(&steps), &steps[steps.len() - 1]);
        let depth = steps.len() - 1;
        let (mut candidates, near) = tried(data, model, library, WORTH, &mut |kind| tick(depth, kind));
        candidates.extend(pairs(data, model, &came_near, WORTH));
        if depth == 1 {
            // What was accepted may only imitate friction and something else together.
            candidates.extend(beside_the_usual(data, &steps[0], library, model.kinds()));
        }
        candidates.sort_by(|a, b| b.score().total_cmp(&a.score()));
        came_near = near;
        let mut next = step_up(data, base, model, &mut candidates);
        if next.is_none() && depth == 0 && most > 1 {
            // None alone explains anything: two may.
            let mut two = pairs(data, model, &came_near, WORTH);
            two.extend(beside_the_usual(data, model, library, model.kinds()));
            two.extend(with_the_usual(data, model, library));
            two.sort_by(|a, b| b.score().total_cmp(&a.score()));
            next = step_up(data, base, model, &mut two);
            candidates.extend(two);
        }
        if next.is_none()
            && let Some(rival) = all.last().and_then(|before| tied(data, model, before, base))
        {
            // Which of the two is there may show only beside what it lacks.
            let mut beside = forward(data, rival, library, WORTH, &mut |_| ());
            next = step_up(data, base, model, &mut beside);
            candidates.extend(beside);
        }
        all.push(candidates);
        let Some(next) = next else { break };
        let next = simpler(data, next, model.score(), base);
        let next = pruned(data, next, &given, model.score(), base);
        used = next.simulating(data);
        step(&used);
        steps.push(next);
    }
    let rivals = rivals(data, &steps, &all, &given);
    steps.pop();
    steps.push(used);
    Selected { steps, first: all.into_iter().next().unwrap_or_default(), rivals }
}

/// Candidates with the effect on which most others build, and one more: a motor is rarely without friction, and what it lacks beside that may
/// look like nothing without. None where that effect is one of the `kinds` that were accepted: then it is tried so anyway.
fn beside_the_usual(data: &Evidence, model: &Fitted, library: &[Kind], kinds: &[Kind]) -> Vec<Fitted> {
    let lacking = library.iter().copied().filter(|kind| lacks(model.kinds(), *kind));
    let beside =
        usual(lacking).filter(|usual| !covers(kinds, *usual)).and_then(|usual| with(data, model, usual));
    beside.map_or_else(Vec::new, |beside| forward(data, &beside, library, WORTH, &mut |_| ()))
}

/// Candidates with an effect that only friction stops beside, and the usual friction: alone such an effect looks wrong, and next to a friction that
/// was fitted without it, too.
fn with_the_usual(data: &Evidence, model: &Fitted, library: &[Kind]) -> Vec<Fitted> {
    let Some(usual) = usual(library.iter().copied()) else { return Vec::new() };
    let asks = |kind: &&Kind| matches!(kind.spec().search, Search::Damped(_)) && lacks(model.kinds(), **kind);
    let begun = library.iter().filter(asks).filter_map(|kind| with(data, model, *kind));
    begun.flat_map(|begun| forward(data, &begun, &[usual], WORTH, &mut |_| ())).collect()
}

/// Of the `candidates` tried on `model`, the one that is believed in its place, searched to its end: of those that the best does not beat
/// the smallest, else the next. The one that was looked at first comes first then. `base` is what the selection began with.
pub fn step_up(data: &Evidence, base: &Fitted, model: &Fitted, candidates: &mut [Fitted]) -> Option<Fitted> {
    // Settled, a candidate may gain a little more.
    let promises = |c: &Fitted| c.gain_over(model).total > 0.5 * WORTH;
    if !candidates.iter().any(promises) {
        return None;
    }
    if let Some(chosen) = simplest(data, candidates, base) {
        candidates[..=chosen].rotate_right(1);
    }
    let worth: Vec<&Fitted> = candidates.iter().filter(|c| promises(c)).collect();
    let (first, rest) = worth.split_at(worth.len().min(TRIED));
    let settled = match believed(data, base, model, first.iter().copied()) {
        Ok(found) => return Some(found),
        Err(settled) => settled,
    };
    let others = rest.iter().filter(|c| !first.iter().any(|tried| is_kin(tried, c)));
    let other = believed(data, base, model, others.take(TRIED).copied()).ok()?;
    // What is doubted does as well: then this is no better known.
    (!settled.iter().any(|doubted| doubted.is_as_good_as(&other, data, base))).then_some(other)
}

/// The best of the `candidates` that does as well as `accepted` by other effects and no more parameters: the records have not decided yet
/// between the two.
pub fn tied<'a>(
    data: &Evidence,
    accepted: &Fitted,
    candidates: &'a [Fitted],
    base: &Fitted,
) -> Option<&'a Fitted> {
    let is_other = |c: &&Fitted| c.size() <= accepted.size() && !is_kin(c, accepted);
    let mut others: Vec<&Fitted> = candidates.iter().filter(is_other).collect();
    // Best first: those that come after the one that is taken need not be cross-validated.
    others.sort_by(|a, b| b.score().total_cmp(&a.score()));
    others.into_iter().find(|c| c.is_as_good_as(accepted, data, base))
}

/// The first of some `candidates` that beats `model` surely, searched to its end; else the first that outweighs it, or is as expected; else all
/// that were searched.
fn believed<'a>(
    data: &Evidence,
    base: &Fitted,
    model: &Fitted,
    candidates: impl Iterator<Item = &'a Fitted>,
) -> Result<Fitted, Vec<Fitted>> {
    let mut settled = Vec::new();
    for candidate in candidates {
        let candidate = candidate.clone().settled(data);
        if candidate.is_lost(model)
            || candidate.adds_a_trifle(model, data)
            || candidate.strays(model, data)
            || candidate.opens_the_motor(model, data)
        {
            continue;
        }
        if candidate.beats_surely(model, data, base) {
            return Ok(candidate);
        }
        settled.push(candidate);
    }
    let outweighs = settled.iter().position(|c| c.outweighs(model, data, base));
    let expected = || settled.iter().position(|c| c.is_as_expected(model, data, base));
    outweighs.or_else(expected).map(|k| settled.swap_remove(k)).ok_or(settled)
}

/// Whether all effects of one of the two are part of the other's.
fn is_kin(one: &Fitted, other: &Fitted) -> bool {
    let within = |a: &Fitted, b: &Fitted| a.kinds().iter().all(|kind| covers(b.kinds(), *kind));
    within(one, other) || within(other, one)
}

/// `accepted`, and those of the models `tried` in its place that do as well; none where none does.
pub fn alike(data: &Evidence, accepted: &Fitted, tried: Vec<Fitted>, base: &Fitted) -> Option<Rivals> {
    let other = |c: &Fitted| !c.kinds().iter().all(|k| covers(accepted.kinds(), *k));
    let mut near: Vec<Fitted> = Vec::new();
    for c in tried.into_iter().filter(other) {
        let named = near.iter().chain([accepted]).any(|n| n.kinds().last() == c.kinds().last());
        if !named && c.is_as_good_as(accepted, data, base) {
            near.push(c);
        }
    }
    (!near.is_empty()).then(|| Rivals { models: std::iter::once(accepted.clone()).chain(near).collect() })
}

/// `model`, or the model with a simpler equation in the place of one that contains it, where the richer one does not beat that: both are
/// searched to the end, the simpler from where the richer ended. Its score stays above the `least`, that of the model before.
fn simpler(data: &Evidence, model: Fitted, least: f64, base: &Fitted) -> Fitted {
    let values = model.values();
    let spread = LazyCell::new(|| Spread::of(&data.train, &values));
    for (rich, parameters) in &values.effects {
        let without = values.without(*rich);
        for (part, at) in parts(*rich) {
            if covers(&without.kinds(), part) {
                continue;
            }
            let poor = Fitted::of(data, &without.with(part, vec![parameters[at]]), SETTLED.0, SETTLED.1);
            let is_enough =
                || may_be_nothing(&spread, *rich, Some(at)) || poor.is_as_good_as(&model, data, base);
            if poor.score() > least && !poor.strays(&model, data) && is_enough() {
                return simpler(data, poor, least, base);
            }
        }
    }
    model
}

/// Whether `kind` of a model with this `spread` may be nothing, or all that it adds to the simpler equation of its parameter `beside`: no size is two
/// standard deviations from zero (Wald's test). What has no size is something.
fn may_be_nothing(spread: &Spread, kind: Kind, beside: Option<usize>) -> bool {
    let spec = kind.spec();
    let is_size = |k: &usize| spec.parameters[*k].strength || parts(kind).any(|(_, place)| place == *k);
    let is_near_zero = |k: usize| {
        let name = format!("{}.{}", spec.name, spec.parameters[k].name);
        let axis = spread.layout.axes.iter().position(|axis| axis.name == name);
        axis.is_none_or(|axis| spread.x[axis].abs() < 2.0 * spread.deviation(axis))
    };
    let mut sizes = (0..spec.parameters.len()).filter(|k| Some(*k) != beside && is_size(k)).peekable();
    (beside.is_some() || sizes.peek().is_some()) && sizes.all(is_near_zero)
}

/// `model` without the effects that may be nothing or that it does as well without (backward elimination), as long as its score stays
/// above the `least`, that of the model before; never without those `given`.
fn pruned(data: &Evidence, model: Fitted, given: &[Kind], least: f64, base: &Fitted) -> Fitted {
    let mut model = model;
    if model.kinds().len() < given.len() + 2 {
        return model;
    }
    let last = model.kinds().last().copied();
    for kind in model.kinds().to_vec() {
        if given.contains(&kind) || Some(kind) == last {
            continue;
        }
        let values = model.values();
        let fewer = Fitted::of(data, &values.without(kind), 2, 8);
        let is_nothing = || may_be_nothing(&Spread::of(&data.train, &values), kind, None);
        let is_enough = || is_nothing() || fewer.is_as_good_as(&model, data, base);
        if fewer.score() > least && !fewer.strays(&model, data) && is_enough() {
            model = fewer;
        }
    }
    model
}

/// What could stand in an accepted effect's place: every other one that came near when the effect was chosen is tried there, and those
/// that the accepted model does not beat are its rivals. `tried` holds the candidates of each step.
fn rivals(data: &Evidence, steps: &[Fitted], tried: &[Vec<Fitted>], given: &[Kind]) -> Vec<Rivals> {
    let (base, model) = (reference(steps), &steps[steps.len() - 1]);
    let values = model.values();
    let of = |kind: &Kind| {
        let step = steps.iter().position(|step| covers(step.kinds(), *kind))?;
        let near = tried.get(step.checked_sub(1)?)?;
        let before = &steps[step - 1];
        let own = values.parameters(*kind)?.to_vec();
        let rest = values.without(*kind);
        let accepted = if model.kinds().last() == Some(kind) {
            model.clone()
        } else {
            Fitted::of(data, &rest.with(*kind, own), 1, 0)
        };
        let others = model.kinds().iter().filter(|k| *k != kind);
        // Nothing else has changed since.
        if others.clone().count() == before.kinds().len()
            && others.clone().all(|k| before.kinds().contains(k))
        {
            let added = |c: &&Fitted| before.kinds().iter().all(|k| covers(c.kinds(), *k));
            return alike(data, &accepted, near.iter().filter(added).cloned().collect(), base);
        }
        let without = Fitted::of(data, &rest, 2, 8);
        let mut library: Vec<Kind> = near.iter().filter_map(|c| c.kinds().last().copied()).collect();
        library.sort_unstable_by_key(|k| k.name());
        library.dedup();
        let gain = model.score() - without.score();
        alike(data, &accepted, forward(data, &without, &library, gain, &mut |_| ()), base)
    };
    model.kinds().iter().filter(|kind| !given.contains(kind)).filter_map(of).collect()
}
