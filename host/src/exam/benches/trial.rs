//! Asks the diagnosis about cases of the benches and keeps what it said beside the truth.

use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::mpsc;
use std::time::Instant;

use motorlens_bench_motor::{Bench, Case, Group};
use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::{case, motor_file, record};
use crate::diagnose::discover::{Options, discover};
use crate::error::Result;
use crate::findings::verdict_of;
use crate::log::Record;
use crate::motor_file::MotorFile;

/// Which cases.
#[derive(Debug, Clone, Serialize)]
pub struct Paper {
    /// First seed.
    pub from: u64,
    /// Cases of each kind of bench.
    pub cases: u64,
    /// Kinds of bench by name; all where empty.
    pub benches: Vec<String>,
}

impl Paper {
    /// Benches and seeds in order.
    pub fn questions(&self) -> Vec<(Bench, u64)> {
        let asked = |bench: &Bench| self.benches.is_empty() || self.benches.iter().any(|b| b == bench.name());
        let seeds = self.from..self.from + self.cases;
        let of = |bench: Bench| seeds.clone().map(move |seed| (bench, seed));
        Bench::ALL.into_iter().filter(asked).flat_map(of).collect()
    }
}

/// A diagnosis, as far as the examination looks at it.
struct Diagnosis {
    effects: Vec<&'static str>,
    ranking: Vec<&'static str>,
    rivals: Vec<Vec<&'static str>>,
    verdict: String,
    /// Says what these records cannot show, or what to run next.
    guides: bool,
    /// Error on the record kept out before and after, in the measured unit.
    before: f64,
    after: f64,
}

/// The one place that calls the diagnosis.
fn ask(records: &[Record], held_out: &[Record], motor: &MotorFile) -> Result<Diagnosis> {
    let options = Options::default();
    let found = discover(records, held_out, motor, &options, &mut |_| ())?;
    let names = |kinds: &[Kind]| kinds.iter().map(|k| k.name()).collect();
    let rung = |k: Option<&crate::diagnose::ladder::Rung>| {
        k.and_then(|rung| rung.validation).map_or(f64::NAN, |m| m.rmse)
    };
    let verdict = serde_json::to_value(verdict_of(&found)).unwrap_or_default();
    Ok(Diagnosis {
        effects: names(&found.effects),
        ranking: found.candidates.iter().map(|c| c.effect.name()).collect(),
        rivals: found.open_sets().iter().map(|set| names(set)).collect(),
        verdict: verdict.as_str().unwrap_or_default().to_owned(),
        guides: !found.selected.rivals.is_empty() || found.limits.iter().any(|l| l.programme.is_some()),
        before: rung(found.ladder.first()),
        after: rung(found.ladder.last()),
    })
}

/// What the diagnosis answered, beside the truth.
#[derive(Debug, Clone, Serialize)]
pub struct Answer {
    /// Kind of bench.
    pub bench: &'static str,
    /// Seed of the case.
    pub seed: u64,
    /// `single`, `pair`, `nothing` or `outside`.
    pub group: &'static str,
    /// Effects that must be found.
    pub asked: Vec<&'static str>,
    /// Effects that are there too, but hardly show; naming them is right.
    pub also: Vec<&'static str>,
    /// All of them with size and visibility.
    pub sizes: String,
    /// Motor, sensor, disturbance.
    pub conditions: String,
    /// Deviation of the disturbance torque over stall.
    pub disturbance: f64,
    /// Accepted effects.
    pub found: Vec<&'static str>,
    /// First diagnosis, best first.
    pub ranking: Vec<&'static str>,
    /// Sets that the data do not tell apart.
    pub rivals: Vec<Vec<&'static str>>,
    /// Verdict; `refused` with the reason in `sizes` where the records were not taken.
    pub verdict: String,
    /// What was said about what these records cannot show.
    pub guides: bool,
    /// Unseen error of the base model over the accepted one's.
    pub fall: f64,
    /// Whole time, s.
    pub seconds: f64,
}

/// Whether `found` says all that `name` says: it is named, or lies within a richer equation, or is the sum of others that are.
fn says(found: &[&'static str], name: &str) -> bool {
    let within = |part: &str| {
        found
            .iter()
            .any(|rich| Kind::by_name(rich).is_some_and(|kind| kind.spec().holds(part)) || *rich == part)
    };
    within(name)
        || Kind::by_name(name).is_some_and(|kind| {
            kind.spec().is_sum() && kind.spec().contains.iter().all(|(part, _)| within(part))
        })
}

impl Answer {
    /// Everything that is there.
    fn truth(&self) -> Vec<&'static str> {
        self.asked.iter().chain(&self.also).copied().collect()
    }

    /// All that was asked for and nothing that is not there.
    pub fn exact(&self) -> bool {
        self.asked.iter().all(|name| says(&self.found, name)) && !self.strange()
    }

    /// An effect was accepted that is not there.
    pub fn strange(&self) -> bool {
        let truth = self.truth();
        self.found.iter().any(|name| !says(&truth, name))
    }

    /// Each accepted effect, or a rival that was named with it, is there.
    pub fn tenable(&self) -> bool {
        let truth = self.truth();
        let open = |name: &str| {
            self.rivals.iter().any(|set| set.contains(&name) && set.iter().any(|other| says(&truth, other)))
        };
        self.found.iter().all(|name| says(&truth, name) || open(name))
    }

    /// The first effect of the first diagnosis is there.
    pub fn first(&self) -> bool {
        let truth = self.truth();
        self.ranking.first().is_some_and(|name| says(&truth, name) || truth.contains(name))
    }
}

