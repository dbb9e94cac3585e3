//! A motor that stands while its drive goes on to both sides: the driver was off, whatever it was told.
//!
//! A stop and a weight hold against one side, friction against a drive that turns the motor nowhere else. What holds against both sides is
//! a driver that is off, a shaft that is held, or a sensor that stands.

use std::ops::Range;

use super::Record;
use super::labels::Labels;
use super::motion::{STANDS, peak, speed, stretches};
use super::suspicion::Odd;
use super::switched_off::without;
use super::times::ranges_in_words;

/// A drive pushes from this share of the highest on, and turns the motor elsewhere in this share of the samples in which it does.
const PUSHES: f64 = 0.4;
const ELSEWHERE: f64 = 0.8;
/// It stands for so long, s, and is pushed to either side for so long, in so many samples.
const LONG_S: f64 = 0.5;
const PUSHED_S: f64 = 0.1;
const FEWEST: usize = 4;

/// The motor stands amid a drive that goes to both sides.
pub(super) fn stands_amid(record: &Record) -> Option<Odd> {
    if record.is_of_position_loop() {
        return None;
    }
    let (time, volts, speed) = (&record.time_s, &record.voltage_v, speed(record));
    if speed.len() != record.len() || record.is_empty() {
        return None;
    }
    let (fastest, highest) = (peak(&speed), peak(volts));
    let stands = |k: usize| speed[k].abs() <= STANDS * fastest;
    let pushes = |k: &usize| volts[*k].abs() >= PUSHES * highest;
    let pushed = |run: &Range<usize>, side: f64| {
        let samples = run.clone().filter(|k| volts[*k] * side >= PUSHES * highest);
        let held = |k: usize| time.get(k + 1).map_or(0.0, |next| next - time[k]);
        let (count, for_s) = samples.fold((0, 0.0), |(count, for_s), k| (count + 1, for_s + held(k)));
        count >= FEWEST && for_s >= PUSHED_S
    };
    let mut found = stretches(record.len(), stands);
    found
        .retain(|run| time[run.end - 1] - time[run.start] >= LONG_S && pushed(run, 1.0) && pushed(run, -1.0));
    let pushing = || (0..record.len()).filter(pushes);
    let turning = pushing().filter(|k| !stands(*k)).count();
    let elsewhere = pushing().count() - found.iter().cloned().flatten().filter(pushes).count();
    if found.is_empty()
        || fastest == 0.0
        || highest == 0.0
        || (turning as f64) < ELSEWHERE * elsewhere as f64
        || turning < FEWEST
    {
        return None;
    }
    let last = record.len() - 1;
    let times: Vec<(f64, f64)> = found.iter().map(|run| (time[run.start], time[run.end.min(last)])).collect();
    Some((
        "switched_off",
        "voltage_v",
        format!(
            "the motor stands from {} while its drive goes to both sides and turns it elsewhere: the driver was off whatever it was told, \
             something held the shaft, or its sensor stood{}",
            ranges_in_words(&times),
            Labels::of(record.labels.as_ref(), &times)
        ),
        without(record, &times),
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor with friction of 0.5 V under steps to both sides, on while `on`, between stops at `limit` rad.
    fn motor(limit: f64, on: impl Fn(f64) -> bool) -> Record {
        let levels = [8.0, -6.0, 3.0, -10.0, 5.0, -7.0, 9.0, -2.0];
        let time_s: Vec<f64> = (0..1600).map(|k| f64::from(k) * 0.01).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| levels[(2.5 * t) as usize % 8]).collect();
        let (mut x, mut w) = (0.0_f64, 0.0_f64);
        let angles = time_s.iter().zip(&voltage_v).map(|(t, volts)| {
            for _ in 0..10 {
                let push = if on(*t) { *volts } else { 0.0 };
                let held = if w == 0.0 { push.clamp(-0.5, 0.5) } else { 0.5 * w.signum() };
                let next = w + 0.001 / 0.08 * (2.0 * (push - held) - w);
                w = if w * next < 0.0 { 0.0 } else { next };
                x += 0.001 * w;
                if x.abs() > limit {
                    (x, w) = (limit * x.signum(), 0.0);
                }
            }
            x
        });
        let angle_rad = Some(angles.collect());
        Record { name: "run".into(), time_s, voltage_v, angle_rad, ..Record::default() }
    }

    #[test]
    fn a_driver_that_is_off_amid_its_commands_is_told_with_the_ranges_to_skip() {
        let (name, _, why, fix) =
            stands_amid(&motor(1e9, |t| !(5.0..7.5).contains(&t) && !(12.0..13.5).contains(&t))).unwrap();
        assert!(name == "switched_off" && why.contains("to both sides"), "{why}");
        assert!(fix.contains("--skip run:5.") && fix.contains("--skip run:12."), "{fix}");
    }

    #[test]
    fn what_always_drives_and_what_meets_stops_is_none() {
        for limit in [1e9, 2.0, 0.5] {
            assert_eq!(stands_amid(&motor(limit, |_| true)), None, "{limit} rad");
        }
        // Where nothing ever turns at such a drive it is friction.
        let mut stuck = motor(1e9, |t| t < 1.0);
        stuck.voltage_v.iter_mut().take(100).for_each(|v| *v *= 0.3);
        assert_eq!(stands_amid(&stuck), None);
        // What runs out with nothing that drives it.
        let mut runs_out = motor(1e9, |t| t < 1.0);
        runs_out.voltage_v.iter_mut().for_each(|v| *v = 0.0);
        assert_eq!(stands_amid(&runs_out), None);
    }
}
