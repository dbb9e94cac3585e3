//! The climb: effects are added one by one while unseen records say that it is worth it.

use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;

use super::candidate::{Candidate, Errors, STEADY};
use super::contained;
use super::evidence::Evidence;
use super::stage::{self, Effort};

/// A first effect must lower the increments' error to this share, on the records fitted and on those kept out.
const WORTH: f64 = 0.97;
/// A further effect must do more on the mean of both: what a slightly wrong law leaves over looks like a small
/// effect.
const WORTH_MORE: f64 = 0.85;
/// The error itself on unseen records must not rise by more than this, whatever its increments do.
const NO_WORSE: f64 = 1.1;
/// Where the unseen records do not show an effect: their increments' error must not rise by more than this, and that
/// of the records fitted must fall to this share.
const NOT_WORSE: f64 = 1.005;
const CLEARLY: f64 = 0.8;
/// Share of the error itself, on both, that a slow effect must leave at most ...
const PLAINLY: f64 = 0.35;
/// ... or, where it leaves no more than noise, of an error that was this many noise units.
const ALL_OF_IT: f64 = 0.6;
const SLOW: f64 = 1.8;
const NOISE: f64 = 1.2;
/// Models whose increments' errors differ by less than this (6 %) count as equal: the one with fewer parameters wins.
const EQUAL: f64 = 0.06;
/// ... unless its error itself is that many times larger: the increments do not see slow drift.
const DRIFT: f64 = 1.5;
/// Share of the way down to a measured floor that may be left, and of the error itself where that drifts.
const MOSTLY_THERE: f64 = 0.3;
const MOST_OF_THE_DRIFT: f64 = 0.55;
/// Nothing is left to find below this many noise units in a steady model: the base, and one that explains already.
const AT_THE_FLOOR: f64 = 1.02;
const NEAR_THE_FLOOR: f64 = 1.15;

/// What the climb found.
#[derive(Debug)]
pub struct Climb {
    /// Rungs from the base model to the last accepted one.
    pub rungs: Vec<Candidate>,
    /// The first stage's candidates, best first.
    pub first: Vec<Candidate>,
    /// The last stage's candidates that were not worth adding.
    pub refused: Vec<Candidate>,
    /// Effects that were added and taken back in the end.
    pub withdrawn: Vec<Kind>,
}

impl Climb {
    /// Takes the effects back where most of the way down to a measured floor was not gone: physics outside the library
    /// lends itself to many effects in part, and is none of them.
    fn withdraw(&mut self) {
        let (model, base) = (self.model(), &self.rungs[0]);
        let far = model.excess() > MOSTLY_THERE * base.excess()
            || base.drift() > STEADY && model.drift() > MOST_OF_THE_DRIFT * base.drift();
        if !model.explains() && far {
            self.withdrawn = model.kinds().to_vec();
            self.rungs.truncate(1);
        }
    }

    /// The accepted model.
    pub fn model(&self) -> &Candidate {
        &self.rungs[self.rungs.len() - 1]
    }
}

/// Whether `more` is worth its parameters over `less`: better on both sets of records, in the increments or, where these
/// stay as they are, plainly in the error that they add up to.
pub fn worth(more: &Candidate, less: &Candidate) -> bool {
    let of = |e: fn(&Errors) -> f64| (e(&more.train) / e(&less.train), e(&more.unseen) / e(&less.unseen));
    let (train, unseen) = of(|e| e.increments);
    let (drift, unseen_drift) = of(|e| e.position);
    let drifted = less.train.position.min(less.unseen.position);
    let left = more.train.position.max(more.unseen.position);
    let slow = drifted > STEADY && drift.max(unseen_drift) < PLAINLY
        || drifted > SLOW && left < NOISE && drift.max(unseen_drift) < ALL_OF_IT;
    if slow && train.max(unseen) < NOT_WORSE {
        return true;
    }
    let mean = if less.kinds().is_empty() { WORTH } else { WORTH_MORE };
    // Unseen records at the floor already cannot get better, only worse.
    let silent = less.unseen.increments < NEAR_THE_FLOOR && unseen < NOT_WORSE && train < CLEARLY;
    train < WORTH
        && (unseen < WORTH || silent)
        && (train * unseen).sqrt() < mean
        && unseen_drift < NO_WORSE
        && more.merit() < less.merit() + WORTH.ln()
}

/// The simplest of those that are as good as the best.
pub fn simplest(candidates: &[Candidate]) -> Option<&Candidate> {
    let best = candidates.iter().min_by(|a, b| a.merit().total_cmp(&b.merit()))?;
    let good = || candidates.iter().filter(|c| as_good(c, best));
    let size = good().map(Candidate::size).min()?;
    let of_size = || good().filter(|c| c.size() == size);
    let merit = of_size().map(Candidate::merit).fold(f64::MAX, f64::min);
    of_size().filter(|c| c.merit() <= merit + TIE).min_by_key(|c| rarity(c))
}

/// Below this difference of merit two laws of the same size fit alike, and the commoner one is meant.
const TIE: f64 = 0.04;

