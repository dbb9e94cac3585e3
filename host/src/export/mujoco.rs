//! MJCF for MuJoCo 4: a hinge with MuJoCo's own `dcmotor`, and beside it a Python program with the laws that MJCF lacks.
//!
//! `dcmotor` is the base model: resistance, motor constant and electrical time constant, so that the speed acts on the current.
//! Dry friction is the joint's, a weight a body's, a spring the joint's; cogging, heating and delay are the actuator's. Every
//! other effect that acts on voltage, torque or reading is in the program. Two masses with a gap or a spring between them are one
//! joint here: those effects are lost.

use motorlens_shared::effects::{Kind, Port};

use super::hook::{Beside, program};
use super::{Exported, Lost, Options, effects};
use crate::model_file::Model;

/// Step of the simulation where none is asked for, s.
pub(super) const STEP_S: f64 = 2.5e-4;
/// Temperature coefficient of copper's resistance, 1/K: heating is a share of resistance, and any number gives the same share.
const COPPER: f64 = 0.0039;
const AMBIENT_C: f64 = 20.0;

/// What the MJCF is made of.
#[derive(Default)]
struct Parts {
    /// N m.
    friction: f64,
    /// N m/rad, and rad.
    stiffness: f64,
    reference: f64,
    /// N m, against forward motion.
    load: f64,
    weight: Option<(f64, f64)>,
    /// Attributes of the actuator.
    motor: String,
    /// More actuators.
    beside: String,
}

/// Writes both files.
pub(super) fn export(model: &Model, options: &Options) -> Exported {
    let b = &model.base;
    let step_s = options.step_s.unwrap_or(STEP_S);
    let scale = options.torque_per_volt.unwrap_or(1.0);
    // V s/rad is N m/A, so that the resistance follows from the stall torque per volt.
    let constant = b.base().back_emf();
    let resistance = constant / scale;

    let all = effects(model);
    let (lost, kept): (Vec<_>, Vec<_>) = all.into_iter().partition(|(kind, _)| kind.is_transmission());
    let mut own: Vec<(Kind, Vec<f64>)> = kept.iter().filter(|(kind, _)| !native(*kind)).cloned().collect();
    // What acts on a late voltage must be late too.
    let late = own.iter().any(|(kind, _)| kind.spec().port == Port::Voltage);
    own = kept.iter().filter(|(kind, _)| !native(*kind) || late && *kind == Kind::Delay).cloned().collect();

    let mut parts = Parts::default();
    for (kind, p) in kept.iter().filter(|(kind, _)| !own.iter().any(|(other, _)| other == kind)) {
        add(&mut parts, *kind, p, &Setting { scale, step_s, resistance, model });
    }
    let mut notes = Vec::new();
    if options.torque_per_volt.is_none() {
        notes.push(
            "The torque scale is unknown from voltage and motion, so torques are in volts; give --torque-per-volt for N m."
                .to_owned(),
        );
    }
    if !own.is_empty() {
        let names: Vec<&str> = own.iter().map(|(kind, _)| kind.name()).collect();
        notes.push(format!(
            "MJCF has no place for {}: the Python file beside it applies them.",
            names.join(", ")
        ));
    }
    let lost: Vec<Lost> = lost
        .iter()
        .map(|(kind, _)| Lost::new(*kind, "rotor and load are one joint, and nothing lies between them"))
        .collect();
    let text = mjcf(model, &parts, &Scales { scale, step_s, constant, resistance }, &notes);
    let beside = (!own.is_empty()).then(|| {
        let beside = Beside { torque_per_volt: scale, resistance, friction: parts.friction, step_s };
        ("py", program(model, &own, &beside))
    });
    let carried = lost.iter().fold(model.values(), |values, lost| values.without(lost.effect));
    Exported { content: text.into_bytes(), beside, notes, lost, carried }
}

/// Effects that MJCF expresses itself.
fn native(kind: Kind) -> bool {
    use Kind::{Cogging, ConstantLoad, Coulomb, CoulombAsymmetric, Delay, Gravity, Spring, WindingHeating};
    matches!(
        kind,
        Coulomb | CoulombAsymmetric | ConstantLoad | Gravity | Spring | Cogging | WindingHeating | Delay
    )
}

struct Setting<'a> {
    scale: f64,
    step_s: f64,
    resistance: f64,
    model: &'a Model,
}

