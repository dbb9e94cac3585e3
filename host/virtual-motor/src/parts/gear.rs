//! How the rotor moves the load: rigidly, through a gap, or through a spring.

use super::find;
use crate::effect::Effect;
use crate::motor::Motor;
use crate::table::Kind;
use std::f64::consts::TAU;

/// The torque that passes the gear as a function of its twist.
#[derive(Debug, Clone, PartialEq)]
pub enum Coupling {
    /// Rotor and load are one inertia.
    Rigid,
    /// A dead band of `2 half_gap`, then spring and damper that only push (Nordin and Gutman 2002, "modified
    /// dead zone"); both apply when a soft shaft has a gap too.
    Elastic {
        /// Half the gap, rad of the output shaft.
        half_gap: f64,
        /// N m/rad at the output shaft.
        stiffness: f64,
        /// N m s/rad at the output shaft.
        damping: f64,
    },
}

/// Natural frequency and damping ratio of the tooth contact: far above the motor's own dynamics, well below the
/// step rate, and nearly without rebound.
const CONTACT_HZ: f64 = 200.0;
const CONTACT_DAMPING: f64 = 0.5;

/// The coupling, with the rotor's inertia (motor shaft) and the load's (output shaft) that go with it.
pub fn coupling(motor: &Motor, effects: &[Effect]) -> (Coupling, f64, f64) {
    let compliance = find(effects, Kind::Compliance);
    let backlash = find(effects, Kind::Backlash);
    let [gap_deg, gap_share, ..] = backlash.unwrap_or_default();
    let share = match (compliance, backlash) {
        (Some([_, share, ..]), _) => share,
        (None, Some(_)) => gap_share,
        (None, None) => return (Coupling::Rigid, motor.rotor_inertia, motor.load_inertia),
    };
    let at_output = motor.gear_ratio * motor.gear_ratio;
    let total = motor.inertia() * at_output;
    let (rotor, load) = (total * (1.0 - share), total * share);
    let (stiffness, damping) = match compliance {
        Some([frequency, _, ratio, _]) => {
            let speed = TAU * frequency;
            (load * speed * speed, 2.0 * ratio * speed * load)
        }
        None => {
            let reduced = rotor * load / total;
            let speed = TAU * CONTACT_HZ;
            (reduced * speed * speed, 2.0 * CONTACT_DAMPING * speed * reduced)
        }
    };
    let half_gap = 0.5 * gap_deg.to_radians();
    (Coupling::Elastic { half_gap, stiffness, damping }, rotor / at_output, load)
}

/// Torque on the load at this twist (rotor ahead of load, rad of the output shaft) and its rate, N m.
#[inline]
pub fn torque(half_gap: f64, stiffness: f64, damping: f64, twist: f64, rate: f64) -> f64 {
    let pressed = if twist > half_gap {
        twist - half_gap
    } else if twist < -half_gap {
        twist + half_gap
    } else if half_gap > 0.0 {
        return 0.0;
    } else {
        twist
    };
    let torque = stiffness * pressed + damping * rate;
    if half_gap > 0.0 && torque * pressed < 0.0 { 0.0 } else { torque }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_whole_inertia_stays_that_of_the_motor() {
        let motor = Motor::paper();
        for text in ["backlash=2,share=0.3", "compliance=10,share=0.6", "coulomb=0.2"] {
            let (_, rotor, load) = coupling(&motor, &[Effect::parse(text).unwrap()]);
            let total = rotor + load / (motor.gear_ratio * motor.gear_ratio);
            assert!((total / motor.inertia() - 1.0).abs() < 1e-12, "{text}");
        }
    }

    #[test]
    fn contact_pushes_but_never_pulls() {
        assert_eq!(torque(0.1, 50.0, 2.0, 0.05, 9.0), 0.0);
        assert!((torque(0.1, 50.0, 2.0, 0.12, 0.0) - 1.0).abs() < 1e-12);
        assert_eq!(torque(0.1, 50.0, 2.0, 0.12, -9.0), 0.0);
        assert!(torque(0.1, 50.0, 2.0, -0.12, 0.0) < 0.0);
    }

    #[test]
    fn a_soft_shaft_pulls_both_ways() {
        assert!((torque(0.0, 50.0, 2.0, -0.1, 1.0) - (-3.0)).abs() < 1e-12);
        assert_eq!(torque(0.0, 50.0, 2.0, 0.0, 1.0), 2.0);
    }
}
