//! Feedforward gains for WPILib: volts = kS sign(v) + kV v + kA a, and kG for an arm or an elevator.
//!
//! Of dw/dt = c (u + f) - b w and u = v - k_e w follow kV = k_e + b / c = gain^-1 and kA = 1 / c = tau_m / gain. A weight's torque
//! -(sine sin x + cosine cos x) is held by kG cos(x - x0); a constant load by a kG of its own. What the driver swallows has to be
//! commanded before anything moves, as static friction has, so it belongs to kS. Source: WPILib's feedforward classes.
//! In C++ an `ElevatorFeedforward` is in metres and would refuse radians: there kG is added to the shaft's own feedforward.

use motorlens_shared::effects::Kind;

use super::actuator::{leave, one_level, take};
use super::{Exported, Lost};
use crate::model_file::Model;
use crate::sentence::capital;

const TAKEN: [Kind; 7] = [
    Kind::Coulomb,
    Kind::CoulombAsymmetric,
    Kind::Stribeck,
    Kind::DeadZone,
    Kind::ConstantLoad,
    Kind::Gravity,
    Kind::Delay,
];

/// Gains with their units, as text to paste from.
pub(super) fn export(model: &Model) -> Exported {
    let (a, lost, carried) = take(model, &TAKEN, "a feedforward has kS, kV, kA and kG only");
    let b = &model.base;
    let (ks, kv, ka) = (a.friction + a.dead_zone, 1.0 / b.gain, b.tau_m / b.gain);
    let mut notes = vec![format!(
        "The winding's time constant ({:.1e} s) and the size of the encoder's steps play no part.",
        b.tau_e
    )];
    if a.dead_zone > 0.0 {
        notes.push(format!(
            "kS holds {:.4} V of dead zone beside {:.4} V of friction.",
            a.dead_zone, a.friction
        ));
    }
    if let Some([excess, speed, _]) = a.stribeck {
        notes.push(format!(
            "Breaking away takes {excess:.4} V more than kS; that is over above some {:.3} rad/s.",
            2.0 * speed
        ));
    }
    let why =
        format!("is for the controller's delay compensation: a command acts {:.3} ms late", 1e3 * a.delay_s);
    let mut left = leave(model, &[Kind::Delay], &why);
    let (kg, arm) = match a.weight {
        // Forward torque is -(s sin x + c cos x) = -kG cos(x - x0).
        Some([sine, cosine]) => (sine.hypot(cosine), Some(sine.atan2(cosine))),
        None => (a.load, None),
    };
    if let (Some(zero), true) = (arm, a.load != 0.0) {
        let why = format!(
            "of {:.4} V comes beside kG, and is for you to add; zero of the arm at {zero:.4} rad",
            a.load
        );
        left.extend(leave(model, &[Kind::ConstantLoad, Kind::CoulombAsymmetric], &why));
    }
    let carried = one_level(carried, ks, &[Kind::DeadZone]);
    let text = text([ks, kv, ka, kg], arm, &notes, &left);
    Exported::numbers(text, carried, notes, lost, left)
}

fn text([ks, kv, ka, kg]: [f64; 4], arm: Option<f64>, notes: &[String], left: &[Lost]) -> String {
    let turn = std::f64::consts::TAU;
    let kind = match arm {
        Some(_) => "Arm",
        None if kg != 0.0 => "Elevator",
        None => "SimpleMotor",
    };
    let (order, with_g) = if kind == "SimpleMotor" { ("kS, kV, kA", "") } else { ("kS, kG, kV, kA", "kG, ") };
    let zero = arm.map_or(String::new(), |zero| {
        format!("The arm's angle for calculate() is the log's less {zero:.6} rad: there the weight pulls hardest.\n")
    });
    let (gravity, gravity_cpp, gravity_py) = if with_g.is_empty() {
        (String::new(), String::new(), String::new())
    } else {
        (
            format!("  static final double kG = {kg:.9}; // V\n"),
            format!("constexpr auto kG = {kg:.9}_V;\n"),
            format!("kG = {kg:.9}  # V\n"),
        )
    };
    let notes: String = notes.iter().map(|note| format!("{note}\n")).collect();
    // For whoever has the pasted lines alone.
    let beside = |sign: &str| -> String {
        left.iter().map(|left| format!("{sign} {} {}.\n", capital(left.effect.name()), left.why)).collect()
    };
    let (beside_c, beside_python) = (beside("//"), beside("#"));
    let class = format!("{kind}Feedforward");
    let python_class = if kind == "SimpleMotor" { "SimpleMotorFeedforwardRadians" } else { &class };
    let (cpp_header, cpp_class, cpp_order, cpp_load) = match kind {
        "Arm" => ("ArmFeedforward", "ArmFeedforward", order, ""),
        "Elevator" => (
            "SimpleMotorFeedforward",
            "SimpleMotorFeedforward<units::radians>",
            "kS, kV, kA",
            "// Command feedforward.Calculate(...) + kG: frc::ElevatorFeedforward takes metres.\n",
        ),
        _ => ("SimpleMotorFeedforward", "SimpleMotorFeedforward<units::radians>", order, ""),
    };
    format!(
        "\
Written by motorlens. Angles and speeds are of the output shaft.

kS = {ks:.9} V
kV = {kv:.9} V s/rad      = {kv_turn:.9} V s/rotation
kA = {ka:.9} V s^2/rad    = {ka_turn:.9} V s^2/rotation
kG = {kg:.9} V

{zero}{notes}
--- Java (radians)
{beside_c}  // import edu.wpi.first.math.controller.{class};
  static final double kS = {ks:.9}; // V
{gravity}  static final double kV = {kv:.9}; // V s/rad
  static final double kA = {ka:.9}; // V s^2/rad
  final {class} feedforward = new {class}({order});

--- C++ (radians)
#include <frc/controller/{cpp_header}.h>
#include <units/angular_acceleration.h>
#include <units/angular_velocity.h>
#include <units/voltage.h>
{beside_c}constexpr auto kS = {ks:.9}_V;
{gravity_cpp}constexpr auto kV = {kv:.9}_V / 1_rad_per_s;
constexpr auto kA = {ka:.9}_V / 1_rad_per_s_sq;
{cpp_load}frc::{cpp_class} feedforward{{{cpp_order}}};

--- Python (radians)
import wpimath.controller
{beside_python}kS = {ks:.9}  # V
{gravity_py}kV = {kv:.9}  # V s/rad
kA = {ka:.9}  # V s^2/rad
feedforward = wpimath.controller.{python_class}({order})
",
        kv_turn = kv * turn,
        ka_turn = ka * turn,
    )
}
