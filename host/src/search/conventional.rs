//! The conventional fit: bounded nonlinear least squares on all eight parameters, from a nameplate start.
//!
//! Solver: the `levenberg-marquardt` crate, a port of MINPACK's `lmder`. It knows no bounds, so each parameter
//! is the image of an unbounded number z: ln x = ln start + ln(bound) sin z, which never leaves
//! start / bound ..= start * bound (James and Roos, MINUIT, 1975). The parameters enter the response through
//! three combinations, so five directions of the Jacobian are zero and the solver leaves them where they were.

use super::dispatch::Level;
use super::record::{LinearRecord, RecordError, Records};
use levenberg_marquardt::{LeastSquaresProblem, LevenbergMarquardt};
use motorlens_shared::motor::{Combinations, PARAMETERS, PaperMotor};
use nalgebra_lm::storage::Owned;
use nalgebra_lm::{Const, DMatrix, DVector, Dyn, Matrix, SVector, Vector};
use serde::Serialize;
use std::time::Instant;

/// Largest ratio between a fitted parameter and its start.
const BOUND: f64 = 100.0;
/// Step of the forward difference in z.
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
    let problem =
        Problem { records, start: *start, z: SVector::zeros(), evaluations: std::cell::Cell::new(0) };
    let (problem, report) = LevenbergMarquardt::new().minimize(problem);
    let motor = problem.motor(&problem.z);
    let combinations = motor.combinations();
    let mut squared = 0.0;
    records.errors(&combinations, |_, _, e| squared += e * e);
    ConventionalResult {
        motor,
        parameters: motor.genes(),
        combinations,
        iae: records.exact_iae(&combinations),
        rmse: (squared / records.samples() as f64).sqrt(),
        evaluations: problem.evaluations.get(),
        ending: format!("{:?}", report.termination),
        seconds: began.elapsed().as_secs_f64(),
    }
}

struct Problem<'a> {
    records: &'a Records,
    start: PaperMotor,
    z: SVector<f64, PARAMETERS>,
    evaluations: std::cell::Cell<u64>,
}

impl Problem<'_> {
    fn motor(&self, z: &SVector<f64, PARAMETERS>) -> PaperMotor {
        let start = self.start.genes();
        let x = core::array::from_fn(|k| start[k] * (BOUND.ln() * z[k].sin()).exp());
        PaperMotor::from_genes(x, self.start.gear_ratio)
    }

    fn errors(&self, z: &SVector<f64, PARAMETERS>) -> DVector<f64> {
        self.evaluations.set(self.evaluations.get() + 1);
        let mut errors = Vec::with_capacity(self.records.samples());
        self.records.errors(&self.motor(z).combinations(), |_, _, e| errors.push(e));
        DVector::from_vec(errors)
    }
}

impl LeastSquaresProblem<f64, Dyn, Const<PARAMETERS>> for Problem<'_> {
    type ResidualStorage = Owned<f64, Dyn>;
    type JacobianStorage = Owned<f64, Dyn, Const<PARAMETERS>>;
    type ParameterStorage = Owned<f64, Const<PARAMETERS>>;

    fn set_params(&mut self, z: &Vector<f64, Const<PARAMETERS>, Self::ParameterStorage>) {
        self.z = *z;
    }

    fn params(&self) -> Vector<f64, Const<PARAMETERS>, Self::ParameterStorage> {
        self.z
    }

    fn residuals(&self) -> Option<DVector<f64>> {
        Some(self.errors(&self.z))
    }

    fn jacobian(&self) -> Option<Matrix<f64, Dyn, Const<PARAMETERS>, Self::JacobianStorage>> {
        let here = self.errors(&self.z);
        let mut jacobian = DMatrix::zeros(here.len(), PARAMETERS);
        for k in 0..PARAMETERS {
            let mut z = self.z;
            z[k] += DIFFERENCE;
            jacobian.set_column(k, &((self.errors(&z) - &here) / DIFFERENCE));
        }
        Some(jacobian.fixed_columns::<PARAMETERS>(0).into_owned())
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
