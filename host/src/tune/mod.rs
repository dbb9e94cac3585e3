//! Gains for a motor's velocity and position loops, from its model, and what its effects cost in tracking.
//!
//! The loops are designed on the base model with all that delays them: half a period of the controller, the delay and the sensor's lag of
//! the effects; with compliance or backlash on its two masses. Then the whole model, effects and encoder included, follows a profile under
//! those gains, with one compensation after the other added, and answers steps, after which it may not come to rest. A torque that depends
//! on the angle is compensated by the effect's own equation, at the angle that is wanted and at the one that is measured: whichever tracks
//! better stays for what is added next.

mod limit_cycle;
mod load;
mod loops;
mod plot;
mod profile;
mod step;
mod trial;

use motorlens_shared::effects::Kind;
use serde::Serialize;

pub use limit_cycle::LimitCycle;
pub use load::Load;
pub use loops::{Loop, Margins};
pub use plot::plot;
pub use step::Step;
pub use trial::{Course, Tracking, Trial};

use crate::error::{Error, Result};
use crate::model_file::Model;

/// Share of the voltage by which a count of the encoder may move the command.
const COARSE: f64 = 0.1;

/// What is asked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// Period of the controller, s.
    pub period_s: f64,
    /// Phase margin of the design, degrees.
    pub phase_margin_deg: f64,
    /// Largest voltage of the controller, V; the supply where absent.
    pub limit_v: Option<f64>,
}

impl Default for Options {
    fn default() -> Self {
        Self { period_s: 5e-3, phase_margin_deg: 60.0, limit_v: None }
    }
}

/// Feedforward: volts = kS sign(w) + kV w + kA a + kG.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Feedforward {
    /// Static friction, V.
    pub ks_v: f64,
    /// V s/rad.
    pub kv_v_s_per_rad: f64,
    /// V s^2/rad.
    pub ka_v_s2_per_rad: f64,
    /// Constant load, V.
    pub kg_v: f64,
    /// Command that the driver swallows, V: added in the direction of the command.
    pub dead_zone_v: f64,
}

/// Gains, margins, and how they track.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Tuned {
    /// PI of the velocity: u = kp e + ki (integral of e).
    pub velocity: Loop,
    /// PD of the position: u = kp e + kd (de/dt).
    pub position: Loop,
    /// What is commanded beside them.
    pub feedforward: Feedforward,
    /// Effects whose torque depends on the angle: what is commanded against them.
    pub loads: Vec<Load>,
    /// Everything that delays the loops, s.
    pub delay_s: f64,
    /// The profile followed with one compensation after the other.
    pub trials: Vec<Trial>,
    /// Steps of the position and of the velocity: on the base model, with all effects, and with all compensations.
    pub steps: Vec<Step>,
    /// Which compensation pays, a sentence each.
    pub advice: Vec<String>,
}

/// Designs the loops of `model` and tries them.
///
/// # Errors
/// A period, a margin or a limit that no loop can hold, a margin that no gain of this model holds.
///
/// ```
/// # let path = concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json");
/// let model = motorlens::Model::read(path.as_ref())?;
/// let tuned = motorlens::tune::tune(&model, &motorlens::tune::Options::default())?;
/// println!("kp = {} V/rad, kd = {} V s/rad", tuned.position.kp, tuned.position.kd);
/// assert!(tuned.position.kp > 0.0);
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn tune(model: &Model, options: &Options) -> Result<Tuned> {
    if !(options.period_s > 0.0 && options.period_s <= 0.1) {
        let why = format!("a controller with a period of {} s", options.period_s);
        return Err(Error::usage(why, "give a period of more than 0 and at most 0.1 s"));
    }
    if !(20.0..=80.0).contains(&options.phase_margin_deg) {
        let why = format!("a phase margin of {} degrees", options.phase_margin_deg);
        return Err(Error::usage(why, "give 20 to 80 degrees"));
    }
    if let Some(limit) = options.limit_v.filter(|limit| !(limit.is_finite() && *limit > 0.0)) {
        return Err(Error::usage(format!("a controller limited to {limit} V"), "give a positive voltage"));
    }
    let delay_s = 0.5 * options.period_s + lag_s(model);
    let margin = options.phase_margin_deg.to_radians();
    let plant = loops::Plant::of(model, delay_s);
    let none = |of: &str| {
        Error::usage(
            format!("no gain of the {of} loop holds a phase margin of {} degrees", options.phase_margin_deg),
            "ask for a smaller margin, down to 20 degrees; or check the damping in the model: a shaft with next to none rings under every gain",
        )
    };
    let velocity = loops::velocity(&plant, margin).ok_or_else(|| none("velocity"))?;
    let position = loops::position(&plant, margin).ok_or_else(|| none("position"))?;
    let feedforward = feedforward(model);
    let loads = load::Loads::of(model);
    let (trials, steps) = trial::all(model, options, &[velocity, position], &feedforward, &loads);
    let mut advice = trial::advice(&trials);
    advice.extend(limit_cycle::advice(&steps));
    advice.extend(plant.told().map(str::to_owned));
    let count_v = position.kp * model.rig.count_rad + position.kd * model.rig.count_rad / options.period_s;
    let limit_v = options.limit_v.unwrap_or(model.rig.supply_v);
    if count_v > COARSE * limit_v {
        advice.push(format!(
            "A count of the encoder moves the position's command by {count_v:.2} V of {limit_v:.1} V: a longer period or a larger \
             phase margin makes it gentler."
        ));
    }
    Ok(Tuned { velocity, position, feedforward, loads: loads.told, delay_s, trials, steps, advice })
}

/// Value of a parameter of an effect; 0 where the model has none.
fn parameter(model: &Model, kind: Kind, place: usize) -> f64 {
    model.effects.iter().find(|e| e.effect == kind).map_or(0.0, |e| e.parameters[place].value)
}

/// How late the effects make voltage and reading, s.
fn lag_s(model: &Model) -> f64 {
    // A filter lags by its time constant, a held reading by half of its holding.
    parameter(model, Kind::Delay, 0)
        + parameter(model, Kind::SensorLag, 0)
        + 0.5 * parameter(model, Kind::SensorLag, 1)
}

fn feedforward(model: &Model) -> Feedforward {
    let of = |kind| parameter(model, kind, 0);
    Feedforward {
        ks_v: of(Kind::Coulomb) + of(Kind::CoulombAsymmetric) + of(Kind::Stribeck) + of(Kind::VoltageDrop),
        kv_v_s_per_rad: 1.0 / model.base.gain,
        ka_v_s2_per_rad: model.base.tau_m / model.base.gain,
        kg_v: of(Kind::ConstantLoad) + parameter(model, Kind::CoulombAsymmetric, 1),
        dead_zone_v: of(Kind::DeadZone),
    }
}
