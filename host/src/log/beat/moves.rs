//! What readings move by from one sample to the next, in fast and even motion.

use crate::log::timing::mean_interval;

/// The speed at a move is that over so many samples before and behind it.
pub(super) const AROUND: usize = 3;
/// ... and, in even motion, differs by no more than this share between so many before and so many behind.
const STRETCH: usize = 7;
pub(super) const EVEN: f64 = 0.35;
/// Moves that are enough for a guess.
const ENOUGH: usize = 768;

/// What the readings moved by from one sample to the next, in fast and even motion.
#[derive(Debug, Clone, Copy)]
pub(super) struct Move {
    /// The two samples, s after the first.
    pub(super) from: f64,
    pub(super) to: f64,
    /// Counts.
    pub(super) by: f64,
    /// The samples around it that tell the speed, s, and what they move by, counts.
    pub(super) around: [f64; 2],
    pub(super) around_by: f64,
    /// Counts per second.
    pub(super) speed: f64,
    /// What the move is beyond `speed x interval`, counts.
    pub(super) excess: f64,
}

/// Sum of squares, counts^2.
pub(super) fn excess(moves: &[Move]) -> f64 {
    moves.iter().map(|m| m.excess * m.excess).sum()
}

/// Moves in motion of `fast` counts per interval that is as `even`.
pub(super) fn moves(time_s: &[f64], values: &[f64], count: f64, fast: f64, even: f64) -> Vec<Move> {
    let n = values.len();
    if count <= 0.0 || n < 4 * STRETCH {
        return Vec::new();
    }
    let interval = mean_interval(time_s);
    let by = |from: usize, to: usize| (values[to] - values[from]) / count;
    let speed = |from: usize, to: usize| by(from, to) / (time_s[to] - time_s[from]);
    let at = |k: usize| time_s[k] - time_s[0];
    (STRETCH + 1..n - STRETCH)
        .filter_map(|k| {
            let (first, last) = (k - 1 - AROUND, k + AROUND);
            let mean = speed(first, last);
            let is_even = |_: &f64| {
                let [before, behind] = [speed(k - 1 - STRETCH, k - 1), speed(k, k + STRETCH)];
                (behind - before).abs() <= even * mean.abs()
            };
            let speed = Some(mean).filter(|v| v.abs() * interval >= fast).filter(is_even)?;
            Some(Move {
                from: at(k - 1),
                to: at(k),
                by: by(k - 1, k),
                around: [at(first), at(last)],
                around_by: by(first, last),
                speed,
                excess: by(k - 1, k) - speed * (at(k) - at(k - 1)),
            })
        })
        .collect()
}

/// Enough of `moves`, spread evenly.
pub(super) fn thinned(moves: &[Move]) -> Vec<Move> {
    moves.iter().step_by(moves.len().div_ceil(ENOUGH).max(1)).copied().collect()
}

/// The time that `moves` cover, s.
pub(super) fn span(moves: &[Move]) -> f64 {
    moves[moves.len() - 1].to - moves[0].from
}
