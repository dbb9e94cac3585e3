//! Many garbled readings: some stand beside each other then, and their steps lie beside those of the motion.
//!
//! So a reading is held against the median of those around it, which up to three garbled ones of seven hardly move (the Hampel identifier;
//! R. K. Pearson, *IEEE Trans. Control Syst. Technol.* 10, 2002). How far readings of a motion are off from it forms a continuum; garbled
//! ones lie beyond a gap that is nearly empty.

use super::motion::{peak, span};
use super::repair::APART;
use super::sentinels::FEW_COUNTS;
use super::timing::quantile;

/// Readings to either side that make the median.
const REACH: usize = 3;
/// Fewer than these are few, and have rules of their own.
const FEWEST: usize = 10;
/// The garbled ones are no more than this share, and what lies in the gap below them is no more than that share of theirs.
const MOST: f64 = 0.2;
const IN_GAP: f64 = 0.05;
/// So much of an angle is not beside any of them.
const UNTOUCHED: f64 = 0.2;
/// Half of the garbled speeds are so many times as fast as nearly all others, ...
const FASTER: f64 = 1.2;
const NEARLY_ALL: f64 = 0.99;
/// ... and half of them come without a change of the voltage of this share of the highest, which a blip of the motor has.
const CHANGE: f64 = 0.3;

/// The samples of an angle that are garbled, where many are: no step of the others is nearly as far.
pub(super) fn many_angles(angle: &[f64]) -> Vec<usize> {
    let Some(Beyond { off, samples, smallest }) = Beyond::of(angle) else { return Vec::new() };
    let mut is_near = vec![false; angle.len()];
    samples.iter().for_each(|k| is_near[around(angle.len(), *k)].fill(true));
    let untouched = (1..angle.len()).filter(|k| !is_near[*k] && !is_near[k - 1]);
    let steps: Vec<f64> = untouched.map(|k| angle[k] - angle[k - 1]).collect();
    let far = APART * peak(&steps) + FEW_COUNTS * smallest;
    let garbled: Vec<usize> = samples.into_iter().filter(|k| off[*k] > far).collect();
    let is_sure = garbled.len() >= FEWEST && steps.len() as f64 >= UNTOUCHED * angle.len() as f64;
    if is_sure { garbled } else { Vec::new() }
}

/// The samples of a speed that are garbled, where many are: most are faster than the motor goes, and come at any time.
pub(super) fn many_speeds(speed: &[f64], volts: &[f64]) -> Vec<usize> {
    let Some(Beyond { samples, .. }) = Beyond::of(speed) else { return Vec::new() };
    let others = (0..speed.len()).filter(|k| samples.binary_search(k).is_err());
    let usual = quantile(&mut others.map(|k| speed[k].abs()).collect::<Vec<f64>>(), NEARLY_ALL);
    let faster = samples.iter().filter(|k| speed[**k].abs() > FASTER * usual).count();
    let highest = peak(volts);
    let before = |k: usize| &volts[k.saturating_sub(REACH)..(k + 2).min(volts.len())];
    let unprovoked = samples.iter().filter(|k| span(before(**k)) <= CHANGE * highest).count();
    if 2 * faster >= samples.len() && 2 * unprovoked >= samples.len() { samples } else { Vec::new() }
}

/// Readings beyond a gap.
struct Beyond {
    /// How far each reading is off the median around it.
    off: Vec<f64>,
    /// Those beyond, in order.
    samples: Vec<usize>,
    /// The smallest step of all.
    smallest: f64,
}

