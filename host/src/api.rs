//! The library's front door: plain slices in, findings out.
//!
//! [`discover`] takes time, voltage and angle (or speed) of one record; [`discover_records`] takes several, with records to judge by
//! and what is known of the motor. Work runs on a thread of its own while the caller's thread hands every [`Event`] to the
//! observer, which stops it by returning [`ControlFlow::Break`]: the search then takes no further steps, and the call ends with
//! [`Error::Cancelled`]. Nothing of a call outlives it, and no state is shared between calls.
//!
//! ```
//! use std::ops::ControlFlow;
//! use motorlens::{Measured, Options, discover};
//!
//! // A second-order motor that swallows a volt in each direction: 4 s of steps, 500 samples a second.
//! let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 2e-3).collect();
//! let volts: Vec<f64> = (0..2000).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0, -7.0][k / 250 % 6]).collect();
//! let mut angle = vec![0.0];
//! let (mut x, mut w) = (0.0, 0.0);
//! for k in 0..1999 {
//!     for _ in 0..20 {
//!         let v: f64 = volts[k];
//!         w += 1e-4 * (0.9 * v.signum() * (v.abs() - 1.0).max(0.0) - w) / 0.05;
//!         x += 1e-4 * w;
//!     }
//!     angle.push((x / 1e-3_f64).round() * 1e-3);
//! }
//! let found = discover(&time, &volts, Measured::Angle(&angle), &Options::default(), &mut |_| ControlFlow::Continue(()))?;
//! println!("{}: {:?}", found.findings.headline, found.findings.effects);
//! # assert!(found.model.base.gain > 0.5);
//! # Ok::<(), motorlens::Error>(())
//! ```

use std::ops::ControlFlow;
use std::path::PathBuf;
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use motorlens_shared::effects::Kind;

pub use crate::diagnose::discover::{self as search, Progress};
use crate::diagnose::plan::Limits;
pub use crate::error::{Error, Result};
use crate::estimate;
use crate::findings::{Findings, NextExperiment};
use crate::log::{self, Record};
pub use crate::model_file::Model;
use crate::motor_file::MotorFile;
use crate::stop::Stop;

/// What was measured of the output shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measured<'a> {
    /// Its angle, rad.
    Angle(&'a [f64]),
    /// Its speed, rad/s.
    Speed(&'a [f64]),
}

/// What to look for, and what is known.
#[derive(Debug, Clone)]
pub struct Options {
    /// Records that touch no fit and no choice: they are scored once, at the end.
    pub validation: Vec<Record>,
    /// What is known of the motor.
    pub motor: MotorFile,
    /// Effects that may be added.
    pub library: Vec<Kind>,
    /// Most effects to add.
    pub most: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { validation: Vec::new(), motor: MotorFile::default(), library: Kind::ALL.to_vec(), most: 4 }
    }
}

/// What goes on, for whoever watches.
#[derive(Debug, Clone)]
pub enum Event {
    /// Nothing new in the last tenth of a second: a moment to look for a wish to stop.
    Waiting,
    /// An effect is tried on the model of so many effects.
    Trying {
        /// Effects in the model so far.
        depth: usize,
        /// The effect on trial.
        effect: Kind,
    },
    /// A model of the sequence is fitted.
    Model {
        /// Its effects.
        effects: Vec<Kind>,
        /// Root mean square error on the records fitted, in the measured unit.
        rmse: f64,
    },
    /// A generation of the genetic algorithm is done.
    Generation {
        /// Its number.
        number: u32,
        /// Its best integral of the absolute error.
        iae: f64,
    },
}

/// Sees every event; stops the call by returning [`ControlFlow::Break`].
pub type Observer<'a> = &'a mut dyn FnMut(&Event) -> ControlFlow<()>;

/// What a discovery found.
#[derive(Debug)]
pub struct Discovered {
    /// Effects, verdict, parameters, candidates, rivals: the document of `discover --json`.
    pub findings: Findings,
    /// The model on all records.
    pub model: Model,
}

/// One record from slices: times (s) that rise, the voltage at the driver's output (V) held from each sample to the next, and
/// what was measured of the output shaft.
///
/// # Errors
/// Slices of different length, numbers that are not finite, times that do not rise, too few samples.
///
/// ```
/// use motorlens::{Measured, record};
/// let time: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.01).collect();
/// let run = record("run", &time, &[6.0; 50], Measured::Speed(&[1.0; 50]))?;
/// assert_eq!(run.len(), 50);
/// assert!(record("run", &time, &[6.0; 49], Measured::Speed(&[1.0; 50])).is_err());
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn record(name: &str, time_s: &[f64], voltage_v: &[f64], measured: Measured) -> Result<Record> {
    let (column, values) = match measured {
        Measured::Angle(values) => ("angle_rad", values),
        Measured::Speed(values) => ("speed_rad_s", values),
    };
    let columns = [("time_s", time_s), ("voltage_v", voltage_v), (column, values)];
    check(name, &columns)?;
    if time_s.len() < log::FEWEST_SAMPLES {
        let why = format!("{} samples are too few to fit a motor", time_s.len());
        return Err(crate::error::BadInput::new(
            name.as_ref(),
            why,
            "record some seconds with changing voltage",
        )
        .into());
    }
    Ok(laid_out(name, time_s, voltage_v, measured))
}

