//! Negative numbers that were printed as those of a type without a sign: -1 of 16 bits is 65535.
//!
//! They show as values near zero and near the width of the type with nothing between, and with their signs the course is much smoother.
//! Those of a byte may reach further from zero, where the motion tells them.

use super::Record;
use super::motion::{correlation, ends, speed};
use super::remap::remapped;
use super::suspicion::Odd;
use super::units::{INT8, Quantity};
use super::voltages::goes_both_ways;

/// The widths of such types, and one of which nothing is sure: a duty that is off or full is written so.
const WIDTHS: [f64; 2] = [65_536.0, 4_294_967_296.0];
pub(super) const BYTE: f64 = 256.0;
/// What is near an end, in shares of the width; a signed number of that type reaches half of it.
const NEAR: f64 = 0.25;
/// Different values at either end from which they are no two levels of a duty.
const FEWEST: usize = 4;
/// What is left of the changes from row to row with the signs.
const SMOOTHER: f64 = 0.5;
/// ... and where they reach so far from zero that they pass through all numbers of a byte.
const SMOOTHER_OF_FAR: f64 = 0.75;

/// The width of the type that took the signs of `values` away, if one did.
pub(super) fn width_of(values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    among(&WIDTHS, values)
}

/// Whether a type of 8 bits may have taken the signs of `values` away.
pub(super) fn may_be_bytes(values: impl Iterator<Item = f64> + Clone) -> bool {
    among(&[BYTE], values).is_some()
}

fn among(widths: &[f64], values: impl Iterator<Item = f64> + Clone) -> Option<f64> {
    let mut high = f64::MIN;
    for value in values.clone() {
        if value < 0.0 || value.fract() != 0.0 {
            return None;
        }
        high = high.max(value);
    }
    let width = widths.iter().copied().find(|width| high < *width && high >= (1.0 - NEAR) * width)?;
    let is_near = |value: f64| value < NEAR * width || value >= (1.0 - NEAR) * width;
    if !values.clone().all(is_near) {
        return None;
    }
    is_smoother_with_sign(values, width, SMOOTHER).then_some(width)
}

/// Whether a duty that reaches further from zero than [`may_be_bytes`] allows runs much smoother as a byte with a sign.
pub(super) fn may_be_far_bytes(values: impl Iterator<Item = f64> + Clone) -> bool {
    are_bytes(values.clone()) && is_smoother_with_sign(values, BYTE, SMOOTHER_OF_FAR)
}

/// Whether values are whole numbers of a byte, on both sides of its half.
fn are_bytes(mut values: impl Iterator<Item = f64> + Clone) -> bool {
    let is_byte = |value: f64| (0.0..BYTE).contains(&value) && value.fract() == 0.0;
    let (mut below, mut above) = (values.clone(), values.clone());
    values.all(is_byte) && below.any(|value| value < 0.5 * BYTE) && above.any(|value| value >= 0.5 * BYTE)
}

/// Whether several values at either end of a type of this width make a course as numbers with a sign that has no more than
/// this share of the changes.
fn is_smoother_with_sign(values: impl Iterator<Item = f64> + Clone, width: f64, share: f64) -> bool {
    let different = |is_high: bool| {
        let mut found: Vec<f64> = Vec::new();
        for value in values.clone().filter(|value| (*value > 0.5 * width) == is_high) {
            if !found.contains(&value) {
                found.push(value);
            }
            if found.len() == FEWEST {
                return true;
            }
        }
        false
    };
    let changes = |value: &dyn Fn(f64) -> f64| {
        let after = values.clone().skip(1);
        values.clone().zip(after).map(|(a, b)| (value(b) - value(a)).abs()).sum::<f64>()
    };
    let is_smoother = changes(&|value| signed(value, width)) < share * changes(&|value| value);
    different(false) && different(true) && is_smoother
}

