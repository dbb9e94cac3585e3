//! A driver that was switched off while its command stayed: the log says driven, and the motor stands.
//!
//! Friction may keep a motor standing at a drive that keeps another one turning, but it ends no steady motion at an unchanged drive. A
//! weight, a spring and a stop do, each at the same angle again. So the motion must have ended, and the motor have stood elsewhere too.

use std::ops::Range;

use super::Record;
use super::labels::Labels;
use super::motion::{STANDS, angle, peak, span, speed};
use super::quantum::quantum;
use super::suspicion::Odd;
use super::times::{ranges_in_words, skip_of};
use super::timing::median;

/// A command that stays is the same number, but for how a quotient is rounded, as a share of the highest.
const SAME: f64 = 1e-6;
/// A drive of less than this share of the highest drives nothing.
const DRIVEN: f64 = 0.05;
/// The motor turns above this share of its highest speed.
const TURNS: f64 = 0.1;
/// It stands for so many samples at least, and for this share of the record; all together for that one.
const FEWEST: usize = 10;
const LONG: f64 = 0.03;
const ALL_LONG: f64 = 0.1;
/// It turns steadily within this share of its usual speed at a drive, in half of the samples in which it turns there, and for so many readings
/// before it stands.
const EVEN: f64 = 0.25;
const FEWEST_EVEN: f64 = 8.0;
/// What runs down would come to rest at about the rate at which it gets slower: at the rate of a steady motion less than this share of the
/// speed would be gone by then. The rate is the highest that the scatter of the readings allows, in so many standard errors.
const FALLS: f64 = 0.35;
const SURE: f64 = 2.0;
/// Rests of a motor at a stop or under a weight are nearer to each other than this share of the whole way.
const APART: f64 = 0.05;

/// The motor stands at a drive at which it turns elsewhere, and steady motion ended without a change of the drive.
pub(super) fn switched_off(record: &Record) -> Option<Odd> {
    // A position loop holds the shaft where it is.
    if record.is_of_position_loop() {
        return None;
    }
    let seen = Seen::of(record)?;
    let rests = seen.rests();
    let (level, settled, all) = rests.iter().find_map(|rest| {
        let level = seen.drive[rest.start];
        let settled = seen.settled(level)?;
        seen.before(rest, settled)?;
        let all: Vec<&Range<usize>> =
            rests.iter().filter(|other| seen.is_same(seen.drive[other.start], level)).collect();
        seen.is_switched_off(&all).then_some((level, settled, all))
    })?;
    let last = record.len() - 1;
    let times = all.iter().map(|rest| {
        let from = seen.before(rest, settled).unwrap_or(rest.start);
        (record.time_s[from], record.time_s[rest.end.min(last)])
    });
    let times: Vec<(f64, f64)> = times.collect();
    let of = if seen.by_supply { "of the supply" } else { "V" };
    Some((
        "switched_off",
        "voltage_v",
        format!(
            "the motor stands from {} at a drive of {level:.3} {of} that turns it steadily at {:.2} rad/s elsewhere, and its motion ended \
             without a change of the drive: the driver was off while its command stayed, or something held the shaft{}",
            ranges_in_words(&times),
            settled * level.signum(),
            Labels::of(record.labels.as_ref(), &times)
        ),
        without(record, &times),
    ))
}

/// The remedy where the driver was off at these `times` of `record`.
pub(super) fn without(record: &Record, times: &[(f64, f64)]) -> String {
    format!(
        "no model turns and stands at one drive: leave that out with {}, and log a duty of 0 while the driver is off (a column of the log may \
         tell when: command, state, power, enable)",
        skip_of(record, times)
    )
}