/// Columns that were checked, as a record.
pub(crate) fn laid_out(name: &str, time_s: &[f64], voltage_v: &[f64], measured: Measured) -> Record {
    let (angle, values) = match measured {
        Measured::Angle(values) => (true, values),
        Measured::Speed(values) => (false, values),
    };
    let own = || Some(values.to_vec());
    Record {
        name: name.to_owned(),
        path: PathBuf::from(name),
        time_s: time_s.to_vec(),
        voltage_v: voltage_v.to_vec(),
        angle_rad: if angle { own() } else { None },
        speed_rad_s: if angle { None } else { own() },
        ..Record::default()
    }
}

/// Whether `columns`, time first, are numbers in step.
pub(crate) fn check(name: &str, columns: &[(&str, &[f64])]) -> Result<()> {
    let bad = |column: &str, why: String, remedy: &str| -> Result<()> {
        Err(crate::error::BadInput::new(name.as_ref(), why, remedy).in_column(column).into())
    };
    let rows = columns[0].1.len();
    for (column, values) in columns {
        if values.len() != rows {
            let why = format!("{} values, and {rows} times", values.len());
            return bad(column, why, "give every column a value for each time");
        }
        if let Some(k) = values.iter().position(|x| !x.is_finite()) {
            let why = format!("value {k} (from 0) is {}", values[k]);
            return bad(column, why, "leave out the rows that have no number");
        }
    }
    if let Some(k) = columns[0].1.windows(2).position(|t| t[1] <= t[0]) {
        let t = columns[0].1;
        let why =
            format!("time does not rise from value {k} (from 0), {} s, to the next, {} s", t[k], t[k + 1]);
        return bad(columns[0].0, why, "sort the rows by time, and give each time once");
    }
    Ok(())
}

/// Fits, diagnoses and adds effects until nothing is worth adding, on one record; see [`record`] for the slices.
///
/// # Errors
/// A record that no fit can use; [`Error::Cancelled`] where the observer stopped it.
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
        let asked = search::Options { library: options.library.clone(), most: options.most };
        let found = search::discover(records, &options.validation, &options.motor, &asked, &mut told(tell))?;
        let faults = log::data_faults(records.iter().chain(&options.validation));
        let findings = Findings::new(&found, &faults).supposing(records);
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
        let asked = search::Options { library: options.library.clone(), most: options.most };
        let found = search::discover(records, &options.validation, &options.motor, &asked, &mut told(tell))?;
        let volts = volts.unwrap_or_else(|| found.evidence.highest_voltage());
        Ok(found.experiment(Limits { volts, seconds }).next)
    })
}

/// Fits the parameters of a model whose effects are given, by the method that `how` names.
///
/// # Errors
/// Records that no fit can use, effects that no model can hold, [`Error::Cancelled`].
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::{Measured, Options, estimate, fit, record};
/// # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
/// # let volts: Vec<f64> = (0..1500).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0][k / 200 % 5]).collect();
/// # let (mut angle, mut x, mut w) = (vec![0.0], 0.0_f64, 0.0_f64);
/// # for k in 0..1499 {
/// #     for _ in 0..20 {
/// #         w += 1e-4 * (0.9 * volts[k] - w) / 0.05;
/// #         x += 1e-4 * w;
/// #     }
/// #     angle.push((x / 1e-3).round() * 1e-3);
/// # }
/// let run = record("run", &time, &volts, Measured::Angle(&angle))?;
/// let fitted = fit(&[run], &Options::default(), &estimate::Options::default(), &mut |_| ControlFlow::Continue(()))?;
/// let gain = fitted.parameters.iter().find(|p| p.name == "gain").expect("every model has one");
/// assert!((gain.value - 0.9).abs() < 0.01);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn fit(
    records: &[Record],
    options: &Options,
    how: &estimate::Options,
    observer: Observer,
) -> Result<estimate::Fit> {
    watched(observer, move |tell| {
        estimate::fit(records, &options.validation, &options.motor, how, &mut |number, iae| {
            tell(Event::Generation { number, iae });
        })
    })
}

