//! What the fields of the mapping dialogue say of the rig: how a file is read with them, and what they tell of its motor.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::log::mapping::Mapping;
use crate::log::{EncoderShaft, ReadOptions};
use crate::motor_file::MotorFile;

/// What the fields of the dialogue say of the rig; a query gives all of it as text.
#[derive(Debug, Clone, Default, Serialize, Deserialize)]
pub struct Rig {
    /// Supply of the driver, V, where the log has the duty only.
    pub supply_v: Option<String>,
    /// Counts per turn of the output shaft.
    pub counts_per_rev: Option<String>,
    /// Metres of a linear axis per turn of the output shaft.
    pub metres_per_rev: Option<String>,
    /// Rows per second, where no column tells the time.
    pub rate_hz: Option<String>,
    /// Turns of the motor per turn of the output shaft.
    pub gear_ratio: Option<String>,
    /// Where the encoder sits.
    pub encoder_shaft: Option<EncoderShaft>,
}

impl Rig {
    /// What `options` say, and where they say nothing of the motor what is known of it.
    pub fn of(options: &ReadOptions, motor: &MotorFile) -> Self {
        let text = |value: Option<f64>| value.map(|value| value.to_string());
        let own = &options.motor;
        Self {
            supply_v: text(options.supply_volts),
            counts_per_rev: text(own.counts_per_rev.or(motor.counts_per_rev)),
            metres_per_rev: text(own.metres_per_rev.or(motor.metres_per_rev)),
            rate_hz: text(options.rate_hz),
            gear_ratio: text(own.gear_ratio.or(motor.gear_ratio)),
            encoder_shaft: own.encoder_shaft.or(motor.encoder_shaft),
        }
    }

    /// The number in a field, if there is one.
    fn number(field: &Option<String>, name: &str) -> Result<Option<f64>> {
        let Some(text) = field.as_deref().map(str::trim).filter(|text| !text.is_empty()) else {
            return Ok(None);
        };
        match text.parse::<f64>() {
            Ok(value) if value.is_finite() && value > 0.0 => Ok(Some(value)),
            _ => Err(Error::usage(
                format!("{name} is \"{text}\""),
                "give a positive number, or leave it empty",
            )),
        }
    }

    /// What is known of the motor: `before`, but for what the fields say.
    pub fn motor(&self, before: MotorFile) -> Result<MotorFile> {
        Ok(MotorFile {
            counts_per_rev: Self::number(&self.counts_per_rev, "counts per turn")?,
            metres_per_rev: Self::number(&self.metres_per_rev, "metres per turn")?,
            gear_ratio: Self::number(&self.gear_ratio, "gear ratio")?,
            encoder_shaft: self.encoder_shaft,
            ..before
        })
    }

    /// How a file is read with the columns of `map`, empty for canonical ones: `before`, but for what map and fields say.
    pub fn options(&self, map: &str, before: ReadOptions) -> Result<ReadOptions> {
        let map = if map.is_empty() { None } else { Some(map.parse()) };
        let map: Option<Mapping> =
            map.transpose().map_err(|why: String| Error::usage(why, "choose the columns again"))?;
        // The fields have no place for whose rows were chosen.
        let map = match before.map.as_ref().and_then(Mapping::only) {
            Some(only) => Some(map.unwrap_or_default().with_only(only.clone())),
            None => map,
        };
        let supply_volts = Self::number(&self.supply_v, "supply")?;
        let rate_hz = Self::number(&self.rate_hz, "samples per second")?;
        let motor = self.motor(before.motor)?;
        Ok(ReadOptions { map, supply_volts, rate_hz, motor, ..before })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_field_that_is_no_positive_number_is_named() {
        let rig = Rig { gear_ratio: Some("-3".into()), ..Rig::default() };
        assert!(rig.motor(MotorFile::default()).unwrap_err().to_string().contains("gear ratio is \"-3\""));
        assert_eq!(Rig::default().motor(MotorFile::default()).unwrap(), MotorFile::default());
    }

    #[test]
    fn other_columns_are_those_of_the_same_rows() {
        let before = ReadOptions { map: Some("only=id:3".parse().unwrap()), ..ReadOptions::default() };
        for (map, written) in [("", "only=id:3"), ("time=t,speed=w:rpm", "time=t,speed=w:rpm,only=id:3")] {
            let options = Rig::default().options(map, before.clone()).unwrap();
            assert_eq!(options.map.unwrap().written(), written);
        }
    }
}
