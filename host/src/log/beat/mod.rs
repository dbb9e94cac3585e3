//! How long a sensor holds its readings where that is about a sampling interval, or less.
//!
//! Between two samples of even motion such readings move by `speed x hold x m`, where `m` counts the updates in between:
//! one more now and then, or none. What they move beyond `speed x interval` beats with the updates; where all of it falls
//! into place once every reading is dated at its update, the readings are held. [`super::hold`] tells longer holds from
//! the instants of changes, which say nothing where nearly every sample changes.

mod moves;
mod numbers;
mod spectrum;
mod updates;

use super::hold::Hold;
use super::timing::mean_interval;
use moves::{AROUND, EVEN, Move, excess, moves, span, thinned};
pub use numbers::{Numbers, hold_of};
use spectrum::{Beat, beats, sharpen};
use updates::{Updates, beat_of, likely_age, settle};

/// Shortest and longest hold, sampling intervals.
const SHORTEST: f64 = 0.18;
const LONGEST: f64 = 2.6;
/// Slowest motion, counts per interval.
const FAST: f64 = 5.0;
/// Moves that a record must show.
const FEWEST_MOVES: usize = 60;
/// Mean square of what two countings leave of a move, counts^2; held readings leave so many times more at least.
const COUNTING: f64 = 1.0 / 6.0;
const ABOVE_COUNTING: f64 = 3.0;
/// Of fast moves, more than this share stand still where a hold is longer than that.
const STILL: f64 = 0.7;
/// Of what is beyond counting, a hold leaves less than this share; a first guess from few moves, less than that.
const LEFT: f64 = 0.15;
const LEFT_AT_FIRST: f64 = 0.4;
/// Moves that the first guess is made from.
const FIRST: usize = 96;
/// A beat's first harmonic explains this share of the excess at least; of the tallest peak, that share makes another.
const FIRST_HARMONIC: f64 = 0.22;
const PEAK: f64 = 0.6;
/// Most peaks that are tried: even stamps show one and the same beat at every multiple of their rate.
const PEAKS: usize = 12;
/// A beat of fewer cycles per sample shows in single skips.
const RARE: f64 = 1.0 / 7.0;
/// Fewest skips that date each other; most are of one size to within this share, and make up that share of all excess.
const FEWEST_SKIPS: usize = 4;
const ONE_SIZE: f64 = 0.35;
const MOST_EXCESS: f64 = 0.5;
/// Where the hold is known, motion of this many counts per interval tells the age.
const SLOW: f64 = 1.0;

/// What the readings of a record say of a hold.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Shown {
    /// They move as they should, or too slowly to tell.
    Nothing,
    /// They do not move as they should, and a hold does not explain it.
    Otherwise,
    /// They are held.
    Held(Hold),
}

/// What the readings `values` at `time_s`, counted in steps of `count`, say of a hold; or of that of `known` seconds.
pub fn beat(time_s: &[f64], values: &[f64], count: f64, known: Option<f64>) -> Shown {
    let moves = moves(time_s, values, count, FAST, EVEN);
    let before = excess(&moves);
    let counting = COUNTING * moves.len() as f64;
    let still = moves.iter().filter(|m| m.by == 0.0).count() as f64;
    if moves.len() < FEWEST_MOVES || before < ABOVE_COUNTING * counting {
        return Shown::Nothing;
    }
    let interval = mean_interval(time_s);
    let found = match known {
        Some(hold_s) => {
            let age = age(time_s, values, count, hold_s);
            Some(settle(&moves, Updates { rate: 1.0 / hold_s, age }, interval))
        }
        None if still > STILL * moves.len() as f64 => None,
        None => lock(&moves, &moves, [1.0 / LONGEST, 1.0 / SHORTEST].map(|x| x / interval), interval)
            .or_else(|| {
                let (skips, band) = skips(&moves, interval)?;
                lock(&skips, &moves, band, interval)
            }),
    };
    let explained = |left: f64| left - counting < LEFT * (before - counting);
    match found.filter(|(_, left)| explained(*left)) {
        None => Shown::Otherwise,
        Some((updates, _)) => {
            let time_s = 1.0 / updates.rate;
            Shown::Held(Hold { time_s, age_s: updates.age.rem_euclid(time_s), changes: moves.len() })
        }
    }
}

/// Whether a hold of `hold_s` is short enough for its beat with the samples at `time_s` to tell.
pub fn tells(time_s: &[f64], hold_s: f64) -> bool {
    hold_s < LONGEST * mean_interval(time_s)
}

