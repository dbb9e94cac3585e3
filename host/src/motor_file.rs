//! `motor.toml`: what is known of a motor before any log is read.
//!
//! ```toml
//! gear_ratio = 104            # turns of the motor per turn of the output
//! counts_per_rev = 4992       # of the output shaft, after x4 decoding and gearing
//! metres_per_rev = 0.008      # of a linear axis, per turn of the output
//! encoder_shaft = "motor"     # or "output"
//! [nameplate]
//! voltage_v = 12
//! no_load_speed_rad_s = 6.2   # of the output shaft
//! [fixed]
//! inductance_h = 0.0005       # parameters by name, not fitted
//! ```

use std::collections::BTreeMap;
use std::path::Path;

use serde::Deserialize;
use toml::Spanned;

use crate::error::{BadInput, Result};
use crate::log::EncoderShaft;
use crate::nearest::nearest;

/// Figures of a data sheet: starts and weak priors of a fit. Speeds and torques are of the output shaft,
/// inertia and torque constant of the motor itself.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Nameplate {
    /// Rated voltage, V.
    pub voltage_v: Option<f64>,
    /// Speed of the output shaft at rated voltage without load, rad/s.
    pub no_load_speed_rad_s: Option<f64>,
    /// Current at rated voltage without load, A.
    pub no_load_current_a: Option<f64>,
    /// Current at rated voltage with the shaft held, A.
    pub stall_current_a: Option<f64>,
    /// Torque of the output shaft at rated voltage when held, N m.
    pub stall_torque_nm: Option<f64>,
    /// Resistance of the winding, Ohm.
    pub resistance_ohm: Option<f64>,
    /// Inductance of the winding, H.
    pub inductance_h: Option<f64>,
    /// Torque per current at the motor shaft, N m/A; equals the back-EMF constant in V s/rad.
    pub torque_constant_nm_a: Option<f64>,
    /// Inertia of the rotor at the motor shaft, kg m^2.
    pub rotor_inertia_kg_m2: Option<f64>,
    /// Mechanical time constant, s.
    pub mechanical_time_constant_s: Option<f64>,
    /// Electrical time constant, s.
    pub electrical_time_constant_s: Option<f64>,
}

/// Everything that a motor file may hold; all of it optional.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MotorFile {
    /// Turns of the motor shaft per turn of the output shaft.
    pub gear_ratio: Option<f64>,
    /// Encoder counts per turn of the output shaft, after x4 decoding and gearing.
    pub counts_per_rev: Option<f64>,
    /// Way of a linear axis per turn of the output shaft, m: the lead of its screw, the circumference of its wheel.
    pub metres_per_rev: Option<f64>,
    /// Where the encoder sits; the motor shaft if absent.
    pub encoder_shaft: Option<EncoderShaft>,
    /// Figures of the data sheet.
    pub nameplate: Nameplate,
    /// Parameters by name that a fit must leave at the given value.
    pub fixed: BTreeMap<String, f64>,
}

