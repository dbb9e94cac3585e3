//! A `motor.toml` as a data sheet would have it: right about gear and encoder, roughly right about the rest.

use motorlens_virtual_motor::{EncoderShaft, Motor};
use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};

/// The text of the motor file. Speed, resistance and stall current are off by up to 10 %, the inductance by up to 20 %.
pub fn text(motor: &Motor, seed: u64) -> String {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x706c_6174_6521);
    let mut about =
        |value: f64, spread: f64| digits(value * (1.0 + spread * (2.0 * rng.random::<f64>() - 1.0)), 3);
    let shaft = match motor.encoder_shaft {
        EncoderShaft::Motor => "motor",
        EncoderShaft::Output => "output",
    };
    format!(
        "gear_ratio = {}\ncounts_per_rev = {}  # of the output shaft, after x4 and gearing\nencoder_shaft = \"{shaft}\"\n\n\
         [nameplate]  # as on a data sheet: within 10 to 20 %\nvoltage_v = {}\nno_load_speed_rad_s = {}\n\
         stall_current_a = {}\nresistance_ohm = {}\ninductance_h = {}\n",
        motor.gear_ratio,
        digits(motor.counts_per_output_turn(), 12),
        motor.nominal_v,
        about(motor.no_load_speed(), 0.1),
        about(motor.stall_current(), 0.1),
        about(motor.resistance_ohm, 0.1),
        about(motor.inductance_h, 0.2),
    )
}

/// The value rounded to so many significant digits.
fn digits(value: f64, digits: i32) -> f64 {
    let shift = digits - 1 - value.abs().log10().floor() as i32;
    let rounded = format!("{value:.*}", usize::try_from(shift).unwrap_or(0));
    rounded.parse().unwrap_or(value)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motor_file;
    use std::path::Path;

    #[test]
    fn the_reader_understands_it_and_it_is_about_right() {
        for seed in 0..50 {
            let motor = Motor::hidden(seed);
            let file = motor_file::parse(Path::new("motor.toml"), &text(&motor, seed)).unwrap();
            assert_eq!(file.gear_ratio, Some(motor.gear_ratio));
            let near = |value: Option<f64>, truth: f64, spread: f64| {
                assert!((value.unwrap() / truth - 1.0).abs() < spread + 0.006);
            };
            near(file.counts_per_rev, motor.counts_per_output_turn(), 0.0);
            near(file.nameplate.no_load_speed_rad_s, motor.no_load_speed(), 0.1);
            near(file.nameplate.resistance_ohm, motor.resistance_ohm, 0.1);
            near(file.nameplate.inductance_h, motor.inductance_h, 0.2);
        }
    }

    #[test]
    fn digits_are_significant() {
        assert_eq!(digits(0.003_533_3, 3), 0.003_53);
        assert_eq!(digits(34.987, 3), 35.0);
        assert_eq!(digits(1440.0, 12), 1440.0);
    }
}
