//! An angle and a speed of one record must be one motion: where they are not, their units, their gears or the clock are others.

use std::f64::consts::TAU;

use super::Record;
use super::motion::slope;
use super::remap::{remapped, without};
use super::sysid::TEST_KEY;
use super::unit_check::fault;
use super::units::Quantity::{Angle, Speed, Time};
use super::units::{Quantity, Unit};
use super::usable::Fault;

/// What else was meant where an angle and a speed are no one motion as they were read.
#[derive(Clone, Copy)]
enum Other {
    /// The units of angle and speed.
    Motion([&'static str; 2]),
    /// The unit of the time.
    Time(&'static str),
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
    let (looks, other) = likely(ratio);
    let why = format!("the speed is {ratio:.3} times the change of the angle; {looks}");
    // What was read in other units than the canonical ones looks otherwise.
    let plain = |quantity: Quantity| record.unit_of(quantity) == quantity.si();
    let is_plain = record.meta.get(TEST_KEY).is_none() && plain(Angle) && plain(Speed);
    let fix = match other {
        Some(Other::Motion([angle, speed])) if is_plain => {
            format!("if so, say {}", remapped(record, &[(Angle, Angle, angle), (Speed, Speed, speed)]))
        }
        Some(Other::Time(unit)) if is_plain && plain(Time) => {
            format!("if so, say {}", remapped(record, &[(Time, Time, unit)]))
        }
        _ => in_agreeing_units(record, ratio).unwrap_or_else(|| {
            format!(
                "leave the speed out, as the angle suffices: {}; or the angle: {}",
                without(record, Speed),
                without(record, Angle)
            )
        }),
    };
    Some(fault("speed_rad_s", why, fix))
}

/// The mapping with another unit of the speed, or of the angle, by which both are one motion though the speed is `ratio` times the change of the
/// angle as they are mapped.
fn in_agreeing_units(record: &Record, ratio: f64) -> Option<String> {
    record.map.as_ref()?;
    let (angle, speed) = (record.unit_of(Angle), record.unit_of(Speed));
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
    let told = record.meta.counts_per_rev().filter(|_| record.unit_of(Angle).starts_with("counts"))?;
    let counts = (told / ratio).round();
    (counts >= 1.0).then(|| {
        format!(
            "if the speed is that of the output shaft and in the unit that it was read in, the encoder makes {counts} counts per turn of it: \
             --counts-per-rev {counts}"
        )
    })
}

/// What a speed that is so many times the change of the angle looks like, with the other units where it tells them.
fn likely(ratio: f64) -> (&'static str, Option<Other>) {
    use Other::{Motion, Time};
    const RATIOS: [(f64, &str, Other); 10] = [
        (60.0 / TAU, "the speed looks like rpm", Motion(["rad", "rpm"])),
        (360.0 / TAU, "the speed looks like deg/s", Motion(["rad", "deg/s"])),
        (1.0 / TAU, "the speed looks like turns per second", Motion(["rad", "rev/s"])),
        (TAU / 360.0, "the angle looks like degrees", Motion(["deg", "rad/s"])),
        (TAU, "the angle looks like turns", Motion(["rev", "rad/s"])),
        (60.0, "the angle looks like turns and the speed like rpm", Motion(["rev", "rpm"])),
        (360.0, "the angle looks like turns and the speed like deg/s", Motion(["rev", "deg/s"])),
        (1.0 / 6.0, "the angle looks like degrees and the speed like rpm", Motion(["deg", "rpm"])),
        (1000.0, "the time looks like milliseconds", Time("ms")),
        (1e6, "the time looks like microseconds", Time("us")),
    ];
    let off = |row: &(f64, &str, Other)| (ratio / row.0 - 1.0).abs();
    RATIOS
        .into_iter()
        .filter(|row| off(row) < 0.1)
        .min_by(|one, other| off(one).total_cmp(&off(other)))
        .map_or(
            ("one of them is in another unit, or on the other side of the gears", None),
            |(_, text, other)| (text, Some(other)),
        )
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::log::read_tests::assert_bad;
    use crate::log::usable::{check_usable, tests::motor};

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
    fn a_speed_that_no_unit_makes_that_of_the_angle_is_left_out_or_the_time_is_another() {
        for (map, times, remedy) in [
            (
                "time=t:ms,voltage=u:V,angle=x:deg,speed=w:rpm",
                0.02,
                "--map time=t:ms,voltage=u:V,angle=x:deg; or",
            ),
            (
                "time=t:s,voltage=u:V,angle=x:rad,speed=w:rad/s",
                1000.0,
                "if so, say --map time=t:ms,voltage=u:V",
            ),
            ("", 43.0, "--map angle=angle_rad:rad; or the angle: --map speed=speed_rad_s:rad/s"),
        ] {
            let mut record = motor();
            record.map = map.parse().ok().filter(|_| !map.is_empty());
            record.speed_rad_s = Some(
                slope(&record.time_s, record.angle_rad.as_ref().unwrap()).iter().map(|w| times * w).collect(),
            );
            let fault = agreement(&record).unwrap();
            assert!(fault.fix.contains(remedy), "{}", fault.fix);
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
