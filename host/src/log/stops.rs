//! Hard stops: the shaft stands at one end of its way while the voltage pushes it on.

use super::Record;
use super::labels::Labels;
use super::motion::{ends, peak, slope, span};
use super::quantum::quantum;
use super::suspicion::Odd;
use super::timing::quantile;

/// The voltage must push so many times as hard as what moves the shaft or makes it leave: friction alone holds less ...
const HARDER: f64 = 1.5;
/// ... and by this share of the highest.
const PUSHES: f64 = 0.3;
/// What stands at so much of the highest voltage is held by no weight that the motor moves.
const FULL: f64 = 0.6;
/// Shortest stay at the stop, s, together.
const STAY_S: f64 = 0.1;
/// A stop yields by this share of the whole way.
const SOFT: f64 = 0.004;
/// A drive is unchanged within this share of the highest.
const SAME: f64 = 0.03;
/// The motion has not ended at this share of its usual speed under that drive, which is the speed above this share of all: it may have begun
/// slowly.
const MOVES_ON: f64 = 0.95;
const BELOW_USUAL: f64 = 0.75;
/// Ranges named in a message.
const NAMED: usize = 4;

/// The angle stands at its largest or smallest value under a voltage that moves it elsewhere.
pub(super) fn hard_stop(record: &Record) -> Option<Odd> {
    let angle = record.angle_rad.as_ref()?;
    // A position loop holds a load at one angle, as a stop does.
    if record.servo.is_some() || record.meta.get("kp").is_some() {
        return None;
    }
    let near = (SOFT * span(angle)).max(2.0 * quantum(angle).unwrap_or(0.0));
    let speed = slope(&record.time_s, angle);
    let ends = ends(angle);
    let found: Vec<_> = [(ends.1, 1.0), (ends.0, -1.0)]
        .into_iter()
        .filter_map(|(end, outwards)| Some((end, stays(record, angle, &speed, near, end, outwards)?)))
        .collect();
    let (end, volts) = found.first().map(|(end, (volts, _))| (*end, *volts))?;
    let ranges: Vec<(f64, f64)> = found.into_iter().flat_map(|(_, (_, ranges))| ranges).collect();
    // A driver that was off lets the shaft stand anywhere: hardly twice at one end.
    let (cause, no_model, instead) = if ranges.len() == 1 {
        (
            "it meets a stop, or the driver was off while its command stayed (it stands there once, which does not tell them apart)",
            "no model has either: leave this time out",
            "and look into the columns of the log that may tell which it was (command, state, power, enable): log a duty of 0 while the driver is \
             off, or record a motion that does not reach the stop",
        )
    } else {
        (
            "it meets a stop",
            "no model has the stop: leave these times out",
            "or record a motion that does not reach it",
        )
    };
    let more = ranges.len().saturating_sub(NAMED);
    let named: Vec<String> =
        ranges.iter().take(NAMED).map(|(from, to)| format!("{from:.3} s to {to:.3} s")).collect();
    let skip: Vec<String> = ranges
        .iter()
        .map(|(from, to)| {
            format!("--skip {}", super::guess::quoted(&format!("{}:{from:.3}..{to:.3}", record.name)))
        })
        .collect();
    let rest = if more > 0 { format!(" and {more} times more") } else { String::new() };
    Some((
        "hard_stop",
        "angle_rad",
        format!(
            "the angle stands at {end:.2} rad at up to {volts:.1} V, a voltage that moves the motor elsewhere: {cause}, from {}{rest}{}",
            named.join(", from "),
            Labels::of(record.labels.as_ref(), &ranges)
        ),
        format!("{no_model} with {}, {instead}", skip.join(" ")),
    ))
}

