//! What users give: logs, tables and what is known of the motor.

use std::collections::BTreeMap;
use std::path::PathBuf;

use motorlens::formula::Library;
use motorlens::log::{self, ReadArgs, ReadOptions, Record, servo};
use motorlens::motor_file::{self, MotorFile};
use motorlens::{Kind, Measured, Options};
use pyo3::prelude::*;
use pyo3::types::PyBytes;

use crate::fault::{failed, refused};

/// A record: a log file, a record that was read, or a name with its columns as 64-bit numbers in the machine's order.
#[derive(FromPyObject)]
pub(crate) enum Given {
    Read(Py<NativeRecord>),
    File(PathBuf),
    Table(String, BTreeMap<String, Vec<u8>>),
}

/// A record of a log file, with everything that its file and the options tell of it.
#[pyclass(frozen, name = "NativeRecord")]
pub(crate) struct NativeRecord(Record);

#[pymethods]
impl NativeRecord {
    #[getter]
    fn name(&self) -> &str {
        &self.0.name
    }
    /// Data quality problems, in sentences.
    #[getter]
    fn warnings(&self) -> Vec<String> {
        self.0.warnings.iter().map(|w| format!("{}: {}; {}", w.place, w.what, w.fix)).collect()
    }
    fn columns<'py>(&self, py: Python<'py>) -> Vec<(&'static str, Bound<'py, PyBytes>)> {
        let record = &self.0;
        let columns = [
            ("time_s", Some(&record.time_s)),
            ("voltage_v", Some(&record.voltage_v)),
            ("angle_rad", record.angle_rad.as_ref()),
            ("speed_rad_s", record.speed_rad_s.as_ref()),
            ("current_a", record.current_a.as_ref()),
            ("supply_v", record.supply_v.as_ref()),
        ];
        columns.into_iter().filter_map(|(name, column)| Some((name, bytes(py, column?)))).collect()
    }
}

/// The options by which the command line reads logs.
#[derive(clap::Parser)]
#[command(name = "read")]
struct Reading {
    logs: Vec<PathBuf>,
    #[command(flatten)]
    options: ReadArgs,
}

/// Reads logs as the command line does with these words.
#[pyfunction]
pub(crate) fn read(py: Python, words: Vec<String>) -> PyResult<Vec<NativeRecord>> {
    let words = std::iter::once("read".to_owned()).chain(words);
    let asked = <Reading as clap::Parser>::try_parse_from(words).map_err(|e| misread(&e))?;
    let loaded = py.detach(|| log::load(&asked.logs, &asked.options)).map_err(|e| failed(&e))?;
    Ok(loaded.records.into_iter().map(NativeRecord).collect())
}

/// What is wrong with words that were made of a call's arguments.
pub(crate) fn misread(error: &clap::Error) -> PyErr {
    let told = error.to_string();
    let why = told.lines().next().unwrap_or_default().trim_start_matches("error: ").to_owned();
    refused(why, "give the arguments that motorlens --help has of this call, with _ for -")
}

/// 64-bit numbers from bytes, wherever they lie.
pub(crate) fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).filter_map(|number| Some(f64::from_ne_bytes(number.try_into().ok()?))).collect()
}

pub(crate) fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    PyBytes::new(py, bytemuck::cast_slice(numbers))
}

/// The records of `given`; the motor's figures stand above what a log says.
fn each(given: Vec<Given>, motor: &MotorFile) -> PyResult<Vec<Record>> {
    let reading = ReadOptions { motor: motor.clone(), ..ReadOptions::default() };
    let mut records = Vec::new();
    for given in given {
        match given {
            Given::File(path) => records.extend(log::read(&path, &reading).map_err(|e| failed(&e))?),
            Given::Table(name, columns) => records.push(table(&name, &columns, motor)?),
            Given::Read(record) => records.push(known(record.get().0.clone(), motor)?),
        }
    }
    Ok(records)
}

/// Records to fit and records to judge by, as the command line lays them out: one controller for all servos, and those in which the motor
/// stands still, which tell its breakaway voltage and no more, set aside.
pub(crate) fn records(
    given: Vec<Given>,
    validate: Vec<Given>,
    motor: &MotorFile,
) -> PyResult<(Vec<Record>, Vec<Record>)> {
    let mut records = each(given, motor)?;
    let fitted = records.len();
    records.extend(each(validate, motor)?);
    servo::close_loops(&mut records);
    let mut validation = records.split_off(fitted);
    let said = log::set_aside_still(&mut records, &mut validation);
    if let Some(first) = records.first_mut() {
        first.warnings.extend(said);
    }
    Ok((records, validation))
}

fn table(name: &str, columns: &BTreeMap<String, Vec<u8>>, motor: &MotorFile) -> PyResult<Record> {
    let column = |wanted: &str| columns.get(wanted).map(|bytes| numbers(bytes));
    let (angle, speed) = (column("angle_rad"), column("speed_rad_s"));
    let measured = match (&angle, &speed) {
        (Some(angle), _) => Measured::Angle(angle),
        (None, Some(speed)) => Measured::Speed(speed),
        (None, None) => return Err(refused(format!("{name}: nothing was measured"), "give angle_rad")),
    };
    let (time, volts) = (column("time_s").unwrap_or_default(), column("voltage_v").unwrap_or_default());
    let mut record = motorlens::record(name, &time, &volts, measured).map_err(|e| failed(&e))?;
    record.current_a = column("current_a");
    record.supply_v = column("supply_v");
    if angle.is_some() {
        record.speed_rad_s = speed;
    }
    known(record, motor)
}

/// `record` with the motor's figures above its own.
fn known(mut record: Record, motor: &MotorFile) -> PyResult<Record> {
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

/// What one call may use: the library's effects, and those of the user's own that these files describe.
pub(crate) fn library(own: &[PathBuf]) -> PyResult<Library> {
    let all = own.iter().try_fold(Library::default(), |library, file| library.with_file(file));
    all.map_err(|e| failed(&e))
}

/// Effects of `library` by their names.
pub(crate) fn kinds(names: &[String], library: &Library) -> PyResult<Vec<Kind>> {
    let one = |name: &String| motorlens::estimate::effect_by_name(name, library).map_err(|e| failed(&e));
    names.iter().map(one).collect()
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
    library: &Library,
) -> PyResult<Asked> {
    let (records, validation) = records(given, validate, &motor)?;
    let library = library.kinds().to_vec();
    Ok(Asked { records, options: Options { validation, motor, library, most } })
}
