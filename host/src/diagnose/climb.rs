//! The climb: effects are added one by one while unseen records say that it is worth it.

use motorlens_shared::effects::Kind;
use motorlens_shared::simulator::MAX_EFFECTS;

use super::candidate::{Candidate, Errors, STANDS_OUT, STEADY};
use super::contained;
use super::detours;
use super::evidence::Evidence;
use super::shake::shake;
use super::slow_pwm;
use super::stage::Effort;
use super::step::{TO_THE_END, look, prune, settled};
use super::teeth::settle_teeth;
use super::way::{FAR, drifts, falls_short};
use super::worth::{NEAR_THE_FLOOR, SLOW, as_good, promises, rivals, simplest, worth};

/// Nothing is left to find below this many noise units in a steady base model.
const AT_THE_FLOOR: f64 = 1.02;
/// ... nor beside a first effect below these, of the increments and of the error itself.
const BESIDE_A_FIRST: (f64, f64) = (1.05, 1.3);

/// What the climb found.
#[derive(Debug)]
pub struct Climb {
    /// Rungs from the base model to the last accepted one.
    pub rungs: Vec<Candidate>,
    /// The first stage's candidates, best first; of equals the simplest.
    pub first: Vec<Candidate>,
    /// The last stage's candidates that were not worth adding.
    pub refused: Vec<Candidate>,
    /// Effects that were added and taken back in the end.
    pub withdrawn: Vec<Kind>,
}

impl Climb {
    /// Takes the effects back where they stop short of a measured floor: physics outside the library
    /// lends itself to many effects in part, and is none of them. A climb that ended at its `most` effects is left as it is.
    pub fn withdraw(&mut self, evidence: &Evidence, most: usize) {
        let measured = evidence.repeated && self.rungs.len() <= most;
        // How many counts a record loses is chance, so that no second run tells another record's floor.
        if measured && falls_short(self.model(), &self.rungs[0]) && !self.model().foretold {
            self.withdrawn = self.model().kinds().to_vec();
            self.rungs.truncate(1);
        }
    }

    /// Lets `better` stand in the accepted model's place, and lead the first stage where it is of that.
    pub fn believe(&mut self, better: Candidate) {
        if let Some(place) = self.first.iter().position(|c| c.kinds() == better.kinds()) {
            self.first.remove(place);
            self.first.insert(0, better.clone());
        }
        self.rungs.pop();
        self.rungs.push(better);
    }

    /// Whether the accepted model is all that there is: it leaves noise, and its effects end the drift, but for what is next to
    /// nothing of it.
    pub fn explains_all(&self) -> bool {
        const AT_THE_FLOOR_IN_UNREST: f64 = 1.1;
        const EVEN: f64 = 1.2;
        let (model, base) = (self.model(), &self.rungs[0]);
        // What two runs differ by is in the floor, and all records share it: what is left above it is left by the wrong effect.
        let at_the_floor = model.larger_increments() < AT_THE_FLOOR_IN_UNREST;
        let even = model.calm != Some(false) || at_the_floor && model.worst() < EVEN;
        model.explains_all() && (self.rungs.len() == 1 || !drifts(model, base) && even)
    }

