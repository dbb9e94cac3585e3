//! Hard stops: the shaft stands at one end of its way while the voltage pushes it on.
//!
//! A stop ends the motion at once. What slows down to where it stands by and by had no drive any more.

use std::ops::Range;

use super::Record;
use super::labels::Labels;
use super::motion::{ends, peak, slope, span, stretches};
use super::quantum::quantum;
use super::suspicion::Odd;
use super::switched_off::without;
use super::times::{ranges_in_words, skip_of};
use super::timing::{median, quantile};

/// The voltage must push so many times as hard as what moves the shaft or makes it leave: friction alone holds less ...
const HARDER: f64 = 1.5;
/// ... and by this share of the highest.
const PUSHES: f64 = 0.3;
/// What moves the shaft is this quantile of the voltages under which it moves, in so many samples or more.
const MOVES: f64 = 0.1;
const FEWEST_MOVING: usize = 20;
/// What stands at so much of the highest voltage is held by no weight that the motor moves.
const FULL: f64 = 0.6;
/// The shaft is slow below this share of its highest speed: it may stand at an end of its way, where a stop yields, and moves freely above.
const SLOW: f64 = 0.1;
/// Shortest stay at the stop, s, together.
const STAY_S: f64 = 0.1;
/// A stop yields by this share of the whole way.
const SOFT: f64 = 0.004;
/// One that yields more by this share: the shaft meets it further out than where it stands there then, by so much of its way at most. It stands so
/// for so long, s, and more than once: a spring holds it somewhere too.
const SOFTER: f64 = 0.012;
const OVERSHOT: f64 = 0.1;
const STANDS_S: f64 = 0.05;
const OFTEN: usize = 2;
/// A drive is unchanged within this share of the highest.
const SAME: f64 = 0.03;
/// The motion has not ended at this share of its usual speed under that drive, which is the speed above this share of all: it may have begun
/// slowly.
const MOVES_ON: f64 = 0.95;
const BELOW_USUAL: f64 = 0.75;
/// A shaft that slows down has these shares of its usual speed in two rows or more, and for longer than the shaft stays at a stop, where a row
/// passes over more than so many counts. A stop leaves one row of them: that in which it was met.
const SLOWING: Range<f64> = 0.1..0.8;
const FEWEST_ROWS: usize = 2;
const FEW_COUNTS: f64 = 4.0;

/// The angle stands at its largest or smallest value under a voltage that moves it elsewhere.
pub(super) fn hard_stop(record: &Record) -> Option<Odd> {
    let angle = record.angle_rad.as_ref()?;
    // A position loop holds a load at one angle, as a stop does.
    if record.is_of_position_loop() {
        return None;
    }
    let count = quantum(angle).unwrap_or(0.0);
    let speed = slope(&record.time_s, angle);
    let at = |(low, high): (f64, f64), soft: f64| -> Vec<(f64, (f64, Vec<Stay>))> {
        let near = (soft * span(angle)).max(2.0 * count);
        let stays =
            |(end, outwards)| Some((end, stays(record, angle, &speed, [near, count], end, outwards)?));
        [(high, 1.0), (low, -1.0)].into_iter().filter_map(stays).collect()
    };
    let mut found = at(ends(angle), SOFT);
    if found.is_empty() {
        found = at(standing_ends(&record.time_s, angle, &speed), SOFTER);
        if found.iter().map(|(_, (_, ranges))| ranges.len()).sum::<usize>() < OFTEN {
            return None;
        }
    }
    let (end, volts) = found.first().map(|(end, (volts, _))| (*end, *volts))?;
    let mut ranges: Vec<Stay> = found.into_iter().flat_map(|(_, (_, ranges))| ranges).collect();
    ranges.sort_by(|one, other| one.from.total_cmp(&other.from));
    let times: Vec<(f64, f64)> = ranges.iter().map(|stay| (stay.from, stay.until)).collect();
    let said = Labels::of(record.labels.as_ref(), &times);
    if let [Stay { from, until, slowed_s: Some(slowed_s) }] = ranges.as_slice() {
        return Some((
            "switched_off",
            "voltage_v",
            format!(
                "the motor stands at {end:.2} rad from {from:.3} s to {until:.3} s, at up to {volts:.1} V, which moves it elsewhere, and it slowed \
                 down to there for {slowed_s:.2} s, which a stop gives no time for: the driver was off while its command stayed, or something \
                 soft held the shaft{said}"
            ),
            without(record, &times),
        ));
    }
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
    Some((
        "hard_stop",
        "angle_rad",
        format!(
            "the angle stands at {end:.2} rad at up to {volts:.1} V, a voltage that moves the motor elsewhere: {cause}, from {}{said}",
            ranges_in_words(&times)
        ),
        format!("{no_model} with {}, {instead}", skip_of(record, &times)),
    ))
}

