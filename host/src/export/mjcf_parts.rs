//! Parts of an MJCF: what each effect that MuJoCo has itself is made of.
//!
//! `lugre` of a `dcmotor` is a bristle of stiffness s0 and damping s1: z' = w - s0 |w| z / g(w), torque -(s0 z + s1 z'), with
//! g(w) = F_C + (F_S - F_C) exp(-(w / v_S)^2). In steady sliding that is `stribeck` with its excess falling like a bell (tail 0), and no
//! other tail. It is not used: before it slides the bristle yields by g / s0, which dry friction does not, and on the log of a rig that
//! creeps and sticks that came to a quarter more error (0.104 for 0.083 rad).

use motorlens_shared::effects::Kind;

use super::xml;
use crate::model_file::Model;

/// Temperature coefficient of copper's resistance, 1/K: heating is a share of resistance, and any number gives the same share.
const COPPER: f64 = 0.0039;
const AMBIENT_C: f64 = 20.0;

/// What the MJCF is made of.
#[derive(Default)]
pub(super) struct Parts {
    /// N m.
    pub friction: f64,
    /// More of it for a simulation without the Python file, N m.
    pub alone: f64,
    /// N m/rad, and rad.
    pub stiffness: f64,
    pub reference: f64,
    /// N m, against forward motion.
    pub load: f64,
    pub weight: Option<(f64, f64)>,
    /// Attributes of the actuator.
    pub motor: String,
    /// More actuators.
    pub beside: String,
}

/// Effects that MJCF expresses itself.
pub(super) fn native(kind: Kind) -> bool {
    use Kind::{
        Cogging, Compliance, ConstantLoad, Coulomb, CoulombAsymmetric, Delay, Gravity, Spring, WindingHeating,
    };
    matches!(
        kind,
        Coulomb
            | CoulombAsymmetric
            | Compliance
            | ConstantLoad
            | Gravity
            | Spring
            | Cogging
            | WindingHeating
            | Delay
    )
}

/// What an effect is written with.
pub(super) struct Setting<'a> {
    pub scale: f64,
    pub step_s: f64,
    pub resistance: f64,
    /// The joint that the motor turns.
    pub driven: &'a str,
    pub model: &'a Model,
}

/// Puts an effect into `parts`.
pub(super) fn add(parts: &mut Parts, kind: Kind, p: &[f64], setting: &Setting) {
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
                    "\n    <dcmotor name=\"second_harmonic\" joint=\"{}\" input=\"none\" motorconst=\"0 0\" resistance=\"1\"{}/>",
                    xml(setting.driven),
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

/// Distance of the weight from the axis and its radius, m: so small that its inertia hardly counts.
const ARM_M: f64 = 1e-4;
const RADIUS_M: f64 = 1e-3;

/// A weight whose torque is -(sine sin x + cosine cos x), and its inertia.
///
/// A mass m at angle a0 + x from the direction of gravity pulls back with m g r sin(a0 + x).
pub(super) fn bob((sine, cosine): (f64, f64), scale: f64) -> (String, f64) {
    let (size, start) = (sine.hypot(cosine) * scale, cosine.atan2(sine));
    let mass = size / (9.81 * ARM_M);
    let (x, y) = (ARM_M * start.sin(), -ARM_M * start.cos());
    let geom = format!(
        "\n      <geom type=\"sphere\" size=\"{RADIUS_M:e}\" pos=\"{x:e} {y:e} 0\" mass=\"{mass:e}\" contype=\"0\" conaffinity=\"0\"/>"
    );
    (geom, mass * (ARM_M * ARM_M + 0.4 * RADIUS_M * RADIUS_M))
}
