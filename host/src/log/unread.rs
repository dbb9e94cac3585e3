//! A speed that stands at one number for long where nothing was read: 65535, -1, or 0 amid motion.
//!
//! A shaft at rest and a coarse sensor stand at one number too, but they come there by way of the motor's inertia or at an edge of its drive. What
//! goes to a number at once and from it at once while the drive holds, or beyond all other speeds, was not read there.

use std::collections::BTreeSet;
use std::ops::Range;

use super::Record;
use super::dropouts::{FAST, LONGEST_SPIKE};
use super::edges::EDGE;
use super::garbled::SPIKE_SPEED;
use super::motion::{runs, span};
use super::repair::APART;
use super::sentinels::{FEW_COUNTS, MOST};

/// A speed answers to an edge of its drive within so many of its own changes.
const LATEST: usize = 4;

/// The runs of samples at which the speed of `record` was not read: long ones, and shorter ones of the same number.
pub(super) fn unread_speeds(record: &Record) -> Vec<Range<usize>> {
    // What drives a position loop is not logged.
    let speed = record.speed_rad_s.as_deref().filter(|_| record.servo.is_none());
    speed.map(|speed| unread(speed, &record.voltage_v)).unwrap_or_default()
}

/// Whether a run of one number is longer than any garbled reading.
pub(super) fn is_long(run: &Range<usize>) -> bool {
    run.len() > LONGEST_SPIKE
}

fn unread(speed: &[f64], volts: &[f64]) -> Vec<Range<usize>> {
    let runs = runs(speed);
    let readings = Readings::of(speed, volts, &runs);
    let is_sudden = |run: &&Range<usize>| readings.sides(run).any(|k| readings.is_sudden(k));
    let tried = readings.numbers(runs.iter().filter(|run| is_long(run) && is_sudden(run)));
    if tried.is_empty() {
        return Vec::new();
    }
    let of_these = runs.iter().filter(|run| tried.contains(&readings.number(run)) && is_sudden(run));
    let jumps = readings.jumps(of_these);
    let is_jump = |k: usize| jumps.binary_search(&k).is_ok();
    // At an end of the record one of the two jumps is not seen.
    let is_unread = |run: &&Range<usize>| {
        let is_seen = readings.sides(run).count() > 1 || readings.is_beyond(speed[run.start]);
        is_long(run) && is_seen && readings.sides(run).all(is_jump)
    };
    let found = readings.numbers(runs.iter().filter(is_unread));
    // Where the motion happens to pass near the number, the run has one jump.
    let is_of_them =
        |run: &&Range<usize>| found.contains(&readings.number(run)) && readings.sides(run).any(is_jump);
    let out: Vec<Range<usize>> = runs.iter().filter(is_of_them).cloned().collect();
    let count: usize = out.iter().map(ExactSizeIterator::len).sum();
    if count as f64 > MOST * speed.len() as f64 { Vec::new() } else { out }
}

/// Readings of a speed, and what of their steps its drive explains.
struct Readings<'a> {
    speed: &'a [f64],
    /// The fastest of those that no long run holds, rad/s.
    fastest: f64,
    /// Samples behind which the drive changes at once.
    edges: Vec<usize>,
    /// Samples in which the speed may still answer to such an edge.
    reach: usize,
}

impl<'a> Readings<'a> {
    fn of(speed: &'a [f64], volts: &[f64], runs: &[Range<usize>]) -> Self {
        let holds = EDGE * span(volts);
        let edges = (1..volts.len()).map(|k| k - 1).filter(|k| (volts[k + 1] - volts[*k]).abs() > holds);
        let short = runs.iter().filter(|run| !is_long(run));
        Self {
            speed,
            fastest: short.fold(0.0_f64, |most, run| most.max(speed[run.start].abs())),
            edges: edges.collect(),
            reach: LATEST * speed.len() / runs.len().max(1),
        }
    }

    /// The samples before the way to the number of `run`, and before the way back: one only at an end of the record.
    fn sides(&self, run: &Range<usize>) -> impl Iterator<Item = usize> {
        let back = (run.end < self.speed.len()).then(|| run.end - 1);
        [run.start.checked_sub(1), back].into_iter().flatten()
    }

    /// The number of `run`, for comparison: -0 is 0.
    fn number(&self, run: &Range<usize>) -> u64 {
        (self.speed[run.start] + 0.0).to_bits()
    }

