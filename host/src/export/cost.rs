//! What a target's lack costs: the model is simulated with and without, on records where there are any.
//!
//! A program of the model's own step (C, Python, Modelica, FMU) is simulated there as it runs: in its own steps, each under the mean of the
//! record's voltage, begun at the first angle and first speed of the model's own run. MuJoCo runs its MJCF there itself, where a Python has it.
//! What the simulators of robots make of the numbers that they get is not simulated here: the tests run those tools.

use std::path::Path;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::{Exported, Stepper, in_mujoco};
use crate::api::{Event, Observer, watched};
use crate::compare::free_run::{FreeRun, begun_runs, free_runs, pooled, runs_elsewhere, runs_in_steps};
use crate::compare::problem_as_it_is;
use crate::error::Result;
use crate::fit::grid::Grid;
use crate::fit::layout::Values;
use crate::log::Record;
use crate::model_file::Model;
use crate::motor_file::MotorFile;

/// How far two simulations part.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Apart {
    /// Root mean square over all samples, rad (rad/s where only speed is measured).
    pub rms: f64,
    /// Largest difference.
    pub worst: f64,
}

/// The cost of one effect that is lacking, or would be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Of {
    /// The effect that is lacking.
    pub effect: Kind,
    /// The model against itself without it, or with the level of its dry friction alone where the target keeps that.
    #[serde(flatten)]
    pub apart: Apart,
}

/// What a target costs.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Cost {
    /// On what it was simulated.
    pub on: String,
    /// rad or rad/s.
    pub unit: &'static str,
    /// The whole model against what the target has of it; where its tool did not run it, without what that tool's own steps cost.
    pub all: Apart,
    /// Each effect by itself.
    pub each: Vec<Of>,
    /// rms errors against the measurement: of the model, and of what the target has; none without records.
    pub errors: Option<[f64; 2]>,
    /// Step in which the target was run on the records, s; none where it was not, and stands as what it has of the model.
    pub step_s: Option<f64>,
    /// Shortest step in which the model itself runs through the records, s; none without records, and of a target whose steps are others.
    pub own_step_s: Option<f64>,
    /// The tool that ran the target; none where it is a program of the model's own step.
    pub tool: Option<&'static str>,
    /// Why its tool did not run it, a clause.
    pub not_run: Option<String>,
}

/// Share of the model's own error by which a target may be worse.
const AS_GOOD: f64 = 0.01;

impl Cost {
    /// What the target has of the model errs on these records by more than a hundredth above the whole model.
    pub fn is_too_high(&self) -> bool {
        self.errors.is_some_and(|[with, without]| without.is_nan() || without > (1.0 + AS_GOOD) * with)
    }

    /// The step, s to a microsecond, that would make the program as good as the model, where it has another one and is not.
    pub fn better_step_s(&self) -> Option<f64> {
        let (step_s, own_s) = (self.step_s?, self.own_step_s?);
        let is_another = (step_s / own_s - 1.0).abs() > 0.01;
        (is_another && self.is_too_high()).then(|| (own_s * 1e6).round() / 1e6)
    }

    /// The cost in a clause, such as "0.333 rad (rms, at most 0.91) on steps.csv".
    pub fn clause(&self) -> String {
        let Apart { rms, worst } = self.all;
        let errors = self.errors.map_or(String::new(), |[with, without]| {
            format!("; error against the measurement {without:.3e} {0} instead of {with:.3e} {0}", self.unit)
        });
        format!("{rms:.3e} {} (rms; at most {worst:.3e}) on {}{errors}", self.unit, self.on)
    }
}

/// What `exported` costs beside `model` on `records`, or on a standard programme where there are none. A target that is MuJoCo's is run there by
/// `python`, if one is given that has MuJoCo, else simulated as what it has of the model. That may take minutes: the observer is told how far it
/// is ([`Event::Running`]).
///
/// # Errors
/// Records that cannot be simulated; [`Error::Cancelled`](crate::Error::Cancelled) where the observer stopped it.
///
/// ```
/// use std::ops::ControlFlow;
/// use motorlens::export::cost::cost;
/// use motorlens::export::{Format, Options, export};
/// use motorlens::motor_file::MotorFile;
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
/// let model = motorlens::Model::read(path.as_ref())?;
/// let options = Options { torque_per_volt: Some(0.1), ..Options::default() };
/// let exported = export(&model, Format::Urdf, &options)?;
/// let price = cost(&model, &exported, &[], &MotorFile::default(), None, &mut |_| ControlFlow::Continue(()))?;
/// println!("without the winding's inductance: {}", price.clause());
/// assert!(price.all.rms > 0.0 && !price.is_too_high());
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn cost(
    model: &Model,
    exported: &Exported,
    records: &[Record],
    motor: &MotorFile,
    python: Option<&Path>,
    observer: Observer,
) -> Result<Cost> {
    watched(observer, move |tell| priced(model, exported, records, motor, python, tell))
}

