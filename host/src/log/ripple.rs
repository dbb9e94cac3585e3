//! Whether a motor answers to each step of a voltage that is updated regularly.
//!
//! A voltage in steps is a smooth course and a sawtooth on top, one tooth an update. Where the drive itself holds the voltage, the
//! shaft follows the teeth as a first-order motor does, `tau w' + w = gain v`, a little late perhaps; where only the log holds it,
//! they drove nothing. So the angle is compared with the answer to the teeth alone, both freed of what is slower than a tooth by
//! taking off their mean over one update, twice: it holds none of the teeth, and all of the rest but its fourth derivative.

use super::weak::Regression;

/// What the motion shows of the teeth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Answer {
    /// Share of the teeth's answer that is in the motion, at the lateness where that is largest: near 1, or near 0.
    pub share: f64,
    /// Its standard deviation, with an update for a sample.
    pub deviation: f64,
}

/// Teeth at either end of the steps that are left out of the comparison.
const MARGIN: usize = 3;
/// Teeth that are compared, from the first on, and latenesses within one that are tried.
const MOST_TEETH: usize = 2000;
const LATENESSES: usize = 32;

/// The answer of `angle` to the teeth of `volts`, which change at the rows `changes`, most of them `hold` rows after the one before;
/// rows are `interval` s apart and `motor` is what a regression makes of them.
pub(super) fn answer(
    angle: &[f64],
    volts: &[f64],
    changes: &[usize],
    hold: usize,
    interval: f64,
    motor: Regression,
) -> Option<Answer> {
    let (first, last) = (*changes.first()?, *changes.last()?);
    let from = first + MARGIN * hold;
    let to = last.checked_sub(MARGIN * hold)?.min(from + MOST_TEETH * hold);
    if to < from + 2 * hold {
        return None;
    }
    // The smooth course goes through the middles of the steps.
    let middle = |pair: &[usize]| 0.5 * (pair[0] + pair[1] - 1) as f64;
    let mut teeth = vec![0.0; volts.len()];
    for three in changes.windows(3) {
        let (before, after) = (middle(&three[..2]), middle(&three[1..]));
        let (low, high) = (volts[three[0]], volts[three[1]]);
        for k in before.ceil() as usize..=after.floor() as usize {
            let part = (k as f64 - before) / (after - before);
            teeth[k] = volts[k] - (low + part * (high - low));
        }
    }
    let tau = if motor.tau_s > 0.0 { motor.tau_s } else { 0.25 * hold as f64 * interval };
    let share = 1.0 - (-interval / tau).exp();
    let (mut speed, mut turned) = (0.0, 0.0);
    let follows = teeth.iter().map(|v| {
        let now = turned;
        let next = speed + share * (motor.gain * v - speed);
        turned += 0.5 * (speed + next) * interval;
        speed = next;
        now
    });
    let predicted = freed(&freed(&follows.collect::<Vec<_>>(), hold), hold);
    let measured = freed(&freed(angle, hold), hold);
    let late = |rows: usize| {
        let (y, p) = (&measured[from + rows..to], &predicted[from..to - rows]);
        let sum = |of: &dyn Fn(f64, f64) -> f64| y.iter().zip(p).map(|(y, p)| of(*y, *p)).sum::<f64>();
        let size = sum(&|_, p| p * p);
        let share = sum(&|y, p| y * p) / size;
        let left = sum(&|y, p| (y - share * p).powi(2));
        let teeth = y.len() as f64 / hold as f64;
        (size > 0.0).then(|| Answer { share, deviation: (left / size / teeth).sqrt() })
    };
    (0..=hold).step_by(hold.div_ceil(LATENESSES)).filter_map(late).max_by(|a, b| a.share.total_cmp(&b.share))
}

/// `values` without their mean over about `hold` rows around each.
fn freed(values: &[f64], hold: usize) -> Vec<f64> {
    let mut sums = vec![0.0];
    // Sums of what the first value is taken off of, which a large angle would not drown.
    let origin = values.first().copied().unwrap_or_default();
    values.iter().for_each(|v| sums.push(sums[sums.len() - 1] + v - origin));
    let (back, forth) = (hold / 2, hold - hold / 2);
    (0..values.len())
        .map(|k| {
            let (from, to) = (k.saturating_sub(back), (k + forth).min(values.len()));
            values[k] - origin - (sums[to] - sums[from]) / (to - from) as f64
        })
        .collect()
}
