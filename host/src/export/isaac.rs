//! An actuator configuration for Isaac Lab: `DCMotorCfg`, whose torque is clipped by the line from stall to no-load speed.
//!
//! `saturation_effort` is the stall torque at the nominal voltage and `velocity_limit` the speed at which back-EMF takes all of it:
//! the line is the motor's own torque, and the joint's viscous friction comes off it once more. Armature and friction are the motor's.
//! Isaac Lab's motor follows a torque, not a voltage: back-EMF is in the clip only. Source: Isaac Lab, isaaclab.actuators (2.3; 3.0
//! calls the limits `actuator_effort_limit` and `actuator_velocity_limit` and takes the names of 2.3 until 4.0).

use motorlens_shared::effects::Kind;

use super::actuator::{LOADS, OF_THE_ROBOT, leave, one_level, take};
use super::{Exported, Format, Options};
use crate::error::Result;
use crate::model_file::Model;

const TAKEN: [Kind; 6] =
    [Kind::Coulomb, Kind::Stribeck, Kind::Delay, Kind::ConstantLoad, Kind::Gravity, Kind::Spring];

/// A Python file with the configuration.
pub(super) fn export(model: &Model, options: &Options) -> Result<Exported> {
    let scale = options.torque(Format::Isaac)?;
    let (a, lost, carried) =
        take(model, &TAKEN, "Isaac Lab's DC motor has armature, friction and limits only");
    let b = &model.base;
    let volts = model.rig.nominal_v;
    let excess = a.stribeck.map_or(0.0, |[excess, ..]| excess);
    // What the clip makes of a torque is not what the motor makes of a voltage.
    let voltage = format!(
        "The motor follows a torque. For a voltage u command effort = saturation_effort * (u / {volts} - speed / velocity_limit)."
    );
    let mut left = leave(model, &LOADS, OF_THE_ROBOT);
    let mut notes = vec![voltage.clone()];
    if excess > 0.0 {
        notes.push(
            "The break-away level falls at once when the joint moves, not over a range of speeds.".into(),
        );
    }
    let delay = if a.delay_s > 0.0 {
        let why = "is in a comment alone: DelayedPDActuatorCfg takes it in steps of the simulation";
        left.extend(leave(model, &[Kind::Delay], why));
        format!(
            "# The command acts {:.4} s late: that many seconds / sim.dt are min_delay and max_delay.\n",
            a.delay_s
        )
    } else {
        String::new()
    };
    let text = format!(
        "\
# Written by motorlens for Isaac Lab 2.3; 3.0 takes it too, and warns that its limits have new names. Torques in N m, speeds in rad/s, of the output shaft at {volts} V.
from isaaclab.actuators import DCMotorCfg

# {voltage}
{delay}MOTOR = DCMotorCfg(
    joint_names_expr=[{name:?}],
    saturation_effort={stall:.9},
    effort_limit={stall:.9},
    velocity_limit={no_load:.9},
    stiffness={stiffness:.9},  # critically damped with the armature at a tenth of the stall torque per radian
    damping={damping:.9},
    armature={armature:.9e},
    friction={break_away:.9},
    dynamic_friction={friction:.9},
    viscous_friction={viscous:.9e},
)
",
        name = options.name.as_deref().unwrap_or("output"),
        stall = scale * volts,
        no_load = volts / b.base().back_emf(),
        stiffness = 0.1 * scale * volts,
        damping = 2.0 * (0.1 * scale * volts * scale * b.tau_m / b.gain).sqrt(),
        armature = scale * b.tau_m / b.gain,
        break_away = scale * (a.friction + excess),
        friction = scale * a.friction,
        viscous = scale * b.viscous_share / b.gain,
    );
    let carried = one_level(carried, a.friction, &[]);
    Ok(Exported::numbers(text, carried, notes, lost, left))
}
