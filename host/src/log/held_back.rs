//! A shaft that something outside held back for a while: the speed falls at an unchanged voltage, and returns.
//!
//! No effect of a motor does that once. What the motor's own load does (a weight, cogging) comes again with every turn and leaves no even
//! speed beside it; a stop does not let go. Averaged into the gain such a range makes the motor weaker than it is.

use std::f64::consts::TAU;

use super::Record;
use super::motion::{peak, speed};
use super::suspicion::Odd;
use super::times::skip_of;
use super::timing::{median, quantile};

/// A voltage is the same within this share of the highest.
const SAME_VOLTS: f64 = 0.03;
/// The shaft is held where the speed is below this share of what it was, and free again above that one.
const HELD: f64 = 0.7;
const FREE: f64 = 0.85;
/// It is held for so many samples and seconds at least: what is shorter is a garbled reading.
const FEWEST: usize = 5;
const SHORTEST_S: f64 = 0.15;
/// Before and after, the speed is within this share of its middle for nearly all of the time, which is longer than so many samples.
const EVEN: f64 = 0.15;
const NEARLY_ALL: f64 = 0.9;
const FEWEST_EVEN: usize = 20;
/// What the speed settles at is this quantile of it: on its way there, and held back, it is less.
const SETTLED: f64 = 0.75;
/// The even speed is most of it, as it is not beside a weight that the motor lifts and lets down.
const MOSTLY: f64 = 0.6;
/// What comes more often in a record is its load, as is what comes again after a turn, within this share of it.
const MOST: usize = 2;
const ONE_TURN: f64 = 0.1;

/// The speed departs at an unchanged voltage and comes back.
pub(super) fn held_back(record: &Record) -> Option<Odd> {
    if record.servo.is_some() {
        return None;
    }
    let speed = speed(record);
    if speed.len() != record.len() {
        return None;
    }
    let highest = peak(&record.voltage_v);
    let mut found: Vec<Departure> = Vec::new();
    let mut begin = 0;
    for k in 1..=record.len() {
        let changes =
            k == record.len() || (record.voltage_v[k] - record.voltage_v[begin]).abs() > SAME_VOLTS * highest;
        if changes {
            if record.voltage_v[begin].abs() > SAME_VOLTS * highest {
                found.extend(departures(&record.time_s[begin..k], &speed[begin..k], begin));
            }
            begin = k;
        }
    }
    let first = found.first().filter(|_| found.len() <= MOST)?;
    if let ([one, other], Some(angle)) = (found.as_slice(), &record.angle_rad)
        && ((angle[other.from] - angle[one.from]).abs() / TAU - 1.0).abs() < ONE_TURN
    {
        return None;
    }
    let time = |k: usize| record.time_s[k.min(record.len() - 1)];
    let named: Vec<String> = found
        .iter()
        .map(|one| {
            format!(
                "{:.3} s to {:.3} s (samples {} to {})",
                time(one.from),
                time(one.to),
                one.from + 1,
                one.to + 1
            )
        })
        .collect();
    let times: Vec<(f64, f64)> = found.iter().map(|one| (time(one.from), time(one.to))).collect();
    Some((
        "held_back",
        if record.speed_rad_s.is_some() { "speed_rad_s" } else { "angle_rad" },
        format!(
            "the speed falls from {:.2} to {:.2} rad/s at an unchanged {:.2} V and comes back, from {}: something outside held the shaft, or a \
             load that comes seldom, and the gain takes it for the motor's own",
            first.before,
            first.lowest,
            record.voltage_v[first.from],
            named.join(" and from ")
        ),
        format!(
            "leave that out with {}, unless the load of the motor does it: then record several turns of it",
            skip_of(record, &times)
        ),
    ))
}

/// From where to where a speed departs, from what, and how far.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Departure {
    from: usize,
    to: usize,
    before: f64,
    lowest: f64,
}

