//! Two numbers for what was not read in one column, 65535 and -1: each hides the other from the rules for one of them.
//!
//! Both stand at an end of the column. Without them its steps are those of the motion, which tell that neither is a reading, however
//! seldom it comes; and once one of them is left out, the rest is looked at again. A long run of one number lies between two jumps.

use std::borrow::Cow;
use std::ops::Range;

use super::dropouts::LONGEST_SPIKE;
use super::motion::{ends, peak};
use super::repair::APART;

/// A column is looked at so often at most.
const PASSES: usize = 4;
/// No reading is off by fewer than so many of the smallest steps.
pub(super) const FEW_COUNTS: f64 = 4.0;
/// Where more than this share of the column would be no reading, its ends belong to it.
pub(super) const MOST: f64 = 0.4;

/// What `find` finds among `count` samples, and again among those that it leaves: it is told which pass it is, from 0, and the samples
/// that are left, and gives places among these in order.
pub(super) fn in_passes(count: usize, find: impl Fn(usize, &[usize]) -> Vec<usize>) -> Vec<usize> {
    let mut kept: Vec<usize> = (0..count).collect();
    let mut out = Vec::new();
    for pass in 0..PASSES {
        let found = find(pass, &kept);
        if found.is_empty() {
            break;
        }
        out.extend(found.iter().map(|place| kept[*place]));
        let mut place = 0;
        kept.retain(|_| {
            place += 1;
            found.binary_search(&(place - 1)).is_err()
        });
    }
    out.sort_unstable();
    out
}

/// The `values` at these samples, each of which comes once: not copied where they are all, as in the first pass.
pub(super) fn picked<'a>(values: &'a [f64], samples: &[usize]) -> Cow<'a, [f64]> {
    if samples.len() == values.len() {
        return Cow::Borrowed(values);
    }
    samples.iter().map(|k| values[*k]).collect()
}

/// The samples at the lowest or the highest number of all that no step of the others explains, and that lie beyond so many times all
/// others. Zeros have a rule of their own.
pub(super) fn at_the_ends(values: &[f64], beyond: f64) -> Vec<usize> {
    let (low, high) = ends(values);
    let is_end = |value: f64| value != 0.0 && (value == low || value == high);
    let (mut runs, mut is_in_run) = (Vec::new(), vec![false; values.len()]);
    let mut k = 1;
    while k < values.len() {
        let long = values[k..].iter().take_while(|value| is_end(**value)).count();
        let is_between = !is_end(values[k - 1]) && k + long < values.len();
        if is_between && (1..=LONGEST_SPIKE).contains(&long) {
            is_in_run[k..k + long].fill(true);
            runs.push(k..k + long);
        }
        k += long.max(1);
    }
    let others: Vec<f64> = (0..values.len()).filter(|k| !is_in_run[*k]).map(|k| values[k]).collect();
    let (mut furthest, mut smallest) = (0.0_f64, f64::INFINITY);
    for (k, pair) in values.windows(2).enumerate() {
        let step = (pair[1] - pair[0]).abs();
        if step > 0.0 && !is_in_run[k] && !is_in_run[k + 1] {
            (furthest, smallest) = (furthest.max(step), smallest.min(step));
        }
    }
    let (far, fastest) = (APART * furthest + FEW_COUNTS * smallest, beyond * peak(&others));
    let is_none = |run: &Range<usize>| {
        let (before, after) = (values[run.start - 1], values[run.end]);
        values[run.clone()]
            .iter()
            .all(|value| value.abs() > fastest && (value - before).abs() > far && (value - after).abs() > far)
    };
    let found: Vec<usize> = runs.into_iter().filter(is_none).flatten().collect();
    if found.len() as f64 > MOST * values.len() as f64 { Vec::new() } else { found }
}

/// Of the jump to a number for nothing more than this share is undone by the jump back.
const UNDONE: f64 = 0.5;

