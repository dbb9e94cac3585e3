//! What Python calls: records as bytes, answers as JSON. The package around it makes them arrays and dataclasses.

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::Mutex;

use motorlens::estimate::{self, Method, effect_by_name};
use motorlens::export;
use motorlens::log::{self, ReadOptions, Record};
use motorlens::motor_file::{self, MotorFile};
use motorlens::simulate::SimulateArgs;
use motorlens::{Error, Event, Measured, Model, Options, Running};
use motorlens_shared::effects::Kind;
use pyo3::create_exception;
use pyo3::exceptions::{PyException, PyKeyboardInterrupt};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::{Value, json};

create_exception!(
    _native,
    MotorlensError,
    PyException,
    "Input that cannot be used: where, why, and what to do."
);

/// A record: a log file, or a name with its columns as 64-bit numbers in the machine's order.
#[derive(FromPyObject)]
enum Given {
    File(PathBuf),
    Table(String, BTreeMap<String, Vec<u8>>, BTreeMap<String, String>),
}

/// Columns of a table that a record may have.
const COLUMNS: [&str; 6] = ["time_s", "voltage_v", "angle_rad", "speed_rad_s", "current_a", "supply_v"];

fn failed(error: &Error) -> PyErr {
    match error {
        Error::Cancelled => PyKeyboardInterrupt::new_err(()),
        other => MotorlensError::new_err(other.to_string()),
    }
}

fn refused(why: impl Into<String>, remedy: &str) -> PyErr {
    failed(&Error::usage(why.into(), remedy))
}

/// 64-bit numbers from bytes, wherever they lie.
fn numbers(bytes: &[u8]) -> Vec<f64> {
    bytes.chunks_exact(8).filter_map(|number| Some(f64::from_ne_bytes(number.try_into().ok()?))).collect()
}

fn bytes<'py>(py: Python<'py>, numbers: &[f64]) -> Bound<'py, PyBytes> {
    PyBytes::new(py, bytemuck::cast_slice(numbers))
}