/// The number of a type with a sign that has the bits of `value`.
pub(super) fn signed(value: f64, width: f64) -> f64 {
    if value >= 0.5 * width { value - width } else { value }
}

/// A motion goes with a drive that has its sign by at least this correlation, and by so much more than with one that lost it.
const GOES_WITH: f64 = 0.5;
const MORE: f64 = 0.3;

/// ... or, of a drive that reaches far from zero, so much more than with one as it is written, whatever the sign of the encoder.
const MORE_OF_FAR: f64 = 0.15;

/// Whether a `drive` of 8 bits lost its sign, as a `speed` tells that goes with it where it has one and not as it is written. Where the
/// encoder is turned round it is the other way about, which is a fault of its own.
pub(super) fn is_byte_without_sign(drive: &[f64], speed: &[f64]) -> bool {
    let values = drive.iter().copied();
    are_bytes(values.clone()) && {
        let (with_sign, as_written) = (with_byte_sign(drive, speed), correlation(drive, speed));
        let far = || with_sign > as_written.abs() + MORE_OF_FAR;
        with_sign > GOES_WITH && if may_be_bytes(values) { with_sign > as_written + MORE } else { far() }
    }
}

/// Whether a motor turns both ways by a `drive` of 8 bits without a sign, and goes with it neither as it is written nor as a byte that lost
/// its sign.
pub(super) fn leaves_direction_open(drive: &[f64], speed: &[f64]) -> bool {
    let goes = |correlation: f64| correlation.abs() > GOES_WITH;
    are_bytes(drive.iter().copied())
        && goes_both_ways(speed)
        && !goes(correlation(drive, speed))
        && !goes(with_byte_sign(drive, speed))
}

/// Whether a motion goes with a `drive` of 8 bits as it is written, and rather so than as a byte that lost its sign, whatever the sign of
/// the encoder.
pub(super) fn goes_as_written(drive: &[f64], speed: &[f64]) -> bool {
    let as_written = correlation(drive, speed).abs();
    as_written > GOES_WITH && as_written > with_byte_sign(drive, speed).abs()
}

/// The correlation of a `speed` with a `drive` whose bytes have a sign.
fn with_byte_sign(drive: &[f64], speed: &[f64]) -> f64 {
    let signed: Vec<f64> = drive.iter().map(|value| signed(*value, BYTE)).collect();
    correlation(&signed, speed)
}