fn priced(
    model: &Model,
    exported: &Exported,
    records: &[Record],
    motor: &MotorFile,
    python: Option<&Path>,
    tell: &dyn Fn(Event),
) -> Result<Cost> {
    if records.is_empty() {
        let (time, volts) = standard(model.rig.nominal_v);
        let run = |values: &Values| -> Result<Vec<f64>> {
            Model { base: values.base, ..as_model(model, values) }.simulate(&time, &volts, 0.0)
        };
        let whole = run(&model.values())?;
        let against = |values: &Values| -> Result<Apart> { Ok(apart(whole.iter().zip(&run(values)?))) };
        return Ok(Cost {
            on: "a standard programme of 8 s".into(),
            unit: "rad",
            all: against(&exported.carried)?,
            each: each(model, exported, &against)?,
            errors: None,
            step_s: None,
            own_step_s: None,
            tool: None,
            not_run: None,
        });
    }
    let problem = problem_as_it_is(model, records, motor)?;
    let (whole, begun): (Vec<FreeRun>, Vec<Grid>) = begun_runs(&problem, &model.values()).into_iter().unzip();
    let (mut tool, mut step_s, mut not_run) = (None, None, None);
    let there = match (exported.stepper, python) {
        (Stepper::Program(own_s), _) => {
            step_s = Some(own_s);
            runs_in_steps(&problem, &exported.carried, &begun, records, own_s)
        }
        (Stepper::Mujoco(own_s), Some(python)) => {
            let mut ended = 0.0;
            let run = |volts: &[f64], begin| {
                let share = |of_this: f64| (ended + of_this) / records.len() as f64;
                let tell = |of_this: f64| tell(Event::Running { share: share(of_this) });
                let shown = in_mujoco::run(model, exported, python, volts, begin, &tell);
                ended += 1.0;
                shown
            };
            match runs_elsewhere(&begun, records, own_s, run) {
                Ok(runs) => {
                    (tool, step_s) = (Some("MuJoCo"), Some(own_s));
                    runs
                }
                Err(why) => {
                    not_run = Some(why);
                    free_runs(&problem, &exported.carried)
                }
            }
        }
        _ => free_runs(&problem, &exported.carried),
    };
    let parted = |other: &[FreeRun]| -> Apart {
        apart(whole.iter().zip(other).flat_map(|(a, b)| a.simulated.iter().zip(&b.simulated)))
    };
    let against = |values: &Values| -> Result<Apart> { Ok(parted(&free_runs(&problem, values))) };
    let rmse = |runs: &[FreeRun]| pooled(runs).unwrap_or_default().rmse;
    let names: Vec<&str> = records.iter().map(|r| r.name.as_str()).collect();
    Ok(Cost {
        on: names.join(", "),
        unit: whole.first().map_or("rad", |run| run.quantity.unit()),
        all: parted(&there),
        each: each(model, exported, &against)?,
        errors: Some([rmse(&whole), rmse(&there)]),
        step_s,
        own_step_s: begun.iter().map(|grid| grid.step_s).reduce(f64::min).filter(|_| tool.is_none()),
        tool,
        not_run,
    })
}

fn each(model: &Model, exported: &Exported, against: &dyn Fn(&Values) -> Result<Apart>) -> Result<Vec<Of>> {
    let lost = exported.lost.iter().chain(&exported.left);
    lost.map(|lost| Ok(Of { effect: lost.effect, apart: against(&lost.of(&model.values()))? })).collect()
}

/// What longer steps than a millisecond cost, on the standard programme with a voltage held for each step.
pub fn of_steps(model: &Model, step_s: f64) -> Apart {
    let (_, volts) = standard(model.rig.nominal_v);
    let held: Vec<f64> =
        (0..).map_while(|k| volts.get((f64::from(k) * step_s * 1e3).round() as usize)).copied().collect();
    let run = |parts: u32| -> Vec<f64> {
        let mut motor = model.start(step_s / f64::from(parts), 0.0);
        held.iter().map(|v| (0..parts).fold(0.0, |_, _| motor.step(*v))).collect()
    };
    let short = run((step_s * 1e3).ceil().max(1.0) as u32);
    apart(short.iter().zip(&run(1)))
}

fn as_model(model: &Model, values: &Values) -> Model {
    Model::new(values, &model.rig(1e-3), &model.prior(), model.origin.clone())
}

fn apart<'a>(pairs: impl Iterator<Item = (&'a f64, &'a f64)>) -> Apart {
    let (mut sum, mut worst, mut count) = (0.0, 0.0_f64, 0_u32);
    for (a, b) in pairs {
        sum += (a - b) * (a - b);
        worst = worst.max((a - b).abs());
        count += 1;
    }
    Apart { rms: (sum / f64::from(count.max(1))).sqrt(), worst }
}

/// 8 s at a kilohertz within 0.9 of the nominal voltage: levels of half a second, then a slow sine that turns the motor round.
fn standard(nominal_v: f64) -> (Vec<f64>, Vec<f64>) {
    const LEVELS: [f64; 8] = [0.5, 0.0, -0.4, 0.2, 0.9, -0.7, 0.1, -0.1];
    let at = |k: u32| {
        let level = LEVELS[(k / 500) as usize % LEVELS.len()];
        let sine = 0.5 * (std::f64::consts::TAU * 0.5 * f64::from(k) * 1e-3).sin();
        nominal_v * if k < 4000 { level } else { sine }
    };
    (0..8000).map(|k| (f64::from(k) * 1e-3, at(k))).unzip()
}
