//! Numbers that can hardly be in the unit that the column claims.
//!
//! Every rule needs two facts that exclude each other, so that an unusual motor is not refused.

use std::f64::consts::TAU;

use super::Record;
use super::motion::{peak, slope, speed};
use super::quantum::quantum;
use super::remap::remapped;
use super::sysid::TEST_KEY;
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

/// Units that are wrong beyond doubt.
pub fn unit_faults(record: &Record) -> Vec<Fault> {
    let checks = [time, voltage, angle, agreement, shaft_speed, gain];
    checks.iter().filter_map(|check| check(record)).collect()
}

fn fault(column: &'static str, why: String, fix: impl Into<String>) -> Fault {
    Fault { name: "wrong_units", column, why, fix: fix.into() }
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
    (interval < FASTEST_INTERVAL).then(|| {
        fault(
            "time_s",
            format!("a sample every {interval:e} s is too fast to be logged; the unit looks too small"),
            match slower_unit(record, interval) {
                Some(unit) => {
                    format!("if the column is in {unit}, say {}", remapped(record, &[(Time, Time, unit)]))
                }
                None => "check the unit given with --map time=...; a column in seconds needs none".into(),
            },
        )
    })
}

/// The unit in which the times of a log that was mapped are plausible, where in the one they were read in they are `interval` s apart.
fn slower_unit(record: &Record, interval: f64) -> Option<&'static str> {
    let source = record.map.as_ref()?.source(Time)?;
    let written = if source.written.is_empty() { Time.si() } else { &source.written };
    plausible_unit(interval / Unit::parse(Time, written).ok()?.factor)
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

/// Angle and speed of one record must be one motion.
pub(super) fn agreement(record: &Record) -> Option<Fault> {
    let derived = slope(&record.time_s, record.angle_rad.as_ref()?);
    let measured = record.speed_rad_s.as_ref()?;
    let (mut product, mut square, mut energy) = (0.0, 0.0, 0.0);
    for (derived, measured) in derived.iter().zip(measured) {
        product += derived * measured;
        square += derived * derived;
        energy += measured * measured;
    }
    let together = product / (square * energy).sqrt();
    if together.is_nan() || together <= 0.8 {
        return None;
    }
    let ratio = (energy / square).sqrt();
    if (0.5..2.0).contains(&ratio) {
        return None;
    }
    if let Some(fix) = counts_of_a_turn(record, ratio) {
        let why = format!(
            "the speed is {ratio:.3} times the change of the angle; the counts per turn do not fit it"
        );
        return Some(fault("speed_rad_s", why, fix));
    }
    let (looks, units) = likely(ratio);
    let why = format!("the speed is {ratio:.3} times the change of the angle; {looks}");
    // What was read in other units than the canonical ones looks otherwise.
    let plain = |quantity| {
        let source = record.map.as_ref().and_then(|map| map.source(quantity));
        source.is_none_or(|source| ["", "rad", "rad/s"].contains(&source.written.as_str()))
    };
    let is_plain = record.meta.get(TEST_KEY).is_none() && plain(Angle) && plain(Speed);
    let fix = match units {
        Some([angle, speed]) if is_plain => {
            format!("if so, say {}", remapped(record, &[(Angle, Angle, angle), (Speed, Speed, speed)]))
        }
        _ => in_agreeing_units(record, ratio).unwrap_or_else(|| {
            format!(
                "give the units of both, for example {}",
                remapped(record, &[(Angle, Angle, "deg"), (Speed, Speed, "rpm")])
            )
        }),
    };
    Some(fault("speed_rad_s", why, fix))
}

/// The mapping with another unit of the speed, or of the angle, by which both are one motion though the speed is `ratio` times the change of the
/// angle as they are mapped.
fn in_agreeing_units(record: &Record, ratio: f64) -> Option<String> {
    let map = record.map.as_ref()?;
    let written = |quantity: Quantity| {
        map.source(quantity)
            .map(|source| source.written.as_str())
            .filter(|unit| !unit.is_empty())
            .unwrap_or(quantity.si())
    };
    let (angle, speed) = (written(Angle), written(Speed));
    let factor = |quantity: Quantity, unit: &str| {
        Unit::parse(quantity, unit).ok().filter(|unit| unit.per_turn.is_none()).map(|unit| unit.factor)
    };
    let like = |quantity: Quantity, units: &[&'static str], wanted: f64| {
        let is =
            |unit: &&&str| factor(quantity, unit).is_some_and(|factor| (factor / wanted - 1.0).abs() < 0.1);
        units.iter().find(is).copied()
    };
    let other_speed = like(Speed, &["rad/s", "deg/s", "rev/s", "rpm"], factor(Speed, speed)? / ratio);
    let other_angle = like(Angle, &["rad", "deg", "rev"], factor(Angle, angle)? * ratio);
    let by = |angle: &str, speed: &str| remapped(record, &[(Angle, Angle, angle), (Speed, Speed, speed)]);
    match (other_speed, other_angle) {
        (Some(unit), Some(other)) => Some(format!(
            "if the speed is in {unit}, say {}; if the angle is in {other}, {}",
            by(angle, unit),
            by(other, speed)
        )),
        (Some(unit), None) => Some(format!("if the speed is in {unit}, say {}", by(angle, unit))),
        (None, Some(unit)) => Some(format!("if the angle is in {unit}, say {}", by(unit, speed))),
        (None, None) => None,
    }
}

