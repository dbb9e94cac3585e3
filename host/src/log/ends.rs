//! Speeds at the ends of the type that they were kept in: readings that stay there are clipped, and those that went beyond came out at the
//! other end, which is undone where the speed's course tells it for certain.

use super::motion::{alignment, different, ends, peak};
use super::repair::{leave_out, named};
use super::suspicion::place_of;
use super::timing::{median, median_interval};
use super::units::Quantity;
use super::weak::Weak;
use super::{Record, Warning};

/// Types with a sign, by their lowest and highest number.
const TYPES: [(f64, f64); 2] = [(-128.0, 127.0), (-32_768.0, 32_767.0)];
/// The end of a type is reached by so many readings or more.
const FEWEST: usize = 3;
/// A motor that settles at a speed comes to rest there; one that is clipped heads for so many numbers beyond the end, by two stretches of so
/// many readings before it, the second of which is at most this share of the first.
const BEYOND: f64 = 6.0;
const STRETCH: usize = 3;
const SLOWEST: f64 = 0.97;
/// A number beyond the end comes out within this share of the type's width of the other end, and the motion goes on through it.
const NEAR_END: f64 = 0.35;
const GOES_ON: f64 = 0.25;
/// Undone, no number may be further from the one before than this share of the width, half of which tells nothing, ...
const NEXT: f64 = 0.35;
/// ... no two rows further apart than so many intervals, ...
const LONGEST: f64 = 1.5;
/// ... and the motor's equation leaves no more than this share of the voltage, and of what it leaves as the numbers stand.
const EXPLAINED: f64 = 0.1;
const BETTER: f64 = 0.3;

/// The speed, rad/s, of one in the numbers that the log holds.
fn factor(record: &Record) -> Option<f64> {
    let unit = record.source(Quantity::Speed).map(|source| source.unit);
    let per_turn = match unit.and_then(|unit| unit.per_turn) {
        Some(per_turn) => record.meta.one_turn(per_turn)?,
        None => 1.0,
    };
    Some(unit.map_or(1.0, |unit| unit.factor / per_turn))
}

/// The speed in the numbers that the log holds, where all of them are whole.
fn written(record: &Record) -> Option<Vec<f64>> {
    let factor = factor(record)?;
    let numbers = record.speed_rad_s.as_ref()?.iter().map(|speed| speed / factor);
    let whole = |number: f64| {
        ((number - number.round()).abs() < 1e-6 * number.abs().max(1.0)).then_some(number.round())
    };
    numbers.map(whole).collect()
}

/// The type at one of whose ends the numbers stop.
fn kept_in(numbers: &[f64]) -> Option<(f64, f64)> {
    let (low, high) = ends(numbers);
    TYPES
        .into_iter()
        .find(|(least, most)| low >= *least && high <= *most && (low <= least + 1.0 || high == *most))
}

/// Readings that stay at an end of their type although the motion goes on.
fn clipped(numbers: &[f64]) -> Vec<usize> {
    let Some((least, most)) = kept_in(numbers) else { return Vec::new() };
    // Some drives keep to -127, so that both ends are alike.
    let lowest = if numbers.contains(&least) { least } else { least + 1.0 };
    let at_end = |k: usize| numbers[k] == most || numbers[k] == lowest;
    let found: Vec<usize> = (0..numbers.len()).filter(|k| at_end(*k)).collect();
    let stays = found.windows(2).any(|pair| pair[1] == pair[0] + 1 && numbers[pair[0]] == numbers[pair[1]]);
    let mut beyond: Vec<f64> = found
        .iter()
        .filter(|k| **k > 2 * STRETCH && (1..=2 * STRETCH + 1).all(|before| !at_end(**k - before)))
        .filter_map(|k| {
            Some(heading(&numbers[k - 2 * STRETCH - 1..*k], numbers[*k].signum())? - numbers[*k].abs())
        })
        .collect();
    let goes_beyond = median(&mut beyond) > BEYOND;
    if found.len() >= FEWEST && stays && goes_beyond { found } else { Vec::new() }
}

