//! From records to a problem and a first base model.

use motorlens_shared::effects::Kind;

use super::fast;
use crate::error::Result;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::setup;
use crate::log::{Record, check_all_usable, check_some};
use crate::motor_file::MotorFile;

/// Lays out the records and fits the base model to all of them.
///
/// # Errors
/// Records that no fit can use.
pub fn prepare(records: &[Record], motor: &MotorFile) -> Result<(Problem, Values)> {
    check_some(records)?;
    check_all_usable(records)?;
    Ok(with_base(setup::problem(records, motor)))
}

/// The same for a model of `effects`: speeds are read as such a model says.
///
/// # Errors
/// Records that no fit can use.
pub fn prepare_for(records: &[Record], motor: &MotorFile, effects: &[Kind]) -> Result<(Problem, Values)> {
    let (problem, base) = prepare(records, motor)?;
    let otherwise = || problem.read_otherwise(&fast::search(&problem, &base, effects).values);
    let asks = !effects.is_empty() && problem.speeds().is_some();
    Ok(match asks.then(otherwise).flatten() {
        Some(otherwise) => with_base(setup::problem_of(records, motor, Some(otherwise))),
        None => (problem, base),
    })
}

fn with_base((mut problem, start): (Problem, Values)) -> (Problem, Values) {
    let (layout, x) = problem.fit_base(&start);
    let base = layout.unpack(&x);
    (problem, base)
}
