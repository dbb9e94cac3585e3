//! Angles that wrap at a turn or at the width of a counter, unwrapped.

use std::f64::consts::TAU;

use super::dropouts::LONGEST_SPIKE;
use super::motion::ends;
use super::quantum::quantum;
use super::repair::{APART, far_steps};
use super::suspicion::place_of;
use super::units::{Quantity, Unit};
use super::{Record, Warning};

/// Readings of a wrapped angle come this near to both ends of its turn, in shares of it,
const FILLED: f64 = 0.05;
/// cross it so often,
const FEWEST_WRAPS: usize = 3;
/// and leave so little of the change of their steps once they are unwrapped,
const SMOOTHER: f64 = 0.2;
/// none of which is much further than the others: by more than so many counts.
const FEW_COUNTS: f64 = 4.0;

/// A wrapped angle: its full turn in its unit, and the steps at which it wraps.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Wrapped {
    turn: f64,
    steps: Vec<usize>,
}

/// Whether, and how, an angle wraps.
pub(super) fn wrapped(angle: &[f64]) -> Option<Wrapped> {
    let apart = || Some(Wrapped { turn: modulus(angle)?, steps: far_steps(angle) });
    apart().or_else(|| within_a_turn(angle))
}

/// The number at which an angle wraps, if it does.
pub(super) fn turn_of(angle: &[f64]) -> Option<f64> {
    (angle.len() > 1).then(|| wrapped(angle)).flatten().map(|wrapped| wrapped.turn)
}

/// A motion of up to half a turn between two samples hides its wraps among its steps. Where the readings fill a usual turn from its begin
/// to its end and never leave it, steps of more than half of it are wraps if the motion is much smoother without them.
fn within_a_turn(angle: &[f64]) -> Option<Wrapped> {
    let (low, high) = ends(angle);
    let count = quantum(angle).filter(|count| *count > 0.0);
    let bits = count.map(|count| count * ((high - low) / count).log2().ceil().exp2());
    let turn = [TAU, 360.0, 1.0].into_iter().chain(bits).find(|turn| {
        // Turned round by the mapping, an angle of 0 to 360 degrees begins at -360.
        let begins = [0.0, -0.5 * turn, -turn]
            .into_iter()
            .any(|begin| (low - begin).abs() < FILLED * turn && low >= begin - 1e-6 * turn);
        begins && high - low <= turn * (1.0 + 1e-9) && high - low > (1.0 - FILLED) * turn
    })?;
    let step = |k: usize| angle[k + 1] - angle[k];
    let steps: Vec<usize> = (0..angle.len() - 1).filter(|&k| step(k).abs() > 0.5 * turn).collect();
    let short = |k: usize| step(k) - turn * (step(k) / turn).round();
    let roughness = |step: &dyn Fn(usize) -> f64| -> f64 {
        (1..angle.len() - 1).map(|k| (step(k) - step(k - 1)).powi(2)).sum()
    };
    let is_smoother = roughness(&short) < SMOOTHER * roughness(&step);
    // A number at the end of a type that stands for no reading goes there from anywhere, and back: unwrapped it still stands alone. A pause, in
    // which the motor turned on, is one such step.
    let usual = (0..angle.len() - 1).filter(|k| step(*k).abs() <= 0.5 * turn).map(|k| short(k).abs());
    let furthest = APART * usual.fold(0.0, f64::max) + FEW_COUNTS * count.unwrap_or(0.0);
    let odd: Vec<usize> = steps.iter().copied().filter(|k| short(*k).abs() > furthest).collect();
    let is_motion = odd.windows(2).all(|pair| pair[1] - pair[0] > LONGEST_SPIKE);
    (steps.len() >= FEWEST_WRAPS && is_smoother && is_motion).then_some(Wrapped { turn, steps })
}

