//! Which effects a motor has, and the experiment that tells more.

use super::observed::{told, watched};
use super::{Event, Measured, Observer, Options, record, search};
use crate::diagnose::plan::Limits;
use crate::error::Result;
use crate::findings::{Findings, NextExperiment};
use crate::log::{self, Record};
use crate::model_file::Model;

/// What a discovery found.
#[derive(Debug)]
pub struct Discovered {
    /// Effects, verdict, parameters, candidates, rivals: the document of `discover --json`.
    pub findings: Findings,
    /// The model on all records.
    pub model: Model,
}

/// Fits, diagnoses and adds effects until nothing is worth adding, on one record; see [`record`] for the slices.
///
/// # Errors
/// A record that no fit can use; [`Error::Cancelled`](crate::Error::Cancelled) where the observer stopped it.
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::{Measured, Options, discover};
/// # // The friction of 0.4 V that the example's model has.
/// # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
/// # let volts: Vec<f64> = (0..1500).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0][k / 200 % 5]).collect();
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
/// # let angle = motorlens::Model::read(path.as_ref())?.simulate(&time, &volts, 0.0)?;
/// # let angle: Vec<f64> = angle.iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
/// let found = discover(&time, &volts, Measured::Angle(&angle), &Options::default(), &mut |_| ControlFlow::Continue(()))?;
/// println!("{}", found.findings.headline);
/// assert!(found.model.values().kinds().iter().any(|effect| effect.name() == "coulomb"));
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn discover(
    time_s: &[f64],
    voltage_v: &[f64],
    measured: Measured,
    options: &Options,
    observer: Observer,
) -> Result<Discovered> {
    discover_records(&[record("record", time_s, voltage_v, measured)?], options, observer)
}

/// The same on several records of one motor.
///
/// # Errors
/// As [`discover`].
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::{Measured, Options, discover_records, record};
///
/// # // A motor with a friction of 0.4 V.
/// # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
/// # let model = motorlens::Model::read(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json").as_ref())?;
/// # let moved = |steps: [f64; 5]| -> motorlens::Result<(Vec<f64>, Vec<f64>)> {
/// #     let volts: Vec<f64> = (0..1500).map(|k| steps[k / 200 % 5]).collect();
/// #     let angle = model.simulate(&time, &volts, 0.0)?.iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
/// #     Ok((volts, angle))
/// # };
/// # let (volts, angle) = moved([6.0, 0.0, -4.0, 2.0, 9.0])?;
/// # let (other_volts, other_angle) = moved([-3.0, 7.0, 0.0, -8.0, 4.0])?;
/// // Two runs as slices; log::read makes records of files.
/// let run = record("run", &time, &volts, Measured::Angle(&angle))?;
/// let unseen = record("unseen", &time, &other_volts, Measured::Angle(&other_angle))?;
/// let options = Options { validation: vec![unseen], most: 1, ..Options::default() };
/// let found = discover_records(&[run], &options, &mut |event| {
///     eprintln!("{event:?}");
///     ControlFlow::Continue(())
/// })?;
/// println!("{}", found.findings.headline);
/// assert_eq!(found.findings.effects.len(), 1);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn discover_records(records: &[Record], options: &Options, observer: Observer) -> Result<Discovered> {
    watched(observer, move |tell| {
        let found = searched(records, options, tell)?;
        let faults = log::data_faults(records.iter().chain(&options.validation));
        let findings = Findings::new(&found, &faults);
        let findings = findings.supposing(records, &options.motor, &found.evidence.whole.rig);
        Ok(Discovered { findings, model: found.model })
    })
}

/// The experiment that would tell apart what `records` leave open, within `volts` (V; what the records reached, if absent)
/// and `seconds`; none where nothing is open.
///
/// # Errors
/// As [`discover`].
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::{Measured, Options, plan, record};
/// # // The friction of 0.4 V that the example's model has.
/// # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
/// # let volts: Vec<f64> = (0..1500).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0][k / 200 % 5]).collect();
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
/// # let angle = motorlens::Model::read(path.as_ref())?.simulate(&time, &volts, 0.0)?;
/// # let angle: Vec<f64> = angle.iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
/// let runs = [record("run", &time, &volts, Measured::Angle(&angle))?];
/// if let Some(next) = plan(&runs, &Options::default(), Some(12.0), 8.0, &mut |_| ControlFlow::Continue(()))? {
///     println!("{}: {} segments", next.why, next.programme.segments.len());
///     assert!(!next.programme.segments.is_empty());
/// }
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn plan(
    records: &[Record],
    options: &Options,
    volts: Option<f64>,
    seconds: f64,
    observer: Observer,
) -> Result<Option<NextExperiment>> {
    watched(observer, move |tell| {
        // The loop of `discover`: an experiment that is proposed after its first step may be another one.
        let found = searched(records, options, tell)?;
        let volts = volts.unwrap_or_else(|| found.evidence.highest_voltage());
        Ok(found.experiment(Limits { volts, seconds }).next)
    })
}

/// The loop of fit, diagnosis and effects.
fn searched(records: &[Record], options: &Options, tell: &dyn Fn(Event)) -> Result<search::Discovery> {
    search::discover(records, &options.validation, &options.motor, &options.asked(), &mut told(tell))
}
