//! Records laid out for a model that exists.

use crate::error::Result;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::setup;
use crate::log::{Record, check_all_usable, check_some};
use crate::model_file::Model;
use crate::motor_file::MotorFile;

/// The records as `model` sees them: its own rig and beliefs, first speeds found under it.
///
/// # Errors
/// Records that say nothing about a motor; see [`check_all_usable`].
pub fn problem_of(model: &Model, records: &[Record], motor: &MotorFile) -> Result<Problem> {
    check_some(records)?;
    check_all_usable(records)?;
    let (mut problem, _) = laid_out(model, records, motor);
    problem.find_moving_starts(&model.values());
    Ok(problem)
}

/// The same with the first speeds of a rough base model, and that model: where a fit begins.
pub fn laid_out(model: &Model, records: &[Record], motor: &MotorFile) -> (Problem, Values) {
    let (mut problem, start) = setup::problem(records, motor);
    problem.rig = model.rig(problem.rig.step_s);
    problem.prior = model.prior();
    (problem, start)
}
