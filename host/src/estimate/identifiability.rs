//! What the data cannot tell, and what would unlock it.
//!
//! Voltage and motion determine three combinations of the paper's eight parameters. The other five directions
//! are free: whatever eight numbers a search returns, infinitely many others move the shaft in the same way.

use motorlens_shared::motor::{PARAMETERS, PaperMotor, SYMBOLS};
use serde::Serialize;

use crate::fit::layout::BaseValues;
use crate::log::Record;

/// A measurement, and what it would determine.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Unlock {
    /// What to measure.
    pub measure: &'static str,
    /// Parameters that it adds to those known.
    pub determines: Vec<&'static str>,
    /// How.
    pub how: &'static str,
}

/// Eight numbers that move the shaft as the fitted model does.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// What was chosen freely.
    pub chosen: &'static str,
    /// Km Kb L R Jsh Jr Br Bsh in SI units.
    pub parameters: Vec<Named>,
    /// Largest relative difference of its three combinations from the fitted ones.
    pub difference: f64,
}

/// A number of such an answer.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Named {
    /// The paper's symbol.
    pub symbol: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// Value.
    pub value: f64,
}

/// What is open, and how to close it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Identifiability {
    /// Combinations of the eight parameters that voltage and motion determine.
    pub determined: usize,
    /// Directions in which the eight parameters may be moved without any change of the motion.
    pub free: usize,
    /// The same in a sentence.
    pub meaning: String,
    /// Some of the infinitely many answers.
    pub eight_parameters: Vec<Answer>,
    /// Measurements that would end the choice.
    pub unlock: Vec<Unlock>,
}

const COMBINATIONS: usize = 3;

/// What the fitted base leaves open on a motor of this gear; `records` tell what is measured already.
pub fn identifiability(base: &BaseValues, gear_ratio: f64, records: &[Record]) -> Identifiability {
    let has_current = records.iter().any(|r| r.current_a.is_some());
    let emf = (1.0 - base.viscous_share) / (base.gain * gear_ratio);
    let answers = [
        ("R = 1 ohm, Km = Kb, all inertia and friction at the rotor", 1.0, emf, 0.0),
        ("R = 10 ohm, Km = Kb, all inertia and friction at the rotor", 10.0, emf, 0.0),
        (
            "R = 1 ohm, Km = 100 Kb (which no real machine has), all inertia and friction at the shaft",
            1.0,
            100.0 * emf,
            1.0,
        ),
    ];
    let eight_parameters = answers.map(|(chosen, resistance, torque_constant, at_shaft)| {
        let motor = motor(base, gear_ratio, resistance, torque_constant, at_shaft);
        Answer { chosen, difference: difference(&motor, base), parameters: named(&motor) }
    });
    Identifiability {
        determined: COMBINATIONS,
        free: PARAMETERS - COMBINATIONS,
        meaning: format!(
            "voltage and motion determine {COMBINATIONS} combinations of the {PARAMETERS} parameters; the answers below \
             move the shaft in exactly the same way, and so do infinitely many others"
        ),
        eight_parameters: eight_parameters.to_vec(),
        unlock: unlocks(has_current),
    }
}

/// The motor of this base whose winding has `resistance`, with a share of inertia and friction at the shaft.
///
/// tau_e = L/R; J = Kg Km tau_m / (gain R) at the output; D = share J / tau_m; Kb = (1 - share) / (gain Kg).
fn motor(base: &BaseValues, gear: f64, resistance: f64, torque_constant: f64, at_shaft: f64) -> PaperMotor {
    let inertia = gear * torque_constant * base.tau_m / (base.gain * resistance);
    let damping = base.viscous_share * inertia / base.tau_m;
    PaperMotor {
        torque_constant,
        back_emf_constant: (1.0 - base.viscous_share) / (base.gain * gear),
        inductance: base.tau_e * resistance,
        resistance,
        shaft_inertia: at_shaft * inertia,
        rotor_inertia: (1.0 - at_shaft) * inertia / (gear * gear),
        rotor_damping: (1.0 - at_shaft) * damping / (gear * gear),
        shaft_damping: at_shaft * damping,
        gear_ratio: gear,
    }
}

fn difference(motor: &PaperMotor, base: &BaseValues) -> f64 {
    let (c, b) = (motor.combinations(), base);
    let product = 1.0 / (b.tau_m * b.tau_e);
    [
        c.b_over_a1 / (b.gain * product),
        c.a2_over_a1 / (1.0 / b.tau_e + b.viscous_share / b.tau_m),
        c.a3_over_a1 / product,
    ]
    .iter()
    .fold(0.0, |worst: f64, ratio| worst.max((ratio - 1.0).abs()))
}

fn named(motor: &PaperMotor) -> Vec<Named> {
    let row = |((symbol, unit), value): (&(&'static str, &'static str), f64)| Named { symbol, unit, value };
    SYMBOLS.iter().zip(motor.genes()).map(row).collect()
}

fn unlocks(has_current: bool) -> Vec<Unlock> {
    let mut list = Vec::new();
    if !has_current {
        list.push(Unlock {
            measure: "the motor's current (a column current_a)",
            determines: vec!["R", "L", "Km"],
            how: "R is the fitted R i over the measured i, L = tau_e R, and Km = Kb in SI units; with Km the total inertia \
                  and damping follow",
        });
    }
    list.push(Unlock {
        measure: "a stall test: current (and torque) at a known voltage with the shaft held",
        determines: vec!["R", "L", "Km"],
        how: "R = V / i at stall; the stall torque over the current is Kg Km",
    });
    list.push(Unlock {
        measure: "a second log with a disc of known inertia on the shaft",
        determines: vec!["Km / R", "total inertia", "total damping"],
        how: "tau_m grows by the disc's share of the inertia, which sets the scale of every torque",
    });
    list.push(Unlock {
        measure: "a log of the motor without its gear, or the rotor's inertia from a data sheet",
        determines: vec!["Jr and Jsh apart", "Br and Bsh apart"],
        how: "through a rigid gear rotor and shaft move as one: only their sum acts",
    });
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn very_different_eights_have_the_same_three_combinations() {
        let base = BaseValues { gain: 0.06, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };
        let open = identifiability(&base, 104.0, &[]);
        assert_eq!((open.determined, open.free), (3, 5));
        for answer in &open.eight_parameters {
            assert!(answer.difference < 1e-12, "{answer:?}");
            assert_eq!(answer.parameters.len(), 8);
        }
        let value = |k: usize, symbol| {
            let all = &open.eight_parameters[k].parameters;
            all.iter().find(|p| p.symbol == symbol).unwrap().value
        };
        assert!((value(1, "R") / value(0, "R") - 10.0).abs() < 1e-12);
        assert!(value(2, "Jsh") > 0.0 && value(0, "Jsh") == 0.0);
    }

    #[test]
    fn a_measured_current_is_not_asked_for_again() {
        let base = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };
        let with = Record { current_a: Some(vec![0.0]), ..Record::default() };
        assert_eq!(identifiability(&base, 30.0, &[]).unlock.len(), 4);
        assert_eq!(identifiability(&base, 30.0, &[with]).unlock.len(), 3);
    }
}