/// A record as its drive commanded it and as it moved.
struct Seen {
    /// The command: the voltage, or its share of the supply where that is what stays the same.
    drive: Vec<f64>,
    by_supply: bool,
    highest: f64,
    speed: Vec<f64>,
    fastest: f64,
    /// Samples that repeat one reading of the speed, in the median.
    repeats: f64,
    /// The quantisation step of the speed, rad/s; 0 where it has none.
    step: f64,
    /// Where the shaft is, in any unit.
    angle: Vec<f64>,
}

impl Seen {
    fn of(record: &Record) -> Option<Seen> {
        let speed = speed(record);
        if speed.len() != record.len() || speed.is_empty() {
            return None;
        }
        let volts = &record.voltage_v;
        let has_both = |values: &[f64]| values.iter().any(|v| *v < 0.0) && values.iter().any(|v| *v > 0.0);
        // Without its sign a speed does not tell where the shaft is.
        if record.angle_rad.is_none() && has_both(volts) && !has_both(&speed) {
            return None;
        }
        let stays = |drive: &[f64]| {
            let same = SAME * peak(drive);
            drive.windows(2).filter(|pair| (pair[1] - pair[0]).abs() <= same).count()
        };
        let share = record.supply_v.as_ref().filter(|supply| supply.iter().all(|v| *v > 0.0));
        let share = share.map(|supply| volts.iter().zip(supply).map(|(v, s)| v / s).collect::<Vec<f64>>());
        let share = share.filter(|share| stays(share) > stays(volts));
        let by_supply = share.is_some();
        let drive = share.unwrap_or_else(|| volts.clone());
        let (highest, fastest) = (peak(&drive), peak(&speed));
        let readings = speed.chunk_by(|one, next| one == next).filter(|same| same[0].abs() > TURNS * fastest);
        let repeats = median(&mut readings.map(|same| same.len() as f64).collect::<Vec<f64>>()).max(1.0);
        let step = quantum(&speed).unwrap_or(0.0);
        Some(Seen { drive, by_supply, highest, speed, fastest, repeats, step, angle: angle(record) })
    }

    fn is_same(&self, one: f64, other: f64) -> bool {
        (one - other).abs() <= SAME * self.highest
    }

    fn is_slow(&self, k: usize) -> bool {
        self.speed[k].abs() <= STANDS * self.fastest
    }

    /// The ranges of samples in which the motor stands at one drive.
    fn rests(&self) -> Vec<Range<usize>> {
        let stands = |k: usize| self.is_slow(k) && self.drive[k].abs() > DRIVEN * self.highest;
        let fewest = FEWEST.max((LONG * self.speed.len() as f64) as usize);
        let (mut found, mut k) = (Vec::new(), 0);
        while k < self.speed.len() {
            let begin = k;
            while k < self.speed.len() && stands(k) && self.is_same(self.drive[k], self.drive[begin]) {
                k += 1;
            }
            if k - begin >= fewest {
                found.push(begin..k);
            }
            k = k.max(begin + 1);
        }
        found
    }

    /// The speed along the drive at which the motor mostly turns at `level`.
    fn settled(&self, level: f64) -> Option<f64> {
        let at_level = self.drive.iter().zip(&self.speed).filter(|(drive, _)| self.is_same(**drive, level));
        let along = at_level.map(|(_, speed)| speed * level.signum());
        let mut turning: Vec<f64> = along.filter(|speed| *speed > TURNS * self.fastest).collect();
        let usual = median(&mut turning);
        let even = turning.iter().filter(|speed| is_near(**speed, usual)).count();
        (even > 0 && 2 * even >= turning.len()).then_some(usual)
    }

    /// The last sample of steady motion, `settled`, that ended in `rest` without a change of the drive.
    fn before(&self, rest: &Range<usize>, settled: f64) -> Option<usize> {
        let level = self.drive[rest.start];
        let is_even = |k: &usize| is_near(self.speed[*k] * level.signum(), settled);
        let driven = (0..rest.start).rev().take_while(|k| self.is_same(self.drive[*k], level));
        let turned = driven.skip_while(|k| !is_even(k)).take_while(|k| !self.is_slow(*k));
        let mut even: Vec<usize> = turned.filter(is_even).collect();
        even.reverse();
        let last = *even.last()?;
        self.is_steady(&even, rest.start).then_some(last)
    }

