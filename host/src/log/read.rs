//! One call for every kind of log file.

use std::io::BufRead;
use std::path::Path;

use super::mapping::Mapping;
use super::text::cannot_read;
use super::{Hold, Metadata, Record, table, text};
use crate::error::{BadInput, Result};
use crate::motor_file::MotorFile;

/// The layout of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Format {
    /// A table with a header; the canonical log, or any other with `--map`.
    #[default]
    Csv,
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
    /// Supply of the driver, V, where the log gives duty only.
    pub supply_volts: Option<f64>,
    /// What is known of the motor, above what the file says.
    pub motor: MotorFile,
}

impl ReadOptions {
    /// Lets the motor file override what the log says of the motor.
    pub(super) fn complete(&self, path: &Path, meta: &mut Metadata) -> Result<()> {
        let known = [
            (
                "gear_ratio",
                self.motor.gear_ratio.map(|ratio| ratio.to_string()),
            ),
            (
                "counts_per_rev",
                self.motor.counts_per_rev.map(|counts| counts.to_string()),
            ),
            (
                "encoder_shaft",
                self.motor.encoder_shaft.map(|shaft| shaft.to_string()),
            ),
        ];
        for (key, value) in known {
            if let Some(value) = value {
                meta.insert(key, &value)
                    .map_err(|why| BadInput::new(path, why, "correct the motor file"))?;
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
    let mut input = text::open(path)?;
    let start = input
        .fill_buf()
        .map_err(|error| cannot_read(path, &error))?;
    match options.format {
        Format::Csv => {
            if start.trim_ascii_start().starts_with(b"{") {
                return Err(BadInput::new(
                    path,
                    "this is JSON, not a table",
                    "give the layout, for example --format wpilib-sysid; a model file comes before the logs",
                )
                .at_line(1)
                .into());
            }
            Ok(vec![table::read(path, input, options)?])
        }
    }
}
