//! Two runs of one programme: what differs between them is noise.

use super::Record;
use super::motion::span;
use super::timing::median_interval;

/// Records of one programme may begin this many samples apart.
const LARGEST_SHIFT: i64 = 10;
/// Voltages are the same where they differ by less than this share of their span: a measured voltage has noise.
const SAME_VOLTAGE: f64 = 0.05;
/// Share of the samples whose voltage must be the same; edges of a step may fall into neighbouring samples.
const SAME_SHARE: f64 = 0.95;
/// Two rates, or two lengths, are the same up to this share.
const SAME_LENGTH: f64 = 0.05;

/// Pairs of records of the same programme, by their places in `records`, the earlier first.
pub fn find_repeats(records: &[Record]) -> Vec<(usize, usize)> {
    let mut pairs = Vec::new();
    for second in 0..records.len() {
        for first in 0..second {
            if aligned(&records[first], &records[second]).is_some() {
                pairs.push((first, second));
            }
        }
    }
    pairs
}

/// The noise level on either of two records of the same programme: rms(difference) / sqrt(2), in rad
/// where both measured the angle, else in rad/s. The mean difference does not count, since an encoder starts
/// anywhere. `None` if the programmes differ or there is no common measured column.
pub fn noise_floor(first: &Record, second: &Record) -> Option<f64> {
    let differences = differences(first, second)?;
    let mean = differences.iter().sum::<f64>() / differences.len() as f64;
    let square = differences.iter().map(|d| (d - mean).powi(2)).sum::<f64>() / differences.len() as f64;
    Some((square / 2.0).sqrt())
}

/// What two runs of one programme measured, the second less the first at each sample of the first, in rad or rad/s.
/// `None` as for [`noise_floor`].
pub fn differences(first: &Record, second: &Record) -> Option<Vec<f64>> {
    let shift_s = aligned(first, second)?;
    let (measured, again) = match (&first.angle_rad, &second.angle_rad) {
        (Some(measured), Some(again)) => (measured, again),
        _ => (first.speed_rad_s.as_ref()?, second.speed_rad_s.as_ref()?),
    };
    let offset = second.time_s[0] - first.time_s[0] + shift_s;
    let at = |(time, value): (&f64, &f64)| Some(interpolate(&second.time_s, again, time + offset)? - value);
    Some(first.time_s.iter().zip(measured).filter_map(at).collect())
}

/// By how much later, in s, the second record runs the same programme; `None` if it does not.
fn aligned(first: &Record, second: &Record) -> Option<f64> {
    let interval = median_interval(&first.time_s);
    let similar = |a: f64, b: f64| (a - b).abs() <= SAME_LENGTH * a.max(b);
    if interval <= 0.0
        || !similar(interval, median_interval(&second.time_s))
        || !similar(first.duration_s(), second.duration_s())
    {
        return None;
    }
    let tolerance = SAME_VOLTAGE * span(&first.voltage_v);
    if tolerance <= 0.0 {
        return None;
    }
    let share = |shift: i64| {
        let offset = second.time_s[0] - first.time_s[0] + shift as f64 * interval;
        let (mut other, mut compared) = (0usize, 0usize);
        for (time, voltage) in first.time_s.iter().zip(&first.voltage_v) {
            if let Some(index) = nearest(&second.time_s, time + offset) {
                compared += 1;
                other += usize::from((second.voltage_v[index] - voltage).abs() > tolerance);
                if other as f64 > (1.0 - SAME_SHARE) * first.len() as f64 {
                    return 0.0; // whatever the rest is like
                }
            }
        }
        if compared * 10 < first.len() * 9 { 0.0 } else { 1.0 - other as f64 / compared as f64 }
    };
    let mut best = (0.0, 0);
    // The smallest shift first: nothing is more alike than all of it.
    for shift in std::iter::once(0).chain((1..=LARGEST_SHIFT).flat_map(|shift| [shift, -shift])) {
        let share = share(shift);
        if share > best.0 {
            best = (share, shift);
        }
        if share == 1.0 {
            break;
        }
    }
    (best.0 >= SAME_SHARE).then_some(best.1 as f64 * interval)
}

/// The sample nearest to `time`, or `None` outside the record.
fn nearest(times: &[f64], time: f64) -> Option<usize> {
    let after = times.partition_point(|t| *t < time);
    let half = (times[times.len() - 1] - times[0]) / times.len() as f64;
    match after {
        0 => (times[0] - time <= half).then_some(0),
        n if n == times.len() => (time - times[n - 1] <= half).then_some(n - 1),
        n => Some(if times[n] - time < time - times[n - 1] { n } else { n - 1 }),
    }
}

fn interpolate(times: &[f64], values: &[f64], time: f64) -> Option<f64> {
    let after = times.partition_point(|t| *t <= time);
    if after == 0 || after == times.len() {
        return (times.last() == Some(&time)).then(|| values[values.len() - 1]);
    }
    let share = (time - times[after - 1]) / (times[after] - times[after - 1]);
    Some(values[after - 1] + share * (values[after] - values[after - 1]))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A record whose voltage steps at every 20th sample by a fixed sequence, beginning `late` samples into it.
    fn run(seed: usize, late: usize, origin_s: f64, noise: f64) -> Record {
        let at = |i: usize| {
            let k = i + late;
            (((k / 20) * (seed * 2 + 1) * 7919) % 13) as f64 - 6.0
        };
        Record {
            time_s: (0..1000).map(|i| origin_s + i as f64 * 0.01).collect(),
            voltage_v: (0..1000).map(at).collect(),
            angle_rad: Some(
                (0..1000)
                    .map(|i| {
                        let sign = if (i * i / 3 + seed).is_multiple_of(2) { 1.0 } else { -1.0 };
                        origin_s + ((i + late) as f64 * 0.02).sin() + sign * noise
                    })
                    .collect(),
            ),
            ..Record::default()
        }
    }

    #[test]
    fn repeats_are_recognised_whatever_their_clock_and_small_delay() {
        let records = [run(1, 0, 0.0, 0.0), run(2, 0, 0.0, 0.0), run(1, 0, 500.0, 0.0), run(1, 6, 9.0, 0.0)];
        assert_eq!(find_repeats(&records), [(0, 2), (0, 3), (2, 3)]);
    }

    #[test]
    fn the_floor_is_the_noise_of_one_run() {
        let quiet = run(1, 0, 0.0, 0.0);
        let noisy = run(1, 0, 3.0, 0.02);
        let floor = noise_floor(&quiet, &noisy).unwrap();
        // All of the difference comes from one of the two runs, so each is charged 0.02 / sqrt(2).
        assert!((floor - 0.02 / 2f64.sqrt()).abs() < 1e-4, "{floor}");
        assert!(noise_floor(&quiet, &run(1, 6, 0.0, 0.0)).unwrap() < 1e-4);
        assert_eq!(noise_floor(&quiet, &run(2, 0, 0.0, 0.0)), None);
    }

    #[test]
    fn records_of_other_length_rate_or_without_voltage_are_no_repeats() {
        let mut short = run(1, 0, 0.0, 0.0);
        short.time_s.truncate(500);
        short.voltage_v.truncate(500);
        let mut slow = run(1, 0, 0.0, 0.0);
        slow.time_s.iter_mut().for_each(|t| *t *= 2.0);
        let mut still = run(1, 0, 0.0, 0.0);
        still.voltage_v.fill(0.0);
        assert!(find_repeats(&[run(1, 0, 0.0, 0.0), short, slow, still.clone(), still]).is_empty());
    }
}
