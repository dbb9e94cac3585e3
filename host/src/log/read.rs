//! One call for every kind of log file.

use std::io::BufRead;
use std::path::Path;

use super::mapping::Mapping;
use super::text::cannot_read;
use super::{Hold, Metadata, Record, apart, bam, formats, repair, servo, sysid, sysid_list, table, text};
use crate::error::{BadInput, Result};
use crate::motor_file::MotorFile;

/// The layout of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Format {
    /// A table with a header; the canonical log, or any other with `--map`.
    #[default]
    Csv,
    /// WPILib's SysId: its JSON, or its data log exported as a CSV list; each test is a record of its own.
    WpilibSysid,
    /// The JSON of Rhoban's BAM: a position servo, its voltage inferred from its loop.
    BamJson,
}

/// How to understand a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ReadOptions {
    /// The layout.
    pub format: Format,
    /// The meaning of the columns of a foreign table.
    pub map: Option<Mapping>,
    /// What the voltage does between samples, above what the file says.
    pub hold: Option<Hold>,
    /// Samples per second, where no column tells the time.
    pub rate_hz: Option<f64>,
    /// Supply of the driver, V, where the log gives duty only.
    pub supply_volts: Option<f64>,
    /// Duty per radian of error of a position servo; of a BAM log, per unit of kp too ([`super::bam::SERVO_GAIN`] if absent).
    pub servo_gain: Option<f64>,
    /// Duty per rad/s that the loop of a servo takes off.
    pub servo_damping: Option<f64>,
    /// What is known of the motor, above what the file says.
    pub motor: MotorFile,
}

impl ReadOptions {
    /// Lets the motor file override what the log says of the motor.
    pub(super) fn complete(&self, path: &Path, meta: &mut Metadata) -> Result<()> {
        let plate = &self.motor.nameplate;
        let gain = plate.no_load_speed_rad_s.zip(plate.voltage_v).map(|(speed, volts)| speed / volts);
        let known = [
            ("no_load_rad_s_per_v", gain.map(|gain| gain.to_string())),
            ("gear_ratio", self.motor.gear_ratio.map(|ratio| ratio.to_string())),
            ("counts_per_rev", self.motor.counts_per_rev.map(|counts| counts.to_string())),
            ("metres_per_rev", self.motor.metres_per_rev.map(|metres| metres.to_string())),
            ("encoder_shaft", self.motor.encoder_shaft.map(|shaft| shaft.to_string())),
        ];
        for (key, value) in known {
            if let Some(value) = value {
                meta.insert(key, &value).map_err(|why| BadInput::new(path, why, "correct the motor file"))?;
            }
        }
        Ok(())
    }
}

/// Reads the records of one file.
///
/// # Errors
/// Bad input with file, line, column, cause and remedy; wrong usage where an option is missing.
pub fn read(path: &Path, options: &ReadOptions) -> Result<Vec<Record>> {
    if let Some((input, output)) = apart::both(path) {
        return Ok(finished(apart::read(path, &input, &output, options)?));
    }
    if let Some(records) = formats::read(path, options)? {
        return Ok(records);
    }
    let mut input = text::open(path)?;
    let start = input.fill_buf().map_err(|error| cannot_read(path, &error))?;
    match options.format {
        Format::WpilibSysid if start.trim_ascii_start().starts_with(b"{") => {
            sysid::read(path, input, options)
        }
        Format::WpilibSysid => sysid_list::read(path, input, options),
        Format::BamJson => Ok(vec![bam::read(path, input, options)?]),
        Format::Csv if start.trim_ascii_start().starts_with(b"{") => {
            let (why, remedy) = json_kind(start);
            Err(BadInput::new(path, why, remedy).at_line(1).into())
        }
        Format::Csv => Ok(finished(table::read(path, input, options)?)),
    }
}

/// The tests of a table, mended and with the controller of a servo found.
pub(super) fn finished(tests: Vec<Record>) -> Vec<Record> {
    let mut records: Vec<Record> = tests.into_iter().flat_map(repair::repaired).collect();
    servo::close_loops(&mut records);
    records
}

/// What the JSON file given as a table most likely is.
fn json_kind(start: &[u8]) -> (&'static str, &'static str) {
    let has = |key: &str| memchr::memmem::find(start, key.as_bytes()).is_some();
    if has("\"slow-forward\"")
        || has("\"fast-forward\"")
        || has("\"slow-backward\"")
        || has("\"fast-backward\"")
    {
        ("this is a SysId file, not a table", "add --format wpilib-sysid")
    } else if has("\"entries\"") && has("\"kp\"") {
        ("this is a BAM log, not a table", "add --format bam-json")
    } else if has("\"schema\"") {
        ("this is a model or a result, not a log", "give the model first and the logs after it")
    } else {
        ("this is JSON, not a table", "convert it to CSV, or name its layout with --format")
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::*;

    #[test]
    fn json_given_as_a_table_is_recognised_and_the_remedy_fits() {
        for (content, cause, remedy) in [
            ("{\"fast-forward\": []}", "SysId", "wpilib-sysid"),
            ("{\"kp\": 1, \"entries\": []}", "BAM", "bam-json"),
            ("{\"schema\": 1}", "model", "model first"),
            ("  {}", "JSON", "CSV"),
        ] {
            let (_directory, path) = file(content.as_bytes());
            assert_bad(&read(&path, &ReadOptions::default()).unwrap_err(), "line 1", cause, remedy);
        }
    }
}
