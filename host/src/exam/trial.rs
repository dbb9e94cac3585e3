//! Runs the loop on hidden cases.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::case::Case;
use super::question::{Group, Question};
use super::truth;
use crate::diagnose::contained::covers;
use crate::diagnose::discover::{Options, Progress, discover};
use crate::error::Result;
use crate::findings::{Verdict, verdict_of};
use crate::select::fitted::Fitted;

/// What the loop answered to a question, beside the truth.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// What was asked for.
    pub group: Group,
    /// The question's seed.
    pub seed: u64,
    /// Names of the hidden effects.
    pub truth: Vec<&'static str>,
    /// With their sizes.
    pub sizes: String,
    /// Rate, gear, faults of the log.
    pub conditions: String,
    /// Deviation of the torque disturbance, as a share of the stall torque.
    pub disturbance: f64,
    /// Accepted effects.
    pub found: Vec<&'static str>,
    /// Candidates of the first diagnosis, best first.
    pub ranking: Vec<&'static str>,
    /// What they leave, in multiples of the noise, every time scale alike; the base model last.
    pub errors: Vec<f64>,
    /// The same of the accepted model.
    pub reached: f64,
    /// What the data could not tell from the accepted effects, a set for each that has such.
    pub rivals: Vec<Vec<&'static str>>,
    /// What they leave, the accepted model's first in each set.
    pub rival_errors: Vec<Vec<f64>>,
    /// What the hidden equations themselves leave, where the answer is another.
    pub truth_errors: Option<f64>,
    /// Verdict.
    pub verdict: Verdict,
    /// False where the hidden equations themselves explain these data and fit no better than the answer.
    pub told: bool,
    /// Error on the record kept out over the noise floor, before and after.
    pub before: f64,
    /// ... after the effects were added.
    pub after: f64,
    /// Time until the first effect was in the model, or there was none, s.
    pub first_seconds: f64,
    /// Time taken by the whole loop, s.
    pub seconds: f64,
    /// Candidate passes.
    pub simulations: u64,
}