/// Where a motion that comes to rest by and by would do so, of two stretches of it in the direction of `sign`; none where it hardly moves.
fn heading(before: &[f64], sign: f64) -> Option<f64> {
    let way = |from: usize| sign * (before[from + STRETCH] - before[from]);
    let (first, second) = (way(0), way(STRETCH));
    let share = second / first.max(second / SLOWEST);
    (second >= FEWEST as f64).then(|| sign * before[2 * STRETCH] + second * share / (1.0 - share))
}

/// Readings behind which the number came out at the other end of its type, and its width.
fn jumps(numbers: &[f64]) -> Option<(Vec<usize>, f64)> {
    let (low, high) = ends(numbers);
    let (least, most) = TYPES.into_iter().find(|(least, most)| low >= *least && high <= *most)?;
    let width = most - least + 1.0;
    // What is clipped jumps from one end to the other too.
    let is_end = |x: f64| x == most || x <= least + 1.0;
    let is_jump = |k: &usize| {
        let (one, other) = (numbers[*k], numbers[*k + 1]);
        let is_far = one.abs().min(other.abs()) > (0.5 - NEAR_END) * width && one * other < 0.0;
        is_far && !(is_end(one) && is_end(other)) && width - (other - one).abs() < GOES_ON * width
    };
    let found: Vec<usize> = (0..numbers.len().saturating_sub(1)).filter(is_jump).collect();
    let reaches = low <= least + 0.1 * width && high >= most - 0.1 * width;
    (found.len() >= FEWEST && reaches).then_some((found, width))
}

/// Those of `jumps` that go against what drives the motor. A motor that is reversed at once goes as far, but with its drive.
fn against_drive(jumps: &[usize], numbers: &[f64], voltage_v: &[f64]) -> Vec<usize> {
    let forth = alignment(numbers, voltage_v).signum();
    let is_against = |k: usize| {
        let drives = [voltage_v[k], voltage_v[k + 1]];
        drives.iter().all(|v| v * forth * numbers[k + 1] < 0.0)
    };
    jumps.iter().copied().filter(|k| is_against(*k)).collect()
}

/// The speed, rad/s, of numbers that went beyond the ends of a type of this width: each is the one that is nearest to the one before, and all
/// of them those at which the motor stands still without a voltage. None where that is not certain.
fn unwrapped(record: &Record, numbers: &[f64], width: f64) -> Option<Vec<f64>> {
    let longest = LONGEST * median_interval(&record.time_s);
    if record.time_s.windows(2).any(|pair| pair[1] - pair[0] > longest) {
        return None;
    }
    let mut turns = 0.0;
    let mut course = vec![numbers[0]];
    for pair in numbers.windows(2) {
        let step = pair[1] - pair[0];
        turns -= (step / width).round();
        if (step - width * (step / width).round()).abs() > NEXT * width {
            return None;
        }
        course.push(pair[1] + width * turns);
    }
    let factor = factor(record)?;
    let as_speed = |numbers: &[f64]| Record {
        speed_rad_s: Some(numbers.iter().map(|number| number * factor).collect()),
        angle_rad: None,
        ..record.clone()
    };
    let mut undone = as_speed(&course);
    let found = Weak::new(&undone)?.under_any_latency()?;
    // A speed that is off by whole widths looks like one that turns without a voltage.
    let off = -found.gain * found.load_v / (width * factor);
    if (off - off.round()).abs() > NEXT || found.gain <= 0.0 || found.left > EXPLAINED {
        return None;
    }
    let before = as_speed(numbers);
    let left = Weak::new(&before).and_then(|weak| Some(weak.under_any_latency()?.left)).unwrap_or(1.0);
    let speed = undone.speed_rad_s.as_mut()?;
    speed.iter_mut().for_each(|speed| *speed -= off.round() * width * factor);
    (found.left < BETTER * left).then(|| std::mem::take(speed))
}

