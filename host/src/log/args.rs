//! The options by which every verb reads logs.

use std::path::PathBuf;

use clap::Args;

use super::apart;
use super::mapping::Mapping;
use super::roles::{Division, Range, divide};
use super::{Format, Hold, ReadOptions, Record, Warning, read, servo, set_aside_still};
use crate::error::Result;
use crate::motor_file::{self, MotorFile};

/// How to read logs, and which to keep out of the fit.
#[derive(Debug, Clone, Default, Args)]
#[command(next_help_heading = "Reading logs")]
pub struct ReadArgs {
    /// Columns of a foreign table, for example time=t:ms,voltage=u,speed=y:deg/s
    ///
    /// Columns by header or by 0-based number. A unit may be left out where the header says it, or it is SI. Units: s ms us ns, V mV, rad deg rev counts m mm, rad/s deg/s rev/s rpm counts/s m/s mm/s,
    /// A mA; a scale may follow: voltage=u:V*0.031, speed=y:rpm/-1. For a drive that logs its duty:
    /// duty=command:255,supply=battery:mV (or --supply-volts). For a position servo: target=goal:deg,angle=position:deg.
    /// Times may be clock times or dates with times; interval=dt:ms is the time since the row before, time=sec+nanosec:ns
    /// adds up two columns, and where nothing tells the time there is --rate. Of rows of several motors only=id:3 reads those of one.
    #[arg(long, value_name = "MAP")]
    pub map: Option<Mapping>,
    /// Layout of the log files
    #[arg(long, value_enum, default_value_t)]
    pub format: Format,
    /// What the voltage does between samples: stays (zero) or runs straight to the next (first)
    #[arg(long, value_enum)]
    pub hold: Option<Hold>,
    /// How many seconds before its row a voltage acts: it was written between two rows, or after its row was logged
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub voltage_lead: Option<f64>,
    /// What is known of the motor: gear_ratio, counts_per_rev, its name plate, values to keep fixed
    #[arg(short, long, value_name = "motor.toml")]
    pub motor: Option<PathBuf>,
    /// Samples per second, where no column tells the time (paper: of the virtual motor's logs too, 100 if absent)
    #[arg(long, value_name = "HZ", value_parser = positive)]
    pub rate: Option<f64>,
    /// Supply of the driver in volts, where no column has it: a duty needs it, and so does what the bridge does between pulses
    #[arg(long, value_name = "VOLTS", value_parser = positive)]
    pub supply_volts: Option<f64>,
    /// Encoder counts per turn of the output shaft, after x4 decoding and gearing (above the motor file's)
    #[arg(long, value_name = "COUNTS", value_parser = positive)]
    pub counts_per_rev: Option<f64>,
    /// Metres that a linear axis goes per turn of the output shaft: a screw's lead, a wheel's circumference (for m, cm, mm; m/s ...)
    #[arg(long, value_name = "METRES", value_parser = positive)]
    pub metres_per_rev: Option<f64>,
    /// Position servos: duty per radian of error (bam-json: and per unit of kp); found from the motion if absent
    #[arg(long, value_name = "GAIN", value_parser = positive)]
    pub servo_gain: Option<f64>,
    /// Position servos: duty that the loop takes off per rad/s of speed; found from the motion with the gain
    #[arg(long, value_name = "DAMPING", value_parser = not_negative)]
    pub servo_damping: Option<f64>,
    /// A log to keep out of every fit and to judge by; repeatable
    #[arg(short, long, value_name = "LOG")]
    pub validate: Vec<PathBuf>,
    /// Seconds to leave out, of all records or of one: 3.2..4.0, run2:3.2..4.0, run2:9.., run2 (all of it); repeatable
    ///
    /// Times are those of the log's own clock, as messages about the data print them. What stands before and after becomes a record
    /// of its own.
    #[arg(long, value_name = "[RECORD:]FROM..TO")]
    pub skip: Vec<Range>,
    /// Seconds to keep out of every fit and to judge by, written as for --skip; repeatable
    #[arg(long, value_name = "[RECORD:]FROM..TO")]
    pub judge_by: Vec<Range>,
}