/// The lowest and the highest angle at which the shaft stands for a while, near its ends; an end itself where it stands nowhere near.
fn standing_ends(time_s: &[f64], angle: &[f64], speed: &[f64]) -> (f64, f64) {
    let ((low, high), slow) = (ends(angle), SLOW * peak(speed));
    let mut rests = stretches(angle.len(), |k| speed[k].abs() < slow);
    rests.retain(|rest| time_s[rest.end - 1] - time_s[rest.start] >= STANDS_S);
    let near = |end: f64| {
        let all = rests.iter().map(|rest| angle[rest.end - 1]);
        all.filter(move |stands| (end - stands).abs() <= OVERSHOT * (high - low))
    };
    (near(low).reduce(f64::min).unwrap_or(low), near(high).reduce(f64::max).unwrap_or(high))
}

/// A time in which the shaft stands at an end of its way.
struct Stay {
    /// When its motion ended, s.
    from: f64,
    /// When it left, s.
    until: f64,
    /// For how long it had slowed down before, s, where it did.
    slowed_s: Option<f64>,
}

/// The highest voltage that pushed against `end`, and the times in which the shaft stood within `near` of it; a step of the angle is a `count`.
fn stays(
    record: &Record,
    angle: &[f64],
    speed: &[f64],
    [near, count]: [f64; 2],
    end: f64,
    outwards: f64,
) -> Option<(f64, Vec<Stay>)> {
    let (time, volts) = (&record.time_s, &record.voltage_v);
    let (slow, highest) = (SLOW * peak(speed), peak(volts));
    // The voltages that move it freely in this direction.
    let mut moving: Vec<f64> = (0..angle.len())
        .filter(|&k| speed[k] * outwards > slow && (angle[k] - end).abs() > near)
        .map(|k| (volts[k] * outwards).max(0.0))
        .collect();
    // What mostly moves against its voltage has its sign turned round, and where it stands then says nothing.
    if moving.len() < FEWEST_MOVING || median(&mut moving) == 0.0 {
        return None;
    }
    let free = quantile(&mut moving, MOVES);
    let at_end = |k: usize| (angle[k] - end).abs() <= near && speed[k].abs() < slow;
    let along = |k: usize| speed[k] * outwards;
    let (mut hardest, mut stay, mut ranges, mut left) = (0.0_f64, 0.0, Vec::new(), 0);
    for Range { start: begin, end: after } in stretches(angle.len(), at_end) {
        let pushed: Vec<f64> = volts[begin..after].iter().map(|v| v * outwards).collect();
        let (least, push) = ends(&pushed);
        let until = time[after.min(angle.len() - 1)];
        // Friction holds against both directions alike, a stop against one: `-least` is what it took to leave.
        let held = free.max(-least);
        // A stop lets nothing through: what leaves it while it is still pushed was late, or is driven the other way.
        let lets_through = after < angle.len() && pushed.last().is_some_and(|last| *last > HARDER * held);
        // A weight balances one voltage; a stop stands whatever pushes.
        let stands = push > FULL * highest || push - least > PUSHES * highest;
        if push > HARDER * held && push > PUSHES * highest && stands && !lets_through {
            hardest = hardest.max(push);
            stay += until - time[begin];
            let unchanged = |i: &usize| (volts[*i] - volts[begin]).abs() <= SAME * highest;
            let under_it: Vec<usize> = (left..begin).rev().take_while(unchanged).collect();
            let from = last_motion(&under_it, along, slow).unwrap_or(begin.saturating_sub(1));
            let way = |k: usize| (angle[k + 1] - angle[k]) * outwards;
            let slowing = slowing(&under_it, way, FEW_COUNTS * count);
            let slowed_s: f64 = slowing.iter().map(|k| time[k + 1] - time[*k]).sum();
            let slowed_s = (slowing.len() >= FEWEST_ROWS && slowed_s > STAY_S).then_some(slowed_s);
            ranges.push(Stay { from: time[from], until, slowed_s });
        }
        left = after;
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

/// The last of `samples`, the latest first, in which the shaft was slowing down: the `way` that it goes in each is less than usual there, which
/// is more than a `few` counts.
fn slowing(samples: &[usize], way: impl Fn(usize) -> f64, few: f64) -> Vec<usize> {
    let mut moving: Vec<f64> = samples.iter().map(|k| way(*k)).filter(|way| *way > 0.0).collect();
    if moving.is_empty() {
        return Vec::new();
    }
    let usual = quantile(&mut moving, BELOW_USUAL);
    let slower = samples.iter().copied().take_while(|k| way(*k) < SLOWING.end * usual);
    slower.filter(|k| usual > few && SLOWING.contains(&(way(*k) / usual))).collect()
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

    /// A robot that drives faster and faster, and whose driver goes off at the end of its log: its command stays, and the wheels lose this share of
    /// their speed in each row.
    fn robot(loses: f64) -> Record {
        let time_s: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.1).collect();
        let command = |k: usize| 2.0 * (1 + k / 40) as f64;
        let (mut w, mut x) = (0.0, 0.0);
        let angles = (0..200).map(|k| {
            w += if k < 180 { 0.5 * (command(k) - w) } else { -loses * w };
            x += 0.1 * w;
            x
        });
        let angle_rad = Some(angles.collect());
        let voltage_v = (0..200).map(command).collect();
        Record { name: "run".into(), time_s, voltage_v, angle_rad, ..Record::default() }
    }

    #[test]
    fn a_shaft_that_stands_at_once_and_once_met_a_stop_or_has_lost_its_driver() {
        let (name, _, why, fix) = hard_stop(&robot(1.0)).unwrap();
        assert!(name == "hard_stop" && why.contains("a stop, or the driver was off"), "{why}");
        assert!(fix.contains("--skip run:17.") && fix.contains("..19.900"), "{fix}");
    }

    #[test]
    fn a_shaft_that_runs_down_to_where_it_stands_has_lost_its_driver_and_its_run_down_is_left_out_too() {
        let (name, _, why, fix) = hard_stop(&robot(0.5)).unwrap();
        assert!(name == "switched_off" && why.contains("slowed down to there for 0.30 s"), "{why}");
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

    /// Stops that yield by a radian at 400 V, which the shaft meets a fifth of a radian further out than it stands there then.
    #[test]
    fn a_stop_that_yields_is_one_and_a_spring_is_none() {
        let levels = [3.0, 8.0, 2.0, -4.0, -9.0, -2.0];
        let driven = |load: &dyn Fn(f64) -> f64| {
            let time_s: Vec<f64> = (0..1600).map(|k| f64::from(k) * 0.01).collect();
            let voltage_v: Vec<f64> = time_s.iter().map(|t| levels[(2.5 * t) as usize % 6]).collect();
            let (mut x, mut w) = (0.0_f64, 0.0_f64);
            let angles = voltage_v.iter().map(|volts| {
                let at = x;
                for _ in 0..10 {
                    let push = volts - load(x);
                    let held = if w == 0.0 { push.clamp(-0.5, 0.5) } else { 0.5 * w.signum() };
                    let next = w + 0.001 / 0.08 * (2.0 * (push - held) - w);
                    w = if w * next < 0.0 { 0.0 } else { next };
                    x += 0.001 * w;
                }
                at
            });
            let angle_rad = Some(angles.collect());
            Record { name: "run".into(), time_s, voltage_v, angle_rad, ..Record::default() }
        };
        let (name, _, why, fix) = hard_stop(&driven(&|x| 400.0 * (x - x.clamp(-2.0, 2.0)))).unwrap();
        assert!(name == "hard_stop" && why.contains("stands at 2.00 rad"), "{why}");
        let begin = |range: &str| range.split("..").next().and_then(|text| text.parse::<f64>().ok()).unwrap();
        let begins: Vec<f64> = fix.split("--skip run:").skip(1).map(begin).collect();
        assert!(begins.len() >= OFTEN && begins.is_sorted(), "{fix}");
        for load in [&(|x: f64| 1.5 * x) as &dyn Fn(f64) -> f64, &|x: f64| 6.0 * x.sin(), &|_: f64| 0.0] {
            assert_eq!(hard_stop(&driven(load)), None);
        }
    }
}