/// The records of `given`; the motor's figures stand above what a log says.
fn records(given: Vec<Given>, motor: &MotorFile) -> PyResult<Vec<Record>> {
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

fn table(
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
fn motor(path: Option<PathBuf>, text: Option<&str>) -> PyResult<MotorFile> {
    match (path, text) {
        (Some(path), _) => motor_file::read(&path),
        (None, Some(text)) => motor_file::parse("motor".as_ref(), text),
        (None, None) => Ok(MotorFile::default()),
    }
    .map_err(|e| failed(&e))
}

/// Watches for Ctrl-C and hands events to `progress`; an exception there stops the search and goes on from here.
fn watched<T: Send>(
    py: Python,
    progress: Option<Py<PyAny>>,
    work: impl FnOnce(&mut dyn FnMut(&Event) -> ControlFlow<()>) -> motorlens::Result<T> + Send,
) -> PyResult<T> {
    let raised: Mutex<Option<PyErr>> = Mutex::new(None);
    let done = py.detach(|| {
        work(&mut |event| {
            let told = Python::attach(|py| {
                py.check_signals()?;
                if let (Some(call), Some(event)) = (&progress, told(event)) {
                    call.call1(py, (event.to_string(),))?;
                }
                PyResult::Ok(())
            });
            match told {
                Ok(()) => ControlFlow::Continue(()),
                Err(error) => {
                    if let Ok(mut place) = raised.lock() {
                        *place = Some(error);
                    }
                    ControlFlow::Break(())
                }
            }
        })
    });
    match (done, raised.into_inner().unwrap_or_default()) {
        (_, Some(raised)) => Err(raised),
        (done, None) => done.map_err(|e| failed(&e)),
    }
}

fn told(event: &Event) -> Option<Value> {
    match event {
        Event::Waiting => None,
        Event::Trying { depth, effect } => Some(json!({ "trying": effect, "depth": depth })),
        Event::Model { effects, rmse } => Some(json!({ "effects": effects, "rmse": rmse })),
        Event::Generation { number, iae } => Some(json!({ "generation": number, "iae": iae })),
    }
}

/// Everything that a call on records needs.
struct Asked {
    records: Vec<Record>,
    options: Options,
}

fn asked(given: Vec<Given>, validate: Vec<Given>, motor: MotorFile, most: usize) -> PyResult<Asked> {
    let mut validation = records(validate, &motor)?;
    let mut records = records(given, &motor)?;
    // A record in which the motor stands still tells its breakaway voltage, and no more.
    let said = log::set_aside_still(&mut records, &mut validation);
    if let Some(first) = records.first_mut() {
        first.warnings.extend(said);
    }
    Ok(Asked { records, options: Options { validation, motor, most, ..Options::default() } })
}

fn text(value: &impl serde::Serialize) -> PyResult<String> {
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
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, NativeModel)> {
    let asked = asked(given, validate, motor(motor_path, motor_text)?, most)?;
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
    progress: Option<Py<PyAny>>,
) -> PyResult<(String, NativeModel)> {
    let asked = asked(given, validate, motor(motor_path, motor_text)?, 0)?;
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
    let effects = effects
        .iter()
        .map(|name| effect_by_name(name))
        .collect::<Result<Vec<_>, _>>()
        .map_err(|e| failed(&e))?;
    let how = estimate::Options { method, effects, population, generations, seed };
    let seed = how.seed;
    let fitted = watched(py, progress, move |observer| {
        motorlens::fit(&asked.records, &asked.options, &how, observer)
    })?;
    let document = json!({
        "schema": 1, "method": method, "effects": fitted.model.values().kinds(), "parameters": fitted.parameters,
        "combinations": fitted.combinations, "train": fitted.train, "validation": fitted.validation,
        "objective_history": fitted.objective_history, "seed": seed, "evaluations": fitted.evaluations,
        "seconds": fitted.seconds,
    });
    Ok((text(&document)?, NativeModel(fitted.model)))
}

#[pyfunction]
fn add(
    py: Python,
    model: &NativeModel,
    effect: &str,
    given: Vec<Given>,
    validate: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
) -> PyResult<(String, NativeModel)> {
    let effect = effect_by_name(effect).map_err(|e| failed(&e))?;
    let asked = asked(given, validate, motor(motor_path, motor_text)?, 0)?;
    let model = model.0.clone();
    let done = watched(py, None, move |observer| {
        motorlens::add(&model, effect, &asked.records, &asked.options, observer)
    })?;
    let document = json!({
        "schema": 1, "effect": effect, "worth_adding": done.worth, "why": done.why,
        "effects": done.model.values().kinds(), "given": done.given, "before": done.before, "after": done.after,
        "moved": done.moved, "parameters": done.parameters,
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
    progress: Option<Py<PyAny>>,
) -> PyResult<Option<String>> {
    let asked = asked(given, Vec::new(), motor(motor_path, motor_text)?, 1)?;
    let next = watched(py, progress, move |observer| {
        motorlens::plan(&asked.records, &asked.options, volts, seconds, observer)
    })?;
    next.map(|next| text(&next)).transpose()
}

/// A free run for each record: its name, its quantity, and times, measured and simulated values.
type Run<'py> = (String, String, Bound<'py, PyBytes>, Bound<'py, PyBytes>, Bound<'py, PyBytes>);

#[pyfunction]
fn compare<'py>(
    py: Python<'py>,
    model: &NativeModel,
    given: Vec<Given>,
    motor_path: Option<PathBuf>,
    motor_text: Option<&str>,
) -> PyResult<(String, Vec<Run<'py>>)> {
    use motorlens::compare::free_run::{free_runs, pooled};
    let motor = motor(motor_path, motor_text)?;
    let records = records(given, &motor)?;
    let model = model.0.clone();
    let runs = py
        .detach(|| {
            let mut problem = motorlens::compare::problem_of(&model, &records, &motor)?;
            problem.fixed.clear();
            Ok(free_runs(&problem, &model.values()))
        })
        .map_err(|e: Error| failed(&e))?;
    let of = |run: &motorlens::compare::free_run::FreeRun| {
        let mut row = json!(run.measures());
        row["record"] = json!(run.record);
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

#[pyfunction]
fn effects() -> PyResult<String> {
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
    text(&Kind::ALL.iter().map(row).collect::<Vec<_>>())
}

/// The options of `motorlens simulate`, as it reads them.
#[derive(clap::Parser)]
struct Simulation {
    #[command(flatten)]
    options: SimulateArgs,
}

/// Writes logs of the virtual motor, as `motorlens simulate` does with these options.
#[pyfunction]
fn simulate(py: Python, options: Vec<String>) -> PyResult<String> {
    let words = std::iter::once("simulate".to_owned()).chain(options);
    let read = <Simulation as clap::Parser>::try_parse_from(words)
        .map_err(|e| refused(e.to_string(), "see motorlens simulate --help for the options"))?;
    let done = py.detach(|| motorlens::simulate::run(&read.options)).map_err(|e| failed(&e))?;
    text(&done)
}

/// A fitted motor.
#[pyclass(frozen, name = "NativeModel")]
#[derive(Clone)]
struct NativeModel(Model);

#[pymethods]
impl NativeModel {
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Model::read(&path).map(Self).map_err(|e| failed(&e))
    }
    fn write(&self, path: PathBuf) -> PyResult<()> {
        self.0.write(&path).map_err(|e| failed(&e))
    }
    fn to_json(&self) -> PyResult<String> {
        text(&self.0)
    }
    fn simulate<'py>(
        &self,
        py: Python<'py>,
        time_s: &[u8],
        voltage_v: &[u8],
        angle_rad: f64,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let (time, volts) = (numbers(time_s), numbers(voltage_v));
        let angles = py.detach(|| self.0.simulate(&time, &volts, angle_rad)).map_err(|e| failed(&e))?;
        Ok(bytes(py, &angles))
    }
    fn start(&self, step_s: f64, angle_rad: f64) -> PyResult<NativeRun> {
        if !(step_s > 0.0 && step_s <= 0.01) {
            return Err(refused(format!("a step of {step_s} s"), "give more than 0 and at most 0.01 s"));
        }
        Ok(NativeRun(self.0.start(step_s, angle_rad)))
    }
    /// The file, a second file with its ending, notes, and what is lacking with its cost in sentences.
    fn export<'py>(
        &self,
        py: Python<'py>,
        format: &str,
        step_s: Option<f64>,
        torque_per_volt: Option<f64>,
        name: Option<String>,
    ) -> PyResult<Exported<'py>> {
        let format = <export::Format as clap::ValueEnum>::from_str(format, false).map_err(|_| {
            refused(format!("there is no format \"{format}\""), "motorlens export --help lists them")
        })?;
        let options = export::Options { step_s, torque_per_volt, name, bam_model: None };
        let (done, cost) = py
            .detach(|| {
                let done = export::export(&self.0, format, &options)?;
                let cost = export::cost::cost(&self.0, &done, &[], &MotorFile::default())?;
                Ok((done, cost))
            })
            .map_err(|e: Error| failed(&e))?;
        let lost = done
            .lost
            .iter()
            .map(|lost| format!("{} has no place for {}: {}", format.title(), lost.effect, lost.why));
        let costs = (!done.lost.is_empty()).then(|| format!("together {}", cost.clause()));
        let lost = lost.chain(costs).collect();
        let beside = done.beside.map(|(ending, text)| (ending.to_owned(), text));
        Ok((PyBytes::new(py, &done.content), beside, done.notes, lost))
    }
}