impl Beyond {
    /// Of `values`, [`FEWEST`] or more; none where there is no such gap.
    fn of(values: &[f64]) -> Option<Self> {
        let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs()).filter(|step| *step > 0.0);
        let smallest = steps.fold(f64::INFINITY, f64::min);
        if !smallest.is_finite() {
            return None;
        }
        let off: Vec<f64> = (0..values.len()).map(|k| (values[k] - median_around(values, k)).abs()).collect();
        let mut furthest = off.clone();
        let first = ((1.0 - MOST) * off.len() as f64) as usize;
        furthest.select_nth_unstable_by(first, f64::total_cmp);
        let furthest = &mut furthest[first..];
        furthest.sort_unstable_by(f64::total_cmp);
        let beyond = |k: usize| APART * furthest[k] + FEW_COUNTS * smallest;
        let limit = (0..furthest.len()).find_map(|k| {
            let place = furthest.partition_point(|off| *off <= beyond(k));
            let garbled = furthest.len() - place;
            let in_gap = place - k - 1;
            (garbled < FEWEST || in_gap as f64 <= IN_GAP * garbled as f64).then_some((beyond(k), garbled))
        });
        let (limit, _) = limit.filter(|(_, garbled)| *garbled >= FEWEST)?;
        let samples = (0..off.len()).filter(|k| off[*k] > limit).collect();
        Some(Self { off, samples, smallest })
    }
}

/// The samples whose median stands for that of sample `k` of so many.
fn around(count: usize, k: usize) -> std::ops::Range<usize> {
    k.saturating_sub(REACH)..(k + REACH + 1).min(count)
}

/// The median of the readings around sample `k`, the upper of two.
fn median_around(values: &[f64], k: usize) -> f64 {
    let mut window = [0.0; 2 * REACH + 1];
    let seen = &values[around(values.len(), k)];
    let window = &mut window[..seen.len()];
    window.copy_from_slice(seen);
    window.sort_unstable_by(f64::total_cmp);
    window[seen.len() / 2]
}

#[cfg(test)]
mod tests {
    use super::super::repair::repaired;
    use super::super::repair::tests::{moving, swing};
    use super::*;

    /// Numbers without an order, 0 to 1.
    fn random(k: usize) -> f64 {
        ((k as f64 * 12.9898).sin() * 43_758.545).rem_euclid(1.0)
    }

    /// Every thirteenth sample or so, some beside each other.
    fn is_garbled(k: usize) -> bool {
        k > 3 && k < 790 && random(k) < 0.08
    }

    fn error(k: usize) -> f64 {
        let size = 40.0 + 60.0 * random(k + 5000);
        if random(k + 9000) < 0.5 { size } else { -size }
    }

    #[test]
    fn many_garbled_angles_of_any_size_are_left_out_beside_each_other_too() {
        let mut record = moving(swing);
        record.angle_rad.iter_mut().for_each(|angle| {
            (0..800).filter(|k| is_garbled(*k)).for_each(|k| angle[k] += error(k));
        });
        let garbled = (0..800).filter(|k| is_garbled(*k)).count();
        let parts = repaired(record);
        assert_eq!((parts.len(), parts[0].len()), (1, 800 - garbled));
        assert!(
            parts[0].warnings[0].what.contains(&format!("{garbled} readings")),
            "{:?}",
            parts[0].warnings
        );
    }

    #[test]
    fn many_garbled_speeds_are_left_out_and_what_pulses_of_the_drive_make_is_not() {
        let speed = |garbled: bool| -> Vec<f64> {
            let swing = |k: usize| 20.0 * (0.0085 * k as f64).cos() + 0.05 * random(k);
            (0..800).map(|k| swing(k) + if garbled && is_garbled(k) { error(k) } else { 0.0 }).collect()
        };
        let steady = vec![4.0; 800];
        let garbled: Vec<usize> = (0..800).filter(|k| is_garbled(*k)).collect();
        assert_eq!(many_speeds(&speed(true), &steady), garbled);
        assert!(many_speeds(&speed(false), &steady).is_empty());
        let pulses: Vec<f64> = (0..800).map(|k| if is_garbled(k) { 12.0 } else { 0.0 }).collect();
        let blips: Vec<f64> = pulses.iter().map(|v| 3.0 * v).collect();
        assert!(many_speeds(&blips, &pulses).is_empty());
    }
}