/// The departures of `speed` under one voltage; none where it is uneven otherwise. The first sample is that of number `first`.
fn departures(time_s: &[f64], speed: &[f64], first: usize) -> Vec<Departure> {
    // The sign of the turning does not matter, and what it settles at is what it mostly is.
    let sign = median(&mut speed.to_vec()).signum();
    let speed: Vec<f64> = speed.iter().map(|w| w * sign).collect();
    let settled = quantile(&mut speed.clone(), SETTLED);
    let Some(arrived) = speed.iter().position(|w| *w > FREE * settled).filter(|_| settled > 0.0) else {
        return Vec::new();
    };
    let (mut found, mut outside) = (Vec::new(), Vec::new());
    let mut k = arrived;
    while k < speed.len() {
        if speed[k] >= HELD * settled {
            outside.push(k);
            k += 1;
            continue;
        }
        // From where it leaves what is even to where it is back.
        let from = (arrived..k).rev().find(|i| speed[*i] > (1.0 - 0.5 * EVEN) * settled).unwrap_or(arrived);
        let Some(to) = (k..speed.len()).find(|i| speed[*i] > (1.0 - 0.5 * EVEN) * settled) else {
            // It does not come back: a stall, a stop, or the end of the motion.
            return Vec::new();
        };
        let held = (k..to).filter(|i| speed[*i] < HELD * settled).count();
        let lowest = speed[k..to].iter().copied().fold(f64::INFINITY, f64::min);
        if held >= FEWEST && time_s[to] - time_s[k] >= SHORTEST_S {
            found.push(Departure {
                from: first + from,
                to: first + to,
                before: sign * settled,
                lowest: sign * lowest,
            });
        }
        outside.truncate(outside.partition_point(|i| *i < from));
        k = to;
    }
    let even = outside.iter().filter(|i| (speed[**i] / settled - 1.0).abs() <= EVEN).count();
    let is_even = outside.len() >= FEWEST_EVEN
        && outside.len() as f64 >= MOSTLY * (speed.len() - arrived) as f64
        && even as f64 >= NEARLY_ALL * outside.len() as f64;
    if is_even { found } else { Vec::new() }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A motor at two voltages with a `torque` (V) by time, angle and speed.
    fn driven(torque: impl Fn(f64, f64) -> f64) -> Record {
        let time_s: Vec<f64> = (0..800).map(|k| f64::from(k) * 0.005).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| if *t < 3.0 { 10.0 } else { 4.0 }).collect();
        let (mut x, mut w) = (0.0, 0.0);
        let speeds = time_s.iter().zip(&voltage_v).map(|(t, volts)| {
            for _ in 0..10 {
                w += 0.0005 / 0.08 * (2.0 * (volts - torque(*t, x)) - w);
                x += 0.0005 * w;
            }
            w
        });
        let speed_rad_s = Some(speeds.collect());
        Record { name: "run".into(), time_s, voltage_v, speed_rad_s, ..Record::default() }
    }

    #[test]
    fn a_shaft_that_is_held_for_a_while_is_told_with_the_range_to_skip() {
        let held = driven(|t, _| if (1.2..1.8).contains(&t) { 6.0 } else { 0.5 });
        let (name, _, why, fix) = held_back(&held).unwrap();
        assert!(name == "held_back" && why.contains("from 19.00 to 8.0"), "{why}");
        assert!(fix.contains("--skip run:1.20") && fix.contains("..1.96"), "{fix}");
        let mut turned = held.clone();
        turned.speed_rad_s.iter_mut().flatten().for_each(|w| *w = -*w);
        assert!(held_back(&turned).is_some());
    }

    #[test]
    fn what_a_motor_does_by_itself_is_none() {
        // Free, with a weight, with one that is slow to pass, stalled for good.
        for torque in [
            &(|_, _| 0.5) as &dyn Fn(f64, f64) -> f64,
            &|_, x: f64| 4.0 * x.sin(),
            &|_, x: f64| 4.0 * (0.1 * x).sin(),
            &|t, _| if t > 1.2 { 9.0 } else { 0.0 },
        ] {
            assert_eq!(held_back(&driven(torque)), None);
        }
    }
}
