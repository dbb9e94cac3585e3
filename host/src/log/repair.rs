//! What a counter or a sensor did to a record, undone or left out and said: spikes, wrapped angles, resets, pauses.
//!
//! The steps of a moving shaft form a continuum: what stands alone above it by a factor is no motion. Two such steps
//! there and back are a garbled reading, steps that all have the size of one modulus a wrapped angle, and any other a
//! counter that was reset. A record is cut at a reset and at a long pause: nothing tells what happened in between.

use std::ops::Range;

use super::dropouts::LONGEST_SPIKE;
use super::ends::leave_out_clipped;
use super::garbled::{hold_voltage_spikes, leave_out_spikes};
use super::holes::{holes, leave_out_passed};
use super::motion::peak;
use super::samples::FEWEST_SAMPLES;
use super::sentinels::between_jumps;
use super::slow_sensor::leave_out_held;
use super::timing::median_interval;
use super::unread::unread_speeds;
use super::wraps::unwrap_angle;
use super::{Record, Warning};

/// Steps this many times as large as the largest ordinary one are no motion.
pub(super) const APART: f64 = 3.0;
/// What is left of a step that is undone is less than this share of it.
const UNDONE: f64 = 0.25;
/// Share of the steps, from the largest on, among which such steps are sought.
const RARE: f64 = 0.2;
/// A record is cut at a pause of so many intervals and seconds.
const PAUSE_INTERVALS: f64 = 10.0;
const PAUSE_S: f64 = 0.25;
/// What to do about records that were cut.
const SEPARATE: &str = "log without pauses, and read the counter in full width; nothing is to be done if these are separate tests";
/// ... and about readings that are none.
const CABLE: &str = "check the sensor's cable and the transmission of the log";
/// Times named in a message.
const NAMED: usize = 5;

/// The parts of `record`, each without what no motor did.
pub fn repaired(mut record: Record) -> Vec<Record> {
    // Before anything is left out: what drove the motor then is known.
    let missing: Vec<f64> = holes(&record).into_iter().map(|k| record.time_s[k]).collect();
    let clipped = leave_out_clipped(&mut record);
    hold_voltage_spikes(&mut record);
    leave_out_spikes(&mut record);
    unwrap_angle(&mut record);
    let mut pauses = pauses(&record);
    let last_before = |time_s: &f64| record.time_s.partition_point(|t| t <= time_s).checked_sub(1);
    pauses.extend(clipped.iter().filter_map(last_before));
    pauses.sort_unstable();
    pauses.dedup();
    // What the motor did in a pause is no jump of its counter.
    let mut resets = record.angle_rad.as_deref().map(far_steps).unwrap_or_default();
    resets.extend(record.angle_rad.as_deref().map(resets_to_start).unwrap_or_default());
    resets.sort_unstable();
    resets.dedup();
    resets.retain(|k| pauses.binary_search(k).is_err());
    leave_out_passed(&record, &mut resets);
    let mut holes: Vec<usize> = missing.iter().filter_map(last_before).collect();
    holes.retain(|k| pauses.binary_search(k).is_err() && resets.binary_search(k).is_err());
    let unread = Unread {
        angle: record.angle_rad.as_deref().map(|angle| between_jumps(angle, &resets)).unwrap_or_default(),
        speed: unread_speeds(&record),
    };
    let mut parts = cut(record, [&pauses, &holes, &resets], &unread);
    parts.iter_mut().for_each(leave_out_held);
    parts
}

/// Steps (from sample k to k + 1) of `values` that stand apart from the motion, at most two in a row in one direction.
pub(super) fn far_steps(values: &[f64]) -> Vec<usize> {
    let steps: Vec<f64> = values.windows(2).map(|p| (p[1] - p[0]).abs()).collect();
    let mut sorted: Vec<f64> = steps.iter().copied().filter(|step| *step > 0.0).collect();
    sorted.sort_by(f64::total_cmp);
    if sorted.len() < FEWEST_SAMPLES {
        return Vec::new();
    }
    let rare = ((1.0 - RARE) * sorted.len() as f64) as usize;
    // A few counts are what a slow motion is written in.
    let smallest = sorted[0].max(1e-9 * peak(values));
    let Some(limit) = (rare..sorted.len() - 1)
        .find(|&k| sorted[k + 1] > APART * sorted[k] + 4.0 * smallest)
        .map(|k| 0.5 * (sorted[k] + sorted[k + 1]))
    else {
        return Vec::new();
    };
    let far: Vec<usize> = (0..steps.len()).filter(|&k| steps[k] > limit).collect();
    // A burst of fast motion in a still record is motion: it goes on in its direction. Garbled readings go there and back.
    let goes_on = |k: usize| (values[k + 1] - values[k]) * (values[k + 2] - values[k + 1]) > 0.0;
    let moves = 2 * sorted.len() >= steps.len();
    let burst = |run: &[usize]| {
        let (first, last) = (run[0], run[run.len() - 1]);
        run.len() > 2 && (first..last).any(goes_on) && !(moves && is_undone(values, run))
    };
    if far.chunk_by(|one, next| next - one == 1).any(burst) { Vec::new() } else { far }
}

