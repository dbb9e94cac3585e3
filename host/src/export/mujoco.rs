//! MJCF for MuJoCo 4: a hinge with MuJoCo's own `dcmotor`, and beside it a Python program with the equations that MJCF lacks.
//!
//! `dcmotor` is the base model: resistance, motor constant and electrical time constant, so that the speed acts on the current.
//! Dry friction is the joint's, a weight a body's, a spring the joint's; cogging, heating and delay are the actuator's. Its
//! `saturation` is no iron's: it clips torque, current and the current's rate, and K stays what it is. Rotor and
//! load with `compliance` between them are two bodies on one axis, tied by a tendon of its stiffness and damping. Every other
//! effect that acts on voltage, torque or reading is in the program, the gear contact of `backlash` between two bodies too: a
//! tendon with a dead band would be damped within it.

use motorlens_shared::effects::{Kind, Port};

use super::hook::{Beside, contact_grid, program};
use super::mjcf_parts::{Parts, Setting, add, bob, native};
use super::step::holding;
use super::two_bodies::{Between, OUTPUT, ROTOR};
use super::{Exported, Lost, Options, Stepper, effects, level, xml};
use crate::error::{Error, Result};
use crate::model_file::Model;
use crate::sentence::capital;

/// Step of the simulation where none is asked for, s: friction and loads then add less than a hundredth to a good model's error.
const STEP_S: f64 = 5e-5;

/// Writes both files.
///
/// # Errors
/// A step that is too long for what lies between rotor and load.
pub(super) fn export(model: &Model, options: &Options) -> Result<Exported> {
    let b = &model.base;
    let all = effects(model);
    let between = Between::of(&all);
    let step_s = step(between.as_ref(), options)?;
    let scale = options.torque_per_volt.unwrap_or(1.0);
    // V s/rad is N m/A, so that the resistance follows from the stall torque per volt.
    let constant = b.base().back_emf();
    let resistance = constant / scale;

    // A model has one transmission, the first: motorlens simulates no second one either.
    let first = between.as_ref().map(|between| between.kind);
    let kept: Vec<_> =
        all.into_iter().filter(|(kind, _)| !kind.is_transmission() || Some(*kind) == first).collect();
    let mut own: Vec<(Kind, Vec<f64>)> = kept.iter().filter(|(kind, _)| !native(*kind)).cloned().collect();
    // What acts on a late voltage must be late too.
    let late = own.iter().any(|(kind, _)| kind.spec().port == Port::Voltage);
    own = kept.iter().filter(|(kind, _)| !native(*kind) || late && *kind == Kind::Delay).cloned().collect();

    let output = options.name.as_deref().unwrap_or(OUTPUT);
    if between.is_some() && output == ROTOR {
        let why = format!("{ROTOR} is the name of the motor's own joint beside the load's");
        return Err(Error::usage(why, "give another --name"));
    }
    let driven = if between.is_some() { ROTOR } else { output };
    let mut parts = Parts::default();
    for (kind, p) in kept.iter().filter(|(kind, _)| !own.iter().any(|(other, _)| other == kind)) {
        add(&mut parts, *kind, p, &Setting { scale, step_s, resistance, driven, model });
    }
    let mut notes = Vec::new();
    if options.torque_per_volt.is_none() {
        notes.push(
            "The torque scale is unknown from voltage and motion, so torques are in volts; give --torque-per-volt for N m."
                .to_owned(),
        );
    }
    // Who has the MJCF alone is to have at least the level of a friction whose course it cannot express.
    parts.alone = scale * own.iter().filter_map(|(kind, p)| level(*kind, p)).sum::<f64>();
    let left: Vec<Lost> = own
        .iter()
        .map(|(kind, p)| {
            let stays = if level(*kind, p).is_some() {
                ", without which its level stays as dry friction"
            } else {
                ""
            };
            let why = format!("has no place in MJCF: the Python file beside it applies it{stays}");
            Lost::new(*kind, why).but_for_its_level()
        })
        .collect();
    // What a motor that begins in motion had before, for each rad/s.
    let holding = holding(&b.base(), &model.rig(step_s));
    let current_per_speed = holding - constant;
    let scales = Scales { output, driven, scale, step_s, constant, resistance, holding };
    if step_s > usual_step_s(model) {
        notes.push(format!("With steps of {step_s:e} s MuJoCo may err by more than a hundredth of a good model's error; leave out the step."));
    }
    // For whoever opens the file without having read what was said when it was written.
    let beside_it = left.iter().map(|left| format!("{} {}.", capital(left.effect.name()), left.why));
    let comment: Vec<String> = notes.iter().cloned().chain(beside_it).collect();
    let text = mjcf(model, &parts, &scales, between.as_ref(), &comment);
    let beside = (!own.is_empty()).then(|| {
        let friction = parts.friction;
        let contact_steps = contact_grid(&own).map_or(1, |grid_s| (grid_s / step_s).round() as u32);
        let names = [output, driven];
        let torque_per_volt = scale;
        let beside = Beside {
            torque_per_volt,
            resistance,
            friction,
            step_s,
            holding,
            current_per_speed,
            contact_steps,
            names,
        };
        ("py", program(model, &own, &beside))
    });
    Ok(Exported {
        content: text.into_bytes(),
        beside,
        notes,
        lost: Vec::new(),
        left,
        carried: model.values(),
        stepper: Stepper::Mujoco(step_s),
    })
}