    /// Whether the motor kept its speed in the samples `even` before it stood from `rest` on, rather than ran down to there.
    fn is_steady(&self, even: &[usize], rest: usize) -> bool {
        let readings = even.len() as f64 / self.repeats;
        if readings < FEWEST_EVEN {
            return false;
        }
        let speed = |k: usize| self.speed[k].abs();
        let usual = mean(even, speed);
        let scatter = mean(even, |k| (speed(k) - usual).powi(2)).sqrt();
        let (early, late) = even.split_at(even.len() / 2);
        let error = 2.0 * scatter / readings.sqrt();
        let fell = mean(early, speed) - mean(late, speed) + SURE * error + 0.5 * self.step;
        let passed = mean(late, |k| k as f64) - mean(early, |k| k as f64);
        fell * (rest - late[0]) as f64 <= FALLS * usual * passed
    }

    /// Whether rests at one drive are long, and at different angles.
    fn is_switched_off(&self, rests: &[&Range<usize>]) -> bool {
        let samples: usize = rests.iter().map(|rest| rest.len()).sum();
        let angles: Vec<f64> = rests.iter().map(|rest| self.angle[rest.end - 1]).collect();
        samples as f64 >= ALL_LONG * self.speed.len() as f64 && span(&angles) > APART * span(&self.angle)
    }
}

fn is_near(speed: f64, usual: f64) -> bool {
    (speed - usual).abs() <= EVEN * usual
}