/// The step among the `far` ones that undoes the one at this place among them, some samples later, and its place; none where none does.
pub(super) fn undoing(values: &[f64], far: &[usize], place: usize) -> Option<(usize, usize)> {
    let there = far[place];
    let next = (place + 1..far.len()).take_while(|other| far[*other] - there <= LONGEST_SPIKE);
    next.map(|other| (other, far[other])).find(|(_, back)| comes_back(values, there, *back))
}

/// Whether all steps of a `run` undo each other some samples later, as those of garbled readings beside each other do.
fn is_undone(values: &[f64], run: &[usize]) -> bool {
    let mut place = 0;
    while place < run.len() {
        let Some((other, _)) = undoing(values, run, place) else { return false };
        place = other + 1;
    }
    true
}

/// Whether the steps `there` and `back`, from sample k to k + 1, undo each other: all between is far from where it was, and what follows is not.
fn comes_back(values: &[f64], there: usize, back: usize) -> bool {
    let off = |k: usize| (values[k] - values[there]).abs();
    let least = (there + 1..=back).map(off).fold(f64::INFINITY, f64::min);
    off(back + 1) < UNDONE * least
}

/// A counter that is set back goes so many times as far at once as in the samples around, ...
const SET_BACK: f64 = 8.0;
/// ... or so many times where it surely was more than once.
const SET_BACK_AGAIN: f64 = 2.5;
/// Changes of the reading before and after that tell how fast the shaft turns, however long each reading is held.
const AROUND: usize = 3;

/// Steps of `values` back to where they began, which the motion around them does not make: the counter is set to zero before each test. They
/// are as long as each test happened to go, so that none stands apart from all others.
fn resets_to_start(values: &[f64]) -> Vec<usize> {
    let step = |k: usize| (values[k + 1] - values[k]).abs();
    let last = values.len().saturating_sub(1);
    let smallest = (0..last).map(step).filter(|step| *step > 0.0).fold(f64::INFINITY, f64::min);
    let changes: Vec<usize> = (0..last).filter(|k| step(*k) > 0.0).collect();
    let back = |factor: f64| -> Vec<usize> {
        let is_reset = |place: &usize| {
            let k = changes[*place];
            let around = place.saturating_sub(AROUND)..(place + 1 + AROUND).min(changes.len());
            let usual =
                around.filter(|other| other != place).map(|other| step(changes[other])).fold(0.0, f64::max);
            let to_start = (values[k + 1] - values[0]).abs() <= usual + smallest;
            to_start && step(k) > factor * usual + SET_BACK * smallest
        };
        (0..changes.len()).filter(is_reset).map(|place| changes[place]).collect()
    };
    let surely = back(SET_BACK);
    if surely.len() > 1 { back(SET_BACK_AGAIN) } else { surely }
}

/// Samples behind which the log pauses, or its clock starts anew.
fn pauses(record: &Record) -> Vec<usize> {
    let longest = (PAUSE_INTERVALS * median_interval(&record.time_s)).max(PAUSE_S);
    let pause = |k: &usize| !(0.0..=longest).contains(&(record.time_s[k + 1] - record.time_s[*k]));
    (0..record.len().saturating_sub(1)).filter(pause).collect()
}

/// Runs of samples at which nothing was read.
struct Unread {
    angle: Vec<Range<usize>>,
    speed: Vec<Range<usize>>,
}

impl Unread {
    fn runs(&self) -> impl Iterator<Item = &Range<usize>> {
        self.angle.iter().chain(&self.speed)
    }
}