/// Undoes or names speeds that went beyond the ends of their type, and leaves out those that stay there. Tells the times behind which the
/// record is to be cut.
pub(super) fn leave_out_clipped(record: &mut Record) -> Vec<f64> {
    let Some(numbers) = written(record) else { return Vec::new() };
    let place = place_of(record, "speed_rad_s");
    if let Some((samples, width)) = jumps(&numbers) {
        let bits = width.log2();
        if let Some(speed) = unwrapped(record, &numbers, width) {
            let most = peak(&speed);
            record.warnings.push(Warning {
                place,
                what: format!(
                    "wrapped_numbers: the numbers went beyond the ends of {bits:.0} bits {} times, and were put back by the speed's course, \
                     which reaches {most:.4} rad/s: {}",
                    samples.len(),
                    named(&samples, &record.time_s)
                ),
                fix: "nothing, if the motor is that fast; otherwise keep them in a wider type".into(),
            });
            record.speed_rad_s = Some(speed);
            return Vec::new();
        }
        let samples = against_drive(&samples, &numbers, &record.voltage_v);
        if samples.len() >= FEWEST {
            record.warnings.push(Warning {
                place,
                what: format!(
                    "wrapped_numbers: the numbers jump by about {width} {} times, as {:.0} does that is kept as {:.0}: {}",
                    samples.len(),
                    0.6 * width,
                    -0.4 * width,
                    named(&samples, &record.time_s)
                ),
                fix: format!(
                    "keep them in a wider type ({}), or log the count itself, of which differences can be taken afterwards; until then leave \
                     these parts out (--skip)",
                    if width > 256.0 { "int32_t" } else { "int16_t" }
                ),
            });
            return Vec::new();
        }
    }
    let samples = clipped(&numbers);
    if samples.is_empty() || samples.len() == record.len() {
        return Vec::new();
    }
    let ends = different(samples.iter().map(|k| numbers[*k]));
    let ends: Vec<String> = ends.iter().map(f64::to_string).collect();
    record.warnings.push(Warning {
        place,
        what: format!(
            "clipped_readings: {} readings stand at {}, the end of a type of {} bits, while the motion goes on, and were left out: {}",
            samples.len(),
            ends.join(" or "),
            if numbers[samples[0]].abs() > 128.0 { 16 } else { 8 },
            named(&samples, &record.time_s)
        ),
        fix: "keep the speed in a wider type (int32_t, float), or in a larger unit".into(),
    });
    without(record, &samples)
}

