//! Whether target and angle of a servo can be those of one shaft: it follows its target, and is never there at once.

use super::Record;
use super::motion::{correlation, span};
use super::remap::remapped;
use super::reversed::SIGN_FLIPPED;
use super::units::Quantity;
use super::usable::Fault;

/// The angle is the target again where it is the same in every row, or what that was up to so many rows before, ...
const MOST_LATE: usize = 3;
/// ... within this share of the way of the target.
const SAME: f64 = 1e-6;
/// A shaft that turns against its target goes with it as little as this, and over this share of its way: one that is asked for too fast a motion
/// goes over less, and late.
const AGAINST: f64 = -0.6;
const FAR: f64 = 0.5;

/// What is wrong with the angle of a servo beside its target.
pub(super) fn target_fault(record: &Record) -> Option<Fault> {
    let (servo, angle) = (record.servo.as_ref()?, record.angle_rad.as_ref()?);
    let target = &servo.target_rad;
    let way = span(target);
    let is_again = |late: usize| {
        let mut pairs = target.iter().zip(angle.iter().skip(late));
        pairs.all(|(one, other)| (one - other).abs() <= SAME * way)
    };
    if way > 0.0 && (0..=MOST_LATE).any(is_again) {
        return Some(Fault {
            name: "target_as_angle",
            column: "angle_rad",
            why: "the angle is the target again in every row, which no shaft does: what was commanded was logged twice, and not where the shaft was"
                .into(),
            fix: "map the column that the servo measured (present, actual, state), or read its position back and log that".into(),
        });
    }
    let along = correlation(target, angle);
    (along < AGAINST && span(angle) > FAR * way).then(|| {
        let turned = [Quantity::Angle, Quantity::Speed].map(|quantity| (quantity, quantity, "*-1"));
        let count = if record.speed_rad_s.is_some() { 2 } else { 1 };
        Fault {
            name: SIGN_FLIPPED,
            column: "angle_rad",
            why: format!(
                "the shaft turns against its target (correlation {along:.2}): one of them has the other sign"
            ),
            fix: format!(
                "turn the angle round with {}, or the target alike",
                remapped(record, &turned[..count])
            ),
        }
    })
}

#[cfg(test)]
mod tests {
    use super::super::servo::Servo;
    use super::*;
    use crate::log::check_usable;

    /// A servo whose angle is this of its target, which follows it.
    fn servo(angle: impl Fn(usize, &[f64], f64) -> f64) -> Record {
        let time_s: Vec<f64> = (0..500).map(|k| f64::from(k) * 0.02).collect();
        let target: Vec<f64> = time_s.iter().map(|t| (0.7 * t).sin() + 0.3 * (2.1 * t).sin()).collect();
        let mut x = 0.0;
        let angles = (0..500).map(|k| {
            x += 0.3 * (target[k] - x);
            angle(k, &target, x)
        });
        let angle_rad = Some(angles.collect());
        let map = "time=t:s,target=goal:rad,angle=pos:rad".parse().ok();
        let servo = Some(Servo { target_rad: target, gain: None, damping: None });
        Record { time_s, voltage_v: vec![1.0; 500], angle_rad, servo, map, ..Record::default() }
    }

    #[test]
    fn a_target_that_was_logged_twice_is_no_angle() {
        assert_eq!(target_fault(&servo(|_, _, x| x)), None);
        for late in [0, 1, 3] {
            let fault = target_fault(&servo(|k, target, _| target[k.saturating_sub(late)])).unwrap();
            assert!(fault.name == "target_as_angle" && fault.fix.contains("measured"), "{fault:?}");
        }
    }

    #[test]
    fn a_shaft_that_turns_against_its_target_is_told_with_the_mapping_that_turns_it_round() {
        let record = servo(|_, _, x| 0.2 - x);
        let fault = target_fault(&record).unwrap();
        assert!(fault.name == SIGN_FLIPPED && fault.fix.contains("angle=pos:rad*-1"), "{fault:?}");
        assert!(check_usable(&record).is_err());
    }
}