fn add(parts: &mut Parts, kind: Kind, p: &[f64], setting: &Setting) {
    let scale = setting.scale;
    match kind {
        Kind::Coulomb => parts.friction += scale * p[0],
        Kind::CoulombAsymmetric => {
            // A level that differs by direction is a level and a constant torque, at rest too.
            parts.friction += scale * p[0];
            parts.load += scale * p[1];
        }
        Kind::Spring if p[0] > 0.0 => {
            parts.stiffness = scale * p[0];
            parts.reference = -p[1] / p[0];
        }
        Kind::Spring => parts.load += scale * p[1],
        Kind::ConstantLoad => parts.load += scale * p[0],
        Kind::Gravity => parts.weight = Some((p[0], p[1])),
        Kind::Cogging => {
            let periods = p[4] * setting.model.rig.gear_ratio;
            parts.motor += &ripple((scale * p[0], scale * p[1]), periods);
            if (p[2], p[3]) != (0.0, 0.0) {
                // An actuator has one ripple; one without a motor constant has nothing else.
                parts.beside += &format!(
                    "\n    <dcmotor name=\"second_harmonic\" joint=\"output\" input=\"none\" motorconst=\"0 0\" resistance=\"1\"{}/>",
                    ripple((scale * p[2], scale * p[3]), 2.0 * periods)
                );
            }
        }
        Kind::WindingHeating if p[0] > 0.0 => {
            let nominal = setting.model.rig.nominal_v;
            let capacity = COPPER * nominal * nominal / (p[0] * setting.resistance);
            parts.motor += &format!(
                " thermal=\"{:e} {capacity:e} 0 {COPPER} {AMBIENT_C} {AMBIENT_C}\"",
                p[1] / capacity
            );
        }
        Kind::Delay if p[0] > 0.0 => {
            let samples = (p[0] / setting.step_s).ceil() as usize + 2;
            parts.motor += &format!(" delay=\"{:e}\" nsample=\"{samples}\"", p[0]);
        }
        _ => {}
    }
}

/// -(sine sin a + cosine cos a) as MuJoCo writes it: amplitude sin(a + phase).
fn ripple((sine, cosine): (f64, f64), periods: f64) -> String {
    format!(" cogging=\"{:e} {periods:e} {:e}\"", sine.hypot(cosine), (-cosine).atan2(-sine))
}

struct Scales {
    scale: f64,
    step_s: f64,
    constant: f64,
    resistance: f64,
}

fn mjcf(model: &Model, parts: &Parts, scales: &Scales, notes: &[String]) -> String {
    let b = &model.base;
    let Scales { scale, step_s, constant, resistance } = scales;
    let (bob, inertia) = parts.weight.map_or((String::new(), 0.0), |w| bob(w, *scale));
    let load = if parts.load == 0.0 {
        String::new()
    } else {
        format!(
            "\n    <general name=\"load\" joint=\"output\" gainprm=\"0\" biastype=\"affine\" biasprm=\"{:e} 0 0\"/>",
            -parts.load
        )
    };
    // Two hyphens would end an XML comment.
    let comment: String = notes.iter().map(|s| format!("\n       {}", s.replace("--", ""))).collect();
    format!(
        r#"<mujoco model="motorlens">
  <!-- Written by motorlens for MuJoCo 4. Control: volts at the driver's output; joint: the output shaft.{comment} -->
  <compiler angle="radian"/>
  <option timestep="{step_s:e}" gravity="0 -9.81 0" integrator="implicitfast"/>
  <worldbody>
    <body name="shaft">
      <joint name="output" type="hinge" axis="0 0 1" armature="{armature:e}" damping="{damping:e}"
             frictionloss="{friction:e}" solreffriction="{hard:e} 1" solimpfriction="0.9999 0.9999 0.001 0.5 2"
             stiffness="{stiffness:e}" springref="{reference:e}"/>
      <geom type="cylinder" size="0.005 0.01" mass="1e-9"/>{bob}
    </body>
  </worldbody>
  <actuator>
    <dcmotor name="motor" joint="output" motorconst="{constant:e} {constant:e}" resistance="{resistance:e}"
             inductance="0 {tau_e:e}"{motor} ctrllimited="true" ctrlrange="-{supply:e} {supply:e}"/>{beside}{load}
  </actuator>
</mujoco>
"#,
        armature = scale * b.tau_m / b.gain - inertia,
        damping = scale * b.viscous_share / b.gain,
        // A joint without friction has no constraint for the program to set.
        friction = parts.friction.max(1e-9 * scale),
        hard = 2.0 * step_s,
        stiffness = parts.stiffness,
        reference = parts.reference,
        tau_e = b.tau_e,
        motor = parts.motor,
        supply = model.rig.supply_v,
        beside = parts.beside,
    )
}

/// Distance of the weight from the axis and its radius, m: so small that its inertia hardly counts.
const ARM_M: f64 = 1e-4;
const RADIUS_M: f64 = 1e-3;

/// A weight whose torque is -(sine sin x + cosine cos x), and its inertia.
///
/// A mass m at angle a0 + x from the direction of gravity pulls back with m g r sin(a0 + x).
fn bob((sine, cosine): (f64, f64), scale: f64) -> (String, f64) {
    let (size, start) = (sine.hypot(cosine) * scale, cosine.atan2(sine));
    let mass = size / (9.81 * ARM_M);
    let (x, y) = (ARM_M * start.sin(), -ARM_M * start.cos());
    let geom = format!(
        "\n      <geom type=\"sphere\" size=\"{RADIUS_M:e}\" pos=\"{x:e} {y:e} 0\" mass=\"{mass:e}\"/>"
    );
    (geom, mass * (ARM_M * ARM_M + 0.4 * RADIUS_M * RADIUS_M))
}