    fn numbers<'r>(&self, runs: impl Iterator<Item = &'r Range<usize>>) -> BTreeSet<u64> {
        runs.map(|run| self.number(run)).collect()
    }

    fn is_beyond(&self, number: f64) -> bool {
        number.abs() > SPIKE_SPEED * self.fastest
    }

    /// Whether the step behind sample `k` is none that the drive asks for.
    fn is_sudden(&self, k: usize) -> bool {
        let next = self.edges.partition_point(|edge| edge + self.reach < k);
        let holds = self.edges.get(next).is_none_or(|edge| *edge > k + 1);
        holds || self.is_beyond(self.speed[k]) || self.is_beyond(self.speed[k + 1])
    }

    /// The sudden steps to and from the `runs` that are far beyond all other steps, which are the motor's own.
    fn jumps<'r>(&self, runs: impl Iterator<Item = &'r Range<usize>>) -> Vec<usize> {
        let beside: BTreeSet<usize> = runs.flat_map(|run| self.sides(run)).collect();
        let step = |k: usize| (self.speed[k + 1] - self.speed[k]).abs();
        let own = (1..self.speed.len()).map(|k| k - 1).filter(|k| !beside.contains(k)).map(step);
        let (furthest, smallest) = own
            .filter(|step| *step > 0.0)
            .fold((0.0_f64, f64::INFINITY), |(far, small), step| (far.max(step), small.min(step)));
        let far = (APART * furthest + FEW_COUNTS * smallest).max(FAST * self.fastest);
        beside.into_iter().filter(|k| self.is_sudden(*k) && step(*k) > far).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::super::repair::repaired;
    use super::super::repair::tests::{moving, swing};
    use super::*;

    /// A motor of 3 rad/s/V and 50 ms under `volts`, read every 5 ms with a scatter of 0.05 rad/s.
    fn driven(volts: impl Fn(f64) -> f64) -> Record {
        let mut record = moving(swing);
        record.voltage_v = record.time_s.iter().map(|t| volts(*t)).collect();
        let mut w = 0.0;
        let speeds = record.voltage_v.iter().enumerate().map(|(k, v)| {
            w += 0.1 * (3.0 * v - w);
            w + 0.05 * ((k * k) as f64).sin()
        });
        (record.speed_rad_s, record.angle_rad) = (Some(speeds.collect()), None);
        record
    }

    fn wave(t: f64) -> f64 {
        6.0 + 4.0 * (2.0 * t).sin()
    }

    fn stairs(t: f64) -> f64 {
        [4.0, 8.0, 5.0, 9.0][t as usize % 4]
    }

    #[test]
    fn a_record_is_cut_where_its_speed_stands_at_a_number_for_nothing() {
        for volts in [wave, stairs] {
            for number in [65_535.0, 32_767.0, 9_999.0, -1.0, 0.0] {
                let mut record = driven(volts);
                let speed = record.speed_rad_s.as_mut().unwrap();
                speed[320..360].fill(number);
                speed[500..512].fill(number);
                speed[700..702].fill(number);
                let parts = repaired(record);
                let lengths: Vec<usize> = parts.iter().map(Record::len).collect();
                assert_eq!(lengths, [320, 140, 286], "{number}: {:?}", parts[0].warnings);
                let said: Vec<&str> = parts[0].warnings.iter().map(|warning| warning.what.as_str()).collect();
                assert!(said.iter().all(|what| what.starts_with("garbled_readings: ")), "{said:?}");
                let when = "2 times, from sample 321 (1.600 s), sample 501 (2.500 s)";
                assert!(
                    said.iter().any(|what| what.contains("the speed jumps") && what.contains(when)),
                    "{said:?}"
                );
            }
        }
    }

    #[test]
    fn a_number_for_nothing_is_told_beside_edges_of_the_drive_and_to_the_end_of_a_record() {
        let mut record = driven(|t| if ((t / 0.03) as usize).is_multiple_of(3) { 8.0 } else { 5.0 });
        record.speed_rad_s.as_mut().unwrap()[600..].fill(65_535.0);
        assert_eq!(unread_speeds(&record).first(), Some(&(600..800)));
    }

    #[test]
    fn a_speed_that_the_motor_brings_to_one_number_was_read() {
        let at_rest = |record: &Record, below: f64| {
            let rests = |w: &f64| if w.abs() < below { 0.0 } else { *w };
            let speed_rad_s = record.speed_rad_s.as_ref().map(|speed| speed.iter().map(rests).collect());
            Record { speed_rad_s, ..record.clone() }
        };
        let quantised = |record: &Record, step: f64, held: usize| {
            let speed = record.speed_rad_s.as_ref().unwrap();
            let reading = |k: usize| (speed[k - k % held] / step).round() * step;
            Record { speed_rad_s: Some((0..speed.len()).map(reading).collect()), ..record.clone() }
        };
        let pulses = |t: f64| if t % 0.2 < 0.1 { 6.0 } else { 0.0 };
        let slow = |t: f64| 3.0 * (1.5 * t).sin();
        for (what, record) in [
            ("a wave", driven(wave)),
            ("pulses to rest", at_rest(&driven(pulses), 0.5)),
            ("pulses of a coarse sensor", quantised(&driven(pulses), 6.0, 1)),
            ("pulses that are held", quantised(&driven(pulses), 0.5, 20)),
            ("a ramp through rest", at_rest(&driven(slow), 1.0)),
            ("a coarse sensor that is held", quantised(&driven(wave), 2.0, 10)),
        ] {
            assert!(unread_speeds(&record).is_empty(), "{what}");
        }
        // A motor that follows each edge of its drive within a row.
        let mut fast = driven(pulses);
        let speeds = fast
            .voltage_v
            .iter()
            .enumerate()
            .map(|(k, v)| 3.0 * v + f64::from(*v > 0.0) * 0.3 * ((k * k) as f64).sin());
        fast.speed_rad_s = Some(speeds.collect());
        assert!(unread_speeds(&fast).is_empty());
    }
}
