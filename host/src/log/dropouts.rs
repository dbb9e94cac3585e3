//! Readings of zero, or of another number that stands for none, in the midst of motion: nothing was read there.
//!
//! No inertia lets a shaft stop and go on as fast within a reading or three. What it does allow is told by the steps between all other
//! readings: by the furthest of them where its drive may have stopped it, by the usual ones where the drive held on.

use std::collections::BTreeMap;
use std::ops::Range;

use super::motion::peak;
use super::repair::APART;
use super::timing::quantile;

/// A garbled reading returns within so many samples.
pub(super) const LONGEST_SPIKE: usize = 3;
/// The usual steps are those but for this share of them: scatter, and readings that are wrong otherwise, are among the rest.
const USUAL: f64 = 0.9;
/// What the usual steps do not allow has this share of the usual speeds: a slow shaft that sticks stops and goes on by itself ...
pub(super) const FAST: f64 = 0.2;
/// ... and the reading before and after differs from the next one by less than this share of the fall, as where nothing slows down.
const SUDDEN: f64 = 0.5;
/// A drive that holds on keeps this share of what it was in so many samples before.
const HELD: f64 = 0.5;
const LATEST: usize = 4;
/// A motion of up to so many counts an interval has intervals without one.
const FEW_COUNTS: f64 = 4.0;
/// Counted is a speed whose slow readings are multiples of the slowest but for this share of it, for jitter, nearly all of them.
const JITTER: f64 = 0.2;
const NEARLY_ALL: f64 = 0.8;
/// Where more than this share of the motion would be no reading, the sensor tells so little that its zeros belong to it.
const MOST_DROPPED: f64 = 0.4;
/// A number comes at least so often where it stands for what was not read.
const FEWEST_SENTINELS: usize = 5;

/// Of an angle, the samples where nothing was read.
pub(super) fn dropouts(values: &[f64]) -> Vec<usize> {
    let zeros = dropped_to_zero(values, None);
    if zeros.is_empty() { at_the_sentinel(values) } else { zeros }
}

/// Of a speed that `volts` drive, the same.
pub(super) fn speed_dropouts(speed: &[f64], volts: &[f64]) -> Vec<usize> {
    let moving = speed.iter().filter(|w| **w != 0.0).count() as f64;
    let zeros = dropped_to_zero(speed, Some(volts));
    if !zeros.is_empty() && zeros.len() as f64 <= MOST_DROPPED * moving {
        return zeros;
    }
    dropouts(speed)
}

fn at_the_sentinel(values: &[f64]) -> Vec<usize> {
    let Some(sentinel) = sentinel(values) else { return Vec::new() };
    let shifted: Vec<f64> = values.iter().map(|value| value - sentinel).collect();
    dropped_to_zero(&shifted, None)
}

/// The number other than zero that stands most often by itself far below or far above both readings beside it.
fn sentinel(values: &[f64]) -> Option<f64> {
    let steps = values.windows(2).map(|pair| (pair[1] - pair[0]).abs());
    let far = APART * steps.sum::<f64>() / values.len().max(1) as f64;
    let mut counts: BTreeMap<u64, usize> = BTreeMap::new();
    for triple in values.windows(3) {
        let (before, after) = (triple[1] - triple[0], triple[1] - triple[2]);
        if triple[1] != 0.0 && before * after > 0.0 && before.abs().min(after.abs()) > far {
            *counts.entry(triple[1].to_bits()).or_default() += 1;
        }
    }
    let (bits, count) = counts.into_iter().max_by_key(|(_, count)| *count)?;
    (count >= FEWEST_SENTINELS).then(|| f64::from_bits(bits))
}