impl ReadArgs {
    /// What is known of the motor; all empty without `--motor`.
    ///
    /// # Errors
    /// Bad input in the motor file.
    pub fn motor_file(&self) -> Result<MotorFile> {
        let mut motor = self.motor.as_deref().map_or_else(|| Ok(MotorFile::default()), motor_file::read)?;
        motor.counts_per_rev = self.counts_per_rev.or(motor.counts_per_rev);
        motor.metres_per_rev = self.metres_per_rev.or(motor.metres_per_rev);
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
            voltage_lead_s: self.voltage_lead,
            rate_hz: self.rate,
            supply_volts: self.supply_volts,
            servo_gain: self.servo_gain,
            servo_damping: self.servo_damping,
            motor: self.motor_file()?,
        })
    }

    /// What is left out of the records, and what of them judges.
    pub fn division(&self) -> Division {
        Division { skip: self.skip.clone(), judge_by: self.judge_by.clone() }
    }
}

/// Records by what they are for.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Loaded {
    /// To fit.
    pub records: Vec<Record>,
    /// To judge by: the logs of `--validate` and the ranges of `--judge-by`.
    pub validation: Vec<Record>,
    /// Data quality problems where one belongs to no record of these.
    pub warnings: Vec<Warning>,
}

/// Reads the records of several files and gives each its role. A record in which the motor stands still tells its breakaway voltage
/// and has none.
///
/// # Errors
/// The first fault met, see [`read`]; wrong usage where a range of `--skip` or `--judge-by` touches no record.
pub fn load(paths: &[PathBuf], args: &ReadArgs) -> Result<Loaded> {
    let options = args.options()?;
    let all = |paths: &[PathBuf]| -> Result<Vec<Record>> {
        let mut records = Vec::new();
        for path in paths {
            records.extend(
                read::with_open_loops(path, &options)
                    .map_err(|error| apart::as_one(error, paths, &options))?,
            );
        }
        Ok(records)
    };
    let (mut records, mut validation) = divide(all(paths)?, all(&args.validate)?, &args.division())?;
    // One controller for all.
    let fitted = records.len();
    records.append(&mut validation);
    servo::close_loops(&mut records);
    validation = records.split_off(fitted);
    let warnings = set_aside_still(&mut records, &mut validation);
    Ok(Loaded { records, validation, warnings })
}

fn not_negative(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && value >= 0.0 => Ok(value),
        _ => Err("give a number of 0 or more".into()),
    }
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
    use crate::error::Error;
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
            "--voltage-lead",
            "0.0045",
            "--validate",
            "a.csv",
            "--validate",
            "b.csv",
        ])
        .unwrap();
        let options = verb.reading.options().unwrap();
        assert_eq!(options.supply_volts, Some(7.9));
        assert_eq!((options.hold, options.voltage_lead_s), (Some(Hold::First), Some(0.0045)));
        assert_eq!(verb.reading.validate.len(), 2);
    }

    #[test]
    fn two_files_of_half_a_log_each_are_proposed_as_one_in_any_order() {
        let directory = tempfile::tempdir().unwrap();
        let table = |name: &str, header: &str, of: fn(f64) -> f64| {
            let rows: String = (0..100).map(|k| format!("{},{}\n", 10 * k, of(f64::from(k)))).collect();
            let path = directory.path().join(name);
            std::fs::write(&path, format!("{header}\n{rows}")).unwrap();
            path
        };
        let drive = table("in.csv", "t_ms,voltage", |k| (0.1 * k).sin());
        let motion = table("out.csv", "t_ms,angle", |k| (0.1 * k).cos());
        for paths in [[drive.clone(), motion.clone()], [motion.clone(), drive.clone()]] {
            let Err(Error::BadInput(fault)) = load(&paths, &ReadArgs::default()) else { panic!() };
            assert_eq!(fault.file, PathBuf::from(format!("{}+{}", drive.display(), motion.display())));
            let map = fault.proposal.unwrap().map.parse().unwrap();
            let args = ReadArgs { map: Some(map), ..ReadArgs::default() };
            assert_eq!(load(&[fault.file], &args).unwrap().records.len(), 1);
        }
        // Two logs of the same kind are two.
        let Err(Error::BadInput(fault)) = load(&[drive.clone(), drive.clone()], &ReadArgs::default()) else {
            panic!()
        };
        assert_eq!(fault.file, drive);
    }

    #[test]
    fn a_wrong_map_is_wrong_usage() {
        let error = Verb::try_parse_from(["fit", "--map", "speed=y:knots"]).err().unwrap();
        assert_eq!(error.exit_code(), 2);
        assert!(error.to_string().contains("no unit of speed"));
    }
}