/// Answers every question on `threads` threads; `each` hears of the answers as they come. They are in the order of the
/// questions.
pub fn examine(paper: &Paper, threads: usize, each: &mut dyn FnMut(&Answer)) -> Vec<Answer> {
    let questions = paper.questions();
    let next = AtomicUsize::new(0);
    let (send, receive) = mpsc::channel();
    let mut answers: Vec<(usize, Answer)> = std::thread::scope(|scope| {
        for _ in 0..threads.max(1) {
            let (send, next, questions) = (send.clone(), &next, &questions);
            scope.spawn(move || {
                while let Some((bench, seed)) = questions.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let place = questions.iter().position(|q| q == &(*bench, *seed)).unwrap_or(0);
                    if send.send((place, answer(&case(*bench, *seed)))).is_err() {
                        break;
                    }
                }
            });
        }
        drop(send);
        receive.into_iter().inspect(|(_, answer)| each(answer)).collect()
    });
    answers.sort_by_key(|(place, _)| *place);
    answers.into_iter().map(|(_, answer)| answer).collect()
}

/// Asks about one case. Records that are refused are an answer too: the user has nothing else.
fn answer(case: &Case) -> Answer {
    let logs = |logs: &[motorlens_bench_motor::Log]| logs.iter().map(record).collect::<Vec<_>>();
    let (training, held_out) = (logs(&case.training), logs(&case.held_out));
    let begun = Instant::now();
    let found = ask(&training, &held_out, &motor_file(&case.known));
    let seconds = begun.elapsed().as_secs_f64();
    let named = |asked: bool| case.hidden.iter().filter(|h| h.asked == asked).map(|h| h.name).collect();
    let size = |h: &motorlens_bench_motor::Hidden| {
        let seen = h.visibility.map(|seen| format!(" ({seen:.1} x noise)"));
        h.size.clone() + &seen.unwrap_or_default()
    };
    let mut sizes = case.hidden.iter().map(size).collect::<Vec<_>>().join(", ");
    let found = found.unwrap_or_else(|error| {
        sizes += &format!("; refused: {error}");
        Diagnosis {
            effects: Vec::new(),
            ranking: Vec::new(),
            rivals: Vec::new(),
            verdict: "refused".into(),
            guides: false,
            before: f64::NAN,
            after: f64::NAN,
        }
    });
    Answer {
        bench: case.bench.name(),
        seed: case.seed,
        group: group_name(case.group),
        asked: named(true),
        also: named(false),
        sizes,
        conditions: case.conditions.clone(),
        disturbance: case.disturbance,
        found: found.effects,
        ranking: found.ranking,
        rivals: found.rivals,
        verdict: found.verdict,
        guides: found.guides,
        fall: found.before / found.after,
        seconds,
    }
}

/// The group's name in documents.
pub fn group_name(group: Group) -> &'static str {
    match group {
        Group::Single => "single",
        Group::Pair => "pair",
        Group::Nothing => "nothing",
        Group::Outside => "outside",
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(asked: &[&'static str], also: &[&'static str], found: &[&'static str]) -> Answer {
        Answer {
            bench: "protocol",
            seed: 1,
            group: "single",
            asked: asked.to_vec(),
            also: also.to_vec(),
            sizes: String::new(),
            conditions: String::new(),
            disturbance: 0.0,
            found: found.to_vec(),
            ranking: found.to_vec(),
            rivals: Vec::new(),
            verdict: "explained".into(),
            guides: false,
            fall: 1.0,
            seconds: 0.0,
        }
    }

    #[test]
    fn a_richer_law_says_what_a_simpler_one_says_but_not_the_other_way() {
        assert!(told(&["coulomb"], &[], &["coulomb"]).exact());
        assert!(!told(&["stribeck"], &[], &["coulomb"]).exact());
        assert!(!told(&["stribeck"], &[], &["coulomb"]).strange());
        assert!(told(&["coulomb_asymmetric"], &[], &["coulomb", "constant_load"]).exact());
        assert!(told(&["gravity"], &["coulomb"], &["gravity"]).exact());
        assert!(told(&["gravity"], &["coulomb"], &["gravity", "coulomb"]).exact());
        assert!(told(&["gravity"], &[], &["gravity", "delay"]).strange());
    }

    #[test]
    fn a_rival_that_is_there_makes_an_answer_tenable() {
        let mut answer = told(&["dead_zone"], &[], &["voltage_drop"]);
        assert!(!answer.tenable());
        answer.rivals = vec![vec!["voltage_drop", "dead_zone"]];
        assert!(answer.tenable() && !answer.exact());
    }
}
