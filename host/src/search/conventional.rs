//! The conventional fit: bounded nonlinear least squares on all eight parameters, from a nameplate start.
//!
//! The parameters enter the response through three combinations, so five directions of the Jacobian are zero and the solver leaves
//! them where they were.

use super::dispatch::Level;
use super::least_squares::Search;
use super::record::{LinearRecord, RecordError, Records};
use levenberg_marquardt::LevenbergMarquardt;
use motorlens_shared::motor::{Combinations, PARAMETERS, PaperMotor};
use serde::Serialize;
use std::cell::Cell;
use std::time::Instant;

/// Largest ratio between a fitted parameter and its start.
const BOUND: f64 = 100.0;
/// Step of the forward difference.
const DIFFERENCE: f64 = 1e-6;

/// What [`conventional`] found.
#[derive(Debug, Clone, Serialize)]
pub struct ConventionalResult {
    /// The paper's x_sm.
    pub motor: PaperMotor,
    /// The same in the paper's order.
    pub parameters: [f64; PARAMETERS],
    /// What the records determine.
    pub combinations: Combinations,
    /// Summed over the records, in double precision; rad s or rad.
    pub iae: f64,
    /// Root of the mean squared error, rad or rad/s: what this method minimises.
    pub rmse: f64,
    /// Simulations of all records.
    pub evaluations: u64,
    /// How the solver ended.
    pub ending: String,
    /// The search alone.
    pub seconds: f64,
}

/// Least squares on angle and speed records from `start`, all of whose parameters must be positive.
///
/// # Errors
/// See [`RecordError`].
pub fn conventional(records: &[LinearRecord], start: &PaperMotor) -> Result<ConventionalResult, RecordError> {
    Ok(conventional_on(&Records::new(records, Level::best())?, start))
}

/// [`conventional`] on records that are already prepared.
#[must_use]
pub fn conventional_on(records: &Records, start: &PaperMotor) -> ConventionalResult {
    let began = Instant::now();
    let evaluations = Cell::new(0);
    let motor = |x: &[f64]| {
        PaperMotor::from_genes(core::array::from_fn::<f64, PARAMETERS, _>(|k| x[k]), start.gear_ratio)
    };
    let errors = |x: &[f64]| {
        evaluations.set(evaluations.get() + 1);
        let mut errors = Vec::with_capacity(records.samples());
        records.errors(&motor(x).combinations(), |_, _, e| errors.push(e));
        errors
    };
    let solver = LevenbergMarquardt::new();
    let search = Search { start: &start.genes(), bound: BOUND, difference: DIFFERENCE, solver };
    let found = search.minimise(errors);
    let motor = motor(&found.x);
    let combinations = motor.combinations();
    ConventionalResult {
        motor,
        parameters: motor.genes(),
        combinations,
        iae: records.exact_iae(&combinations),
        rmse: (found.squares / records.samples() as f64).sqrt(),
        evaluations: evaluations.get(),
        ending: found.ending,
        seconds: began.elapsed().as_secs_f64(),
    }
}

#[cfg(test)]
mod tests {
    use super::conventional_on;
    use crate::search::dispatch::Level;
    use crate::search::record::Records;
    use crate::search::trial::{MOTOR, three_sines};
    use motorlens_shared::linear::Kind;
    use motorlens_shared::motor::PaperMotor;

    #[test]
    fn comes_from_a_wrong_nameplate_to_the_combinations_of_the_true_motor() {
        let records = Records::new(&three_sines(100, Kind::Angle), Level::best()).expect("good");
        let start = PaperMotor {
            resistance: 2.0 * MOTOR.resistance,
            back_emf_constant: 0.7 * MOTOR.back_emf_constant,
            rotor_inertia: 3.0 * MOTOR.rotor_inertia,
            ..MOTOR
        };
        let result = conventional_on(&records, &start);
        let gain = result.combinations.gain() / MOTOR.combinations().gain();
        assert!((gain - 1.0).abs() < 1e-3, "{gain}: {}", result.ending);
        let truth = records.exact_iae(&MOTOR.combinations());
        assert!(result.iae < truth * 1.05, "{} {truth}", result.iae);
        // The eight parameters themselves stay wrong: the data cannot tell.
        assert!((result.motor.rotor_inertia / MOTOR.rotor_inertia - 1.0).abs() > 0.2);
    }
}
