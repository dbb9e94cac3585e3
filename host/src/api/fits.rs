//! Models whose effects are given: fitted, held against records, with one effect more, and fitted to two sets of records.

use motorlens_shared::effects::Kind;

use super::observed::{told, watched};
use super::{Event, Observer, Options, search};
use crate::compare::free_run::{FreeRun, free_runs};
use crate::compare::problem_as_it_is;
use crate::error::Result;
use crate::estimate;
use crate::log::Record;
use crate::model_file::Model;

/// Fits the parameters of a model whose effects are given, by the method that `how` names.
///
/// # Errors
/// Records that no fit can use, effects that no model can hold, [`Error::Cancelled`](crate::Error::Cancelled).
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

/// Simulates a model over each of `records` in an open loop, beside what was measured there. Nothing is fitted but the speeds at which records
/// in motion begin.
///
/// # Errors
/// Records that say nothing about a motor, [`Error::Cancelled`](crate::Error::Cancelled).
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::compare::free_run::pooled;
/// use motorlens::{Measured, Model, Options, compare, record};
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
/// let model = Model::read(path.as_ref())?;
/// # // What the model itself turns, read by an encoder.
/// # let time: Vec<f64> = (0..1500).map(|k| f64::from(k) * 2e-3).collect();
/// # let volts: Vec<f64> = (0..1500).map(|k| [6.0, 0.0, -4.0, 2.0, 9.0][k / 200 % 5]).collect();
/// # let angle = model.simulate(&time, &volts, 0.0)?;
/// # let angle: Vec<f64> = angle.iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
/// let run = record("run", &time, &volts, Measured::Angle(&angle))?;
/// let runs = compare(&model, &[run], &Options::default(), &mut |_| ControlFlow::Continue(()))?;
/// let errors = pooled(&runs).expect("a record has samples");
/// println!("rms error {} rad, largest {} rad", errors.rmse, errors.me);
/// assert!(errors.rmse < 1e-3 && runs[0].simulated.len() == time.len());
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn compare(
    model: &Model,
    records: &[Record],
    options: &Options,
    observer: Observer,
) -> Result<Vec<FreeRun>> {
    watched(observer, move |_| {
        let problem = problem_as_it_is(model, records, &options.motor)?;
        Ok(free_runs(&problem, &model.values()))
    })
}

/// Adds one effect to a model and says whether it is worth it.
///
/// # Errors
/// Records that no fit can use, an effect that the model cannot take, [`Error::Cancelled`](crate::Error::Cancelled).
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
    watched(observer, move |tell| {
        estimate::add(model, effect, records, &options.validation, &options.motor, &mut told(tell))
    })
}

/// Whether two sets of records come from one motor. Models with `effects` are fitted to either set and to both; without `effects`, those
/// that [`discover_records`](crate::discover_records) finds on the first set.
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
            None => search::discover(first, &[], motor, &options.asked(), &mut told(tell))?.effects,
        };
        crate::same::same(first, second, motor, &kinds, &|share| tell(Event::Running { share }))
    })
}
