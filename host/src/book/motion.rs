//! A motor with one effect and without it, over a standard programme.

use motorlens_shared::effects::{Kind, Rig};
use motorlens_shared::excitation::{Player, Programme, Segment, Shape};

use crate::compare::free_run::{FreeRun, free_runs};
use crate::error::{Error, Result};
use crate::fit::grid::Grid;
use crate::fit::layout::{BaseValues, Prior, Values};
use crate::fit::setup;
use crate::log::Record;
use crate::model_file::{Model, Origin};
use crate::motor_file::MotorFile;

/// Samples a second.
const RATE_HZ: u32 = 1000;
/// A small geared motor: 1 rad/s per volt, 60 ms.
const BASE: BaseValues = BaseValues { gain: 1.0, tau_m: 0.06, tau_e: 8e-4, viscous_share: 0.1 };
/// Gear 30, an encoder of 64 counts on the motor, 12 V.
const RIG: Rig = Rig {
    step_s: 1e-3,
    gear_ratio: 30.0,
    encoder_on_motor: true,
    nominal_v: 12.0,
    supply_v: 12.0,
    reference_speed: 12.0,
    count_rad: std::f64::consts::TAU / (30.0 * 64.0),
};

/// The size of `kind` that the book shows, in the order and the units of its parameters: one that the diagnosis tries.
pub fn shown_size(kind: Kind) -> Vec<f64> {
    let spec = kind.spec();
    let tried = spec.probes[spec.probes.len() * 2 / 3];
    tried.iter().zip(spec.parameters).map(|(x, p)| p.plain(*x, &RIG)).collect()
}

/// What the effect does.
pub struct Motion {
    /// The model with it.
    pub values: Values,
    /// The rig.
    pub rig: Rig,
    /// The record against the model with the effect.
    pub with: Vec<FreeRun>,
    /// The same record against the model without it.
    pub without: Vec<FreeRun>,
}

/// Plays the standard programme on a motor with `kind`, read by an encoder.
pub fn motion(kind: Kind) -> Result<Motion> {
    let plain = Values { base: BASE, effects: Vec::new() };
    let values = plain.with(kind, shown_size(kind));
    let prior = Prior { tau_e: (BASE.tau_e, 0.4), viscous_share: (BASE.viscous_share, 0.05) };
    let voltage_v = volts()?;
    let time_s: Vec<f64> = (0..voltage_v.len()).map(|k| k as f64 / f64::from(RATE_HZ)).collect();
    let angle = Model::new(&values, &RIG, &prior, Origin::default()).simulate(&time_s, &voltage_v, 0.0)?;
    let counted = angle.iter().map(|x| (x / RIG.count_rad).round() * RIG.count_rad).collect();
    let record = Record {
        name: "standard programme".into(),
        time_s,
        voltage_v,
        angle_rad: Some(counted),
        ..Record::default()
    };
    let grid = Grid::new(&record, RIG.count_rad);
    let (problem, _) = setup::problem(&[record], &MotorFile::default());
    let mut problem = problem.on(vec![grid]);
    (problem.rig, problem.hold_s) = (RIG, None);
    let (with, without) = (free_runs(&problem, &values), free_runs(&problem, &plain));
    Ok(Motion { values, rig: RIG, with, without })
}

/// Slow ramps, random levels, random reversals.
fn volts() -> Result<Vec<f64>> {
    let segment = |shape, seconds| Segment { shape, seconds };
    let programme = Programme::sequence(
        "standard",
        [
            segment(Shape::Triangle { amplitude_v: 6.0, period_s: 4.0 }, 4.0),
            segment(Shape::Staircase { amplitude_v: 11.0, hold_s: 0.5, seed: 3 }, 4.0),
            segment(Shape::Prbs { amplitude_v: 8.0, chip_s: 0.12, seed: 5 }, 2.0),
        ],
    );
    let player = programme.and_then(|programme| Player::new(&programme, RATE_HZ));
    let player = player.map_err(|error| {
        Error::usage(format!("the standard programme: {error}"), "this is a fault of motorlens")
    })?;
    Ok(player.map(f64::from).collect())
}
