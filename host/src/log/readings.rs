//! Speeds that are late, filtered, or blind near zero, and counters that lose edges beside them.

use super::Record;
use super::agreement::{agreement, counts_of_a_turn};
use super::motion::{low_pass, peak};
use super::suspicion::Odd;
use super::timing::median_interval;

/// Angle and integrated speed may differ by this share.
const DRIFT: f64 = 0.02;
/// How late the speed may be beside its angle, and over how long a mean may be taken, s, and the steps in which that is tried.
const LATEST_S: f64 = 0.2;
const LATE_STEP_S: f64 = 0.01;
/// A speed that lags longer than this is said to do so, ...
const LATE_S: f64 = 0.02;
/// ... as is one that comes so many rows or more behind the motion, which a mean does by half of its length.
const LATE_ROWS: f64 = 2.0;
/// ... where that explains all but this share of what parts it from the angle at once.
const EXPLAINED: f64 = 0.5;

/// How a speed may lag behind the motion.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Lag {
    /// By so many seconds.
    Late(f64),
    /// As its mean over the last seconds.
    Mean(f64),
    /// Behind a first-order filter of this time constant, s.
    Filter(f64),
}

impl Lag {
    fn seconds(self) -> f64 {
        let (Lag::Late(seconds) | Lag::Mean(seconds) | Lag::Filter(seconds)) = self;
        seconds
    }

    /// The angle whose slope the speed then is, at the samples `places`.
    fn angle(self, time_s: &[f64], angle: &[f64], places: &[usize]) -> Vec<f64> {
        let late = |late_s: f64| {
            let mut after = 1;
            places.iter().map(move |place| {
                let t = time_s[*place] - late_s;
                while after + 1 < time_s.len() && time_s[after] <= t {
                    after += 1;
                }
                let part = ((t - time_s[after - 1]) / (time_s[after] - time_s[after - 1])).clamp(0.0, 1.0);
                angle[after - 1] + part * (angle[after] - angle[after - 1])
            })
        };
        match self {
            Lag::Late(late_s) => late(late_s).collect(),
            // The mean speed over a window ends with the window.
            Lag::Mean(mean_s) => {
                let mut sum = 0.0;
                let (to, from): (Vec<f64>, Vec<f64>) = (late(0.0).collect(), late(mean_s).collect());
                let mean = |k: usize| (to[k] - from[k]) / mean_s;
                let passed = (0..to.len()).map(|k| {
                    let before = k.saturating_sub(1);
                    sum += 0.5 * (mean(k) + mean(before)) * (time_s[places[k]] - time_s[places[before]]);
                    sum
                });
                passed.collect()
            }
            Lag::Filter(tau_s) => {
                let filtered = low_pass(time_s, angle, tau_s);
                places.iter().map(|place| filtered[*place]).collect()
            }
        }
    }
}

/// What is left between speed and angle if the speed lags so.
#[derive(Debug, Clone, Copy)]
struct Trial {
    lag: Lag,
    way: f64,
    share: f64,
    left: f64,
}

