//! A model in Python's hands: it simulates, steps, is saved, exported and tuned.

use std::path::PathBuf;

use motorlens::export;
use motorlens::tune::{self, tune};
use motorlens::{Model, Running};
use pyo3::prelude::*;
use pyo3::types::PyBytes;
use serde_json::json;

use crate::fault::{failed, refused};
use crate::records::{Given, bytes, motor, numbers, records};
use crate::text;
use crate::watch::watched;

/// A fitted motor.
#[pyclass(frozen, name = "NativeModel")]
#[derive(Clone)]
pub(crate) struct NativeModel(pub(crate) Model);

#[pymethods]
impl NativeModel {
    #[staticmethod]
    fn read(path: PathBuf) -> PyResult<Self> {
        Model::read(&path).map(Self).map_err(|e| failed(&e))
    }
    #[staticmethod]
    fn from_json(text: &str) -> PyResult<Self> {
        Model::from_json(text).map(Self).map_err(|e| failed(&e))
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
        speed_rad_s: f64,
    ) -> PyResult<Bound<'py, PyBytes>> {
        let (time, volts) = (numbers(time_s), numbers(voltage_v));
        let run = || self.0.simulate_moving(&time, &volts, angle_rad, speed_rad_s);
        let angles = py.detach(run).map_err(|e| failed(&e))?;
        Ok(bytes(py, &angles))
    }
    fn start(&self, step_s: f64, angle_rad: f64, speed_rad_s: f64) -> PyResult<NativeRun> {
        if !(step_s > 0.0 && step_s <= 0.01) {
            return Err(refused(format!("a step of {step_s} s"), "give more than 0 and at most 0.01 s"));
        }
        Ok(NativeRun(self.0.start_moving(step_s, angle_rad, speed_rad_s)))
    }
    /// Gains, trials and steps in JSON, and for each trial and each step its course.
    fn tune<'py>(
        &self,
        py: Python<'py>,
        period_s: f64,
        phase_margin_deg: f64,
        limit_v: Option<f64>,
    ) -> PyResult<(String, Vec<Course<'py>>, Vec<Course<'py>>)> {
        let options = tune::Options { period_s, phase_margin_deg, limit_v };
        let tuned = py.detach(|| tune(&self.0, &options)).map_err(|e| failed(&e))?;
        let columns = |course: &tune::Course| -> Course<'py> {
            [&course.time_s, &course.wanted, &course.reached].map(|column| bytes(py, column))
        };
        let trials = tuned.trials.iter().map(|trial| columns(&trial.course)).collect();
        let steps = tuned.steps.iter().map(|step| columns(&step.course)).collect();
        let mut document = json!(tuned);
        document["schema"] = json!(1);
        document["period_s"] = json!(period_s);
        Ok((text(&document)?, trials, steps))
    }
    /// The file, a second file with its ending, notes, and what is lacking with its cost in sentences.
    fn export<'py>(
        &self,
        py: Python<'py>,
        format: &str,
        how: (Option<f64>, Option<f64>, Option<String>, Option<u8>),
        on: Vec<Given>,
        motor_path: Option<PathBuf>,
        motor_text: Option<&str>,
        progress: Option<Py<PyAny>>,
    ) -> PyResult<Exported<'py>> {
        let format = <export::Format as clap::ValueEnum>::from_str(format, false).map_err(|_| {
            refused(format!("there is no format \"{format}\""), "motorlens export --help lists them")
        })?;
        let (step_s, torque_per_volt, name, bam_model) = how;
        if step_s.is_some_and(|step| !(step > 0.0 && step <= 0.01)) {
            return Err(refused("a step that no export takes", "give more than 0 and at most 0.01 s"));
        }
        if torque_per_volt.is_some_and(|torque| !(torque.is_finite() && torque > 0.0)) {
            return Err(refused("a torque per volt that is none", "give a positive number of N m/V"));
        }
        if bam_model.is_some_and(|number| !(1..=6).contains(&number)) {
            return Err(refused("a model that BAM does not have", "give 1 to 6"));
        }
        let motor = motor(motor_path, motor_text)?;
        let (on, _) = records(on, Vec::new(), &motor)?;
        // The Python that asks is the one whose MuJoCo the file is for.
        let python: Option<PathBuf> = py.import("sys")?.getattr("executable")?.extract()?;
        let options = export::Options { step_s, torque_per_volt, name, bam_model };
        let (done, told, cost) = watched(py, progress, |observer| {
            let done = export::export(&self.0, format, &options)?;
            let cost = export::cost::cost(&self.0, &done, &on, &motor, python.as_deref(), observer)?;
            let told = export::told::told(&done, &self.0, format, &options, Some(&cost));
            Ok((done, told, cost))
        })?;
        // What is simplified is a reason to refuse only where a record tells that it is too much.
        let refuses = !done.lost.is_empty() || cost.is_too_high();
        let (lost, simplified) =
            if refuses { (told.lacking, Vec::new()) } else { (Vec::new(), told.lacking) };
        let notes = simplified.into_iter().chain(told.to_know).collect();
        let beside = done.beside.map(|(ending, text)| (ending.to_owned(), text));
        Ok((PyBytes::new(py, &done.content), beside, notes, lost))
    }
}

/// The times, what was wanted and what was reached.
pub(crate) type Course<'py> = [Bound<'py, PyBytes>; 3];

/// What [`NativeModel::export`] gives.
pub(crate) type Exported<'py> = (Bound<'py, PyBytes>, Option<(String, String)>, Vec<String>, Vec<String>);

/// A model on its way.
#[pyclass(name = "NativeRun")]
pub(crate) struct NativeRun(Running);

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
