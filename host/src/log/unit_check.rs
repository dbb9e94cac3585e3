//! Numbers that can hardly be in the unit that the column claims.
//!
//! Every rule needs two facts that exclude each other, so that an unusual motor is not refused.

use std::f64::consts::TAU;

use super::Record;
use super::agreement::agreement;
use super::motion::{peak, speed};
use super::quantum::quantum;
use super::remap::{Change, remapped};
use super::timing::{FASTEST_INTERVAL, SLOWEST_INTERVAL, median_interval, plausible_unit};
use super::units::Quantity::{Angle, Duty, Speed, Time, Voltage};
use super::units::{Quantity, Unit};
use super::usable::Fault;

/// No motor that is driven by a logging controller sees more.
const HIGHEST_VOLTAGE: f64 = 1000.0;
/// Output speed per volt: below it at slow sampling the clock is suspect, rad/s per V.
const SLUGGISH: f64 = 0.05;
/// Output speed per volt beyond any brushed motor (10,000 turns a minute per volt), rad/s per V.
const FRANTIC: f64 = 1000.0;
/// About 140,000 turns a minute, beyond any brushed motor, rad/s.
const FASTEST_SHAFT: f64 = 15_000.0;
/// A record of fewer seconds has no three readings for the fit, which takes them no closer than half a millisecond.
const SHORTEST_RECORD: f64 = 1.2e-3;
/// Beyond this, V or rad/s, no unit makes a motor of the numbers.
const BEYOND_UNITS: f64 = 1e15;

/// Units that are wrong beyond doubt.
pub fn unit_faults(record: &Record) -> Vec<Fault> {
    if let Some(fault) = bytes(record) {
        return vec![fault];
    }
    let checks = [time, voltage, angle, agreement, shaft_speed, gain];
    checks.iter().filter_map(|check| check(record)).collect()
}

pub(super) fn fault(column: &'static str, why: String, fix: impl Into<String>) -> Fault {
    Fault { name: "wrong_units", column, why, fix: fix.into() }
}

/// Numbers that are none of a motor in any unit: more of them than a hundredth.
fn bytes(record: &Record) -> Option<Fault> {
    let many = |beyond: usize| 100 * beyond > record.len();
    let beyond = |values: &[f64]| values.iter().filter(|value| value.abs() > BEYOND_UNITS).count();
    let moves = |angle: &[f64]| {
        let steps = angle.windows(2).zip(record.time_s.windows(2));
        steps.filter(|(x, t)| (x[1] - x[0]).abs() > BEYOND_UNITS * (t[1] - t[0])).count()
    };
    let speeds = match (&record.speed_rad_s, &record.angle_rad) {
        (Some(speed), _) => beyond(speed),
        (None, Some(angle)) => moves(angle),
        (None, None) => 0,
    };
    let (column, size, of) = if many(speeds) {
        (motion_column(record), top_speed(record), "rad/s")
    } else if many(beyond(&record.voltage_v)) {
        ("voltage_v", peak(&record.voltage_v), "V")
    } else {
        return None;
    };
    Some(fault(
        column,
        format!("{size:.1e} {of} is of no motor in any unit: the numbers are bytes of something else"),
        "print and unpack each number as what it is (%f of a float, %d of a whole number), check the baud rate, look whether single lines read \
         right, and log again",
    ))
}

fn whole(values: &[f64]) -> bool {
    values.iter().all(|value| value.fract() == 0.0)
}

