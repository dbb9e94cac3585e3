//! What Python calls: records as bytes, answers as JSON. The package around it makes them arrays and dataclasses.

mod fault;
mod model;
mod records;
mod runs;
mod watch;

use std::path::PathBuf;

use motorlens::Kind;
use motorlens::estimate::{self, Method};
use motorlens::simulate::SimulateArgs;
use pyo3::prelude::*;
use serde_json::{Value, json};

use crate::fault::{MotorlensError, failed, refused};
use crate::model::{NativeModel, NativeRun};
use crate::records::{Given, NativeRecord, asked, kinds, library, misread, motor};
use crate::watch::watched;

pub(crate) fn text(value: &impl serde::Serialize) -> PyResult<String> {
    serde_json::to_string(value).map_err(|e| refused(e.to_string(), "report this"))
}

#[pyfunction]
fn discover(
    py: Python,
    given: Vec<Given>,
    validate: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
    most: usize,
    own: Vec<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, NativeModel)> {
    let asked = asked(given, validate, motor(motor_path, motor_text)?, most, &library(&own)?)?;
    let found = watched(py, progress, move |observer| {
        motorlens::discover_records(&asked.records, &asked.options, observer)
    })?;
    Ok((text(&found.findings)?, NativeModel(found.model)))
}

#[pyfunction]
fn fit(
    py: Python,
    given: Vec<Given>,
    validate: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
    how: (String, Vec<String>, usize, u32, u64),
    own: Vec<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, NativeModel)> {
    let library = library(&own)?;
    let asked = asked(given, validate, motor(motor_path, motor_text)?, 0, &library)?;
    let (method, effects, population, generations, seed) = how;
    let method = match method.as_str() {
        "fast" => Method::Fast,
        "ga" => Method::Ga,
        "conventional" => Method::Conventional,
        "paper" => Method::Paper,
        "feedforward" => Method::Feedforward,
        other => {
            return Err(refused(
                format!("there is no method \"{other}\""),
                "take fast, ga, conventional, paper or feedforward",
            ));
        }
    };
    let effects = kinds(&effects, &library)?;
    let how = estimate::Options { method, effects, population, generations, seed };
    let seed = how.seed;
    let fitted = watched(py, progress, move |observer| {
        motorlens::fit(&asked.records, &asked.options, &how, observer)
    })?;
    let document = json!({
        "schema": 1, "method": method, "effects": fitted.model.values().kinds(), "parameters": fitted.parameters,
        "combinations": fitted.combinations, "train": fitted.train, "validation": fitted.validation,
        "objective_history": fitted.objective_history, "seed": seed, "evaluations": fitted.evaluations,
        "seconds": fitted.seconds, "supposes": fitted.supposed.sentences(),
    });
    Ok((text(&document)?, NativeModel(fitted.model)))
}

#[pyfunction]
fn add(
    py: Python,
    model: &NativeModel,
    effect: String,
    given: Vec<Given>,
    validate: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
    own: Vec<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, NativeModel)> {
    let library = library(&own)?;
    let effect = kinds(&[effect], &library)?[0];
    let asked = asked(given, validate, motor(motor_path, motor_text)?, 0, &library)?;
    let model = model.0.clone();
    let done = watched(py, progress, move |observer| {
        motorlens::add(&model, effect, &asked.records, &asked.options, observer)
    })?;
    let document = json!({
        "schema": 1, "effect": effect, "worth_adding": done.worth, "why": done.why,
        "effects": done.model.values().kinds(), "given": done.given, "before": done.before, "after": done.after,
        "moved": done.moved, "parameters": done.parameters, "supposes": done.supposed.sentences(),
    });
    Ok((text(&document)?, NativeModel(done.model)))
}

#[pyfunction]
fn plan(
    py: Python,
    given: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
    volts: Option<f64>,
    seconds: f64,
    own: Vec<PathBuf>,
    progress: Option<Py<PyAny>>,
) -> PyResult<Option<String>> {
    let most = motorlens::Options::default().most;
    let asked = asked(given, Vec::new(), motor(motor_path, motor_text)?, most, &library(&own)?)?;
    let next = watched(py, progress, move |observer| {
        motorlens::plan(&asked.records, &asked.options, volts, seconds, observer)
    })?;
    next.map(|next| text(&next)).transpose()
}

#[pyfunction]
fn effects(own: Vec<PathBuf>) -> PyResult<String> {
    let row = |kind: &Kind| {
        let spec = kind.spec();
        let parameters: Vec<Value> = spec
            .parameters
            .iter()
            .map(|p| json!({ "name": p.name, "unit": p.unit, "meaning": p.meaning, "strength": p.strength }))
            .collect();
        json!({
            "name": spec.name, "port": spec.port, "title": spec.title, "equation": spec.equation,
            "source": spec.source, "signature": spec.signature, "parameters": parameters,
        })
    };
    text(&library(&own)?.kinds().iter().map(row).collect::<Vec<_>>())
}

/// The options of `motorlens simulate`, as it reads them.
#[derive(clap::Parser)]
struct Simulation {
    #[command(flatten)]
    options: SimulateArgs,
}

/// Writes logs of the virtual motor, as `motorlens simulate` does with these options.
#[pyfunction]
fn simulate(py: Python, options: Vec<String>, own: Vec<PathBuf>) -> PyResult<String> {
    let words = std::iter::once("simulate".to_owned()).chain(options);
    let read = <Simulation as clap::Parser>::try_parse_from(words).map_err(|e| misread(&e))?;
    let options = SimulateArgs { library: library(&own)?, ..read.options };
    let done = py.detach(|| motorlens::simulate::run(&options)).map_err(|e| failed(&e))?;
    text(&done)
}

/// Writes a file, whole or not at all.
#[pyfunction]
fn write_file(path: PathBuf, content: &[u8]) -> PyResult<()> {
    motorlens::atomic_file::write(&path, content).map_err(|e| failed(&e))
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("MotorlensError", module.py().get_type::<MotorlensError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<NativeModel>()?;
    module.add_class::<NativeRun>()?;
    module.add_class::<NativeRecord>()?;
    module.add_function(wrap_pyfunction!(records::read, module)?)?;
    module.add_function(wrap_pyfunction!(write_file, module)?)?;
    module.add_function(wrap_pyfunction!(discover, module)?)?;
    module.add_function(wrap_pyfunction!(fit, module)?)?;
    module.add_function(wrap_pyfunction!(add, module)?)?;
    module.add_function(wrap_pyfunction!(plan, module)?)?;
    module.add_function(wrap_pyfunction!(runs::compare, module)?)?;
    module.add_function(wrap_pyfunction!(runs::same, module)?)?;
    module.add_function(wrap_pyfunction!(effects, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    Ok(())
}
