//! Readings that were garbled on their way, left out or, of a voltage, held: they stand far from those before and after them.

use super::dropouts::{LONGEST_SPIKE, dropouts, speed_dropouts};
use super::edges::{garbled_behind_edges, keep_drive};
use super::many_garbled::{many_angles, many_speeds};
use super::motion::peak;
use super::repair::{far_steps, leave_out, named, undoing};
use super::sentinels::{at_the_ends, in_passes, picked};
use super::suspicion::place_of;
use super::unread::{is_long, unread_speeds};
use super::wraps::wrapped;
use super::{Record, Warning};

/// A spike of speed is this many times the fastest other reading.
pub(super) const SPIKE_SPEED: f64 = 3.0;
/// ... or goes so many times as far at once as any two others lie apart.
const SUDDEN: f64 = 8.0;
/// More readings of a voltage than this share are no accident of a transmission.
const MOST_GARBLED: f64 = 0.02;

/// Samples between two far steps, there and back; some of them may be far from each other too.
fn spikes(values: &[f64]) -> Vec<usize> {
    let far = far_steps(values);
    let mut found = Vec::new();
    let mut k = 0;
    while k < far.len() {
        if let Some((place, back)) = undoing(values, &far, k) {
            found.extend(far[k] + 1..=back);
            k = place;
        }
        k += 1;
    }
    found
}

/// Of an angle, the samples where nothing was read; where there are none, those that stand far from the others.
fn garbled_angles(angle: &[f64]) -> Vec<usize> {
    in_passes(angle.len(), |pass, kept| {
        let rest = picked(angle, kept);
        if pass > 0 && wrapped(&rest).is_some() {
            return Vec::new();
        }
        let first = |x: &[f64]| many_or_few(many_angles(x), || spikes(x), pass);
        first_of([&dropouts, &first, &|x| at_the_ends(x, 0.0)], &rest)
    })
}

/// The same of a speed that `volts` drive.
fn garbled_speeds(speed: &[f64], volts: &[f64]) -> Vec<usize> {
    in_passes(speed.len(), |pass, kept| {
        let (rest, volts) = (picked(speed, kept), picked(volts, kept));
        let first = |w: &[f64]| many_or_few(many_speeds(w, &volts), || speed_spikes(w), pass);
        first_of([&|w| speed_dropouts(w, &volts), &first, &|w| at_the_ends(w, SPIKE_SPEED)], &rest)
    })
}

/// The `many` garbled samples and the `few` that stand apart; these alone only in the first pass.
fn many_or_few(mut many: Vec<usize>, few: impl Fn() -> Vec<usize>, pass: usize) -> Vec<usize> {
    if !many.is_empty() || pass == 0 {
        many.extend(few());
        many.sort_unstable();
        many.dedup();
    }
    many
}

/// A rule that finds samples which are no readings.
type Rule<'a> = &'a dyn Fn(&[f64]) -> Vec<usize>;

