//! A parameter file of Rhoban's BAM ("Better Actuator Models"), m1 to m6.
//!
//! m1 has dry and viscous friction, m2 a break-away level beside it, m5 friction in proportion to the motor's torque, m6 that with
//! squares. m3 and m4 let friction grow with the difference of motor and load, which no effect here does; they are written where
//! they are asked for, with a share of nothing. Names and equations: bam/model.py of Rhoban/bam; its Stribeck curve is
//! exp(-(|w| / dtheta_stribeck)^alpha), so that `alpha` is 2 for a bell and 1 for an exponential.

use motorlens_shared::effects::Kind;
use serde_json::{Map, Value, json};

use super::actuator::{self, take};
use super::{Exported, Format, Options};
use crate::error::{Error, Result};
use crate::model_file::Model;

const TAKEN: [Kind; 5] =
    [Kind::Coulomb, Kind::CoulombAsymmetric, Kind::Stribeck, Kind::LoadFriction, Kind::Delay];

/// Knee of friction by load that is none, V.
const NO_KNEE_V: f64 = 1e-3;

/// The parameter file.
pub(super) fn export(model: &Model, options: &Options) -> Result<Exported> {
    let scale = options.torque(Format::Bam)?;
    let (a, mut lost, mut carried) =
        take(model, &TAKEN, "BAM models friction and a delay only; a load is its simulator's");
    if a.load != 0.0 {
        let why = "BAM's friction is the same in both directions";
        lost.push(super::Lost::new(Kind::CoulombAsymmetric, why).but_for_its_level());
        carried = actuator::one_level(carried, a.friction, &[]);
    }
    // BAM's friction by load begins with the load; this model's may begin above a knee, and what that costs is told.
    let knees = carried.effects.iter_mut().filter(|(kind, _)| *kind == Kind::LoadFriction);
    for (_, parameters) in knees {
        parameters[1] = parameters[1].min(NO_KNEE_V);
    }
    let smallest = match (a.stribeck.is_some(), a.load_share.is_some()) {
        (_, true) => 5,
        (true, false) => 2,
        (false, false) => 1,
    };
    let number = options.bam_model.unwrap_or(smallest);
    let holds = |needs: &[u8]| needs.contains(&number);
    if a.stribeck.is_some() && !holds(&[2, 4, 5, 6]) || a.load_share.is_some() && !holds(&[5, 6]) {
        let why = format!("BAM's m{number} cannot hold the effects of this model");
        return Err(Error::usage(
            why,
            format!("leave out --bam-model: m{smallest} is the smallest that can"),
        ));
    }
    let constant = model.base.base().back_emf();
    let mut file = Map::new();
    let mut put = |name: &str, value: Value| drop(file.insert(name.to_owned(), value));
    put("kt", json!(constant));
    put("R", json!(constant / scale));
    put("armature", json!(scale * model.base.tau_m / model.base.gain));
    put("q_offset", json!(0.0));
    put("command_delay", json!(a.delay_s));
    put("friction_base", json!(scale * a.friction));
    put("friction_viscous", json!(scale * model.base.viscous_share / model.base.gain));
    let [excess, speed, tail] = a.stribeck.unwrap_or([0.0, 1.0, 0.0]);
    if holds(&[2, 4, 5, 6]) {
        put("friction_stribeck", json!(scale * excess));
        put("dtheta_stribeck", json!(speed));
        put("alpha", json!(2.0 - tail));
    }
    let share = a.load_share.unwrap_or(0.0);
    match number {
        3 | 4 => put("load_friction_base", json!(0.0)),
        5 | 6 => {
            put("load_friction_motor", json!(share));
            put("load_friction_external", json!(0.0));
            put("load_friction_motor_stribeck", json!(0.0));
            put("load_friction_external_stribeck", json!(0.0));
        }
        _ => {}
    }
    if number == 4 {
        put("load_friction_stribeck", json!(0.0));
    }
    if number == 6 {
        put("load_friction_motor_quad", json!(0.0));
        put("load_friction_external_quad", json!(0.0));
    }
    put("model", json!(format!("m{number}")));
    put("actuator", json!(options.name.as_deref().unwrap_or("motor")));
    let mut notes = vec![
        "BAM drives the servo by its own position loop: its actuator class must know this one's.".to_owned(),
    ];
    if options.name.is_none() {
        notes.push("\"actuator\" is the name of BAM's actuator class; give it by --name.".into());
    }
    let why = "is in \"command_delay\", on which BAM 1.0 does not act: shift the commands of a rollout by it";
    let left = actuator::leave(model, &[Kind::Delay], why);
    let content = serde_json::to_string_pretty(&file).unwrap_or_default() + "\n";
    Ok(Exported::numbers(content, carried, notes, lost, left))
}
