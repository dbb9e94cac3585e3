//! From records to a problem and a first base model.

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
    let (problem, start) = setup::problem(records, motor);
    let (layout, x) = problem.fit_base(&start);
    let base = layout.unpack(&x);
    Ok((problem, base))
}