/// The zeros that are no readings; of an angle, which has no `drive` that holds it, those that its furthest step does not allow.
fn dropped_to_zero(values: &[f64], drive: Option<&[f64]>) -> Vec<usize> {
    let ordinary = values.windows(2).filter(|p| p[0] != 0.0 && p[1] != 0.0);
    let mut steps: Vec<f64> = ordinary.map(|p| (p[1] - p[0]).abs()).collect();
    let furthest = peak(&steps);
    let allowed = quantile(&mut steps, USUAL);
    let few_counts = FEW_COUNTS * count_of(values);
    let fast = FAST * quantile(&mut values.iter().map(|value| value.abs()).collect::<Vec<_>>(), USUAL);
    let runs: Vec<Run> = zeros_between(values).into_iter().filter(|run| run.height > few_counts).collect();
    let is_certain = |run: &&Run| {
        let holds = drive.is_some_and(|drive| holds_on(drive, &run.zeros));
        run.height > APART * furthest
            || holds && run.height > (APART * allowed).max(fast) && run.slope < SUDDEN * run.height
    };
    let samples = |runs: &[&Run]| runs.iter().flat_map(|run| run.zeros.clone()).collect::<Vec<usize>>();
    let certain = samples(&runs.iter().filter(is_certain).collect::<Vec<_>>());
    // Where some are certain, the others among slower motion are the same.
    if certain.len() > 1 { samples(&runs.iter().collect::<Vec<_>>()) } else { certain }
}

/// A short run of zeros between readings of one sign.
struct Run {
    zeros: Range<usize>,
    /// How far the nearer of the two readings beside it is from zero.
    height: f64,
    /// The larger step of those before the fall and behind the return.
    slope: f64,
}

fn zeros_between(values: &[f64]) -> Vec<Run> {
    let mut found = Vec::new();
    let at = |k: usize| values.get(k).copied().filter(|value| *value != 0.0);
    let mut k = 1;
    while k + 1 < values.len() {
        let zeros = values[k..].iter().take_while(|w| **w == 0.0).count();
        let (before, after) = (values[k - 1], at(k + zeros).unwrap_or(0.0));
        if zeros > 0 && zeros <= LONGEST_SPIKE && before * after > 0.0 {
            let earlier = k.checked_sub(2).and_then(at).unwrap_or(before);
            let later = at(k + zeros + 1).unwrap_or(after);
            found.push(Run {
                zeros: k..k + zeros,
                height: before.abs().min(after.abs()),
                slope: (before - earlier).abs().max((later - after).abs()),
            });
        }
        k += zeros.max(1);
    }
    found
}

/// Whether what drives the motor neither falls nor turns round up to the end of these samples.
fn holds_on(drive: &[f64], zeros: &Range<usize>) -> bool {
    let begin = zeros.start.saturating_sub(LATEST);
    let before = &drive[begin..zeros.start];
    let (way, least) = (before.last().map_or(1.0, |v| v.signum()), HELD * peak(before));
    drive[begin..zeros.end].iter().all(|v| v * way >= least)
}

