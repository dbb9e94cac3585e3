//! One call for every kind of log file.

use std::io::BufRead;
use std::path::Path;

use super::guess::Known;
use super::mapping::Mapping;
use super::refused::other_than_refused;
use super::{Hold, Metadata, Record, apart, bam, formats, preamble, repair, servo, sysid, table, text};
use crate::error::{BadInput, Error, Result};
use crate::motor_file::MotorFile;

/// The layout of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, clap::ValueEnum)]
pub enum Format {
    /// What the content tells: a table with a header (the canonical log, or any other with `--map`), or one of those below.
    #[default]
    Csv,
    /// WPILib's SysId: its JSON, or its data log, or that exported as a CSV list; each test is a record of its own.
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
    /// How long before its row a voltage acts, s, above what the file says.
    pub voltage_lead_s: Option<f64>,
    /// Samples per second, where no column tells the time.
    pub rate_hz: Option<f64>,
    /// Supply of the driver, V, where no column has it.
    pub supply_volts: Option<f64>,
    /// Duty per radian of error of a position servo; of a BAM log, per unit of kp too ([`super::bam::SERVO_GAIN`] if absent).
    pub servo_gain: Option<f64>,
    /// Duty per rad/s that the loop of a servo takes off.
    pub servo_damping: Option<f64>,
    /// What is known of the motor, above what the file says.
    pub motor: MotorFile,
}

impl ReadOptions {
    /// What need not be assumed of a table whose metadata are `meta`.
    pub(super) fn known(&self, meta: &Metadata) -> Known {
        Known {
            supply_volts: self.supply_volts.is_some(),
            counts_per_rev: meta.counts_per_rev().is_some(),
            metres_per_rev: meta.metres_per_rev().is_some(),
            rate: self.rate_hz.is_some(),
        }
    }

    /// Lets the motor file override what the log says of the motor, and an option what it says of its voltage.
    pub(super) fn complete(&self, path: &Path, meta: &mut Metadata) -> Result<()> {
        let plate = &self.motor.nameplate;
        let gain = plate.no_load_speed_rad_s.zip(plate.voltage_v).map(|(speed, volts)| speed / volts);
        let known = [
            ("no_load_rad_s_per_v", gain.map(|gain| gain.to_string())),
            ("gear_ratio", self.motor.gear_ratio.map(|ratio| ratio.to_string())),
            ("counts_per_rev", self.motor.counts_per_rev.map(|counts| counts.to_string())),
            ("metres_per_rev", self.motor.metres_per_rev.map(|metres| metres.to_string())),
            ("encoder_shaft", self.motor.encoder_shaft.map(|shaft| shaft.to_string())),
            ("voltage_lead_s", self.voltage_lead_s.map(|lead| lead.to_string())),
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
///
/// ```
/// use motorlens::log::{ReadOptions, read};
/// # let directory = tempfile::tempdir().expect("a directory");
/// # let path = directory.path().join("steps.csv");
/// # let row = |k: u32| format!("{:.3},{},{:.4}\n", f64::from(k) * 0.01, k / 100 * 3, f64::from(k) * 0.02);
/// # let rows: String = (0..300).map(row).collect();
/// # std::fs::write(&path, format!("time_s,voltage_v,angle_rad\n{rows}")).expect("a file");
/// // Canonical columns; the map of ReadOptions names those of other logs.
/// let records = read(&path, &ReadOptions::default())?;
/// println!("{}: {} samples", records[0].name, records[0].time_s.len());
/// assert_eq!(records[0].time_s.len(), 300);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn read(path: &Path, options: &ReadOptions) -> Result<Vec<Record>> {
    let mut records = with_open_loops(path, options)?;
    servo::close_loops(&mut records);
    Ok(records)
}

/// The same with the loops of position servos still open, which more files may have to settle.
pub(super) fn with_open_loops(path: &Path, options: &ReadOptions) -> Result<Vec<Record>> {
    let tests = tests(path, options).map_err(|error| other_than_refused(error, options.map.as_ref()))?;
    Ok(tests.into_iter().flat_map(repair::repaired).collect())
}

/// The tests of one file as its reader has them; what is true of every log whatever its layout, [`read`] adds.
fn tests(path: &Path, options: &ReadOptions) -> Result<Vec<Record>> {
    if let Some((input, output)) = apart::both(path) {
        return apart::read(path, &input, &output, options);
    }
    if let Some(records) = formats::read(path, options)? {
        return Ok(records);
    }
    let input = text::open(path)?;
    let json = Json::of(input.decoded());
    match (options.format, json) {
        (Format::WpilibSysid, Some(_)) | (Format::Csv, Some(Json::Sysid)) => {
            sysid::read(path, input, options)
        }
        (Format::BamJson, _) | (Format::Csv, Some(Json::Bam)) => Ok(vec![bam::read(path, input, options)?]),
        (Format::WpilibSysid, None) => Err(no_list(path, input)?),
        (Format::Csv, Some(Json::Own)) => Err(Json::Own.refused(path)),
        (Format::Csv, Some(Json::Other)) => formats::json(path, input)?.records(path, options),
        (Format::Csv, None) => table::read(path, input, options, table::Part::Whole),
    }
}

/// The refusal of a table that should be a list of SysId's.
fn no_list(path: &Path, mut input: impl BufRead) -> Result<Error> {
    let head = preamble::read(path, &mut input, false)?;
    let names = head.headers.unwrap_or_default().join(", ");
    let why = format!("the columns are {names}, not Timestamp, Name, Value");
    let remedy =
        "export the data log as a CSV list; a table with one column per signal is read with --map alone";
    Ok(BadInput::new(path, why, remedy).at_line(head.line).into())
}

/// What a JSON file is, by what its beginning holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Json {
    /// Tests of WPILib's SysId.
    Sysid,
    /// A log of BAM.
    Bam,
    /// What this program writes.
    Own,
    /// Something else.
    Other,
}

impl Json {
    /// The kind of the file that begins so; none where it is no JSON.
    pub fn of(start: &[u8]) -> Option<Json> {
        let has = |key: &str| memchr::memmem::find(start, key.as_bytes()).is_some();
        let tests = ["\"slow-forward\"", "\"fast-forward\"", "\"slow-backward\"", "\"fast-backward\""];
        let known = [
            (tests.into_iter().any(has), Json::Sysid),
            (has("\"entries\"") && has("\"kp\""), Json::Bam),
            (has("\"schema\"") && !has("\"pandas_version\""), Json::Own),
        ];
        let kind = known.into_iter().find_map(|(is, kind)| is.then_some(kind));
        let mut inside = start.trim_ascii_start();
        let is_array = inside.first() == Some(&b'[');
        if is_array {
            inside = inside[1..].trim_ascii_start();
        }
        let is_json = inside.first() == Some(&b'{') || is_array && inside.first() == Some(&b'[');
        is_json.then_some(kind.unwrap_or(Json::Other))
    }

