//! Registers of position servos, logged as they are: whole steps of the servo's own, named as its control table names them.
//!
//! Units of Robotis' X series (emanual.robotis.com, control tables): position 4096 steps a turn, velocity 0.229 rpm, current 2.69 mA,
//! PWM 885 at full duty, input voltage 0.1 V. Servos of protocol 1 (AX, RX) have 1023 steps on 300 degrees, and a speed whose
//! sign is a bit of its own. Feetech's have the same steps a turn and the same unit of the voltage.

use super::ranges::Range;
use crate::log::units::Quantity;

/// Whole numbers beyond this are no degrees of one turn.
const MOST_DEGREES: f64 = 360.0;
/// Steps of a servo of protocol 1.
const STEPS_OF_300_DEG: f64 = 1023.0;
/// Full duty of the register of the PWM.
const FULL_PWM: f64 = 885.0;
/// Supplies of servos in steps of 0.1 V: 4 V to 30 V.
const SUPPLIES: (f64, f64) = (40.0, 300.0);

/// The unit of a register with these values as `--map` writes it; `names` are those of all columns, in small letters. None where the
/// values are no whole steps: somebody converted them.
pub(super) fn unit(quantity: Quantity, values: &[f64], names: &str) -> Option<&'static str> {
    let range = Range::of(values.iter().copied());
    if values.is_empty() || !range.is_whole() {
        return None;
    }
    let first_protocol = ["present_speed", "moving_speed", "present speed", "moving speed"];
    let is_first = first_protocol.iter().any(|name| names.contains(name));
    match quantity {
        Quantity::Angle | Quantity::Target if range.peak() > MOST_DEGREES => {
            let of_300_deg = is_first && range.low >= 0.0 && range.high <= STEPS_OF_300_DEG;
            Some(if of_300_deg { "deg*0.293" } else { "rev/4096" })
        }
        Quantity::Speed if !is_first => Some("rpm*0.229"),
        Quantity::Current => Some("mA*2.69"),
        Quantity::Duty if range.peak() <= FULL_PWM && range.peak() > 100.0 => Some("885"),
        Quantity::Voltage | Quantity::Supply if range.low >= SUPPLIES.0 && range.high <= SUPPLIES.1 => {
            Some("V*0.1")
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn whole_steps_have_the_units_of_the_control_table_and_converted_numbers_have_none() {
        for (quantity, values, names, expected) in [
            (Quantity::Angle, [2048.0, 3100.0], "present_position", Some("rev/4096")),
            (Quantity::Target, [10.0, 512.0], "goal_position present_speed", Some("deg*0.293")),
            (Quantity::Angle, [-90.0, 90.0], "present_position", None),
            (Quantity::Angle, [2048.5, 3100.0], "present_position", None),
            (Quantity::Speed, [-120.0, 265.0], "present_velocity", Some("rpm*0.229")),
            (Quantity::Speed, [0.0, 1400.0], "present_speed", None),
            (Quantity::Current, [-30.0, 41.0], "present_current", Some("mA*2.69")),
            (Quantity::Duty, [-885.0, 885.0], "present_pwm", Some("885")),
            (Quantity::Supply, [118.0, 121.0], "present_input_voltage", Some("V*0.1")),
        ] {
            assert_eq!(unit(quantity, &values, names), expected, "{quantity} {values:?}");
        }
    }
}
