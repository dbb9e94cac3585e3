//! A Modelica model: the equations of the base model, effects as terms, friction smoothed.

use motorlens_shared::effects::Kind;

use super::{Exported, effects, not_expressed};
use crate::model_file::Model;

/// Below this share of the top speed friction fades out, so that solvers need no events.
const SMOOTH: f64 = 1e-3;

/// One model, no libraries.
pub(super) fn export(model: &Model) -> Exported {
    let b = &model.base;
    let r = &model.rig;
    let (mut torque, mut friction, mut voltage, mut resistance) =
        (String::new(), String::new(), "v".to_owned(), String::new());
    let mut left_out = vec![format!(
        "Friction is smoothed below {:.2e} rad/s, so a motor held by it creeps.",
        SMOOTH * r.reference_speed_rad_s
    )];
    for (kind, p) in effects(model) {
        match kind {
            Kind::Coulomb => friction += &format!(" + {:e}", p[0]),
            Kind::CoulombAsymmetric => friction += &format!(" + {:e} + ({:e})*tanh(w/w0)", p[0], p[1]),
            Kind::Stribeck => {
                friction +=
                    &format!(" + {:e} + {:e}/(1 + (w/{:e})^2 + 0.5*(w/{:e})^4)", p[0], p[1], p[2], p[2]);
            }
            Kind::LoadFriction => friction += &format!(" + {:e}*u*u/(abs(u) + {:e})", p[0], p[1]),
            Kind::QuadraticDrag => torque += &format!(" - {:e}*w*abs(w)", p[0]),
            Kind::ConstantLoad => torque += &format!(" - ({:e})", p[0]),
            Kind::Gravity => torque += &format!(" - (({:e})*sin(angle) + ({:e})*cos(angle))", p[0], p[1]),
            Kind::Cogging => {
                let k = p[2] * r.gear_ratio;
                torque += &format!(" - (({:e})*sin({k:e}*angle) + ({:e})*cos({k:e}*angle))", p[0], p[1]);
            }
            Kind::Spring => torque += &format!(" - ({:e}*angle + ({:e}))", p[0], p[1]),
            Kind::DeadZone => {
                let (up, down) = ((p[0] + p[1]).max(0.0), (p[0] - p[1]).max(0.0));
                voltage = format!("({voltage} - max(-{down:e}, min({up:e}, {voltage})))");
            }
            Kind::SupplySag => resistance += &format!(" + {:e}*(v/{:e})^2", p[0], r.supply_v),
            Kind::VoltageDrop => {
                let square = p[1] * p[1];
                voltage +=
                    &format!(" - {:e}*u*(abs(u) + {k:e})/(u*u + {k:e}*abs(u) + {square:e})", p[0], k = p[1]);
            }
            _ => left_out.push(not_expressed(kind, "this Modelica model")),
        }
    }
    let comment: String = left_out.iter().map(|s| format!("\n// {s}")).collect();
    let text = format!(
        r#"// Written by motorlens.{comment}
model Motor "geared DC motor; current and torques as voltages"
  input Real v(unit="V") "voltage at the driver's output";
  output Real angle(unit="rad", start=0, fixed=true) "of the output shaft";
  Real w(unit="rad/s", start=0, fixed=true) "speed of the output shaft";
  Real u(unit="V", start=0, fixed=true) "current times winding resistance";
  Real torque(unit="V") "without friction";
  Real friction(unit="V") "largest that there can be";
  parameter Real gain(unit="rad/(s.V)") = {gain:e} "no-load speed per volt";
  parameter Real tau_m(unit="s") = {tau_m:e} "mechanical time constant";
  parameter Real tau_e(unit="s") = {tau_e:e} "electrical time constant";
  parameter Real viscous_share(unit="1") = {share:e} "of the mechanical damping";
  parameter Real w0(unit="rad/s") = {w0:e} "friction is smooth below";
equation
  tau_e*der(u) = {voltage} - (1 - viscous_share)/gain*w - (1{resistance})*u;
  torque = 0{torque};
  friction = 0{friction};
  der(w) = gain/tau_m*(u + torque - friction*tanh(w/w0)) - viscous_share/tau_m*w;
  der(angle) = w;
end Motor;
"#,
        gain = b.gain,
        tau_m = b.tau_m,
        tau_e = b.tau_e,
        share = b.viscous_share,
        w0 = SMOOTH * r.reference_speed_rad_s,
    );
    Exported { text, left_out }
}