/// Cuts behind the samples `pauses`, `holes` and `resets`, and around what is `unread`, which is left out; so are parts too short to teach anything.
fn cut(record: Record, [pauses, holes, resets]: [&[usize]; 3], unread: &Unread) -> Vec<Record> {
    let around = unread.runs().flat_map(|run| [run.start, run.end]).filter(|k| *k > 0);
    let mut ends: Vec<usize> =
        pauses.iter().chain(holes).chain(resets).map(|k| k + 1).chain(around).chain([record.len()]).collect();
    ends.sort_unstable();
    ends.dedup();
    let begins = [0].into_iter().chain(ends.iter().copied());
    let all: Vec<(usize, usize)> = begins.zip(ends.iter().copied()).collect();
    let is_read = |(a, b): &(usize, usize)| !unread.runs().any(|run| run.start <= *a && *b <= run.end);
    let read: Vec<(usize, usize)> = all.iter().copied().filter(is_read).collect();
    let kept: Vec<(usize, usize)> = read.iter().copied().filter(|(a, b)| b - a >= FEWEST_SAMPLES).collect();
    if all.len() == 1 || kept.is_empty() {
        return vec![record];
    }
    let starts = |runs: &[Range<usize>]| runs.iter().map(|run| run.start).collect::<Vec<usize>>();
    let behind = |samples: &[usize]| samples.iter().map(|k| k + 1).collect::<Vec<usize>>();
    let mut resets = behind(resets);
    resets.retain(|k| !unread.angle.iter().any(|run| run.start == *k || run.end == *k));
    let mut said = Vec::new();
    for (what, when, samples, fix) in [
        ("pauses: the log pauses", "before", behind(pauses), SEPARATE),
        (
            "missing_rows: rows are missing while the voltage changed, and nothing tells when it did",
            "before",
            behind(holes),
            "log without pauses; no voltage is held through what is missing",
        ),
        (
            "lost_counts: the angle jumps, which no motion explains (the counter was reset or lost counts)",
            "before",
            resets,
            SEPARATE,
        ),
        (
            "garbled_readings: the angle jumps to one number, stands there and jumps back, where nothing was read, which is left out",
            "from",
            starts(&unread.angle),
            CABLE,
        ),
        (
            "garbled_readings: the speed jumps to one number, stands there and jumps back without an edge of the drive, where nothing was read, \
             which is left out",
            "from",
            starts(&unread.speed),
            CABLE,
        ),
    ] {
        if !samples.is_empty() {
            let named = named(&samples, &record.time_s);
            said.push((format!("{what} {} times, {when} {named}", samples.len()), fix));
        }
    }
    let short: usize = read.iter().map(|(a, b)| b - a).filter(|n| *n < FEWEST_SAMPLES).sum();
    let short =
        if short > 0 { format!("; {short} samples of shorter parts are left out") } else { String::new() };
    let warnings = said.into_iter().map(|(what, fix)| Warning {
        place: record.path.display().to_string(),
        what: format!("{what}; read as {} records{short}", kept.len()),
        fix: fix.into(),
    });
    let mut before = record.warnings.clone();
    cut_already(&mut before);
    let mut warnings: Vec<Warning> = before.into_iter().chain(warnings).collect();
    let parts = kept.iter().enumerate().map(|(number, &(begin, end))| Record {
        // Said once.
        warnings: std::mem::take(&mut warnings),
        ..part(&record, begin..end, number + 1)
    });
    parts.collect()
}

/// Removes the advice to cut at a gap where that is done.
pub(super) fn cut_already(warnings: &mut Vec<Warning>) {
    warnings.retain(|warning| !warning.what.starts_with(super::samples::MISSING));
}

/// The samples `range` of `record`, as its part of this number.
pub(crate) fn part(record: &Record, range: std::ops::Range<usize>, number: usize) -> Record {
    let mut part = record.clone();
    part.name = format!("{} part {number}", record.name);
    for column in columns(&mut part) {
        *column = column[range.clone()].to_vec();
    }
    part
}

pub(super) fn columns(record: &mut Record) -> impl Iterator<Item = &mut Vec<f64>> {
    let Record { time_s, voltage_v, angle_rad, speed_rad_s, current_a, supply_v, servo, .. } = record;
    let optional = [angle_rad, speed_rad_s, current_a, supply_v].into_iter().flatten();
    let target = servo.as_mut().map(|servo| &mut servo.target_rad);
    [time_s, voltage_v].into_iter().chain(optional).chain(target)
}

/// Takes the samples that are `out` off every column.
pub(super) fn leave_out(record: &mut Record, out: impl Fn(usize) -> bool) {
    for column in columns(record) {
        let mut k = 0;
        column.retain(|_| {
            k += 1;
            !out(k - 1)
        });
    }
}

