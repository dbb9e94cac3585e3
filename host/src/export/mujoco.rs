//! MJCF: a hinge whose armature, damping and friction loss are the motor's, driven in volts.

use motorlens_shared::effects::Kind;

use super::{Exported, Options, effects, not_expressed};
use crate::model_file::Model;

/// The actuator's gear turns volts into torque; back-EMF and viscous friction are the joint's damping.
pub(super) fn export(model: &Model, options: &Options) -> Exported {
    let b = &model.base;
    let scale = options.torque_per_volt;
    let (mut friction, mut stiffness, mut reference, mut load) = (0.0, 0.0, 0.0, 0.0);
    let mut weight: Option<(f64, f64)> = None;
    let mut left_out = vec![
        "The winding is a first-order filter of the command: MuJoCo has no current that the speed acts on."
            .to_owned(),
    ];
    if scale == 1.0 {
        left_out.push(
            "The torque scale is unknown from voltage and motion, so torques are in volts; give --torque-per-volt for N m."
                .to_owned(),
        );
    }
    for (kind, p) in effects(model) {
        match kind {
            Kind::Coulomb => friction += p[0],
            Kind::CoulombAsymmetric | Kind::Stribeck => {
                friction += p[0];
                left_out.push(format!("Of {kind} only the mean level is kept: frictionloss is one number."));
            }
            Kind::Spring if p[0] > 0.0 => {
                stiffness += p[0];
                reference -= p[1] / p[0];
            }
            Kind::ConstantLoad => load += p[0],
            Kind::Gravity => weight = Some((p[0], p[1])),
            _ => left_out.push(not_expressed(kind, "a MuJoCo joint")),
        }
    }
    let (bob, inertia) = weight.map_or((String::new(), 0.0), |w| bob(w, scale));
    // Two hyphens would end an XML comment.
    let comment: String = left_out.iter().map(|s| format!("\n       {}", s.replace("--", ""))).collect();
    let text = format!(
        r#"<mujoco model="motorlens">
  <!-- Written by motorlens. Control: volts at the driver's output; joint: the output shaft.{comment} -->
  <compiler angle="radian"/>
  <option timestep="0.001" gravity="0 -9.81 0" integrator="implicitfast"/>
  <worldbody>
    <body name="shaft">
      <joint name="output" type="hinge" axis="0 0 1" armature="{armature:e}" damping="{damping:e}"
             frictionloss="{friction:e}" stiffness="{stiffness:e}" springref="{reference:e}"/>
      <geom type="cylinder" size="0.005 0.01" mass="1e-9"/>{bob}
    </body>
  </worldbody>
  <actuator>
    <general name="motor" joint="output" gear="{scale:e}" dyntype="filterexact" dynprm="{tau_e:e}"
             gainprm="1" biastype="affine" biasprm="{bias:e} 0 0" ctrllimited="true" ctrlrange="-{supply:e} {supply:e}"/>
  </actuator>
</mujoco>
"#,
        armature = scale * b.tau_m / b.gain - inertia,
        bias = -load,
        damping = scale / b.gain,
        friction = scale * friction,
        stiffness = scale * stiffness,
        tau_e = b.tau_e,
        supply = model.rig.supply_v,
    );
    Exported { text, left_out }
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
