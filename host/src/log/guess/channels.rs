//! Channels of an oscilloscope, whose names tell nothing: which of them is what, by the course of their numbers.

use super::{by_numbers, options_as_if, words};
use crate::log::sample::Sample;
use crate::log::units::Quantity;

/// What oscilloscopes and loggers call their inputs, ...
const CHANNELS: [&str; 5] = ["channel", "ch", "chan", "kanal", "canal"];
/// ... and what may stand behind that.
const VOLTS: [&str; 3] = ["v", "volt", "voltage"];

/// Whether a name is that of a channel: `Channel 1`, `CH2(V)`, `Channel A`.
pub(super) fn is_channel(name: &str) -> bool {
    let (bare, _) = words::bracketed(name);
    let all = words::of(&bare);
    let Some((first, rest)) = all.split_first() else { return false };
    let is_lettered = || rest.iter().any(|word| word.chars().count() == 1);
    let is_plain = |word: &String| word.chars().count() == 1 || VOLTS.contains(&word.as_str());
    let is_numbered = bare.chars().any(|c| c.is_ascii_digit());
    CHANNELS.contains(&first.as_str()) && rest.iter().all(is_plain) && (is_numbered || is_lettered())
}

/// What is asked of a table whose columns are the channels of an oscilloscope, with the options by what their numbers suggest.
pub(in crate::log) fn channels_question(sample: &Sample) -> Option<String> {
    let channels: Vec<usize> = (0..sample.names.len()).filter(|k| is_channel(&sample.names[*k])).collect();
    let [first, second, ..] = channels.as_slice() else { return None };
    let parts = by_numbers::parts(&sample.with_units, &sample.rows);
    let of = |quantities: [Quantity; 2]| {
        parts.iter().find(|part| quantities.contains(&part.quantity) && channels.contains(&part.index))
    };
    let found = of([Quantity::Voltage, Quantity::Duty]).zip(of([Quantity::Angle, Quantity::Speed]));
    let (drive, motion, is_angle, why) = match found {
        Some((drive, motion)) => (
            drive.index,
            motion.index,
            motion.quantity == Quantity::Angle,
            "as their numbers suggest (the second follows the first)",
        ),
        None => (*first, *second, false, "which their numbers do not tell"),
    };
    let called = if is_angle { "angle [rad]" } else { "speed [rad/s]" };
    let options = options_as_if(sample, &[(drive, "voltage [V]"), (motion, called)])?;
    let scale =
        if is_angle { "rad*0.524 for 10 V a turn of 300 deg" } else { "rad/s*104.7 for 1 V at 1000 rpm" };
    let [drive, motion] = [drive, motion].map(|k| &sample.names[k]);
    Some(format!(
        "these are channels of an oscilloscope, and only you know what its probes touched: if \"{drive}\" is the motor's voltage and \"{motion}\" \
         its motion, {why}, say {options}, with the sensor's own scale in the place of the last unit ({scale})"
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn channels_are_asked_for_with_the_one_that_follows_the_other() {
        for (name, is) in [
            ("Channel 1", true),
            ("CH2(V)", true),
            ("Channel A", true),
            ("channel", false),
            ("charge 1", false),
        ] {
            assert_eq!(is_channel(name), is, "{name}");
        }
        let mut speed = 0.0;
        let rows = (0..200).map(|k| {
            let volts = [6.0, -3.0, 0.0, 4.5][k / 50 % 4];
            speed += 0.1 * (0.5 * volts - speed);
            vec![0.01 * k as f64, speed, volts]
        });
        let sample = Sample::of("Time;Channel 1;Channel 2", rows.collect());
        let asked = channels_question(&sample).unwrap();
        assert!(asked.contains("voltage=Channel 2:V,speed=Channel 1:rad/s"), "{asked}");
    }
}