pub(super) fn named(samples: &[usize], time_s: &[f64]) -> String {
    let some: Vec<String> =
        samples.iter().take(NAMED).map(|&k| format!("sample {} ({:.3} s)", k + 1, time_s[k])).collect();
    let more = samples.len().saturating_sub(NAMED);
    some.join(", ") + &if more > 0 { format!(" and {more} more") } else { String::new() }
}

#[cfg(test)]
pub(super) mod tests {
    use std::f64::consts::TAU;

    use super::*;

    pub fn moving(angle: impl Fn(f64) -> f64) -> Record {
        let time_s: Vec<f64> = (0..800).map(|k| f64::from(k) * 0.005).collect();
        let values: Vec<f64> = time_s.iter().map(|t| angle(*t)).collect();
        Record {
            name: "run".into(),
            voltage_v: vec![1.0; 800],
            angle_rad: Some(values),
            time_s,
            ..Record::default()
        }
    }

    pub fn swing(t: f64) -> f64 {
        20.0 * (1.7 * t).sin() + 4.0 * (4.0 * t).sin()
    }

    #[test]
    fn an_angle_wrapped_at_any_usual_turn_is_unwrapped_and_said() {
        for (turn, low) in [(TAU, 0.0), (TAU, -TAU / 2.0), (10.0, 0.0), (360.0 / 20.0, 0.0)] {
            let parts = repaired(moving(|t| (swing(t) - low).rem_euclid(turn) + low));
            assert_eq!(parts.len(), 1, "{turn}");
            assert!(parts[0].warnings[0].what.contains("wraps"), "{:?}", parts[0].warnings);
            let angle = parts[0].angle_rad.as_ref().unwrap();
            for (t, x) in parts[0].time_s.iter().zip(angle) {
                let off = (x - angle[0]) - (swing(*t) - swing(0.0));
                assert!(off.abs() < 0.02, "{turn}: {off} at {t}");
            }
        }
    }

    #[test]
    fn a_wrapped_angle_that_goes_far_between_two_samples_is_unwrapped_too() {
        let fast = |t: f64| 150.0 * swing(t) / 20.0;
        for (turn, low) in [(TAU, 0.0), (TAU, -TAU / 2.0), (TAU, -TAU)] {
            let parts = repaired(moving(|t| (fast(t) - low).rem_euclid(turn) + low));
            let angle = parts[0].angle_rad.as_ref().unwrap();
            let step =
                parts[0].time_s.windows(2).map(|p| (fast(p[1]) - fast(p[0])).abs()).fold(0.0, f64::max);
            assert!(parts.len() == 1 && step > 0.25 * turn, "{step} {:?}", parts[0].warnings);
            for (t, x) in parts[0].time_s.iter().zip(angle) {
                assert!(((x - angle[0]) - (fast(*t) - fast(0.0))).abs() < 0.02, "{turn}: at {t}");
            }
        }
    }

    #[test]
    fn a_record_is_cut_at_resets_and_pauses_and_otherwise_left_alone() {
        assert_eq!(repaired(moving(swing)), [moving(swing)]);
        let mut reset = moving(swing);
        for at in [200, 350, 600] {
            let there = reset.angle_rad.as_ref().unwrap()[at];
            reset.angle_rad.as_mut().unwrap()[at..].iter_mut().for_each(|x| *x -= there + 30.0);
        }
        assert_eq!(repaired(reset).len(), 4);
        // Set to zero before each test, after ways of any length.
        let mut zeroed = moving(swing);
        for at in [90, 200, 350, 470, 600, 690] {
            let there = zeroed.angle_rad.as_ref().unwrap()[at];
            zeroed.angle_rad.as_mut().unwrap()[at..].iter_mut().for_each(|x| *x -= there);
        }
        assert!(repaired(zeroed).len() >= 6);
        // A reading that is held goes far at once, also to where it began.
        let held = moving(|t| swing((t / 0.05).floor() * 0.05));
        assert_eq!(repaired(held).len(), 1);
        let mut paused = moving(swing);
        paused.time_s[400..].iter_mut().for_each(|t| *t += 30.0);
        let parts = repaired(paused);
        assert_eq!(parts.iter().map(Record::len).collect::<Vec<_>>(), [400, 400]);
        assert!(parts[0].warnings[0].what.contains("pauses") && parts[1].warnings.is_empty());
    }
}