/// What [`NativeModel::export`] gives.
type Exported<'py> = (Bound<'py, PyBytes>, Option<(String, String)>, Vec<String>, Vec<String>);

/// A model on its way.
#[pyclass(name = "NativeRun")]
struct NativeRun(Running);

#[pymethods]
impl NativeRun {
    fn step(&mut self, voltage_v: f64) -> f64 {
        self.0.step(voltage_v)
    }
    #[getter]
    fn angle_rad(&self) -> f64 {
        self.0.angle_rad()
    }
    #[getter]
    fn speed_rad_s(&self) -> f64 {
        self.0.speed_rad_s()
    }
    #[getter]
    fn time_s(&self) -> f64 {
        self.0.time_s()
    }
}

#[pymodule]
fn _native(module: &Bound<'_, PyModule>) -> PyResult<()> {
    module.add("MotorlensError", module.py().get_type::<MotorlensError>())?;
    module.add("__version__", env!("CARGO_PKG_VERSION"))?;
    module.add_class::<NativeModel>()?;
    module.add_class::<NativeRun>()?;
    module.add_function(wrap_pyfunction!(discover, module)?)?;
    module.add_function(wrap_pyfunction!(fit, module)?)?;
    module.add_function(wrap_pyfunction!(add, module)?)?;
    module.add_function(wrap_pyfunction!(plan, module)?)?;
    module.add_function(wrap_pyfunction!(compare, module)?)?;
    module.add_function(wrap_pyfunction!(effects, module)?)?;
    module.add_function(wrap_pyfunction!(simulate, module)?)?;
    Ok(())
}
