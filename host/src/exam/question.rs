//! The questions of an examination.

use motorlens_shared::effects::Kind as Law;
use motorlens_virtual_motor::Kind;
use rand::SeedableRng;
use rand::rngs::ChaCha8Rng;
use rand::seq::IndexedRandom;
use serde::Serialize;

use super::case::Conditions;
use crate::simulate::alike;

/// What a question asks for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Group {
    /// One effect is hidden.
    Single,
    /// Nothing is hidden.
    Nothing,
    /// Two effects are hidden.
    Pair,
    /// One effect is hidden that the library has been robbed of.
    Outside,
}

/// A question: which effects to hide in which motor.
#[derive(Debug, Clone)]
pub struct Question {
    /// What it asks for.
    pub group: Group,
    /// Picks motor, sizes and noise.
    pub seed: u64,
    /// What is hidden.
    pub hidden: Vec<Kind>,
    /// Conditions.
    pub conditions: Conditions,
}

/// Whether others add up to `kind`, so that no library can be robbed of it: a friction that differs by direction is an
/// even one and a constant load.
fn is_sum(kind: Kind) -> bool {
    Law::by_name(kind.row().name).is_some_and(|law| law.spec().is_sum())
}

/// How many questions of each group, and from which seed on.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Paper {
    /// First seed.
    pub from: u64,
    /// Cases of every effect alone.
    pub singles: u64,
    /// Cases with nothing missing.
    pub nothing: u64,
    /// Cases with two effects.
    pub pairs: u64,
    /// Cases with an effect that the library lacks.
    pub outside: u64,
    /// Share of single cases with a torque disturbance; half of the cases with nothing missing have one.
    pub disturbed: f64,
    /// Share of cases with noise on the logged voltage, a start in motion, jitter; each on its own.
    pub spoilt: f64,
}

impl Paper {
    /// The questions in order. Seeds do not depend on how many questions another group has.
    pub fn questions(&self, only: &[Kind]) -> Vec<Question> {
        let singles = Conditions { disturbed: self.disturbed, spoilt: self.spoilt };
        let clean = Conditions { disturbed: 0.5, spoilt: self.spoilt };
        let asked = |kind: &Kind| only.is_empty() || only.contains(kind);
        let mut questions = Vec::new();
        let mut ask = |group, seed, hidden, conditions| {
            questions.push(Question { group, seed, hidden, conditions });
        };
        for round in 0..self.singles {
            for (k, kind) in Kind::all().enumerate().filter(|(_, kind)| asked(kind)) {
                ask(Group::Single, self.from + 100 * round + k as u64, vec![kind], singles);
            }
        }
        for k in 0..self.nothing {
            ask(Group::Nothing, self.from + 100_000 + k, Vec::new(), clean);
        }
        for k in 0..self.pairs {
            let seed = self.from + 200_000 + k;
            ask(Group::Pair, seed, pair(seed, only), singles);
        }
        let all: Vec<Kind> = Kind::all().filter(asked).filter(|kind| !is_sum(*kind)).collect();
        for (k, kind) in (0..self.outside).zip(all.into_iter().cycle()) {
            ask(Group::Outside, self.from + 300_000 + k, vec![kind], singles);
        }
        questions
    }
}

/// Two effects that are not alike; one of `only`, where it names any.
fn pair(seed: u64, only: &[Kind]) -> Vec<Kind> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let all: Vec<Kind> = Kind::all().collect();
    let first = *(if only.is_empty() { &all } else { only }).choose(&mut rng).unwrap_or(&Kind::Coulomb);
    let others: Vec<Kind> = all.into_iter().filter(|k| !alike(*k, first)).collect();
    vec![first, *others.choose(&mut rng).unwrap_or(&Kind::Delay)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_effect_is_asked_for_as_often_and_seeds_are_never_used_twice() {
        let paper =
            Paper { from: 7, singles: 3, nothing: 10, pairs: 20, outside: 25, disturbed: 0.0, spoilt: 0.0 };
        let questions = paper.questions(&[]);
        let effects = Kind::all().count();
        assert_eq!(questions.len(), 3 * effects + 55);
        let mut seeds: Vec<u64> = questions.iter().map(|q| q.seed).collect();
        seeds.sort_unstable();
        seeds.dedup();
        assert_eq!(seeds.len(), questions.len());
        for q in questions.iter().filter(|q| q.group == Group::Pair) {
            assert!(!alike(q.hidden[0], q.hidden[1]), "{q:?}");
        }
    }
}