fn time(record: &Record) -> Option<Fault> {
    let interval = median_interval(&record.time_s);
    let milliseconds = interval >= 0.5 && whole(&record.time_s);
    if interval > SLOWEST_INTERVAL || milliseconds {
        let unit = if interval >= 500.0 { "us" } else { "ms" };
        return Some(fault(
            "time_s",
            format!("a sample every {interval} s is too slow for a motor; the column looks like {unit}"),
            format!("if so, say {}", remapped(record, &[(Time, Time, unit)])),
        ));
    }
    let lasts_s = record.duration_s();
    let why = if interval < FASTEST_INTERVAL {
        format!("a sample every {interval:e} s is too fast to be logged")
    } else if lasts_s < SHORTEST_RECORD {
        format!("the record lasts {:.3} ms, in which no motor shows anything", 1e3 * lasts_s)
    } else {
        return None;
    };
    Some(fault(
        "time_s",
        format!("{why}; the unit looks too small"),
        match slower_unit(record, interval) {
            Some(unit) => {
                format!("if the column is in {unit}, say {}", remapped(record, &[(Time, Time, unit)]))
            }
            None => "check the unit given with --map time=...; a column in seconds needs none".into(),
        },
    ))
}

/// Another unit in which the times of a log that was mapped are plausible, where in the one they were read in they are `interval` s apart.
fn slower_unit(record: &Record, interval: f64) -> Option<&'static str> {
    record.source(Time)?;
    let written = record.unit_of(Time);
    plausible_unit(interval / Unit::parse(Time, written).ok()?.factor).filter(|unit| *unit != written)
}

fn voltage(record: &Record) -> Option<Fault> {
    let highest = peak(&record.voltage_v);
    if highest > HIGHEST_VOLTAGE {
        return Some(fault(
            "voltage_v",
            format!("the voltage reaches {highest}, which looks like millivolts or a timer's compare value"),
            format!(
                "say {} for millivolts, or {} --supply-volts 12 for duty (full scale and supply of this drive)",
                remapped(record, &[(Voltage, Voltage, "mV")]),
                remapped(record, &[(Voltage, Duty, "4095")])
            ),
        ));
    }
    (highest > 100.0 && whole(&record.voltage_v)).then(|| {
        fault(
            "voltage_v",
            format!("the voltage holds whole numbers up to {highest}, which looks like a PWM command"),
            format!(
                "say {} --supply-volts 12 (full scale and supply of this drive)",
                remapped(record, &[(Voltage, Duty, if highest <= 255.0 { "255" } else { "1023" })])
            ),
        )
    })
}

fn angle(record: &Record) -> Option<Fault> {
    let angle = record.angle_rad.as_ref()?;
    if whole(angle) && peak(angle) >= 100.0 {
        return Some(fault(
            "angle_rad",
            "the angle holds whole numbers only, which looks like encoder counts or degrees".into(),
            format!(
                "say {} --counts-per-rev 1400 (with the counts of one turn), or {}",
                remapped(record, &[(Angle, Angle, "counts")]),
                remapped(record, &[(Angle, Angle, "deg")])
            ),
        ));
    }
    // The counts of one turn fix what one count must be.
    let step = quantum(angle)? * record.meta.counts_per_rev()? / TAU;
    let close = |unit: f64| (step / unit - 1.0).abs() < 0.05;
    [(360.0 / TAU, "deg"), (1.0 / TAU, "rev")].into_iter().find(|&(unit, _)| close(unit)).map(|(_, unit)| {
        fault(
            "angle_rad",
            format!(
                "one encoder count is {step:.4} times what it is in radians; the column looks like {unit}"
            ),
            format!("say {}, or correct counts_per_rev", remapped(record, &[(Angle, Angle, unit)])),
        )
    })
}

fn shaft_speed(record: &Record) -> Option<Fault> {
    let fast = top_speed(record) * record.meta.gear_ratio().unwrap_or(1.0);
    (fast > FASTEST_SHAFT).then(|| {
        fault(
            motion_column(record),
            format!(
                "the motor shaft would turn at {:.0} turns a minute; the column looks like {}",
                fast * 60.0 / TAU,
                other_units(record)
            ),
            match in_other_units(record) {
                Some(ways) => format!("give the unit, for example {ways}, and check gear_ratio"),
                None => "check the unit of the time and gear_ratio".to_owned(),
            },
        )
    })
}