/// How seldom one meets the last effect of `c`: asked only where the data do not decide.
fn rarity(c: &Candidate) -> usize {
    const COMMON: [Kind; 9] = [
        Kind::Coulomb,
        Kind::DeadZone,
        Kind::Gravity,
        Kind::Backlash,
        Kind::Delay,
        Kind::Cogging,
        Kind::SensorLag,
        Kind::VoltageDrop,
        Kind::ConstantLoad,
    ];
    c.kinds().last().and_then(|k| COMMON.iter().position(|c| c == k)).unwrap_or(COMMON.len())
}

/// Whether the two cannot be told apart by their errors.
fn as_good(c: &Candidate, best: &Candidate) -> bool {
    let log =
        |f: fn(&Errors) -> f64, c: &Candidate| 0.5 * (f(&c.train).max(0.7).ln() + f(&c.unseen).max(0.7).ln());
    log(|e| e.increments, c) <= log(|e| e.increments, best) + EQUAL
        && log(|e| e.position, c) <= log(|e| e.position, best) + DRIFT.ln()
}

/// Climbs from `base` with at most `most` effects of `library`.
pub fn run(
    evidence: &mut Evidence,
    base: Candidate,
    library: &[Kind],
    most: usize,
    tick: &mut dyn FnMut(usize, Kind),
    rung: &mut dyn FnMut(&Evidence, &Candidate),
) -> Climb {
    let mut climb =
        Climb { rungs: vec![base], first: Vec::new(), refused: Vec::new(), withdrawn: Vec::new() };
    rung(evidence, climb.model());
    // A rival of the accepted model goes on beside it, because a wrong first effect may absorb a right second.
    let mut rival: Option<Candidate> = None;
    while climb.rungs.len() <= most.min(MAX_EFFECTS) {
        let depth = climb.rungs.len() - 1;
        let model = climb.model().clone();
        let (floor, effort) =
            if depth == 0 { (AT_THE_FLOOR, Effort::FIRST) } else { (NEAR_THE_FLOOR, Effort::LATER) };
        let quiet = |e: &Errors| e.increments < floor && e.position < STEADY;
        if quiet(&model.train) && quiet(&model.unseen) {
            break;
        }
        let mut found = look(evidence, &model, library, effort, &mut |k| tick(depth, k));
        if depth == 0 {
            climb.first.clone_from(&found);
        }
        if let Some(rival) = rival.take() {
            found.extend(look(evidence, &rival, library, effort, &mut |k| tick(depth, k)));
        }
        found.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
        let worthy: Vec<Candidate> = found.iter().filter(|c| worth(c, &model)).cloned().collect();
        let Some(next) = next_rung(&worthy, &model).cloned() else {
            climb.refused = found;
            break;
        };
        rival = found.iter().find(|c| rivals(c, &next)).cloned();
        let next = contained::together(evidence, prune(evidence, next), library);
        let next = evidence.finish(next);
        let next = evidence.settle_starts(next);
        rung(evidence, &next);
        climb.rungs.push(next);
    }
    if evidence.repeated && climb.rungs.len() <= most {
        climb.withdraw();
    }
    climb
}

/// Everything that one more effect of `library` makes of `model`.
fn look(
    evidence: &Evidence,
    model: &Candidate,
    library: &[Kind],
    effort: Effort,
    tick: &mut dyn FnMut(Kind),
) -> Vec<Candidate> {
    let model = contained::apart(evidence, model);
    let mut found = Vec::new();
    let mut others = Vec::new();
    for kind in library.iter().copied().filter(|kind| contained::may_join(model.kinds(), *kind)) {
        match contained::richer(evidence, &model, kind) {
            Some(richer) => found.push(richer),
            None => others.push(kind),
        }
    }
    found.extend(stage::run(evidence, &model, &others, effort, tick));
    found
}

/// The simplest of the best; of equals, one that keeps what was accepted before.
fn next_rung<'a>(found: &'a [Candidate], model: &Candidate) -> Option<&'a Candidate> {
    let next = simplest(found)?;
    let keeps = |c: &&Candidate| model.kinds().iter().all(|k| contained::covers(c.kinds(), *k));
    if keeps(&next) {
        return Some(next);
    }
    let kept = found.iter().filter(keeps).find(|c| c.size() <= next.size() && as_good(c, next));
    Some(kept.unwrap_or(next))
}

/// Whether `c` is another model about as large and not much worse than `next`.
fn rivals(c: &Candidate, next: &Candidate) -> bool {
    c.size() <= next.size() + 1 && !same(c, next) && c.merit() < next.merit() + RIVAL
}

/// A model this much worse (a factor of two in error and more) has lost.
const RIVAL: f64 = 0.9;

fn same(a: &Candidate, b: &Candidate) -> bool {
    let sorted = |c: &Candidate| {
        let mut kinds = c.kinds().to_vec();
        kinds.sort();
        kinds
    };
    sorted(a) == sorted(b)
}

/// Leaves out every effect that the others made superfluous, and of every effect what is more than a simpler one.
fn prune(evidence: &Evidence, model: Candidate) -> Candidate {
    let mut model = model;
    while model.kinds().len() > 1 {
        let mut fewer: Vec<Candidate> =
            model.kinds().iter().map(|k| evidence.fit(&model.values().without(*k), 10)).collect();
        fewer.extend(contained::simpler(evidence, &model));
        fewer.retain(|c| c.merit() <= model.merit() + EQUAL * 0.5 && as_good(c, &model));
        match simplest(&fewer) {
            Some(c) => model = c.clone(),
            None => break,
        }
    }
    model
}
