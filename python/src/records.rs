//! What users give: logs, tables and what is known of the motor.

use std::collections::BTreeMap;
use std::path::PathBuf;

use motorlens::log::{self, ReadOptions, Record};
use motorlens::motor_file::{self, MotorFile};
use motorlens::{Measured, Options};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::fault::{failed, refused};

/// A record: a log file, or a name with its columns as 64-bit numbers in the machine's order.
#[derive(FromPyObject)]
pub(crate) enum Given {
    File(PathBuf),
    Table(String, BTreeMap<String, Vec<u8>>, BTreeMap<String, String>),
}

/// Columns of a table that a record may have.
pub(crate) const COLUMNS: [&str; 6] =
    ["time_s", "voltage_v", "angle_rad", "speed_rad_s", "current_a", "supply_v"];

/// 64-bit numbers from bytes, wherever they lie.
pub(crate) fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).filter_map(|number| Some(f64::from_ne_bytes(number.try_into().ok()?))).collect()
}

pub(crate) fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    PyBytes::new(py, bytemuck::cast_slice(numbers))
}

/// The records of `given`; the motor's figures stand above what a log says.
pub(crate) fn records(given: Vec<Given>, motor: &MotorFile) -> PyResult<Vec<Record>> {
    let reading = ReadOptions { motor: motor.clone(), ..ReadOptions::default() };
    let mut records = Vec::new();
    for given in given {
        match given {
            Given::File(path) => records.extend(log::read(&path, &reading).map_err(|e| failed(&e))?),
            Given::Table(name, columns, meta) => records.push(table(&name, &columns, &meta, motor)?),
        }
    }
    Ok(records)
}

pub(crate) fn table(
    name: &str,
    columns: &BTreeMap<String, Vec<u8>>,
    meta: &BTreeMap<String, String>,
    motor: &MotorFile,
) -> PyResult<Record> {
    if let Some(other) = columns.keys().find(|column| !COLUMNS.contains(&column.as_str())) {
        let remedy = format!("name the columns {}", COLUMNS.join(", "));
        return Err(refused(format!("{name}: a record has no column {other}"), &remedy));
    }
    let column = |wanted: &str| columns.get(wanted).map(|bytes| numbers(bytes));
    let needed = |wanted: &str| {
        column(wanted).ok_or_else(|| {
            refused(
                format!("{name}: there is no column {wanted}"),
                "give time_s, voltage_v and angle_rad or speed_rad_s",
            )
        })
    };
    let (time, volts) = (needed("time_s")?, needed("voltage_v")?);
    let (angle, speed) = (column("angle_rad"), column("speed_rad_s"));
    let measured = match (&angle, &speed) {
        (Some(angle), _) => Measured::Angle(angle),
        (None, Some(speed)) => Measured::Speed(speed),
        (None, None) => {
            return Err(needed("angle_rad").err().unwrap_or_else(|| refused(name, "give angle_rad")));
        }
    };
    let mut record = motorlens::record(name, &time, &volts, measured).map_err(|e| failed(&e))?;
    for (key, mut value) in meta.clone() {
        if key == "encoder_shaft" {
            value = value.to_lowercase();
        }
        record.meta.insert(&key, &value).map_err(|why| refused(why, "correct the motor's figures"))?;
    }
    let figures = [
        ("gear_ratio", motor.gear_ratio.map(|x| x.to_string())),
        ("counts_per_rev", motor.counts_per_rev.map(|x| x.to_string())),
        ("encoder_shaft", motor.encoder_shaft.map(|x| x.to_string())),
    ];
    for (key, value) in figures {
        if let Some(value) = value {
            record.meta.insert(key, &value).map_err(|why| refused(why, "correct the motor's figures"))?;
        }
    }
    record.current_a = column("current_a");
    record.supply_v = column("supply_v");
    if angle.is_some() {
        record.speed_rad_s = speed;
    }
    Ok(record)
}

/// What is known of the motor: the path of a motor file, or its text.
pub(crate) fn motor(path: Option<PathBuf>, text: Option<&str>) -> PyResult<MotorFile> {
    match (path, text) {
        (Some(path), _) => motor_file::read(&path),
        (None, Some(text)) => motor_file::parse("motor".as_ref(), text),
        (None, None) => Ok(MotorFile::default()),
    }
    .map_err(|e| failed(&e))
}

/// Everything that a call on records needs.
pub(crate) struct Asked {
    pub(crate) records: Vec<Record>,
    pub(crate) options: Options,
}

pub(crate) fn asked(
    given: Vec<Given>,
    validate: Vec<Given>,
    motor: MotorFile,
    most: usize,
) -> PyResult<Asked> {
    let mut validation = records(validate, &motor)?;
    let mut records = records(given, &motor)?;
    // A record in which the motor stands still tells its breakaway voltage, and no more.
    let said = log::set_aside_still(&mut records, &mut validation);
    if let Some(first) = records.first_mut() {
        first.warnings.extend(said);
    }
    Ok(Asked { records, options: Options { validation, motor, most, ..Options::default() } })
}