/// The angle falls behind the speed that stands beside it; a late or filtered speed is no such thing and told as what it is.
pub(super) fn speed_beside_angle(record: &Record) -> Option<Odd> {
    let (angle, speed) = (record.angle_rad.as_ref()?, record.speed_rad_s.as_ref()?);
    let time = &record.time_s;
    if time.len() < 2 {
        return None;
    }
    let step = median_interval(time).max(LATE_STEP_S);
    // The way by the speed, at all samples, and where it is compared: fast records at every few samples only.
    let (mut places, mut ways, mut way) = (vec![0], vec![0.0], 0.0);
    for k in 1..record.len() {
        way += 0.5 * (speed[k] + speed[k - 1]) * (time[k] - time[k - 1]);
        if time[k] - time[places[places.len() - 1]] > 0.4 * LATE_STEP_S {
            places.push(k);
            ways.push(way);
        }
    }
    let trial = |lag: Lag| {
        let lagging = lag.angle(time, angle, &places);
        let (mut way, mut lost, mut left) = (0.0, 0.0, 0.0);
        for k in 1..places.len() {
            // Before that nothing tells what the speed was made of.
            if time[places[k - 1]] - lag.seconds() < time[0] {
                continue;
            }
            let passed: f64 = ways[k] - ways[k - 1];
            let missed = passed - (lagging[k] - lagging[k - 1]);
            way += passed.abs();
            lost += missed * passed.signum();
            left += missed * missed;
        }
        Trial { lag, way, share: lost / way, left }
    };
    let steps = (LATEST_S / step) as usize;
    let seconds = || (1..=steps).map(|k| k as f64 * step);
    let late = seconds().map(|s| trial(Lag::Late(s)));
    let means = seconds().map(|s| trial(Lag::Mean(s)));
    let filters = seconds().map(|s| trial(Lag::Filter(s)));
    let at_once = trial(Lag::Late(0.0));
    let best = std::iter::once(at_once)
        .chain(late)
        .chain(means)
        .chain(filters)
        .min_by(|a, b| a.left.total_cmp(&b.left))?;
    // Lost counts only ever make the angle fall short: where it goes further, or does so at once and only falls short of a
    // speed taken for late, the speed is what errs. A whole factor is a matter of units, and told as such.
    if best.way > 1.0 && at_once.share > DRIFT && best.share > DRIFT && best.share < 0.3 {
        return Some((
            "lost_counts",
            "angle_rad",
            format!("the angle misses {:.1} % of the way that the speed beside it makes", 100.0 * best.share),
            "check the counter at high speed (interrupts, filters, cable); motorlens discover can name the effect lost_counts".into(),
        ));
    }
    // What is off by far is a fault of the units, which is told without this.
    if best.way > 1.0
        && (0.3..0.99).contains(&best.share.abs())
        && agreement(record).is_none()
        && let Some(fix) = counts_of_a_turn(record, 1.0 / (1.0 - best.share))
    {
        return Some((
            "wrong_counts_per_rev",
            "angle_rad",
            format!("the angle goes {:.3} times as far as the speed beside it says", 1.0 - best.share),
            fix,
        ));
    }
    let ms = 1e3 * best.lag.seconds();
    let how = match best.lag {
        Lag::Late(_) => "late by",
        Lag::Mean(_) => "a mean over",
        Lag::Filter(_) => "behind a filter of",
    };
    let behind_s = if let Lag::Mean(mean_s) = best.lag { 0.5 * mean_s } else { best.lag.seconds() };
    let is_late =
        behind_s > 0.99 * (LATE_ROWS * median_interval(time)).max(LATE_STEP_S) || 1e-3 * ms > LATE_S;
    (is_late && best.left < EXPLAINED * at_once.left && best.way > 1.0).then(|| {
        (
            "late_speed",
            "speed_rad_s",
            format!("the speed is {how} {ms:.0} ms beside the angle, which is right: the angle is used and the speed is not"),
            "nothing, if the angle is what counts; else log the speed without its filter".into(),
        )
    })
}

/// A sensor is blind where no reading lies nearer to zero than this share of the fastest ...
const BLIND: f64 = 0.04;
/// ... though so many lie just above, in so many different values,
const JUST_ABOVE: usize = 30;
const LEVELS: usize = 12;
/// and the motion passes through so often.
const PASSES: usize = 4;

/// A step through zero is so many times as long as the next one, where it leaves out what lies between.
const LEAP: f64 = 2.0;

/// Whether the speed leaves out what lies next to zero with its step to sample `k`: it gets there, or passes, by a step that is far longer
/// than the one beside it in which the motor moves. At one that is as long the motor is only fast.
fn is_leap(speed: &[f64], k: usize) -> bool {
    let (before, after) = (speed[k - 1], speed[k]);
    let length = |from: usize| match (speed.get(from), speed.get(from + 1)) {
        (Some(one), Some(other)) => (other - one).abs(),
        _ => 0.0,
    };
    // The sample before the first one is none.
    let braking = if k > 1 && before != 0.0 { length(k - 2) } else { 0.0 };
    let starting = if after != 0.0 { length(k) } else { 0.0 };
    let passes = before * after < 0.0 || (before == 0.0) != (after == 0.0);
    passes && (after - before).abs() > LEAP * braking.max(starting)
}