/// The age of the first reading where the hold is known to be `hold_s`, s.
pub fn age(time_s: &[f64], values: &[f64], count: f64, hold_s: f64) -> f64 {
    let moves = thinned(&moves(time_s, values, count, SLOW, EVEN));
    if moves.is_empty() { 0.0 } else { likely_age(&moves, 1.0 / hold_s, mean_interval(time_s)) }
}

/// Single moves that stand out, and the rates that they leave open: about every so many moves one has an update more, or
/// less, than all others.
fn skips(moves: &[Move], interval: f64) -> Option<(Vec<Move>, [f64; 2])> {
    let late = |m: &Move| m.excess / (m.speed * interval);
    let mut sizes: Vec<f64> = moves.iter().map(|m| late(m).abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let large = 0.5 * sizes[sizes.len() - FEWEST_SKIPS];
    let skips: Vec<Move> = moves.iter().filter(|m| late(m).abs() > large).copied().collect();
    let mean = skips.iter().map(late).sum::<f64>() / skips.len() as f64;
    let alike = skips.iter().filter(|m| (late(m) - mean).abs() < ONE_SIZE * mean.abs()).count();
    // A skip is also part of the speed around it.
    let around = (2 * AROUND + 1) as f64;
    let hold = around * mean / (around - 1.0 - mean);
    let whole = (1.0 / hold.abs()).round();
    let few = (skips.len() as f64) < 1.2 * RARE * moves.len() as f64;
    let clear = 4 * alike > 3 * skips.len() && excess(&skips) > MOST_EXCESS * excess(moves);
    (few && clear && whole * SHORTEST < 1.0).then(|| {
        let other = whole + RARE * hold.signum();
        (skips, [whole.min(other) / interval, whole.max(other) / interval])
    })
}

/// The updates at rates within `band` that leave least of `moves`, told by the beat of `telling`; and what they leave.
fn lock(telling: &[Move], moves: &[Move], band: [f64; 2], interval: f64) -> Option<(Updates, f64)> {
    let width = FIRST.min(telling.len());
    let spans = |first: &usize| span(&telling[*first..*first + width]);
    let first = (0..=telling.len() - width).min_by(|a, b| spans(a).total_cmp(&spans(b)))?;
    let (mut from, mut to) = (first, first + width);
    let mut known = span(&telling[from..to]);
    let mut rate = first_rate(&telling[from..to], moves, band, interval)?;
    while to - from < telling.len() {
        let half = (to - from) / 2;
        (from, to) = (from.saturating_sub(half), (to + half).min(telling.len()));
        let whole = span(&telling[from..to]);
        rate = sharpen(&thinned(&telling[from..to]), rate, 0.3 / known, 0.1 / whole).rate;
        known = whole;
    }
    let updates = sharpen(&thinned(telling), rate, 0.2 / known, 0.05 / known);
    Some(settle(moves, updates, interval))
}

/// The rate within `band` that explains the few moves of `window` best.
fn first_rate(window: &[Move], moves: &[Move], band: [f64; 2], interval: f64) -> Option<f64> {
    let begin = moves.partition_point(|m| m.from < window[0].from);
    let end = moves.partition_point(|m| m.to <= window[window.len() - 1].to);
    let judges = &moves[begin..end];
    let spacing = 0.2 / span(window);
    let mut found = beats(window, band[0], spacing, ((band[1] - band[0]) / spacing) as usize + 1);
    // Less than half a beat is no beat.
    let slow = 0.5 * interval / span(window);
    found.iter_mut().filter(|b| beat_of(b.updates.rate * interval) < slow).for_each(|b| b.power = 0.0);
    let tallest = found.iter().map(|b| b.power).fold(0.0, f64::max);
    if 2.0 * tallest < FIRST_HARMONIC * excess(window) {
        return None;
    }
    let peak =
        |b: &&[Beat]| b[1].power >= PEAK * tallest && b[1].power >= b[0].power && b[1].power >= b[2].power;
    let mut peaks: Vec<&Beat> = found.windows(3).filter(peak).map(|b| &b[1]).collect();
    peaks.sort_unstable_by(|a, b| b.power.total_cmp(&a.power));
    let near = |b: &Beat| {
        let updates = sharpen(window, b.updates.rate, spacing, 0.1 * spacing);
        settle(judges, updates, interval)
    };
    let best = peaks.into_iter().take(PEAKS).map(near).min_by(|a, b| a.1.total_cmp(&b.1))?;
    (best.1 < LEFT_AT_FIRST * excess(judges)).then_some(best.0.rate)
}

#[cfg(test)]
mod tests;