/// The full turn of a wrapped angle, in its unit: all its jumps have this size, and its values span no more.
fn modulus(angle: &[f64]) -> Option<f64> {
    let far = far_steps(angle);
    let step = |k: usize| angle.get(k + 1).zip(angle.get(k)).map_or(0.0, |(b, a)| b - a);
    // The motion goes on while the counter wraps.
    let around = |k: usize| 0.5 * (k.checked_sub(1).map_or(0.0, step) + step(k + 1));
    let mut sizes: Vec<f64> = far.iter().map(|&k| (step(k) - around(k)).abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let size = *sizes.get(sizes.len() / 2)?;
    let motion = (0..angle.len() - 1)
        .filter(|k| far.binary_search(k).is_err())
        .map(|k| step(k).abs())
        .fold(0.0, f64::max);
    let (low, high) = ends(angle);
    let same = |size: f64| sizes.iter().all(|s| (s - size).abs() < motion + 0.01 * size);
    // The motion always goes on in the direction opposite to the jump.
    let onwards = far.iter().filter(|&&k| step(k) * around(k) <= 0.0).count();
    let spans = |size: f64| high - low < 1.01 * size && high - low > size - 2.0 * motion - 0.01 * size;
    if !same(size) || onwards < far.len() || !spans(size) {
        return None;
    }
    // A turn in radians, degrees or revolutions, or a whole number of bits of the counter.
    let count = quantum(angle);
    let bits = count.map(|count| count * (size / count).log2().round().exp2());
    let turns = [TAU, 360.0, 1.0, TAU * 360.0, TAU * TAU];
    let known =
        turns.into_iter().chain(bits).filter(|m| (m / size - 1.0).abs() < 0.02 && spans(*m) && same(*m));
    let known = known.min_by(|a, b| (a - size).abs().total_cmp(&(b - size).abs()));
    known.or((far.len() >= 3).then_some(size))
}

/// Unwraps the angle of `record` where it wraps, and says so.
pub(super) fn unwrap_angle(record: &mut Record) {
    let Some(angle) = &mut record.angle_rad else { return };
    let Some(Wrapped { turn, steps: far }) = wrapped(angle) else { return };
    let (mut offset, mut next) = (0.0, 0);
    for k in 0..angle.len() {
        let jumped = k > 0 && far.get(next) == Some(&(k - 1));
        if jumped {
            // The value before carries the offset already.
            offset -= turn * (angle[k] + offset - angle[k - 1]).signum();
            next += 1;
        }
        angle[k] += offset;
    }
    // In the unit that was mapped; where none was, it may be another one than the radian.
    let (turn, asked) = match written_turn(record, turn) {
        Some(told) => (told, ""),
        None => (format!("{turn:.6} rad"), "; if the unit is not the radian, say so with --map"),
    };
    record.warnings.push(Warning {
        place: place_of(record, "angle_rad"),
        what: format!("wrapped_angle: the angle wraps at {turn}, {} times, and was unwrapped", far.len()),
        fix: format!("log the angle unwrapped, if the motor can make more than half a turn of it between two samples{asked}"),
    });
}

/// So many radians in the unit that the angle of `record` was mapped in.
fn written_turn(record: &Record, turn: f64) -> Option<String> {
    let written = &record.source(Quantity::Angle)?.written;
    let unit = Unit::parse(Quantity::Angle, written).ok().filter(|_| !written.is_empty())?;
    let per_turn = match unit.per_turn {
        Some(per_turn) => record.meta.one_turn(per_turn)?,
        None => 1.0,
    };
    let number = format!("{:.4}", turn / unit.factor.abs() * per_turn);
    Some(format!("{} {written}", number.trim_end_matches('0').trim_end_matches('.')))
}

#[cfg(test)]
mod tests {
    use super::super::repair::tests::{moving, swing};
    use super::*;

    #[test]
    fn a_wrap_is_told_in_the_unit_that_the_angle_was_mapped_in() {
        for (map, told) in [
            ("", "wraps at 6.283185 rad, "),
            ("angle=a:deg", "wraps at 360 deg, "),
            ("angle=a:rev*-1", "wraps at 1 rev*-1, "),
            ("angle=a:counts", "wraps at 4096 counts, "),
        ] {
            let mut record = moving(|t| swing(t).rem_euclid(TAU));
            record.map = map.parse().ok().filter(|_| !map.is_empty());
            record.meta.insert("counts_per_rev", "4096").unwrap();
            unwrap_angle(&mut record);
            let Warning { what, fix, .. } = &record.warnings[0];
            assert!(what.contains(told) && fix.contains("radian") == map.is_empty(), "{what} {fix}");
        }
    }
}