/// What is said of a duty in a record that was printed as a byte without its sign: the motor turns back at its largest numbers.
pub(super) fn byte_duty(record: &Record) -> Option<Odd> {
    let full: f64 = record.source(Quantity::Duty)?.written.parse().ok()?;
    let supply = |k: usize| match &record.supply_v {
        Some(supply) => supply.get(k).copied(),
        None => record.meta.supply_behind_duty(),
    };
    let written = |(k, volts): (usize, &f64)| Some((volts / supply(k)? * full).round());
    let duty: Vec<f64> = record.voltage_v.iter().enumerate().map(written).collect::<Option<_>>()?;
    let speed = speed(record);
    let (_, highest) = ends(&duty);
    let least = duty.iter().copied().filter(|value| *value > 0.5 * BYTE).fold(highest, f64::min);
    let most = duty.iter().copied().filter(|value| *value < 0.5 * BYTE).fold(0.0, f64::max);
    (full == full.round() && duty.len() == speed.len() && is_byte_without_sign(&duty, &speed)).then(|| {
        (
            "unsigned_byte",
            "voltage_v",
            format!(
                "the duty is {least} to {highest} beside 0 to {most}, and the motor turns the other way there: negative numbers were printed as an \
                 unsigned byte, {highest} for {}",
                highest - BYTE
            ),
            format!(
                "say {}, which reads them with their sign; better print them with it (int, %d)",
                remapped(record, &[(Quantity::Duty, Quantity::Duty, &format!("{INT8}/{full}"))])
            ),
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_duty_that_was_printed_as_an_unsigned_byte_is_told_by_the_motion() {
        let course = |k: usize| (11.0 * (0.03 * k as f64).sin()).round();
        let speed: Vec<f64> = (0..600_usize).map(|k| 5.0 * course(k.saturating_sub(4)) + 0.1).collect();
        let mut record = Record {
            map: Some("time=t:s,duty=pwm:255,speed=w:rad/s".parse().unwrap()),
            time_s: (0..600).map(|k| 0.01 * f64::from(k)).collect(),
            supply_v: Some(vec![12.0; 600]),
            voltage_v: (0..600).map(|k| course(k).rem_euclid(BYTE) / 255.0 * 12.0).collect(),
            speed_rad_s: Some(speed.clone()),
            ..Record::default()
        };
        let (name, _, why, fix) = byte_duty(&record).unwrap();
        assert_eq!(name, "unsigned_byte");
        assert!(why.contains("245 to 255 beside 0 to 11"), "{why}");
        assert!(fix.contains("duty=pwm:int8/255"), "{fix}");
        // The motor turns one way whatever the drive does: nothing tells that it lost a sign.
        record.speed_rad_s = Some(speed.iter().map(|w| w.abs()).collect());
        assert_eq!(byte_duty(&record), None);
        record.voltage_v = (0..600).map(|k| course(k) / 255.0 * 12.0).collect();
        assert_eq!(byte_duty(&record), None);
    }

    #[test]
    fn a_duty_of_eight_bits_that_the_motion_goes_with_as_it_is_written_lost_no_sign() {
        let levels = [60.0, -40.0, 90.0, 0.0, -80.0, 30.0, 120.0, -120.0];
        let course = |k: usize| levels[k / 50 % 8];
        let speed: Vec<f64> = (0..800_usize).map(|k| 3.0 * course(k.saturating_sub(4))).collect();
        let drive = |of: &dyn Fn(f64) -> f64| (0..800).map(|k| of(course(k))).collect::<Vec<f64>>();
        assert!(is_byte_without_sign(&drive(&|x| x.rem_euclid(BYTE)), &speed));
        // Locked antiphase, and a drive one way; either with the encoder turned round.
        let back: Vec<f64> = speed.iter().map(|w| -w).collect();
        let one_way: Vec<f64> = speed.iter().map(|w| -w.max(0.0)).collect();
        for extreme in [false, true] {
            let half = drive(&|x| if extreme { 127.5 + 127.5 * x.signum() } else { 128.0 + x });
            assert!(!is_byte_without_sign(&half, &speed) && !is_byte_without_sign(&half, &back));
            let forth = drive(&|x| if extreme && x > 0.0 { 200.0 } else { 2.0 * x.max(0.0) });
            assert!(!is_byte_without_sign(&forth, &one_way));
        }
    }

    #[test]
    fn signs_that_a_type_took_away_are_told_from_large_numbers() {
        let course = |k: i64| (300.0 * (0.05 * k as f64).sin()).round();
        for width in WIDTHS {
            let taken: Vec<f64> = (0..300).map(|k| course(k).rem_euclid(width)).collect();
            assert_eq!(width_of(taken.iter().copied()), Some(width));
            assert!((0..300).all(|k| signed(taken[k as usize], width) == course(k)));
        }
        assert!(may_be_bytes((0..300).map(|k| (course(k) / 6.0).round().rem_euclid(BYTE))));
        // A duty of 16 bits that is off or full; one that rises; a duty of 8 bits.
        for duty in [
            (0..300).map(|k| f64::from(k / 20 % 2) * 65_535.0).collect::<Vec<_>>(),
            (0..300).map(|k| f64::from(k * 218)).collect(),
            (0..300).map(|k| f64::from(k % 256)).collect(),
        ] {
            assert_eq!(width_of(duty.iter().copied()), None);
            assert!(!may_be_bytes(duty.into_iter()));
        }
    }
}