impl Answer {
    /// The accepted effects are those that were hidden, whatever a sum and its parts are called; an equation says all that
    /// a simpler one says which it contains.
    pub fn exact(&self) -> bool {
        let kinds =
            |names: &[&'static str]| -> Vec<Kind> { names.iter().filter_map(|n| Kind::by_name(n)).collect() };
        let (found, truth) = (kinds(&self.found), kinds(&self.truth));
        let all = |these: &[Kind], those: &[Kind]| these.iter().all(|kind| covers(those, *kind));
        all(&found, &truth) && all(&truth, &found)
    }

    /// An effect was accepted that is not hidden here, alone or as a part of one that is.
    pub fn names_a_stranger(&self) -> bool {
        self.found.iter().any(|name| !self.is_hidden(name))
    }

    /// Of every accepted effect it, or a rival that the data could not exclude, is hidden here.
    pub fn names_the_truth_a_rival(&self) -> bool {
        let hidden = |names: &[&'static str]| names.iter().any(|name| self.is_hidden(name));
        let open = |name| self.rivals.iter().any(|set| set[0] == name && hidden(set));
        self.found.iter().all(|name| self.is_hidden(name) || open(*name))
    }

    /// Alone, as a part, or as the sum of several.
    fn is_hidden(&self, name: &str) -> bool {
        let hidden: Vec<Kind> = self.truth.iter().filter_map(|truth| Kind::by_name(truth)).collect();
        Kind::by_name(name).is_some_and(|kind| covers(&hidden, kind))
    }

    /// The plain motor leaves more than noise: something shows.
    pub fn shows(&self) -> bool {
        self.errors.last().is_some_and(|left| *left > 1.15)
    }

    /// A hidden effect stands among the first `places` of the first diagnosis.
    pub fn among_first(&self, places: usize) -> bool {
        self.ranking.iter().take(places).any(|name| self.truth.contains(name))
    }
}

/// Answers `questions` on `threads` threads; `each` hears of every answer as it comes. The answers are in the order of
/// the questions.
///
/// # Errors
/// A made record that the loop refuses, which is a fault of the program.
pub fn examine(questions: &[Question], threads: usize, each: &mut dyn FnMut(&Answer)) -> Result<Vec<Answer>> {
    let next = AtomicUsize::new(0);
    let (send, receive) = mpsc::channel();
    let mut answers: Vec<(usize, Answer)> = std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            let (send, next) = (send.clone(), &next);
            scope.spawn(move || {
                loop {
                    let k = next.fetch_add(1, Ordering::Relaxed);
                    let Some(question) = questions.get(k) else { break };
                    // Nobody listens any more only after an error.
                    if send.send((k, answer(question))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        let mut answers = Vec::new();
        for (k, answer) in receive {
            let answer = answer?;
            each(&answer);
            answers.push((k, answer));
        }
        Ok::<_, crate::error::Error>(answers)
    })?;
    answers.sort_by_key(|(k, _)| *k);
    Ok(answers.into_iter().map(|(_, answer)| answer).collect())
}

/// One question.
///
/// # Errors
/// A made record that the loop refuses.
pub fn answer(question: &Question) -> Result<Answer> {
    let case = Case::new(question.seed, &question.hidden, question.conditions);
    let robbed = question.group == Group::Outside;
    let library =
        Kind::ALL.iter().copied().filter(|kind| !(robbed && case.truth.iter().any(|t| kind.spec().holds(t))));
    let options = Options { library: library.collect(), ..Options::default() };
    let begun = Instant::now();
    let mut diagnosed = None;
    let mut told = |progress| match progress {
        Progress::Rung(rung) if rung.effects.is_empty() => {}
        Progress::Trying { depth: 0, .. } => {}
        _ => _ = diagnosed.get_or_insert_with(|| begun.elapsed().as_secs_f64()),
    };
    let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut told)?;
    let seconds = begun.elapsed().as_secs_f64();
    let over_floor = |rung: usize| {
        let error = found.ladder[rung].validation.map_or(f64::NAN, |m| m.rmse);
        error / case.floor_rad
    };
    let first = &found.selected.first;
    let noise = found.evidence.noise_under(found.selected.model());
    let of = |effect: Kind| first.iter().find(|c| c.kinds().last() == Some(&effect));
    let ranked = found.candidates.iter().filter_map(|c| of(c.effect));
    let left = |c: &Fitted| c.noise.over(&noise);
    let errors = ranked.chain(&found.selected.steps[..1]).map(left);
    let names = |kinds: &[Kind]| kinds.iter().map(|k| k.name()).collect();
    let mut answer = Answer {
        group: question.group,
        seed: question.seed,
        truth: case.truth.clone(),
        sizes: case.sizes.clone(),
        conditions: case.conditions.clone(),
        disturbance: case.disturbance,
        found: names(&found.effects),
        ranking: found.candidates.iter().map(|c| c.effect.name()).collect(),
        errors: errors.collect(),
        reached: left(found.selected.model()),
        rivals: found.open_sets().iter().map(|set| names(set)).collect(),
        rival_errors: found.selected.rivals.iter().map(|set| set.models.iter().map(left).collect()).collect(),
        truth_errors: None,
        verdict: verdict_of(&found),
        told: true,
        before: over_floor(0),
        after: over_floor(found.ladder.len() - 1),
        first_seconds: diagnosed.unwrap_or(seconds),
        seconds,
        simulations: found.simulations,
    };
    if !answer.exact() {
        let hidden: Vec<Kind> = case.truth.iter().filter_map(|name| Kind::by_name(name)).collect();
        let truth = truth::fitted(&found.evidence, &found.selected.steps[0], &hidden);
        answer.told = truth::is_told(&found, truth.as_ref());
        answer.truth_errors = truth.as_ref().map(left);
    }
    Ok(answer)
}