/// The mean of a value over these samples.
fn mean(samples: &[usize], value: impl Fn(usize) -> f64) -> f64 {
    samples.iter().map(|k| value(*k)).sum::<f64>() / samples.len() as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor with a time constant, dry friction of 1 V and a `load` (V) by angle, driven by `command`, on while `on`.
    fn motor(
        tau_s: f64,
        command: impl Fn(f64) -> f64,
        on: impl Fn(f64) -> bool,
        load: impl Fn(f64) -> f64,
    ) -> Record {
        let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| command(*t)).collect();
        let (mut x, mut w) = (0.0, 0.0_f64);
        let speeds = time_s.iter().zip(&voltage_v).map(|(t, volts)| {
            for _ in 0..10 {
                let push = if on(*t) { *volts } else { 0.0 } - load(x);
                let friction = if w == 0.0 { push.clamp(-1.0, 1.0) } else { w.signum() };
                let next = w + 0.001 / tau_s * (2.0 * (push - friction) - w);
                w = if w * next < 0.0 { 0.0 } else { next };
                x += 0.001 * w;
            }
            w
        });
        let speed_rad_s = Some(speeds.collect());
        Record { name: "run".into(), time_s, voltage_v, speed_rad_s, ..Record::default() }
    }

    fn driven(command: impl Fn(f64) -> f64, on: impl Fn(f64) -> bool, load: impl Fn(f64) -> f64) -> Record {
        motor(0.05, command, on, load)
    }

    fn levels(t: f64) -> f64 {
        [4.0, 8.0, 4.0, 6.0, 4.0][(t / 2.0) as usize % 5]
    }

    fn on_at_times(t: f64) -> bool {
        (1.0..5.0).contains(&t) || (6.0..9.0).contains(&t)
    }

    /// The same record as sensors tell it: with noise while it turns, quantised, and held for some rows.
    fn measured(record: &Record) -> [(&'static str, Record); 5] {
        let speed = record.speed_rad_s.clone().unwrap();
        let with = |noise: f64, step: f64, held: usize| {
            let noisy =
                |(k, w): (usize, &f64)| if *w == 0.0 { 0.0 } else { w + noise * ((k * k) as f64).sin() };
            let noisy: Vec<f64> = speed.iter().enumerate().map(noisy).collect();
            let reading = |k: usize| noisy[k - k % held];
            let rounded = |w: f64| if step > 0.0 { (w / step).round() * step } else { w };
            let speed_rad_s = Some((0..noisy.len()).map(|k| rounded(reading(k))).collect());
            Record { speed_rad_s, ..record.clone() }
        };
        [
            ("exact", with(0.0, 0.0, 1)),
            ("held", with(0.0, 0.0, 5)),
            ("quantised", with(0.0, 0.5, 1)),
            ("noisy", with(0.3, 0.0, 1)),
            ("all of it", with(0.3, 0.5, 5)),
        ]
    }

    #[test]
    fn a_driver_that_is_off_while_its_command_stays_is_told_with_the_ranges_to_skip() {
        let record = driven(levels, on_at_times, |_| 0.0);
        let (name, _, why, fix) = switched_off(&record).unwrap();
        assert_eq!(name, "switched_off");
        assert!(why.contains("4.000 V that turns it steadily at 6.00 rad/s"), "{why}");
        assert!(fix.contains("--skip run:0.000..") && fix.contains("--skip run:9."), "{fix}");
        // A duty of a supply that sags is the same drive.
        let supply_v: Vec<f64> = record.time_s.iter().map(|t| 12.0 - 0.1 * t).collect();
        let voltage_v = record.voltage_v.iter().zip(&supply_v).map(|(v, s)| v / 12.0 * s).collect();
        let (.., why, _) = switched_off(&Record { voltage_v, supply_v: Some(supply_v), ..record }).unwrap();
        assert!(why.contains("0.333 of the supply"), "{why}");
    }

    #[test]
    fn a_driver_that_is_off_is_told_by_readings_that_are_held_quantised_or_noisy() {
        for (what, record) in measured(&driven(levels, on_at_times, |_| 0.0)) {
            assert_eq!(switched_off(&record).unwrap().0, "switched_off", "{what}");
        }
    }

    #[test]
    fn a_motor_that_runs_down_to_rest_on_the_last_step_of_a_staircase_is_not_switched_off() {
        for tau_s in [0.05, 0.2] {
            for steps in [&[8.0, 6.0, 4.0, 2.0, 0.8][..], &[8.0, 4.0, 2.0, 0.8], &[8.0, 0.8]] {
                let staircase = |t: f64| steps[t as usize % steps.len()];
                for (what, record) in measured(&motor(tau_s, staircase, |_| true, |_| 0.0)) {
                    assert_eq!(switched_off(&record), None, "{what} after {steps:?}, {tau_s} s");
                }
            }
        }
    }

    #[test]
    fn what_stands_by_friction_a_stop_a_weight_or_a_brake_was_driven() {
        let always = |_: f64| true;
        let slow_ramp = |t: f64| 1.6 * (0.6 * t).sin();
        let to_and_fro = |t: f64| [4.0, -4.0, 4.0, 0.0][t as usize % 4];
        for (what, record) in [
            ("free", driven(levels, always, |_| 0.0)),
            ("runs down", driven(|t| if t % 2.0 < 1.0 { 8.0 } else { 0.0 }, always, |_| 0.0)),
            (
                "runs down to rest at a drive that is too small",
                driven(|t| if t % 2.0 < 1.0 { 8.0 } else { 0.9 }, always, |_| 0.0),
            ),
            ("through the dead zone", driven(slow_ramp, always, |_| 0.0)),
            ("stops", driven(to_and_fro, always, |x: f64| 200.0 * (x - x.clamp(-2.0, 2.0)))),
            ("weight", driven(to_and_fro, always, |x: f64| 6.0 * x.sin())),
            ("spring", driven(to_and_fro, always, |x: f64| 2.0 * x)),
            ("stalled once", driven(levels, |t| t < 9.0, |_| 0.0)),
        ] {
            assert_eq!(switched_off(&record), None, "{what}");
        }
    }
}