/// The highest voltage that pushed against `end`, and from where its motion ended until when the shaft stood within `near` of it.
fn stays(
    record: &Record,
    angle: &[f64],
    speed: &[f64],
    near: f64,
    end: f64,
    outwards: f64,
) -> Option<(f64, Vec<(f64, f64)>)> {
    let (time, volts) = (&record.time_s, &record.voltage_v);
    let (slow, highest) = (0.1 * peak(speed), peak(volts));
    // The voltages that move it freely in this direction.
    let mut moving: Vec<f64> = (0..angle.len())
        .filter(|&k| speed[k] * outwards > slow && (angle[k] - end).abs() > near)
        .map(|k| (volts[k] * outwards).max(0.0))
        .collect();
    if moving.len() < 20 {
        return None;
    }
    moving.sort_by(f64::total_cmp);
    // What mostly moves against its voltage has its sign turned round, and where it stands then says nothing.
    if moving[moving.len() / 2] == 0.0 {
        return None;
    }
    let free = moving[moving.len() / 10];
    let at_end = |k: usize| (angle[k] - end).abs() <= near && speed[k].abs() < slow;
    let (mut hardest, mut stay, mut ranges) = (0.0_f64, 0.0, Vec::new());
    let along = |k: usize| speed[k] * outwards;
    let (mut k, mut left) = (0, 0);
    while k < angle.len() {
        if !at_end(k) {
            k += 1;
            continue;
        }
        let begin = k;
        while k < angle.len() && at_end(k) {
            k += 1;
        }
        let pushed: Vec<f64> = (begin..k).map(|i| volts[i] * outwards).collect();
        let push = pushed.iter().fold(0.0_f64, |p, v| p.max(*v));
        let until = time[k.min(angle.len() - 1)];
        let least = pushed.iter().fold(f64::MAX, |p, v| p.min(*v));
        // Friction holds against both directions alike, a stop against one: `-least` is what it took to leave.
        let held = free.max(-least);
        // A stop lets nothing through: what leaves it while it is still pushed was late, or is driven the other way.
        let lets_through = k < angle.len() && pushed.last().is_some_and(|last| *last > HARDER * held);
        // A weight balances one voltage; a stop stands whatever pushes.
        let stands = push > FULL * highest || push - least > PUSHES * highest;
        if push > HARDER * held && push > PUSHES * highest && stands && !lets_through {
            hardest = hardest.max(push);
            stay += until - time[begin];
            let unchanged = |i: &usize| (volts[*i] - volts[begin]).abs() <= SAME * highest;
            let under_it: Vec<usize> = (left..begin).rev().take_while(unchanged).collect();
            let from = last_motion(&under_it, along, slow).unwrap_or(begin.saturating_sub(1));
            ranges.push((time[from], until));
        }
        left = k;
    }
    (stay > STAY_S).then_some((hardest, ranges))
}

