//! Updates of a held reading, and what they leave of its moves.

use super::moves::Move;

/// Ages that are tried.
const FEWEST_AGES: f64 = 32.0;
const MOST_AGES: f64 = 512.0;

/// How often readings are updated, 1/s, and how old the first one is, s.
#[derive(Debug, Clone, Copy)]
pub(super) struct Updates {
    pub(super) rate: f64,
    pub(super) age: f64,
}

impl Updates {
    /// Number of the update that an instant shows. Instants and ages are positive.
    pub(super) fn number(self, t: f64) -> f64 {
        ((t + self.age) * self.rate) as i64 as f64
    }

    /// Updates between two instants.
    pub(super) fn between(self, from: f64, to: f64) -> f64 {
        self.number(to) - self.number(from)
    }
}

/// How far `ratio` updates per sample are from a whole number of them.
pub(super) fn beat_of(ratio: f64) -> f64 {
    (ratio - ratio.round()).abs()
}

/// What is left of `moves` once readings are dated at their updates: sum of squares, counts^2.
fn left(moves: &[Move], updates: Updates) -> f64 {
    let left = |m: &Move| {
        let around = updates.between(m.around[0], m.around[1]).max(1.0);
        m.by - m.around_by * updates.between(m.from, m.to) / around
    };
    moves.iter().map(|m| left(m).powi(2)).sum()
}

/// Moves the updates at both ends of `moves`, by less and less, to where least is left.
pub(super) fn settle(moves: &[Move], start: Updates, interval: f64) -> (Updates, f64) {
    let ends = [moves[0].from, moves[moves.len() - 1].to];
    let mut turns = ends.map(|t| (t + start.age) * start.rate);
    let updates = |turns: [f64; 2]| {
        let rate = (turns[1] - turns[0]) / (ends[1] - ends[0]);
        // An instant before the first sample has no number.
        let age = turns[0] / rate - ends[0];
        Updates { rate, age: age.rem_euclid(1.0 / rate) }
    };
    let mut least = left(moves, updates(turns));
    let mut by = 0.5 * beat_of(start.rate * interval).clamp(1e-3, 0.1);
    for _ in 0..7 {
        for [x, y] in [[1, 1], [-1, -1], [1, 0], [-1, 0], [0, 1], [0, -1], [1, -1], [-1, 1]] {
            let next = [turns[0] + f64::from(x) * by, turns[1] + f64::from(y) * by];
            let left = left(moves, updates(next));
            if left < least {
                (least, turns) = (left, next);
            }
        }
        by *= 0.5;
    }
    (updates(turns), least)
}

/// The age of the first reading that leaves least of `moves`, s: the middle of those that leave the same.
pub(super) fn likely_age(moves: &[Move], rate: f64, interval: f64) -> f64 {
    let ages = (2.0 / beat_of(rate * interval)).clamp(FEWEST_AGES, MOST_AGES).ceil();
    // In turns of the hold.
    let tried = |turns: f64| (turns, left(moves, Updates { rate, age: turns / rate }));
    let rough = (0..ages as usize).map(|k| tried((k as f64 + 0.5) / ages));
    let rough = rough.min_by(|a, b| a.1.total_cmp(&b.1)).map_or(0.0, |best| best.0);
    let near = |k: i32| tried(1.0 + rough + f64::from(k) / (8.0 * ages));
    let fine: Vec<(f64, f64)> = (-12..=12).map(near).collect();
    let least = fine.iter().map(|t| t.1).fold(f64::MAX, f64::min);
    let best: Vec<f64> = fine.iter().filter(|t| t.1 == least).map(|t| t.0).collect();
    (best.iter().sum::<f64>() / best.len() as f64).rem_euclid(1.0) / rate
}