/// The units that a motion may be in which is far too fast, in words, but for the one that it is read in.
fn other_units(record: &Record) -> String {
    let is_read_in =
        |unit: &str| [Angle, Speed].into_iter().any(|quantity| record.unit_of(quantity).starts_with(unit));
    let units = [("deg", "degrees"), ("counts", "counts"), ("rpm", "rpm")];
    let others: Vec<&str> =
        units.into_iter().filter(|&(unit, _)| !is_read_in(unit)).map(|(_, words)| words).collect();
    match others.split_last() {
        Some((last, before)) if !before.is_empty() => format!("{} or {last}", before.join(", ")),
        _ => others.concat(),
    }
}

/// The mappings that read the motion in degrees, in turns a minute or in counts; none where it is read in one of these.
fn in_other_units(record: &Record) -> Option<String> {
    const COUNTS: &str = " --counts-per-rev 1400 (with the counts of one turn)";
    let is_given = |quantity: Quantity| record.unit_of(quantity) != quantity.si();
    let say = |changes: &[Change]| remapped(record, changes);
    // One of two motions alone would contradict the other.
    let (degrees, counts) = match (record.angle_rad.is_some(), record.speed_rad_s.is_some()) {
        (true, true) => (
            say(&[(Angle, Angle, "deg"), (Speed, Speed, "deg/s")]),
            say(&[(Angle, Angle, "counts"), (Speed, Speed, "counts/s")]),
        ),
        (true, false) => (say(&[(Angle, Angle, "deg")]), say(&[(Angle, Angle, "counts")])),
        (false, _) => (say(&[(Speed, Speed, "rpm")]), say(&[(Speed, Speed, "counts/s")])),
    };
    (!is_given(Angle) && !is_given(Speed)).then(|| format!("{degrees}, or {counts}{COUNTS}"))
}

/// Speed per volt against what motors do, and against the name plate where it is known.
fn gain(record: &Record) -> Option<Fault> {
    let volts = peak(&record.voltage_v);
    let gain = top_speed(record) / volts;
    if !gain.is_finite() || gain == 0.0 {
        return None;
    }
    let interval = median_interval(&record.time_s);
    if interval >= 0.2 && gain < SLUGGISH && record.angle_rad.is_some() {
        return Some(fault(
            "time_s",
            format!(
                "a sample every {interval:.3} s and only {gain:.5} rad/s per volt: the column looks like ms"
            ),
            format!("if so, say {}", remapped(record, &[(Time, Time, "ms")])),
        ));
    }
    if gain > FRANTIC {
        return Some(frantic(record, gain, volts));
    }
    let plate = record.meta.no_load_gain()?;
    // A load or a fast programme slows a motor. Small duties of a driver that floats or freewheels make it several times as fast a volt as its name
    // plate, which tells full voltage; a unit that is wrong makes it 2 pi times as fast or more.
    (gain > 6.0 * plate || gain < plate / 40.0).then(|| {
        fault(
            motion_column(record),
            format!("the motor turns {gain:.4} rad/s per volt, but its name plate says {plate:.4}"),
            match in_other_units(record) {
                Some(ways) => {
                    let millivolts = remapped(record, &[(Voltage, Voltage, "mV")]);
                    format!("check the units ({ways}; {millivolts} where the voltage is in mV) and the [nameplate]")
                }
                None => "check the units of the motion, the voltage and the time, and the [nameplate]".to_owned(),
            },
        )
    })
}

/// What is said of a `gain`, rad/s per V, that no motor has, at `volts` V at most. A unit that was given already is not proposed again.
fn frantic(record: &Record, gain: f64, volts: f64) -> Fault {
    let (quantity, unit) = if record.angle_rad.is_some() { (Angle, "deg") } else { (Speed, "deg/s") };
    let (looks, fix) = if record.unit_of(quantity) == unit {
        (
            format!("and the highest voltage is only {volts:.4} V"),
            "check the number that is full duty and the unit of the voltage first, then the units of the motion and of the time".to_owned(),
        )
    } else {
        let map = remapped(record, &[(quantity, quantity, unit)]);
        (
            "the column looks like degrees or counts".to_owned(),
            format!("give the unit, for example {map}, and check that the voltage is in volts and no duty"),
        )
    };
    fault(
        motion_column(record),
        format!("{gain:.0} rad/s per volt is more than any motor turns; {looks}"),
        fix,
    )
}