/// The last sample in which the shaft still moved `along` as it usually did in `samples`, the latest first, of one drive: what follows is its
/// run-down to where it stands. None where it did not move faster than `slow`.
fn last_motion(samples: &[usize], along: impl Fn(usize) -> f64, slow: f64) -> Option<usize> {
    let mut moving: Vec<f64> = samples.iter().map(|k| along(*k)).filter(|w| *w > slow).collect();
    if moving.is_empty() {
        return None;
    }
    let least = MOVES_ON * quantile(&mut moving, BELOW_USUAL);
    samples.iter().copied().find(|k| along(*k) >= least)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::usable::tests::motor;

    /// A motor whose shaft is held at `limit` rad either way, with friction of `friction` V.
    fn bounded(limit: f64, friction: f64) -> Record {
        let time: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.005).collect();
        let volts: Vec<f64> = time.iter().map(|t| 6.0 * (1.7 * t).sin()).collect();
        let (mut w, mut x) = (0.0_f64, 0.0_f64);
        let mut angles = Vec::new();
        for v in &volts {
            let driven = if w == 0.0 && v.abs() < friction { 0.0 } else { v - friction * v.signum() };
            w += 0.05 * (2.0 * driven - w);
            if v.abs() < friction && w.abs() < 0.2 {
                w = 0.0;
            }
            x += 0.005 * w;
            if x.abs() > limit {
                (x, w) = (limit * x.signum(), 0.0);
            }
            angles.push(x);
        }
        Record {
            name: "a run".into(),
            time_s: time,
            voltage_v: volts,
            angle_rad: Some(angles),
            ..Record::default()
        }
    }

    #[test]
    fn a_stop_is_told_with_its_angle_and_the_options_that_cut_it() {
        let (name, _, why, fix) = hard_stop(&bounded(1.5, 0.5)).unwrap();
        assert_eq!(name, "hard_stop");
        assert!(
            why.contains("stands at 1.50 rad at up to 6.0 V") && why.contains("it meets a stop, from"),
            "{why}"
        );
        assert!(fix.contains("--skip \"a run:") || fix.contains("--skip a run:"), "{fix}");
    }

    /// A robot that drives faster and faster, and whose driver goes off at the end of its log: its command stays, and the wheels run down.
    #[test]
    fn a_shaft_that_stands_once_may_have_lost_its_driver_and_its_run_down_is_left_out_too() {
        let time_s: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.1).collect();
        let command = |k: usize| 2.0 * (1 + k / 40) as f64;
        let (mut w, mut x) = (0.0, 0.0);
        let angles = (0..200).map(|k| {
            let driven = if k < 180 { command(k) } else { 0.0 };
            w += 0.5 * (driven - w);
            x += 0.1 * w;
            x
        });
        let angle_rad = Some(angles.collect());
        let voltage_v = (0..200).map(command).collect();
        let record = Record { name: "run".into(), time_s, voltage_v, angle_rad, ..Record::default() };
        let (name, _, why, fix) = hard_stop(&record).unwrap();
        assert!(name == "hard_stop" && why.contains("a stop, or the driver was off"), "{why}");
        // It ran at full speed until 17.9 s, and the slope over two intervals shows the run-down one sample before.
        assert!(
            fix.contains("--skip run:17.8") && fix.contains("..19.900") && fix.contains("enable"),
            "{fix}"
        );
    }

    #[test]
    fn the_motion_of_a_shaft_that_was_still_getting_faster_ends_where_it_stands() {
        let along = |k: usize| if k < 20 { 0.5 * k as f64 } else { 0.0 };
        let samples: Vec<usize> = (0..25).rev().collect();
        assert_eq!(last_motion(&samples, along, 1.0), Some(19));
        assert_eq!(last_motion(&samples[..5], along, 1.0), None);
    }

    /// One pin of its bridge is wired: it answers one polarity only, and its counts fall under it.
    #[test]
    fn a_motor_whose_counts_have_the_other_sign_and_that_answers_one_polarity_meets_no_stop() {
        let mut x = 0.0;
        let time_s: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.005).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| 6.0 * (0.4 * t).sin()).collect();
        let angles = voltage_v.iter().map(|v| {
            x -= 0.005 * 2.0 * (v - 0.5).max(0.0);
            x
        });
        let angle_rad = Some(angles.collect());
        assert_eq!(hard_stop(&Record { time_s, voltage_v, angle_rad, ..bounded(1.0, 0.0) }), None);
    }

    #[test]
    fn a_shaft_that_creeps_to_where_friction_holds_it_meets_no_stop() {
        // Torque from elsewhere moves it at times under less voltage than its friction; it turns back once.
        let time: Vec<f64> = (0..4000).map(|k| f64::from(k) * 0.002).collect();
        let volts: Vec<f64> = time.iter().map(|t| 2.0 * (0.8 * t).sin()).collect();
        let mut x = 0.0;
        let angles = time.iter().zip(&volts).map(|(t, v)| {
            let pushed = v + 0.6 * (1.5 * t).sin();
            x += 0.002 * (pushed - pushed.clamp(-0.9, 0.9));
            (x / 0.00126_f64).round() * 0.00126
        });
        let angle_rad = Some(angles.collect());
        let record = Record { time_s: time, voltage_v: volts, angle_rad, ..bounded(1.0, 0.0) };
        assert_eq!(hard_stop(&record), None);
    }

    /// A robot that turns against the sign of its drive, three rows late: it stands at its ends under the first rows of each new drive.
    #[test]
    fn a_late_motor_that_leaves_its_end_under_the_drive_meets_no_stop() {
        let drive = |k: usize| [8.0, 0.0, -8.0, 0.0][k / 20 % 4];
        let mut x = 0.0;
        let angles = (0..800).map(|k: usize| {
            x -= 0.05 * drive(k.saturating_sub(3));
            x
        });
        let angle_rad = Some(angles.collect());
        let time_s: Vec<f64> = (0..800).map(|k| f64::from(k) * 0.05).collect();
        let record =
            Record { time_s, voltage_v: (0..800).map(drive).collect(), angle_rad, ..bounded(1.0, 0.0) };
        assert_eq!(hard_stop(&record), None);
    }

    #[test]
    fn friction_that_holds_and_a_motor_that_turns_freely_are_no_stop() {
        for friction in [0.0, 1.0, 3.0] {
            assert_eq!(hard_stop(&bounded(1e9, friction)), None, "{friction}");
        }
        assert_eq!(hard_stop(&motor()), None);
    }
}