/// Leaves out `samples`, in order; what drove the motor in them counts with the sample before them, by its time. Where it changed
/// meanwhile, a mean tells too little of it: the times before that are those at which to cut.
fn without(record: &mut Record, samples: &[usize]) -> Vec<f64> {
    let mut cuts = Vec::new();
    let count = record.len();
    let is_out = |k: usize| samples.binary_search(&k).is_ok();
    let mut kept = (0..count).filter(|k| !is_out(*k)).peekable();
    while let Some(k) = kept.next() {
        let next = kept.peek().copied().unwrap_or(k + 1);
        if next > k + 1 {
            let time = &record.time_s;
            let volt_seconds: f64 = (k..next).map(|i| record.voltage_v[i] * (time[i + 1] - time[i])).sum();
            if record.voltage_v[k..next].iter().any(|v| *v != record.voltage_v[k]) {
                cuts.push(time[k]);
            }
            record.voltage_v[k] = volt_seconds / (time[next] - time[k]);
        }
    }
    leave_out(record, is_out);
    cuts
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drive(k: usize) -> f64 {
        [1.0, 0.4, -0.9, 0.7, -1.0, 0.0][k / 40 % 6]
    }

    /// Steps of a motor of 60 ms, 100 readings a second, up to `fastest` numbers either way.
    fn steps(fastest: f64) -> Vec<f64> {
        let mut speed = 0.0;
        let step = |k: usize| {
            speed += (fastest * drive(k) - speed) * 0.154;
            speed
        };
        (0..2400).map(step).collect()
    }

    fn record(numbers: Vec<f64>) -> Record {
        let time_s: Vec<f64> = (0..numbers.len()).map(|k| 0.01 * k as f64).collect();
        Record {
            voltage_v: vec![6.0; numbers.len()],
            speed_rad_s: Some(numbers),
            time_s,
            ..Record::default()
        }
    }

    #[test]
    fn speeds_that_stay_at_the_end_of_a_type_are_left_out_and_a_top_speed_that_is_one_is_not() {
        for (fastest, least, most) in
            [(180.0, -128.0, 127.0), (160.0, -127.0, 127.0), (40_000.0, -32_768.0, 32_767.0)]
        {
            let mut clipped = record(steps(fastest).iter().map(|x| x.round().clamp(least, most)).collect());
            let ends =
                clipped.speed_rad_s.as_ref().unwrap().iter().filter(|x| [least, most].contains(*x)).count();
            assert_eq!(leave_out_clipped(&mut clipped), [0.0; 0]);
            assert!(ends > 100 && clipped.len() == 2400 - ends, "{fastest}: {ends} {:?}", clipped.warnings);
            assert!(clipped.warnings[0].what.starts_with("clipped_readings: "), "{:?}", clipped.warnings);
            assert!(clipped.voltage_v.iter().all(|v| (v - 6.0).abs() < 1e-9));
            // Where the drive changes in the meantime the record is cut.
            let mut driven = record(steps(fastest).iter().map(|x| x.round().clamp(least, most)).collect());
            driven.voltage_v = (0..2400).map(drive).collect();
            let cuts = leave_out_clipped(&mut driven);
            assert!(!cuts.is_empty() && cuts.iter().all(|time_s| driven.time_s.contains(time_s)), "{cuts:?}");
        }
        for fastest in [127.0, 127.4, 90.0, 1000.0] {
            let plain = record(steps(fastest).iter().map(|x| x.round().clamp(-1e4, 1e4)).collect());
            let mut left = plain.clone();
            leave_out_clipped(&mut left);
            assert_eq!(left, plain, "{fastest}");
        }
    }

    #[test]
    fn numbers_that_went_over_the_end_of_a_type_are_put_back_or_asked_about_and_a_reversal_is_neither() {
        for (fastest, width, every) in
            [(170.0, 256.0, 1), (45_000.0, 65_536.0, 1), (230.0, 256.0, 1), (170.0, 256.0, 8)]
        {
            let wrap = |x: &f64| (x.round() + 0.5 * width).rem_euclid(width) - 0.5 * width;
            let course: Vec<f64> = steps(fastest).into_iter().step_by(every).collect();
            let mut wrapped = record(course.iter().map(wrap).collect());
            wrapped.time_s = (0..course.len()).map(|k| 0.01 * (k * every) as f64).collect();
            wrapped.voltage_v = (0..2400).step_by(every).map(drive).collect();
            let plain = wrapped.clone();
            leave_out_clipped(&mut wrapped);
            assert_eq!((wrapped.len(), wrapped.warnings.len()), (course.len(), 1), "{fastest}");
            assert!(wrapped.warnings[0].what.starts_with("wrapped_numbers: "), "{:?}", wrapped.warnings);
            let found = wrapped.speed_rad_s.unwrap();
            if every == 1 {
                assert!(found.iter().zip(&course).all(|(a, b)| (a - b).abs() < 0.6), "{fastest}");
            } else {
                // From row to row the speed changes by half the width: nothing tells the way.
                assert_eq!(Some(found), plain.speed_rad_s);
                assert!(wrapped.warnings[0].fix.contains("--skip"));
            }
        }
        // A motor that answers at once.
        let levels = |k: usize| [110.0, -115.0, 60.0, -120.0, 0.0, 118.0][k / 40 % 6] + (k % 3) as f64;
        let mut plain = record((0..2400).map(levels).collect());
        plain.voltage_v = plain.speed_rad_s.clone().unwrap_or_default();
        let mut left = plain.clone();
        leave_out_clipped(&mut left);
        assert_eq!(left, plain);
    }
}