fn motion_column(record: &Record) -> &'static str {
    if record.speed_rad_s.is_some() { "speed_rad_s" } else { "angle_rad" }
}

/// The fastest motion of the output shaft, rad/s. A glitch of the sensor is no wrong unit, so the fastest hundredth of
/// the samples does not count.
fn top_speed(record: &Record) -> f64 {
    let mut magnitudes: Vec<f64> = speed(record).iter().map(|speed| speed.abs()).collect();
    if magnitudes.is_empty() {
        return 0.0;
    }
    let index = (magnitudes.len() - 1) * 99 / 100;
    *magnitudes.select_nth_unstable_by(index, f64::total_cmp).1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::motion::slope;
    use crate::log::read_tests::assert_bad;
    use crate::log::usable::{check_usable, tests::motor};

    fn scale(column: Option<&mut Vec<f64>>, factor: f64) {
        column.unwrap().iter_mut().for_each(|value| *value *= factor);
    }

    #[test]
    fn a_unit_that_was_given_is_not_proposed_again() {
        let mut record = motor();
        scale(Some(&mut record.voltage_v), 5e-4);
        record.map = Some("time=0:s,duty=1:65535,angle=2:deg".parse().unwrap());
        let fault = gain(&record).unwrap();
        assert!(fault.why.contains("the highest voltage is only 0.00"), "{}", fault.why);
        assert!(fault.fix.contains("full duty") && !fault.fix.contains("--map"), "{}", fault.fix);
    }

    #[test]
    fn the_remedy_for_too_fast_a_shaft_names_the_columns_that_the_log_has() {
        let mut record = motor();
        scale(record.angle_rad.as_mut(), 1e5);
        record.speed_rad_s = Some(slope(&record.time_s, record.angle_rad.as_ref().unwrap()));
        record.map =
            Some("time=timestep (8Hz):s/8000,voltage=u,angle=position,speed=w:rad/s".parse().unwrap());
        let fault = shaft_speed(&record).unwrap();
        for remedy in [
            "--map \"time=timestep (8Hz):s/8000,voltage=u:V,angle=position:deg,speed=w:deg/s\"",
            "angle=position:counts,speed=w:counts/s\" --counts-per-rev 1400",
        ] {
            assert!(fault.fix.contains(remedy), "{}", fault.fix);
        }
        assert!(!fault.fix.contains("angle_rad"), "{}", fault.fix);
        record.map = Some("time=t:s,voltage=u:V,angle=position:counts,speed=w:counts/s".parse().unwrap());
        assert!(!shaft_speed(&record).unwrap().fix.contains("--map"), "what was given already");
        assert!(shaft_speed(&record).unwrap().why.ends_with("looks like degrees or rpm"));
        (record.angle_rad, record.map) = (None, Some("time=t:s,voltage=u:V,speed=w:rpm*2".parse().unwrap()));
        assert!(shaft_speed(&record).unwrap().why.ends_with("looks like degrees or counts"));
        record.map = None;
        assert!(shaft_speed(&record).unwrap().why.ends_with("looks like degrees, counts or rpm"));
        assert!(shaft_speed(&record).unwrap().fix.contains("--map speed=speed_rad_s:rpm, or"));
    }

    #[test]
    fn a_record_that_is_over_before_a_motor_moves_is_refused_with_the_unit_that_its_times_look_like() {
        let mut record = motor();
        for column in [&mut record.time_s, &mut record.voltage_v, record.angle_rad.as_mut().unwrap()] {
            column.truncate(60);
        }
        assert_eq!(time(&record), None);
        record.time_s.iter_mut().for_each(|t| *t *= 2e-4);
        assert!(time(&record).unwrap().fix.contains("check the unit"));
        record.map = Some("time=t:us,voltage=u:V,angle=x:rad".parse().unwrap());
        let fault = time(&record).unwrap();
        assert!(fault.why.contains("lasts 0.118 ms") && fault.fix.contains("time=t:ms"), "{fault:?}");
    }

    #[test]
    fn each_wrong_unit_is_named_with_the_option_that_corrects_it() {
        let base = motor();
        let whole_ms = |r: &mut Record| r.time_s = (0..2000).map(f64::from).collect();
        let counts = |r: &mut Record| {
            for angle in r.angle_rad.as_mut().unwrap() {
                *angle = (*angle * 200.0).round();
            }
        };
        let degrees = |r: &mut Record| {
            r.meta.insert("counts_per_rev", "1000").unwrap();
            for angle in r.angle_rad.as_mut().unwrap() {
                *angle = (*angle * 1000.0 / TAU).floor() * 0.36;
            }
        };
        let rpm = |r: &mut Record| {
            let speed = slope(&r.time_s, r.angle_rad.as_ref().unwrap());
            r.speed_rad_s = Some(speed.iter().map(|speed| speed * 60.0 / TAU).collect());
        };
        let turns_and_rpm = |r: &mut Record| {
            rpm(r);
            scale(r.angle_rad.as_mut(), 1.0 / TAU);
        };
        let geared = |r: &mut Record| {
            r.meta.insert("gear_ratio", "104").unwrap();
            scale(r.angle_rad.as_mut(), 360.0 / TAU);
        };
        let jittering_ms = |r: &mut Record| {
            for (i, time) in r.time_s.iter_mut().enumerate() {
                *time = i as f64 + 0.01 * (i % 7) as f64;
            }
        };
        let plate_in_rpm = |r: &mut Record| {
            r.meta.insert("no_load_rad_s_per_v", "0.6").unwrap();
            scale(r.angle_rad.as_mut(), 60.0 / TAU);
        };
        type Edit<'a> = &'a dyn Fn(&mut Record);
        let cases: [(Edit, &str, &str, &str); 16] = [
            (&|r| scale(r.angle_rad.as_mut(), 1e30), "column angle_rad", "no motor in any unit", "baud rate"),
            (
                &|r| scale(Some(&mut r.voltage_v), 1e30),
                "column voltage_v",
                "no motor in any unit",
                "baud rate",
            ),
            (&|r| scale(Some(&mut r.time_s), 1000.0), "column time_s", "looks like ms", "time_s:ms"),
            (&|r| scale(Some(&mut r.time_s), 1e6), "column time_s", "looks like us", "time_s:us"),
            (&whole_ms, "column time_s", "looks like ms", "time_s:ms"),
            (&|r| scale(Some(&mut r.time_s), 1e-5), "column time_s", "too fast", "--map time"),
            (&|r| scale(Some(&mut r.voltage_v), 1000.0), "column voltage_v", "millivolts", "voltage_v:mV"),
            (&|r| scale(Some(&mut r.voltage_v), 40.0), "column voltage_v", "PWM", "duty="),
            (&counts, "column angle_rad", "counts", "--counts-per-rev 1400"),
            (&degrees, "column angle_rad", "looks like deg", "angle_rad:deg"),
            (&rpm, "column speed_rad_s", "looks like rpm", "speed_rad_s:rpm"),
            (
                &turns_and_rpm,
                "column speed_rad_s",
                "the angle looks like turns and the speed like rpm",
                "angle=angle_rad:rev,speed=speed_rad_s:rpm",
            ),
            (&geared, "column angle_rad", "turns a minute", "gear_ratio"),
            (
                &|r| scale(Some(&mut r.voltage_v), 5e-4),
                "column angle_rad",
                "more than any motor",
                "angle_rad:deg",
            ),
            (&jittering_ms, "column time_s", "looks like ms", "time_s:ms"),
            (&plate_in_rpm, "column angle_rad", "name plate says 0.6", "[nameplate]"),
        ];
        for (edit, place, cause, remedy) in cases {
            let mut record = base.clone();
            edit(&mut record);
            assert_bad(&check_usable(&record).unwrap_err(), place, cause, remedy);
        }
    }
}