/// The size of one count of a speed that was counted, 0 of any other.
fn count_of(speed: &[f64]) -> f64 {
    let sizes = || speed.iter().map(|w| w.abs()).filter(|w| *w > 0.0);
    let smallest = sizes().fold(f64::INFINITY, f64::min);
    let slow: Vec<f64> = sizes().map(|w| w / smallest).filter(|counts| *counts < FEW_COUNTS + 0.5).collect();
    let whole = slow.iter().filter(|counts| (*counts - counts.round()).abs() < JITTER).count();
    if whole as f64 >= NEARLY_ALL * slow.len() as f64 && smallest.is_finite() { smallest } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::super::repair::repaired;
    use super::super::repair::tests::{moving, swing};
    use super::*;

    #[test]
    fn zeros_in_the_midst_of_motion_are_left_out_and_a_speed_that_passes_zero_is_not() {
        let mut record = moving(swing);
        let speed: Vec<f64> = record.time_s.iter().map(|t| 34.0 * (1.7 * t).cos()).collect();
        (record.angle_rad, record.speed_rad_s) = (None, Some(speed.clone()));
        assert_eq!(repaired(record.clone())[0].len(), 800);
        let mut dropped = speed;
        for k in [20, 77, 301, 302, 640] {
            dropped[k] = 0.0;
        }
        record.speed_rad_s = Some(dropped);
        let parts = repaired(record);
        assert_eq!(parts[0].len(), 795);
        assert!(parts[0].warnings[0].what.contains("sample 21"), "{:?}", parts[0].warnings);
    }

    #[test]
    fn a_number_that_stands_for_what_was_not_read_is_left_out_wherever_it_stands_apart() {
        let mut record = moving(swing);
        let mut speed: Vec<f64> = record.time_s.iter().map(|t| 34.0 * (1.7 * t).cos()).collect();
        let fast: Vec<usize> = (20..780).step_by(10).filter(|k| speed[*k].abs() > 10.0).collect();
        for k in &fast {
            speed[*k] = -0.1;
        }
        (record.angle_rad, record.speed_rad_s) = (None, Some(speed));
        assert_eq!(repaired(record)[0].len(), 800 - fast.len());
    }

    /// A speed that settles at each of two levels, with the scatter of a sensor that times the slots of a disc.
    fn scattering(k: usize) -> f64 {
        let level = if k < 400 { 200.0 } else { 260.0 };
        let settled = 1.0 - (-(k as f64) / 60.0).exp();
        level * settled * (1.0 + 0.12 * ((k * k) as f64).sin())
    }

    #[test]
    fn a_reading_of_none_is_told_from_scatter_and_from_readings_that_are_wrong_otherwise() {
        let volts: Vec<f64> = (0..800).map(|k| if k < 400 { 2.4 } else { 4.8 }).collect();
        let mut speed: Vec<f64> = (0..800).map(scattering).collect();
        assert_eq!(speed_dropouts(&speed, &volts), [0; 0]);
        // Edges that were missed double some readings, and none came in a sixth of the intervals.
        (300..800).step_by(90).for_each(|k| speed[k] *= 2.0);
        let missing: Vec<usize> = (20..795).filter(|k| k % 12 < 2).collect();
        missing.iter().for_each(|k| speed[*k] = 0.0);
        assert_eq!(speed_dropouts(&speed, &volts), missing);
        // A sensor that tells a reading now and then has no other zeros.
        (speed[5], speed[6]) = (200.0, 20.0);
        (20..795).filter(|k| k % 3 > 0).for_each(|k| speed[k] = 0.0);
        assert_eq!(speed_dropouts(&speed, &volts), [0; 0]);
    }

    #[test]
    fn a_motor_that_stops_for_a_moment_did_stop() {
        // Each stop is that of its drive, fast for the log, among steady motion.
        let pauses = |k: usize| k % 40 < 2 && k > 40;
        let volts: Vec<f64> = (0..400).map(|k| if pauses(k) { 0.0 } else { 6.0 }).collect();
        let at_once: Vec<f64> = (0..400_usize)
            .map(|k| {
                if pauses(k.saturating_sub(1)) {
                    0.0
                } else {
                    50.0 + (k as f64).sin() + f64::from(k < 9) * k as f64
                }
            })
            .collect();
        let mut speed = at_once;
        // It was reversed once, without a stop between.
        (speed[10], speed[11]) = (20.0, 70.0);
        assert_eq!(speed_dropouts(&speed, &volts), [0; 0]);
    }

    #[test]
    fn a_slow_motion_of_few_counts_has_intervals_without_one() {
        let count = 3.7;
        for (counts, jitter) in [
            (&(|k: usize| (0.6 * k as f64).floor()) as &dyn Fn(usize) -> f64, 0.0),
            (&|k| (0.6 * k as f64).floor(), 0.05),
            (&|k| (0.75 * k as f64).floor(), 0.0),
            // Slow at first, then fast.
            (&|k| (if k < 200 { 0.7 * k as f64 } else { 140.0 + 9.5 * (k as f64 - 200.0) }).floor(), 0.03),
        ] {
            let interval = |k: usize| 1.0 + jitter * ((k * k) as f64).sin();
            let speed: Vec<f64> =
                (0..400).map(|k| count * (counts(k + 1) - counts(k)) / interval(k)).collect();
            assert!(speed.contains(&0.0) && speed_dropouts(&speed, &[6.0; 400]).is_empty(), "{jitter}");
        }
    }
}