/// What the first rule finds that finds any: where nothing was read at times, the rest is in order.
fn first_of(rules: [Rule<'_>; 3], values: &[f64]) -> Vec<usize> {
    rules.into_iter().map(|rule| rule(values)).find(|found| !found.is_empty()).unwrap_or_default()
}

/// The samples of `record` at which its speed is garbled, and those that are so behind an edge of the drive. Among long runs of a number for nothing
/// neither is to be seen: they are cut out later, and their shorter ones belong to these.
fn garbled_of_speed(record: &Record) -> (Vec<usize>, Vec<usize>) {
    let Some(speed) = record.speed_rad_s.as_deref() else { return (Vec::new(), Vec::new()) };
    let unread = unread_speeds(record);
    let mut is_read = vec![true; speed.len()];
    unread.iter().for_each(|run| is_read[run.clone()].fill(false));
    let kept: Vec<usize> = (0..speed.len()).filter(|k| is_read[*k]).collect();
    let (speed, volts) = (picked(speed, &kept), picked(&record.voltage_v, &kept));
    let of_all = |found: Vec<usize>| found.into_iter().map(|place| kept[place]).collect::<Vec<usize>>();
    let mut garbled = of_all(garbled_speeds(&speed, &volts));
    garbled.extend(unread.into_iter().filter(|run| !is_long(run)).flatten());
    garbled.sort_unstable();
    (garbled, of_all(garbled_behind_edges(&speed, &volts)))
}

pub(super) fn leave_out_spikes(record: &mut Record) {
    let angle = record.angle_rad.as_deref().filter(|x| wrapped(x).is_none());
    let angle = angle.map(garbled_angles).unwrap_or_default();
    let (mut speed, behind_edges) = garbled_of_speed(record);
    if !behind_edges.is_empty() {
        keep_drive(&record.time_s, &mut record.voltage_v, &behind_edges);
        speed.extend(behind_edges);
        speed.sort_unstable();
        speed.dedup();
    }
    for (column, samples) in [("angle_rad", &angle), ("speed_rad_s", &speed)] {
        if samples.is_empty() {
            continue;
        }
        record.warnings.push(Warning {
            place: place_of(record, column),
            what: format!(
                "garbled_readings: {} readings stand far from those before and after them, which no motion explains, and \
                 were left out: {}",
                samples.len(),
                named(samples, &record.time_s)
            ),
            fix: "check the sensor's cable and the transmission of the log".into(),
        });
    }
    let bad = |k: usize| angle.binary_search(&k).is_ok() || speed.binary_search(&k).is_ok();
    if !angle.is_empty() || !speed.is_empty() {
        leave_out(record, bad);
    }
}

/// Spikes far beyond all other readings, or that no inertia allows: many times the largest step between any two others.
fn speed_spikes(speed: &[f64]) -> Vec<usize> {
    let found = spikes(speed);
    let rest: Vec<f64> =
        (0..speed.len()).filter(|k| found.binary_search(k).is_err()).map(|k| speed[k]).collect();
    let (fastest, step) = (peak(&rest), rest.windows(2).fold(0.0, |s: f64, p| s.max((p[1] - p[0]).abs())));
    let height = |k: usize| {
        let before = (0..k).rev().find(|before| found.binary_search(before).is_err());
        (speed[k] - before.map_or(0.0, |before| speed[before])).abs()
    };
    let is_beyond = |k: usize| speed[k].abs() > SPIKE_SPEED * fastest;
    let is_sudden = |k: usize| height(k) > SUDDEN * step && height(k) > 0.5 * fastest;
    found.iter().copied().filter(|&k| is_beyond(k) || is_sudden(k)).collect()
}

/// Readings of a voltage that no drive gives for so short: few, far beyond all others, and back within some samples. The value before
/// them holds.
pub(super) fn hold_voltage_spikes(record: &mut Record) {
    let volts = &mut record.voltage_v;
    let mut sizes: Vec<f64> = volts.iter().map(|v| v.abs()).collect();
    sizes.sort_by(f64::total_cmp);
    let most = (MOST_GARBLED * volts.len() as f64).ceil() as usize;
    let first = sizes.len().saturating_sub(most + 1);
    // The gap above what the drive gives: a voltage of nothing but pulses has none.
    let gap = sizes[first..].windows(2).find(|pair| pair[0] > 0.0 && pair[1] > SPIKE_SPEED * pair[0]);
    let Some(highest) = gap.map(|pair| pair[0]) else { return };
    let garbled: Vec<usize> = (0..volts.len()).filter(|&k| volts[k].abs() > highest).collect();
    if garbled.windows(LONGEST_SPIKE + 1).any(|run| run[LONGEST_SPIKE] - run[0] == LONGEST_SPIKE) {
        return;
    }
    for &k in &garbled {
        volts[k] = if k > 0 { volts[k - 1] } else { 0.0 };
    }
    record.warnings.push(Warning {
        place: place_of(record, "voltage_v"),
        what: format!(
            "garbled_readings: {} readings stand at more than {SPIKE_SPEED} times every other voltage, for a moment each; the value before \
             them holds: {}",
            garbled.len(),
            named(&garbled, &record.time_s)
        ),
        fix: "check the transmission of the log; if the drive did give these, log the voltage more often".into(),
    });
}

#[cfg(test)]
mod tests {
    use super::super::repair::repaired;
    use super::super::repair::tests::{moving, swing};

    #[test]
    fn a_garbled_voltage_is_held_and_a_programme_of_pulses_is_left_alone() {
        let mut record = moving(swing);
        record.voltage_v = record.time_s.iter().map(|t| 6.0 * (3.0 * t).sin()).collect();
        let clean = record.voltage_v.clone();
        (record.voltage_v[300], record.voltage_v[600]) = (999.0, -999.0);
        let parts = repaired(record.clone());
        assert_eq!((parts[0].voltage_v[300], parts[0].voltage_v[600]), (clean[299], clean[599]));
        assert!(parts[0].warnings[0].what.contains("sample 301"), "{:?}", parts[0].warnings);
        record.voltage_v = (0..800).map(|k| if k % 20 == 0 { 12.0 } else { 0.0 }).collect();
        assert_eq!(repaired(record.clone()), [record.clone()]);
        // Equal readings in a voltage that hardly ever changes.
        record.voltage_v = (0..800).map(|k| if k / 200 % 2 == 0 { 6.0 } else { -6.0 }).collect();
        let clean = record.voltage_v.clone();
        for k in (50..800).step_by(90) {
            record.voltage_v[k] = 655.35;
        }
        let parts = repaired(record);
        assert_eq!(parts[0].voltage_v, clean);
        assert!(parts[0].warnings[0].what.contains("9 readings"), "{:?}", parts[0].warnings);
    }

    #[test]
    fn sudden_readings_of_a_speed_are_left_out_though_the_motor_goes_nearly_as_fast_at_times() {
        let mut record = moving(swing);
        let mut speed: Vec<f64> = record.time_s.iter().map(|t| 34.0 * (1.7 * t).cos()).collect();
        for k in [77, 277, 278, 477] {
            speed[k] += 60.0;
        }
        (record.angle_rad, record.speed_rad_s) = (None, Some(speed));
        assert_eq!(repaired(record)[0].len(), 796);
    }

    #[test]
    fn garbled_readings_are_left_out_few_or_many() {
        // Readings next to each other but one.
        let mut record = moving(swing);
        for k in (30..800).step_by(40).flat_map(|k| [k, k + 2]) {
            record.angle_rad.as_mut().unwrap()[k] += 150.0;
        }
        assert_eq!(repaired(record)[0].len(), 800 - 2 * (30..800).step_by(40).count());
        for every in [50, 400] {
            let mut record = moving(swing);
            for k in (30..800).step_by(every) {
                record.angle_rad.as_mut().unwrap()[k] += 150.0;
            }
            let parts = repaired(record);
            assert_eq!((parts.len(), parts[0].warnings.len()), (1, 1));
            assert_eq!(parts[0].len(), 800 - (30..800).step_by(every).count());
            assert!(parts[0].warnings[0].what.contains("sample 31"), "{:?}", parts[0].warnings);
        }
    }
}