type Number = Option<Spanned<f64>>;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFile {
    gear_ratio: Number,
    counts_per_rev: Number,
    metres_per_rev: Number,
    encoder_shaft: Option<EncoderShaft>,
    #[serde(default)]
    nameplate: RawNameplate,
    #[serde(default)]
    fixed: BTreeMap<String, Spanned<f64>>,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct RawNameplate {
    voltage_v: Number,
    no_load_speed_rad_s: Number,
    no_load_current_a: Number,
    stall_current_a: Number,
    stall_torque_nm: Number,
    resistance_ohm: Number,
    inductance_h: Number,
    torque_constant_nm_a: Number,
    rotor_inertia_kg_m2: Number,
    mechanical_time_constant_s: Number,
    electrical_time_constant_s: Number,
}

const KEYS: [&str; 17] = [
    "gear_ratio",
    "counts_per_rev",
    "metres_per_rev",
    "encoder_shaft",
    "nameplate",
    "fixed",
    "voltage_v",
    "no_load_speed_rad_s",
    "no_load_current_a",
    "stall_current_a",
    "stall_torque_nm",
    "resistance_ohm",
    "inductance_h",
    "torque_constant_nm_a",
    "rotor_inertia_kg_m2",
    "mechanical_time_constant_s",
    "electrical_time_constant_s",
];

/// Reads a motor file.
///
/// # Errors
/// Bad input, with line and character: a syntax error, an unknown key (with the nearest known one), a number
/// that is not positive where only a positive one makes sense.
pub fn read(path: &Path) -> Result<MotorFile> {
    let mut text = String::new();
    std::io::Read::read_to_string(&mut crate::log::open_text(path)?, &mut text)
        .map_err(|error| crate::log::cannot_read(path, &error))?;
    parse(path, &text)
}

/// Reads a motor file from its text; `path` serves the messages.
///
/// # Errors
/// As [`read`].
pub fn parse(path: &Path, text: &str) -> Result<MotorFile> {
    let raw: RawFile = toml::from_str(text).map_err(|error| {
        let start = error.span().map_or(0, |span| span.start);
        fault(path, text, start, error.message())
    })?;
    let positive = |number: Number, key: &str| -> Result<Option<f64>> {
        let Some(number) = number else {
            return Ok(None);
        };
        let value = *number.get_ref();
        if value.is_finite() && value > 0.0 {
            return Ok(Some(value));
        }
        Err(fault(path, text, number.span().start, &format!("{key} = {value} is not a positive number"))
            .into())
    };
    let mut fixed = BTreeMap::new();
    for (key, number) in raw.fixed {
        if !number.get_ref().is_finite() {
            let why = format!("{key} = {} is not a finite number", number.get_ref());
            return Err(fault(path, text, number.span().start, &why).into());
        }
        fixed.insert(key, number.into_inner());
    }
    let plate = raw.nameplate;
    Ok(MotorFile {
        gear_ratio: positive(raw.gear_ratio, "gear_ratio")?,
        counts_per_rev: positive(raw.counts_per_rev, "counts_per_rev")?,
        metres_per_rev: positive(raw.metres_per_rev, "metres_per_rev")?,
        encoder_shaft: raw.encoder_shaft,
        nameplate: Nameplate {
            voltage_v: positive(plate.voltage_v, "voltage_v")?,
            no_load_speed_rad_s: positive(plate.no_load_speed_rad_s, "no_load_speed_rad_s")?,
            no_load_current_a: positive(plate.no_load_current_a, "no_load_current_a")?,
            stall_current_a: positive(plate.stall_current_a, "stall_current_a")?,
            stall_torque_nm: positive(plate.stall_torque_nm, "stall_torque_nm")?,
            resistance_ohm: positive(plate.resistance_ohm, "resistance_ohm")?,
            inductance_h: positive(plate.inductance_h, "inductance_h")?,
            torque_constant_nm_a: positive(plate.torque_constant_nm_a, "torque_constant_nm_a")?,
            rotor_inertia_kg_m2: positive(plate.rotor_inertia_kg_m2, "rotor_inertia_kg_m2")?,
            mechanical_time_constant_s: positive(
                plate.mechanical_time_constant_s,
                "mechanical_time_constant_s",
            )?,
            electrical_time_constant_s: positive(
                plate.electrical_time_constant_s,
                "electrical_time_constant_s",
            )?,
        },
        fixed,
    })
}

fn fault(path: &Path, text: &str, start: usize, message: &str) -> BadInput {
    let before = &text[..start.min(text.len())];
    let line = before.matches('\n').count() as u64 + 1;
    let character = before.chars().rev().take_while(|&c| c != '\n').count() + 1;
    let why = message.lines().next().unwrap_or(message);
    let (why, remedy) = match unknown_key(why) {
        Some(key) => (format!("the key \"{key}\" is unknown"), did_you_mean(key, &KEYS)),
        None => (why.to_owned(), "correct this line; all keys are optional".to_owned()),
    };
    BadInput::new(path, why, remedy).at_line(line).at_character(character)
}

/// The key that a TOML file should not have, from the parser's message.
pub(crate) fn unknown_key(message: &str) -> Option<&str> {
    message.strip_prefix("unknown field `")?.split('`').next()
}

/// The nearest of the keys that a file may have.
pub(crate) fn did_you_mean(key: &str, keys: &[&str]) -> String {
    match nearest(key, keys.iter().copied()) {
        Some(known) => format!("did you mean {known}?"),
        None => format!("remove it, or take one of: {}", keys.join(", ")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn message(text: &str) -> String {
        parse(Path::new("motor.toml"), text).unwrap_err().to_string()
    }

    #[test]
    fn a_full_file_is_understood_and_an_empty_one_too() {
        let text = "gear_ratio = 104\ncounts_per_rev = 4992\nencoder_shaft = \"output\"\n\
                    [nameplate]\nvoltage_v = 12\nresistance_ohm = 2.5\n[fixed]\ncoulomb = 0.3\n";
        let motor = parse(Path::new("motor.toml"), text).unwrap();
        assert_eq!(motor.gear_ratio, Some(104.0));
        assert_eq!(motor.encoder_shaft, Some(EncoderShaft::Output));
        assert_eq!(motor.nameplate.resistance_ohm, Some(2.5));
        assert_eq!(motor.fixed["coulomb"], 0.3);
        assert_eq!(parse(Path::new("motor.toml"), "").unwrap(), MotorFile::default());
    }

    #[test]
    fn an_unknown_key_is_named_with_line_and_the_key_that_was_meant() {
        let text = message("gear_ratio = 104\n[nameplate]\nresistence_ohm = 2.5\n");
        assert!(
            text.starts_with("motor.toml, line 3, column 1: the key \"resistence_ohm\" is unknown"),
            "{text}"
        );
        assert!(text.contains("did you mean resistance_ohm?"), "{text}");
    }

    #[test]
    fn impossible_values_and_broken_syntax_are_named_with_line_and_column() {
        for (text, place, cause) in [
            ("gear_ratio = -3", "line 1, column 14", "not a positive number"),
            ("[fixed]\na = nan", "line 2, column 5", "not a finite number"),
            ("gear_ratio = \"big\"", "line 1, column 14", "expected"),
            ("encoder_shaft = \"wheel\"", "line 1", "wheel"),
            ("a = = 1", "line 1", "motor.toml"),
        ] {
            let shown = message(text);
            assert!(shown.contains(place) && shown.contains(cause), "{text}: {shown}");
        }
    }
}
