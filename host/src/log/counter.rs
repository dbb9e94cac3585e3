//! A counter of 16 or 32 bits that goes on where it begins anew, though it does so too seldom for its course to tell.

use super::choice::Wanted;
use super::motion::ends;
use super::units::{PerTurn, Quantity};
use super::wraps;

/// Widths of counters.
const WIDTHS: [f64; 2] = [65_536.0, 4_294_967_296.0];
/// A motion between two rows is a smaller share of the width,
const SLOW: f64 = 0.25;
/// and the one across the end of the counter is no more than this many times the longest of the others.
const ALIKE: f64 = 2.0;

/// Lets an angle in counts go on across the ends of its counter; tells the width and how often it was crossed. What wraps often is left to
/// [`wraps`], which knows all units.
pub(super) fn go_on(column: &Wanted, values: &mut [f64]) -> Option<(f64, usize)> {
    let unit = column.unit;
    if column.quantity != Quantity::Angle || unit.per_turn != Some(PerTurn::Counts) {
        return None;
    }
    let counts: Vec<f64> = values.iter().map(|value| (value / unit.factor + unit.zero).round()).collect();
    let (low, high) = ends(&counts);
    let is_of = |width: &f64| {
        let is_within = low >= 0.0 && high < *width || low >= -0.5 * width && high < 0.5 * width;
        is_within && wraps_at(*width, &counts)
    };
    let width = WIDTHS.into_iter().find(is_of).filter(|_| wraps::turn_of(values).is_none())?;
    let (mut added, mut times) = (0.0, 0);
    for k in 1..counts.len() {
        let step = counts[k] - counts[k - 1];
        if step.abs() > 0.5 * width {
            added -= width * step.signum();
            times += 1;
        }
        values[k] += added * unit.factor;
    }
    Some((width, times))
}

/// Whether the steps of more than half of the width are motions like the others across its end.
fn wraps_at(width: f64, counts: &[f64]) -> bool {
    let steps = counts.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let (far, near): (Vec<f64>, Vec<f64>) = steps.partition(|step| *step > 0.5 * width);
    let longest = near.into_iter().fold(0.0, f64::max);
    !far.is_empty() && longest < SLOW * width && far.iter().all(|step| width - step <= ALIKE * longest)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_over_the_end_of_a_counter_is_told_from_a_reset_and_a_far_motion() {
        for (width, counts, wraps) in [
            (WIDTHS[0], vec![65_480.0, 65_510.0, 10.0, 35.0], true),
            (WIDTHS[1], vec![20.0, 5.0, 4_294_967_291.0, 4_294_967_280.0], true),
            (WIDTHS[1], vec![2_147_483_600.0, 2_147_483_640.0, -2_147_483_610.0], true),
            (WIDTHS[0], vec![40_000.0, 40_030.0, 0.0, 30.0], false),
            (WIDTHS[0], vec![0.0, 40_000.0, 30_000.0, 0.0], false),
        ] {
            assert_eq!(wraps_at(width, &counts), wraps, "{counts:?}");
        }
    }
}
