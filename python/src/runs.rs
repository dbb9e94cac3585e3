//! Models held against records: `compare`, and `same` for two sets of them.

use std::path::PathBuf;

use motorlens::Options;
use motorlens::compare::free_run::{FreeRun, pooled};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::json;

use crate::model::NativeModel;
use crate::records::{Given, bytes, kinds, library, motor, records};
use crate::text;
use crate::watch::watched;

/// An open-loop simulation for each record: its name, its quantity, and times, measured and simulated values.
pub(crate) type Run<'py> = (String, String, Bound<'py, PyBytes>, Bound<'py, PyBytes>, Bound<'py, PyBytes>);

#[pyfunction]
pub(crate) fn compare<'py>(
    py: Python<'py>,
    model: &NativeModel,
    given: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
) -> PyResult<(String, Vec<Run<'py>>)> {
    let motor = motor(motor_path, motor_text)?;
    let (records, _) = records(given, Vec::new(), &motor)?;
    let (model, options) = (model.0.clone(), Options { motor, ..Options::default() });
    let runs = watched(py, None, |observer| motorlens::compare(&model, &records, &options, observer))?;
    let of = |run: &FreeRun| {
        let mut row = json!(run.measures());
        row["record"] = json!(run.record);
        row["first_speed_rad_s"] = json!(run.first_speed_rad_s);
        row
    };
    let document = json!({
        "schema": 1, "effects": model.values().kinds(), "pooled": pooled(&runs).unwrap_or_default(),
        "unit": runs.first().map_or("rad", |run| run.quantity.unit()),
        "records": runs.iter().map(of).collect::<Vec<_>>(),
    });
    let arrays = runs
        .iter()
        .map(|run| {
            let unit = run.quantity.unit().to_owned();
            (
                run.record.clone(),
                unit,
                bytes(py, &run.time_s),
                bytes(py, &run.measured),
                bytes(py, &run.simulated),
            )
        })
        .collect();
    Ok((text(&document)?, arrays))
}

/// Whether `first` and `second` come from one motor; effects are those given, or what a discovery finds on the first set.
#[pyfunction]
pub(crate) fn same(
    py: Python,
    first: Vec<Given>,
    second: Vec<Given>,
    effects: Option<Vec<String>>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
    own: Vec<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<String> {
    let (motor, library) = (motor(motor_path, motor_text)?, library(&own)?);
    let (first, second) = (records(first, Vec::new(), &motor)?.0, records(second, Vec::new(), &motor)?.0);
    let kinds = effects.map(|names| kinds(&names, &library)).transpose()?;
    let options = Options { motor, library: library.kinds().to_vec(), ..Options::default() };
    let done = watched(py, progress, move |observer| {
        motorlens::same(&first, &second, &options, kinds.as_deref(), observer)
    })?;
    let mut document = json!(done);
    document["schema"] = json!(1);
    text(&document)
}
