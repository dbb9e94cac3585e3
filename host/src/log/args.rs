//! The options by which every verb reads logs.

use std::path::PathBuf;

use clap::Args;

use super::mapping::Mapping;
use super::{Format, Hold, ReadOptions, Record, read};
use crate::error::Result;
use crate::motor_file::{self, MotorFile};

/// How to read logs, and which to keep out of the fit.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Reading logs")]
pub struct ReadArgs {
    /// Columns of a foreign table, for example time=t:ms,voltage=u,speed=y:deg/s
    ///
    /// Columns by header or by 0-based number. Units: s ms us, V mV, rad deg rev counts, rad/s deg/s rev/s rpm counts/s,
    /// A mA; a scale may follow: voltage=u:V*0.031, speed=y:rpm/-1. For a drive that logs its duty:
    /// duty=command:255,supply=battery:mV (or --supply-volts).
    #[arg(long, value_name = "MAP")]
    pub map: Option<Mapping>,
    /// Layout of the log files
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// What the voltage does between samples: stays (zero) or runs straight to the next (first)
    #[arg(long, value_enum)]
    pub hold: Option<Hold>,
    /// What is known of the motor: gear_ratio, counts_per_rev, its name plate, values to keep fixed
    #[arg(short, long, value_name = "motor.toml")]
    pub motor: Option<PathBuf>,
    /// Supply of the driver in volts, where the log gives duty only
    #[arg(long, value_name = "VOLTS", value_parser = positive)]
    pub supply_volts: Option<f64>,
    /// Encoder counts per turn of the output shaft, after x4 decoding and gearing (above the motor file's)
    #[arg(long, value_name = "COUNTS", value_parser = positive)]
    pub counts_per_rev: Option<f64>,
    /// Duty per radian of error and unit of kp of a position servo (bam-json; 0.1649 if absent)
    #[arg(long, value_name = "GAIN", value_parser = positive)]
    pub servo_gain: Option<f64>,
    /// A log to keep out of every fit and to judge by; repeatable
    #[arg(short, long, value_name = "LOG")]
    pub validate: Vec<PathBuf>,
}

impl ReadArgs {
    /// What is known of the motor; all empty without `--motor`.
    ///
    /// # Errors
    /// Bad input in the motor file.
    pub fn motor_file(&self) -> Result<MotorFile> {
        let mut motor = self.motor.as_deref().map_or_else(|| Ok(MotorFile::default()), motor_file::read)?;
        motor.counts_per_rev = self.counts_per_rev.or(motor.counts_per_rev);
        Ok(motor)
    }

    /// The options of the reader, with the motor file read.
    ///
    /// # Errors
    /// Bad input in the motor file.
    pub fn options(&self) -> Result<ReadOptions> {
        Ok(ReadOptions {
            format: self.format,
            map: self.map.clone(),
            hold: self.hold,
            supply_volts: self.supply_volts,
            servo_gain: self.servo_gain,
            motor: self.motor_file()?,
        })
    }
}

/// Reads the records of several files, in their order.
///
/// # Errors
/// The first fault met; see [`read`].
pub fn load(paths: &[PathBuf], args: &ReadArgs) -> Result<Vec<Record>> {
    let options = args.options()?;
    let mut records = Vec::new();
    for path in paths {
        records.extend(read(path, &options)?);
    }
    Ok(records)
}

/// Reads the records of `--validate`.
///
/// # Errors
/// The first fault met; see [`read`].
pub fn load_validation(args: &ReadArgs) -> Result<Vec<Record>> {
    load(&args.validate, args)
}

fn positive(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value > 0.0 => Ok(value),
        _ => Err("give a positive number".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use clap::Parser;

    #[derive(Parser)]
    struct Verb {
        #[command(flatten)]
        reading: ReadArgs,
    }

    #[test]
    fn options_are_understood_together() {
        let verb = Verb::try_parse_from([
            "fit",
            "--map",
            "time=t:ms,duty=c:255,speed=y:rpm",
            "--supply-volts",
            "7.9",
            "--hold",
            "first",
            "--validate",
            "a.csv",
            "--validate",
            "b.csv",
        ])
        .unwrap();
        let options = verb.reading.options().unwrap();
        assert_eq!(options.supply_volts, Some(7.9));
        assert_eq!(options.hold, Some(Hold::First));
        assert_eq!(verb.reading.validate.len(), 2);
    }

    #[test]
    fn a_wrong_map_is_wrong_usage() {
        let error = Verb::try_parse_from(["fit", "--map", "speed=y:knots"]).err().unwrap();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("no unit of speed"));
    }
}