    /// The accepted model.
    pub fn model(&self) -> &Candidate {
        &self.rungs[self.rungs.len() - 1]
    }
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
        let unit = evidence.floor;
        let effort = if depth == 0 { Effort::FIRST } else { Effort::LATER };
        // Beside a first effect a slow second one shows in the drift alone; two laws leave a drift of their own.
        let (floor, drift) = match depth {
            0 => (AT_THE_FLOOR, SLOW),
            1 => BESIDE_A_FIRST,
            _ => (NEAR_THE_FLOOR, STEADY),
        };
        let quiet = |e: &Errors| e.increments < floor && e.position < drift;
        let told = evidence.loses_counts && !model.foretold && library.contains(&Kind::LostCounts);
        let shows = model.worst() > STANDS_OUT;
        if quiet(&model.train) && quiet(&model.unseen) && !told && !(shows && depth == 1) {
            break;
        }
        let mut found = look(evidence, &model, library, effort, &mut |k| tick(depth, k));
        let leads = |found: &[Candidate]| found.iter().any(|c| worth(c, &model));
        if depth == 0 && model.excess() > FAR && !leads(&found) {
            let deep = look(evidence, &model, library, Effort::DEEP, &mut |k| tick(depth, k));
            found = if leads(&deep) { deep } else { found };
        }
        if depth == 0 {
            climb.first = best_first(&found);
        }
        if let Some(rival) = rival.take() {
            found.extend(look(evidence, &rival, library, effort, &mut |k| tick(depth, k)));
        }
        found.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
        let mut worthy: Vec<Candidate> = found.iter().filter(|c| worth(c, &model)).cloned().collect();
        let teeth = |c: &&Candidate| shows && c.kinds().last() == Some(&Kind::Cogging);
        let unfinished =
            || found.first().filter(|c| promises(c, &model)).or_else(|| found.iter().find(teeth));
        if let Some(best) = worthy.is_empty().then(unfinished).flatten() {
            // Teeth come down slowly: what they leave of the error itself goes last.
            let finished = settle_teeth(evidence, evidence.fit(&best.values(), TO_THE_END));
            let finished = evidence.finish(finished);
            worthy.extend(Some(finished).filter(|c| worth(c, &model)));
        }
        if worthy.is_empty() {
            worthy.extend(slow_pwm::worthy(evidence, &found, &model));
        }
        let mut next = next_rung(&worthy, &model).cloned();
        if next.is_none() && depth == 0 {
            next = detours::leap(evidence, &model, &found, library, &mut |k| tick(depth, k));
        }
        let unsolved = evidence.repeated && depth < 2 && !model.explains();
        if next.is_none() && most > 1 && unsolved {
            next = detours::deeper(evidence, &climb.rungs[0], &model, &climb.first, library, &mut |k| {
                tick(depth, k)
            });
        }
        let Some(next) = next else {
            climb.refused = found;
            break;
        };
        rival = found.iter().find(|c| rivals(c, &next)).cloned();
        let mut next = settled(evidence, next, library);
        // Each of the two was chosen beside another than it is left with.
        for _ in 0..2 {
            let Some(other) = detours::swapped(evidence, &next, library, &mut |k| tick(depth, k)) else {
                break;
            };
            next = settled(evidence, other, library);
        }
        if let Some(timed) = evidence.time_pulses(&next).or_else(|| evidence.time_late_pulses(&next)) {
            let timed = prune(evidence, timed);
            let refit = |c: &mut Candidate| *c = evidence.fit(&c.values(), TO_THE_END);
            climb.first.iter_mut().filter(|c| c.kinds().contains(&Kind::Coast)).for_each(refit);
            rival = None;
            next = timed;
        }
        if evidence.allow_for_chance(&next.values()) || evidence.floor != unit {
            let again = |candidate: &mut Candidate| *candidate = evidence.again(candidate);
            climb.rungs.iter_mut().chain(&mut climb.first).chain(&mut rival).for_each(again);
            next = evidence.fit(&next.values(), TO_THE_END);
            // Under a lower floor it may be seen to have ended early.
            shake(evidence, &mut next);
        }
        rung(evidence, &next);
        climb.rungs.push(next);
    }
    climb.withdraw(evidence, most);
    climb
}

/// `found` by merit, but the simplest of equals first, as it does when one is added.
pub fn best_first(found: &[Candidate]) -> Vec<Candidate> {
    let best = simplest(found);
    let mut first: Vec<&Candidate> = found.iter().collect();
    first.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
    first.sort_by_key(|c| !best.is_some_and(|best| std::ptr::eq(*c, best)));
    first.into_iter().cloned().collect()
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

#[cfg(test)]
#[path = "climb_tests.rs"]
mod tests;
