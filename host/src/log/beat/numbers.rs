//! The update that every sample shows, and the hold and ages that agree with all of them.
//!
//! A sample at `t` shows update `n` just where `n hold <= t + age < (n + 1) hold`. Every sample narrows what this leaves to
//! the age of its record, and all records together to the hold, to a few millionths.

use super::FAST;
use super::moves::{Move, moves};
use super::updates::Updates;
use crate::log::hold::top;
use crate::log::timing::mean_interval;

/// What a move shows is a whole number of updates to within this.
const CLEAR: f64 = 0.25;
/// Fewest counts between two updates that tell them apart.
const APART: f64 = 4.0;
/// Motion may be less even where the updates are nearly known.
const EVEN: f64 = 1.0;
/// A number that contradicts a first guess of the updates by more than this share of a hold was misread.
const MISREAD: f64 = 0.05;
/// The hold is known to within this share.
const KNOWN: f64 = 5e-5;
/// Fewest samples that tell an age.
const FEWEST: usize = 20;

/// Samples of a record, and the updates that they show.
#[derive(Debug)]
pub struct Numbers {
    /// Time since the first sample, s, and number.
    shown: Vec<[f64; 2]>,
}

impl Numbers {
    /// The numbers that the readings `values` at `time_s` show, counted in steps of `count`: their hold and age are nearly
    /// known.
    pub fn new(time_s: &[f64], values: &[f64], count: f64, hold_s: f64, age_s: f64) -> Self {
        let moves = moves(time_s, values, count, FAST.max(APART * mean_interval(time_s) / hold_s), EVEN);
        let guess = Updates { rate: 1.0 / hold_s, age: age_s };
        let shown = |pair: &[Move]| -> Option<[f64; 2]> {
            let (t, by) = (pair[0].to, more(&pair[0], guess)?);
            // A sample of one update more makes the move before it longer and the one behind it shorter.
            let one = pair[1].from == t && more(&pair[1], guess)? == -by;
            let number = guess.number(t) + by;
            let turns = (t + age_s) / hold_s - number;
            (one && (-MISREAD..1.0 + MISREAD).contains(&turns)).then_some([t, number])
        };
        Self { shown: moves.windows(2).filter_map(shown).collect() }
    }

    /// The numbers beside every change of a reading, where these are updated less often than samples come: `around` are the
    /// last time before each change and the first behind it, s after the first sample.
    pub fn of_changes(around: &[[f64; 2]], hold_s: f64, age_s: f64) -> Self {
        let shown = |[before, after]: &[f64; 2]| {
            let turns = (0.5 * (before + after) + age_s) / hold_s;
            let number = turns.round();
            let clear = (turns - number).abs() * hold_s < 0.5 * (after - before) + MISREAD * hold_s;
            clear.then_some([[*before, number - 1.0], [*after, number]])
        };
        Self { shown: around.iter().filter_map(shown).flatten().collect() }
    }

    /// Whether some age of the first reading agrees with all that is shown.
    pub fn agree(&self, hold_s: f64) -> bool {
        let [youngest, oldest] = self.ages(hold_s);
        youngest <= oldest
    }

    /// Youngest and oldest first reading that agree with a hold, s; where none does, they change places.
    fn ages(&self, hold_s: f64) -> [f64; 2] {
        self.shown.iter().fold([f64::MIN, f64::MAX], |[youngest, oldest], [t, number]| {
            let age = number * hold_s - t;
            [youngest.max(age), oldest.min(age + hold_s)]
        })
    }

    /// The age of the first reading, s; none where too little is shown.
    pub fn age(&self, hold_s: f64) -> Option<f64> {
        let [youngest, oldest] = self.ages(hold_s);
        (self.shown.len() >= FEWEST).then(|| (0.5 * (youngest + oldest)).rem_euclid(hold_s))
    }
}

/// The hold near `about` that leaves every record the widest choice of ages.
pub fn hold_of(records: &[Numbers], about: f64) -> f64 {
    let telling = || records.iter().filter(|record| record.shown.len() >= FEWEST);
    let choice = |hold_s: f64| {
        let widths = telling().map(|record| record.ages(hold_s)).map(|[youngest, oldest]| oldest - youngest);
        widths.fold(f64::MAX, f64::min)
    };
    // Each width is concave in the hold, and so is the least of them.
    if telling().next().is_some() {
        top([about * (1.0 - KNOWN), about * (1.0 + KNOWN)], choice)
    } else {
        about
    }
}

/// How many updates more than `guess` has a move shows; none where it does not show a whole number.
fn more(m: &Move, guess: Updates) -> Option<f64> {
    let around = guess.between(m.around[0], m.around[1]).max(1.0);
    let more = m.by * around / m.around_by - guess.between(m.from, m.to);
    ((more - more.round()).abs() < CLEAR).then_some(more.round())
}