/// What to do about a counted angle beside a speed that is `ratio` times its change: the number of counts is the least sure of all that
/// was told of them. None where the angle is not in counts.
pub(super) fn counts_of_a_turn(record: &Record, ratio: f64) -> Option<String> {
    let angle = record.map.as_ref().and_then(|map| map.source(Angle))?;
    let told = record.meta.counts_per_rev().filter(|_| angle.written.starts_with("counts"))?;
    let counts = (told / ratio).round();
    (counts >= 1.0).then(|| {
        format!(
            "if the speed is that of the output shaft and in the unit that it was read in, the encoder makes {counts} counts per turn of it: \
             --counts-per-rev {counts}"
        )
    })
}

/// What a speed that is so many times the change of the angle looks like, with the units of angle and speed where it tells them.
fn likely(ratio: f64) -> (&'static str, Option<[&'static str; 2]>) {
    const RATIOS: [(f64, &str, Option<[&str; 2]>); 10] = [
        (60.0 / TAU, "the speed looks like rpm", Some(["rad", "rpm"])),
        (360.0 / TAU, "the speed looks like deg/s", Some(["rad", "deg/s"])),
        (1.0 / TAU, "the speed looks like turns per second", Some(["rad", "rev/s"])),
        (TAU / 360.0, "the angle looks like degrees", Some(["deg", "rad/s"])),
        (TAU, "the angle looks like turns", Some(["rev", "rad/s"])),
        (60.0, "the angle looks like turns and the speed like rpm", Some(["rev", "rpm"])),
        (360.0, "the angle looks like turns and the speed like deg/s", Some(["rev", "deg/s"])),
        (1.0 / 6.0, "the angle looks like degrees and the speed like rpm", Some(["deg", "rpm"])),
        (1000.0, "the time looks like milliseconds", None),
        (1e6, "the time looks like microseconds", None),
    ];
    let off = |row: &(f64, &str, Option<[&str; 2]>)| (ratio / row.0 - 1.0).abs();
    RATIOS
        .into_iter()
        .filter(|row| off(row) < 0.1)
        .min_by(|one, other| off(one).total_cmp(&off(other)))
        .map_or(
            ("one of them is in another unit, or on the other side of the gears", None),
            |(_, text, units)| (text, units),
        )
}

fn shaft_speed(record: &Record) -> Option<Fault> {
    let fast = top_speed(record) * record.meta.gear_ratio().unwrap_or(1.0);
    (fast > FASTEST_SHAFT).then(|| {
        fault(
            motion_column(record),
            format!("the motor shaft would turn at {:.0} turns a minute; the column looks like degrees or rpm", fast * 60.0 / TAU),
            "give the unit, for example --map angle=angle_rad:deg or --map speed=speed_rad_s:rpm, and check gear_ratio",
        )
    })
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
        return Some(fault(
            motion_column(record),
            format!(
                "{gain:.0} rad/s per volt is more than any motor turns; the column looks like degrees or counts"
            ),
            format!(
                "give the unit, for example {}, and check that the voltage is in volts and no duty",
                if record.angle_rad.is_some() {
                    remapped(record, &[(Angle, Angle, "deg")])
                } else {
                    remapped(record, &[(Speed, Speed, "deg/s")])
                }
            ),
        ));
    }
    let plate = record.meta.no_load_gain()?;
    // A load or a fast programme slows a motor. Small duties of a driver that floats or freewheels make it several times as fast a volt as its name
    // plate, which tells full voltage; a unit that is wrong makes it 2 pi times as fast or more.
    (gain > 6.0 * plate || gain < plate / 40.0).then(|| {
        fault(
            motion_column(record),
            format!("the motor turns {gain:.4} rad/s per volt, but its name plate says {plate:.4}"),
            "check the units (--map angle=angle_rad:deg, --map speed=speed_rad_s:rpm, --map voltage=voltage_v:mV) and the [nameplate]",
        )
    })
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
    use crate::log::read_tests::assert_bad;
    use crate::log::usable::{check_usable, tests::motor};

    fn scale(column: Option<&mut Vec<f64>>, factor: f64) {
        column.unwrap().iter_mut().for_each(|value| *value *= factor);
    }

    #[test]
    fn a_counted_angle_far_off_its_speed_is_given_the_counts_that_the_speed_tells() {
        let mut record = motor();
        record.speed_rad_s =
            Some(slope(&record.time_s, record.angle_rad.as_ref().unwrap()).iter().map(|w| 0.4 * w).collect());
        record.map = Some("time=t:s,voltage=u:V,angle=enc:counts,speed=w:rad/s".parse().unwrap());
        record.meta.insert("counts_per_rev", "1000").unwrap();
        let error = check_usable(&record).unwrap_err();
        assert_bad(&error, "column speed_rad_s", "0.400 times", "--counts-per-rev 2500");
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
        let cases: [(Edit, &str, &str, &str); 14] = [
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

    #[test]
    fn the_remedy_of_mapped_units_is_those_in_which_both_are_one_motion() {
        let map = |text: &str| Record { map: Some(text.parse().unwrap()), ..Record::default() };
        for (written, ratio, said) in [
            (
                "angle=a:deg,speed=w:rad/s",
                56.9,
                "if the speed is in deg/s, say --map angle=a:deg,speed=w:deg/s; if the angle is in rad",
            ),
            (
                "angle=a:rad,speed=w:deg/s",
                1.0 / 6.0,
                "if the speed is in rpm, say --map angle=a:rad,speed=w:rpm",
            ),
            ("angle=a:deg,speed=w:rpm", 1.0 / 7.0, ""),
        ] {
            let fix = in_agreeing_units(&map(written), ratio).unwrap_or_default();
            assert!(fix.starts_with(said) && said.is_empty() == fix.is_empty(), "{written}: {fix}");
        }
    }
}
