//! The unit of a column: as its name says it, or as its values tell.

use std::f64::consts::TAU;

use super::clocks::time_unit;
use super::drive;
use super::duty_range;
use super::one_motion::NEAR;
use super::ranges::Range;
use crate::log::units::Quantity;
use crate::log::wraps;

/// Rows from which a wrap is told, and the counts of the coarsest encoder that tells its angle.
const NEIGHBOURS: usize = 2000;
pub(super) const FEWEST_COUNTS: f64 = 64.0;
/// Whole numbers that span more than two turns in degrees are counts.
const MOST_DEGREES: f64 = 720.0;
/// Numbers between which a servo is sent that span more than this are no radians.
const MOST_SERVO_RADIANS: f64 = 20.0;
/// Shares of full duty are not always kept to it.
const JUST_ABOVE_ONE: f64 = 1.2;

/// The unit of a column whose name may say one.
pub(super) fn unit_of(quantity: Quantity, said: Option<&'static str>, values: &[f64]) -> String {
    let range = Range::of(values.iter().copied());
    if let (Quantity::Angle, None, Some(unit)) = (quantity, said, unit_of_wrap(values)) {
        return unit.to_owned();
    }
    let unit = match (quantity, said) {
        (Quantity::Duty, _) => {
            let code = duty_range::code(values);
            let duties = values.iter().copied().filter(|value| code.is_none_or(|code| *value != code));
            return full_duty(&Range::of(duties), said);
        }
        (Quantity::Voltage | Quantity::Supply, Some("V")) if range.peak() > drive::MOST_VOLTS => "mV",
        (_, Some(unit)) => unit,
        (Quantity::Time, None) => time_unit(values, &range),
        (Quantity::Interval, None) if range.peak() < 1.0 => "s",
        (Quantity::Interval, None) if range.peak() < 500.0 => "ms",
        (Quantity::Interval, None) => "us",
        (Quantity::Voltage | Quantity::Supply, None) if range.peak() > drive::MOST_VOLTS => "mV",
        (Quantity::Voltage | Quantity::Supply, None) => "V",
        (Quantity::Angle, None) if range.whole && range.high - range.low > MOST_DEGREES => "counts",
        (Quantity::Target, None) if range.high - range.low > MOST_SERVO_RADIANS => "deg",
        (Quantity::Angle | Quantity::Target, None) if range.whole && range.high - range.low > 100.0 => "deg",
        (Quantity::Angle, None) if range.high - range.low > MOST_TENTHS && is_in_tenths(values) => "deg",
        (Quantity::Angle | Quantity::Target, None) => "rad",
        (Quantity::Speed, None) => "rad/s",
        (Quantity::Direction, None) => "sign",
        (Quantity::Current, None) if range.peak() > 60.0 => "mA",
        (Quantity::Current, None) => "A",
    };
    unit.to_owned()
}

/// A tenth of a radian is coarser than any encoder; that of a degree is what people write. Angles that span less may be of slow shafts.
const MOST_TENTHS: f64 = 60.0;
const TENTHS: f64 = 1e-6;

/// Whether all values have one decimal at most, and some have one.
fn is_in_tenths(values: &[f64]) -> bool {
    let off = |x: f64| (x - x.round()).abs();
    values.iter().all(|value| off(10.0 * value) < TENTHS * value.abs().max(1.0))
        && values.iter().any(|value| value.fract() != 0.0)
}

/// The unit of an angle that wraps at a turn of it.
pub(super) fn unit_of_wrap(values: &[f64]) -> Option<&'static str> {
    // Later rows are no neighbours.
    let turn = wraps::turn_of(&values[..values.len().min(NEIGHBOURS)])?;
    let is = |turn_of: f64| (turn / turn_of - 1.0).abs() < NEAR;
    let is_whole = values.iter().all(|value| value.fract() == 0.0);
    let is_count = || is_whole && turn >= FEWEST_COUNTS && is(turn.log2().round().exp2());
    let units = [(is(360.0), "deg"), (is(TAU), "rad"), (is(1.0), "rev"), (is_count(), "counts")];
    units.into_iter().find_map(|(is, unit)| is.then_some(unit))
}

/// What an analog output of Siemens' PLCs has at its full voltage.
pub(super) const ANALOG_OUTPUT: f64 = 27_648.0;

/// The number that is full duty of values that span `range`, where the name may say it.
fn full_duty(range: &Range, said: Option<&'static str>) -> String {
    let peak = range.peak();
    const FULL: [f64; 12] = [
        255.0,
        400.0,
        511.0,
        512.0,
        1000.0,
        1023.0,
        2047.0,
        4095.0,
        10_000.0,
        ANALOG_OUTPUT,
        32_767.0,
        65_535.0,
    ];
    if let Some(unit) = said.filter(|unit| *unit != "us") {
        unit.to_owned()
    } else if let Some(none) = range.pulse_of_no_duty() {
        format!("{none}..2000")
    } else if peak <= 1.0 || peak < JUST_ABOVE_ONE && !range.whole {
        "1".into()
    } else if peak <= 100.0 && (range.has_round_tens || !range.whole) {
        "100".into()
    } else {
        FULL.into_iter().find(|full| peak <= *full).unwrap_or(peak).to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn full_duty_follows_from_the_values() {
        for (peak, step, full) in [
            (0.75, 0.01, "1"),
            (1.03, 0.01, "1"),
            (100.0, 1.0, "100"),
            (60.0, 10.0, "100"),
            (180.0, 1.0, "255"),
            (900.0, 1.0, "1000"),
            (27_648.0, 1.0, "27648"),
        ] {
            let range = Range::of((0..=100).map(|k| (f64::from(k) / 100.0 * peak / step).round() * step));
            assert_eq!(full_duty(&range, None), full, "{peak}");
        }
        for (pulses, full) in
            [([1500.0, 1720.0, 1210.0], "1500..2000"), ([1000.0, 1400.0, 1900.0], "1000..2000")]
        {
            assert_eq!(full_duty(&Range::of(pulses.into_iter()), None), full, "{pulses:?}");
        }
    }
}