/// The speed is never read near zero, although the motor reverses or stops.
pub(super) fn blind_near_zero(record: &Record) -> Option<Odd> {
    let speed = record.speed_rad_s.as_ref()?;
    let fastest = peak(speed);
    let lowest = speed.iter().map(|w| w.abs()).filter(|w| *w > 0.0).fold(f64::MAX, f64::min);
    if !(lowest > BLIND * fastest && lowest < 0.5 * fastest) {
        return None;
    }
    let mut above: Vec<f64> =
        speed.iter().map(|w| w.abs()).filter(|w| *w > 0.0 && *w < 3.0 * lowest).collect();
    above.sort_by(f64::total_cmp);
    let all = above.len();
    // A speed in whole counts a sample has few values near zero, evenly spaced.
    above.dedup_by(|a, b| (*a - *b).abs() < 1e-9 * fastest);
    let passes = (1..speed.len()).filter(|k| is_leap(speed, *k)).count();
    (passes >= PASSES && all >= JUST_ABOVE && above.len() >= LEVELS).then(|| {
        (
            "blind_near_zero",
            "speed_rad_s",
            format!(
                "the speed never reads between {:.3} and {lowest:.3} rad/s, and passes there {passes} times: its sensor does not see slow motion, \
                 which looks like friction",
                -lowest
            ),
            "log the angle, or the encoder's count (--map angle=COLUMN:counts), which slow motion shows too".into(),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::motion::slope;
    use crate::log::usable::tests::motor;

    fn both(change: impl Fn(&mut Vec<f64>)) -> Record {
        let mut record = motor();
        let mut speed = slope(&record.time_s, record.angle_rad.as_ref().unwrap());
        change(&mut speed);
        record.speed_rad_s = Some(speed);
        record
    }

    fn alone(change: impl Fn(&mut Vec<f64>)) -> Record {
        Record { angle_rad: None, ..both(change) }
    }

    #[test]
    fn a_late_or_filtered_speed_is_told_and_no_counter_is_blamed() {
        let late = both(|w| w.rotate_right(8));
        let mean = both(|w| {
            let before = w.clone();
            for k in 10..w.len() {
                w[k] = before[k - 10..k].iter().sum::<f64>() / 10.0;
            }
        });
        let filtered = both(|w| {
            let mut state = w[0];
            for w in w.iter_mut() {
                state += 0.1 * (*w - state);
                *w = state;
            }
        });
        // Two rows of 200 a second, readings of a noisy angle.
        let mut slow = both(|w| w.rotate_right(2));
        slow.time_s.iter_mut().for_each(|t| *t *= 0.005 / median_interval(&motor().time_s));
        slow.speed_rad_s.iter_mut().flatten().for_each(|w| *w *= median_interval(&motor().time_s) / 0.005);
        for record in [late, mean, filtered, slow] {
            let (name, _, why, _) = speed_beside_angle(&record).unwrap();
            assert_eq!(name, "late_speed", "{why}");
        }
        assert_eq!(speed_beside_angle(&both(|_| ())), None);
    }

    #[test]
    fn counts_per_turn_that_contradict_the_speed_are_told_with_the_right_ones() {
        let mut record = both(|w| w.iter_mut().for_each(|w| *w /= 1.55));
        record.map = Some("time=t:s,voltage=u:V,angle=enc:counts,speed=w:rpm".parse().unwrap());
        record.meta.insert("counts_per_rev", "1320").unwrap();
        let (name, _, _, fix) = speed_beside_angle(&record).unwrap();
        assert!(name == "wrong_counts_per_rev" && fix.contains("--counts-per-rev 20"), "{fix}");
        record.map = None;
        assert!(speed_beside_angle(&record).is_none_or(|odd| odd.0 != "wrong_counts_per_rev"));
    }

    #[test]
    fn a_counter_that_loses_edges_is_told_and_an_angle_that_goes_further_lost_none() {
        let lossy = both(|w| w.iter_mut().for_each(|w| *w *= 1.1));
        assert_eq!(speed_beside_angle(&lossy).unwrap().0, "lost_counts");
        let further = both(|w| w.iter_mut().for_each(|w| *w /= 1.1));
        assert_eq!(speed_beside_angle(&further), None);
    }

    #[test]
    fn a_speed_that_is_never_read_near_zero_is_told_and_counts_a_sample_are_not() {
        let wave = |w: &mut Vec<f64>| {
            for (k, w) in w.iter_mut().enumerate() {
                *w = 20.0 * (0.02 * k as f64).sin();
            }
        };
        for mode in 0..3 {
            let record = alone(|w| {
                wave(w);
                let mut last = 0.0;
                for w in w.iter_mut() {
                    let seen = w.abs() > 1.5;
                    *w = match mode {
                        _ if seen => *w,
                        0 => 0.0,
                        1 => last,
                        _ => 1.5_f64.copysign(*w),
                    };
                    last = *w;
                }
            });
            let odd = blind_near_zero(&record);
            assert!(odd.is_some_and(|odd| odd.2.contains("between -1.5")), "{mode}");
        }
        assert_eq!(blind_near_zero(&alone(wave)), None);
        let counted = alone(|w| {
            wave(w);
            w.iter_mut().for_each(|w| *w = (*w / 1.5).round() * 1.5);
        });
        assert_eq!(blind_near_zero(&counted), None);
    }

    /// Rows as long as the motor's time constant: it is at a third of its speed in the first of them.
    #[test]
    fn a_motor_that_starts_within_few_rows_has_no_blind_sensor() {
        let starts = |first: f64| {
            let levels = |k: usize| match k % 40 {
                0..=9 => 0.0,
                10 => first + 0.01 * (k as f64).sin(),
                11 => 23.0,
                _ => 30.0 + (k as f64).sin(),
            };
            let record = alone(|w| w.iter_mut().enumerate().for_each(|(k, w)| *w = levels(k)));
            let speed = record.speed_rad_s.unwrap();
            (1..speed.len()).filter(|k| speed[k - 1] == 0.0 && is_leap(&speed, *k)).count()
        };
        assert_eq!(starts(11.0), 0);
        assert!(starts(20.0) > 0);
    }
}