/// Step of the simulation that a model has without being asked, unless that is unstable, s.
pub(super) fn usual_step_s(model: &Model) -> f64 {
    Between::of(&effects(model)).as_ref().and_then(Between::usual_step_s).unwrap_or(STEP_S)
}

/// Step of the simulation, s.
fn step(between: Option<&Between>, options: &Options) -> Result<f64> {
    let Some(between) = between else { return Ok(options.step_s.unwrap_or(STEP_S)) };
    let longest = between.longest_step_s();
    match options.step_s {
        None => Ok(between.usual_step_s().unwrap_or(STEP_S).min(longest)),
        Some(step_s) if step_s <= longest => Ok(step_s),
        Some(_) => Err(Error::usage(
            format!("{} is stable in MuJoCo with steps of {longest:.1e} s or shorter", between.kind),
            "give a shorter --step, or none",
        )),
    }
}

struct Scales<'a> {
    output: &'a str,
    driven: &'a str,
    scale: f64,
    step_s: f64,
    constant: f64,
    resistance: f64,
    /// Voltage that holds a speed, V s/rad.
    holding: f64,
}

fn mjcf(
    model: &Model,
    parts: &Parts,
    scales: &Scales,
    between: Option<&Between>,
    notes: &[String],
) -> String {
    let b = &model.base;
    let Scales { scale, step_s, constant, resistance, holding, .. } = scales;
    let (output, driven) = (&xml(scales.output), &xml(scales.driven));
    let (bob, weight) = parts.weight.map_or((String::new(), 0.0), |w| bob(w, *scale));
    let load = if parts.load == 0.0 {
        String::new()
    } else {
        format!(
            "\n    <general name=\"load\" joint=\"{output}\" gainprm=\"0\" biastype=\"affine\" biasprm=\"{:e} 0 0\"/>",
            -parts.load
        )
    };
    // Two hyphens would end an XML comment.
    let comment: String = notes.iter().map(|s| format!("\n       {}", s.replace("--", ""))).collect();
    let (inertia, viscous) = (scale * b.tau_m / b.gain, scale * b.viscous_share / b.gain);
    let dry = format!(
        r#"frictionloss="{friction:e}" solreffriction="{hard:e} 1" solimpfriction="0.9999 0.9999 0.001 0.5 2""#,
        // A joint without friction has no constraint for the program to set.
        friction = (parts.friction + parts.alone).max(1e-9 * scale),
        hard = 2.0 * step_s,
    );
    let spring = format!(r#"stiffness="{:e}" springref="{:e}""#, parts.stiffness, parts.reference);
    let body = |name: &str, joint: &str, [armature, damping]: [f64; 2], more: &str, inside: &str| {
        format!(
            r#"
    <body name="{name}">
      <joint name="{joint}" type="hinge" axis="0 0 1" armature="{armature:e}" damping="{damping:e}"
             {more}/>
      <geom type="cylinder" size="0.005 0.01" mass="1e-9" contype="0" conaffinity="0"/>{inside}
    </body>"#
        )
    };
    let (bodies, tendon) = match between {
        None => {
            let more = format!("{dry}\n             {spring}");
            (body("shaft", output, [inertia - weight, viscous], &more, &bob), String::new())
        }
        Some(between) => {
            let of_load = [inertia * between.share, viscous * between.damping];
            let rotor = [inertia - of_load[0], viscous - of_load[1]];
            let shaft = [of_load[0] - weight, of_load[1]];
            let bodies = body("rotor", ROTOR, rotor, &dry, "") + &body("shaft", output, shaft, &spring, &bob);
            (bodies, between.tendon(output, of_load[0]))
        }
    };
    format!(
        r#"<mujoco model="motorlens">
  <!-- Written by motorlens for MuJoCo 4. Control: volts at the driver's output; the joint of body "shaft": the output shaft;
       sensor "encoder": the joint that the encoder sits on.
       To begin in motion at w rad/s (first_speed_rad_s of motorlens compare): qvel of every joint is w, the motor's last act (its current)
       w holding_current, and the history of a delayed actuator w holding_voltage (mj_initCtrlHistory).{comment} -->
  <custom>
    <numeric name="holding_voltage" data="{holding:e}"/>
    <numeric name="holding_current" data="{holding_current:e}"/>
  </custom>
  <compiler angle="radian"/>
  <option timestep="{step_s:e}" gravity="0 -9.81 0" integrator="{integrator}"/>
  <worldbody>{bodies}
  </worldbody>{tendon}
  <actuator>
    <dcmotor name="motor" joint="{driven}" motorconst="{constant:e} {constant:e}" resistance="{resistance:e}"
             inductance="0 {tau_e:e}"{motor} ctrllimited="true" ctrlrange="-{supply:e} {supply:e}"/>{beside}{load}
  </actuator>
  <sensor>
    <jointpos name="encoder" joint="{encoder}"/>
  </sensor>
</mujoco>
"#,
        // Bodies on joints of their own share no implicit damping: the tendon's would hold their common motion back too.
        integrator = if tendon.is_empty() { "implicitfast" } else { "Euler" },
        encoder = if model.rig.encoder_on_motor { driven } else { output },
        holding_current = (holding - constant) / resistance,
        tau_e = b.tau_e,
        motor = parts.motor,
        supply = model.rig.supply_v,
        beside = parts.beside,
    )
}