/// The samples between two `jumps` (from sample k to k + 1, in order) at which an angle stands at one number, and goes on from about where it was:
/// nothing was read there. A counter that was reset stays where it was set to.
pub(super) fn between_jumps(angle: &[f64], jumps: &[usize]) -> Vec<Range<usize>> {
    let is_none = |pair: &&[usize]| {
        let run = &angle[pair[0] + 1..=pair[1]];
        let (before, number, after) = (angle[pair[0]], run[0], angle[pair[1] + 1]);
        run.iter().all(|value| *value == number)
            && (after - before).abs() < (1.0 - UNDONE) * (number - before).abs()
    };
    jumps.windows(2).filter(is_none).map(|pair| pair[0] + 1..pair[1] + 1).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Record;
    use super::super::repair::repaired;
    use super::super::repair::tests::{moving, swing};
    use super::*;

    #[test]
    fn two_numbers_for_nothing_are_left_out_however_they_come() {
        // Beside each other, by themselves, one of them once, and a zero once beside the largest number of 32 bits.
        let high_then_low = |k: usize| match k % 40 {
            7 => Some(65_535.0),
            9 => Some(-1.0),
            _ => None,
        };
        let once = |k: usize| match (k % 40, k) {
            (7, _) => Some(65_535.0),
            (_, 411) => Some(-1.0),
            _ => None,
        };
        let with_zero = |k: usize| match (k % 40, k) {
            (7, _) => Some(4_294_967_295.0),
            (_, 411) => Some(0.0),
            _ => None,
        };
        for odd in [&high_then_low as &dyn Fn(usize) -> Option<f64>, &once, &with_zero] {
            let mut record = moving(|t| 2000.0 + (50.0 * swing(t)).round());
            let angle = record.angle_rad.as_mut().unwrap();
            let out: Vec<usize> = (0..angle.len()).filter(|k| odd(*k).is_some()).collect();
            out.iter().for_each(|k| angle[*k] = odd(*k).unwrap());
            let parts = repaired(record);
            assert_eq!((parts.len(), parts[0].len()), (1, 800 - out.len()), "{:?}", parts[0].warnings);
        }
    }

    #[test]
    fn long_runs_of_a_number_for_nothing_are_no_record_of_a_motor_that_stands() {
        for number in [65_535.0, -1.0] {
            let mut record = moving(|t| 30_000.0 + (50.0 * swing(t)).round());
            let angle = record.angle_rad.as_mut().unwrap();
            angle[300..350].fill(number);
            angle[600..612].fill(number);
            let parts = repaired(record.clone());
            assert_eq!(parts.iter().map(Record::len).collect::<Vec<_>>(), [300, 250, 188], "{number}");
            let said: Vec<&str> = parts[0].warnings.iter().map(|warning| warning.what.as_str()).collect();
            assert!(said.len() == 1 && said[0].starts_with("garbled_readings: "), "{said:?}");
            assert!(said[0].contains("2 times, from sample 301 (1.500 s), sample 601 (3.000 s)"), "{said:?}");
            // A counter that is set to another number once, while the motor stands, is reset.
            let stays = record.angle_rad.as_mut().unwrap();
            stays[350..].iter_mut().for_each(|x| *x += 60_000.0);
            assert!(
                repaired(record)
                    .iter()
                    .any(|part| part.warnings.iter().any(|w| w.what.starts_with("lost_counts")))
            );
        }
    }

    #[test]
    fn a_column_is_copied_only_where_a_part_of_it_is_kept() {
        let column = [3.0, 1.0, 2.0];
        assert!(matches!(picked(&column, &[0, 1, 2]), Cow::Borrowed(_)));
        assert_eq!(*picked(&column, &[0, 2]), [3.0, 2.0]);
    }

    #[test]
    fn the_ends_of_a_motion_are_no_numbers_for_nothing() {
        let angle = moving(swing).angle_rad.unwrap();
        assert!(at_the_ends(&angle, 0.0).is_empty());
        let counts: Vec<f64> = angle.iter().map(|x| (x / 8.0).round()).collect();
        assert!(at_the_ends(&counts, 0.0).is_empty(), "an encoder of few counts");
        // A shaft that stands and is touched once; pulses of a coarse speed that are all alike.
        let touched: Vec<f64> = (0..200).map(|k| if k == 90 { 6.0 } else { 5.0 }).collect();
        assert!(at_the_ends(&touched, 0.0).is_empty());
        let pulses: Vec<f64> = (0..200).map(|k| if k % 2 == 0 { 9.0 } else { f64::from(k % 3) }).collect();
        assert!(at_the_ends(&pulses, 3.0).is_empty());
    }
}