/// Adds one effect to a model and says whether it is worth it.
///
/// # Errors
/// Records that no fit can use, an effect that the model cannot take, [`Error::Cancelled`].
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::{Kind, Measured, Options, add, estimate, fit, record};
/// # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
/// # let volts: Vec<f64> = (0..1500).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0][k / 200 % 5]).collect();
/// # let (mut angle, mut x, mut w) = (vec![0.0], 0.0_f64, 0.0_f64);
/// # for k in 0..1499 {
/// #     for _ in 0..20 {
/// #         w += 1e-4 * (0.9 * volts[k] - w) / 0.05;
/// #         x += 1e-4 * w;
/// #     }
/// #     angle.push((x / 1e-3).round() * 1e-3);
/// # }
/// let runs = [record("run", &time, &volts, Measured::Angle(&angle))?];
/// let options = Options::default();
/// let plain = fit(&runs, &options, &estimate::Options::default(), &mut |_| ControlFlow::Continue(()))?;
/// let added = add(&plain.model, Kind::Coulomb, &runs, &options, &mut |_| ControlFlow::Continue(()))?;
/// assert!(!added.worth, "this motor has no dry friction: {}", added.why);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn add(
    model: &Model,
    effect: Kind,
    records: &[Record],
    options: &Options,
    observer: Observer,
) -> Result<estimate::Addition> {
    watched(observer, move |_| estimate::add(model, effect, records, &options.validation, &options.motor))
}

/// Whether two sets of records come from one motor. Models with `effects` are fitted to either set and to both; without `effects`, those
/// that [`discover_records`] finds on the first set.
///
/// # Errors
/// As [`fit()`].
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::same::Verdict;
/// use motorlens::{Measured, Options, record, same};
/// # let time: Vec<f64> = (0..1000).map(|k| f64::from(k) * 2e-3).collect();
/// # let run = |name: &str, steps: [f64; 5], gain: f64| {
/// #     let volts: Vec<f64> = (0..1000).map(|k| steps[k / 100 % 5]).collect();
/// #     let (mut angle, mut x, mut w) = (vec![0.0], 0.0_f64, 0.0_f64);
/// #     for k in 0..999 {
/// #         for _ in 0..20 {
/// #             w += 1e-4 * (gain * volts[k] - w) / 0.05;
/// #             x += 1e-4 * w;
/// #         }
/// #         angle.push((x / 1e-3).round() * 1e-3);
/// #     }
/// #     record(name, &time, &volts, Measured::Angle(&angle))
/// # };
/// # let one = run("one", [6.0, 0.0, -4.0, 2.0, 9.0], 0.9)?;
/// # let other = run("other", [-3.0, 7.0, 0.0, -8.0, 4.0], 1.2)?;
/// // Two records, of motors that turn 0.9 and 1.2 rad/s per volt.
/// let found = same(&[one], &[other], &Options::default(), Some(&[]), &mut |_| ControlFlow::Continue(()))?;
/// assert_eq!(found.verdict, Verdict::Different);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn same(
    first: &[Record],
    second: &[Record],
    options: &Options,
    effects: Option<&[Kind]>,
    observer: Observer,
) -> Result<crate::same::Comparison> {
    watched(observer, move |tell| {
        let motor = &options.motor;
        let kinds = match effects {
            Some(kinds) => kinds.to_vec(),
            None => {
                let asked = search::Options { library: options.library.clone(), most: options.most };
                search::discover(first, &[], motor, &asked, &mut told(tell))?.effects
            }
        };
        crate::same::same(first, second, motor, &kinds)
    })
}

/// What a search tells, as the observer's events.
fn told(tell: &dyn Fn(Event)) -> impl FnMut(Progress) {
    move |progress| match progress {
        Progress::Trying { depth, effect } => tell(Event::Trying { depth, effect }),
        Progress::Rung(rung) => tell(Event::Model { effects: rung.effects, rmse: rung.train.rmse }),
        Progress::Anew(_) => {}
    }
}

/// Runs `work` on a thread of its own, and the observer here.
fn watched<T: Send>(observer: Observer, work: impl FnOnce(&dyn Fn(Event)) -> Result<T> + Send) -> Result<T> {
    const PATIENCE: Duration = Duration::from_millis(100);
    let (events, seen) = channel();
    let stop = Stop::default();
    let stopped = std::thread::scope(|scope| {
        let stop = &stop;
        let worker = scope.spawn(move || {
            // A search that is to stop has no listener any more.
            stop.heeded_by(|| work(&|event| drop(events.send(event))))
        });
        loop {
            let event = match seen.recv_timeout(PATIENCE) {
                Ok(event) => event,
                Err(RecvTimeoutError::Timeout) => Event::Waiting,
                Err(RecvTimeoutError::Disconnected) => break,
            };
            if observer(&event).is_break() {
                stop.ask();
                drop(seen);
                drop(worker.join());
                return None;
            }
        }
        Some(worker.join().unwrap_or_else(|fault| std::panic::resume_unwind(fault)))
    });
    stopped.unwrap_or(Err(Error::Cancelled))
}