    /// What the file is, where it needs no mapping.
    pub fn told(self) -> Option<&'static str> {
        match self {
            Json::Sysid => Some(
                "a file of SysId: each of its tests becomes a record; positions in rotations of the output shaft",
            ),
            Json::Bam => Some("a log of a position servo in the layout of BAM, which becomes one record"),
            Json::Own | Json::Other => None,
        }
    }

    /// The refusal of what is no log.
    pub fn refused(self, path: &Path) -> Error {
        let (why, remedy) = match self {
            Json::Own => {
                ("this is a model or a result, not a log", "give the model first and the logs after it")
            }
            _ => ("this is JSON, not a table", "convert it to CSV, or name its layout with --format"),
        };
        BadInput::new(path, why, remedy).at_line(1).into()
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::*;

    #[test]
    fn json_is_told_by_its_content_and_the_remedy_fits() {
        for (content, cause, remedy) in [
            ("{\"fast-forward\": []}", "none of slow-forward", "raw data of SysId"),
            ("{\"kp\": 0, \"entries\": []}", "kp = 0", "gain of the servo"),
            ("{\"schema\": 1}", "model", "model first"),
            ("  {}", "JSON", "CSV"),
        ] {
            let (_directory, path) = file(content.as_bytes());
            let error = read(&path, &ReadOptions::default()).unwrap_err();
            assert_bad(&error, "", cause, remedy);
        }
    }

    #[test]
    fn a_table_is_no_list_of_sysid() {
        let (_directory, path) = file(b"time_s,voltage_v,angle_rad\n1,2,3\n");
        let options = ReadOptions { format: Format::WpilibSysid, ..ReadOptions::default() };
        assert_bad(&read(&path, &options).unwrap_err(), "line 1", "not Timestamp, Name, Value", "--map");
    }

    #[test]
    fn tests_of_sysid_in_json_need_no_format() {
        let rows: Vec<[f64; 4]> =
            (0..40).map(|k| [0.02 * f64::from(k), 6.0, 0.1 * f64::from(k), 5.0]).collect();
        let (_directory, path) = file(serde_json::json!({ "fast-forward": rows }).to_string().as_bytes());
        let by_content = read(&path, &ReadOptions::default()).unwrap();
        let asked = ReadOptions { format: Format::WpilibSysid, ..ReadOptions::default() };
        assert_eq!(by_content, read(&path, &asked).unwrap());
        assert_eq!(by_content.len(), 1);
    }
}
