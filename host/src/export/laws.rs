//! Effects as statements that C and Python both read.
//!
//! Names: `volts` the command; `v` the voltage so far; `torque`; `up` and `down` the friction against forward
//! and backward motion; `drop`; `series`; `current`, `speed`, `angle` the state; `start` the first angle.

use motorlens_shared::effects::{Kind, Rig};

/// The statements of an effect; none where the step of the exported program has no place for it.
pub(super) fn statements(kind: Kind, p: &[f64], rig: &Rig) -> Option<Vec<String>> {
    let friction = |up: String, down: String| vec![format!("up += {up}"), format!("down += {down}")];
    let ripple = |turns: &str, at: &str| {
        vec![format!("torque -= {:e} * sin({turns} * {at}) + {:e} * cos({turns} * {at})", p[0], p[1])]
    };
    Some(match kind {
        Kind::DeadZone => {
            let (up, down) = ((p[0] + p[1]).max(0.0), (p[0] - p[1]).max(0.0));
            vec![format!("v -= clamp(v, -{down:e}, {up:e})")]
        }
        Kind::SupplySag => {
            vec![format!(
                "series += {:e} * (volts / {:e}) * (volts / {:e})",
                p[0], rig.supply_v, rig.supply_v
            )]
        }
        Kind::VoltageDrop => vec![format!("drop += {:e}", p[0])],
        Kind::Coulomb => friction(format!("{:e}", p[0]), format!("{:e}", p[0])),
        Kind::CoulombAsymmetric => {
            friction(format!("{:e}", (p[0] + p[1]).max(0.0)), format!("{:e}", (p[0] - p[1]).max(0.0)))
        }
        Kind::Stribeck => {
            let square = format!("(speed / {:e}) * (speed / {:e})", p[2], p[2]);
            let f = format!("{:e} + {:e} / (1.0 + {square} + 0.5 * {square} * {square})", p[0], p[1]);
            friction(f.clone(), f)
        }
        Kind::LoadFriction => {
            let f = format!("{:e} * fabs(current)", p[0]);
            friction(f.clone(), f)
        }
        Kind::QuadraticDrag => vec![format!("torque -= {:e} * speed * fabs(speed)", p[0])],
        Kind::Gravity => ripple("1.0", "angle"),
        Kind::ConstantLoad => vec![format!("torque -= {:e}", p[0])],
        Kind::Cogging => {
            let middle = format!("(angle + {:e} * speed)", 0.5 * rig.step_s);
            // Angles of the motor shaft; `order` periods a turn.
            ripple(&format!("{:e}", p[2] * rig.gear_ratio), &middle)
        }
        Kind::Spring => vec![format!("torque -= {:e} * (angle - start) + {:e}", p[0], p[1])],
        _ => return None,
    })
}
