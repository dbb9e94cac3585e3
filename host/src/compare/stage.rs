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

/// The same for a simulation of `model` as it is: its own values stand, whatever is known of the motor.
///
/// # Errors
/// As [`problem_of`].
pub(crate) fn problem_as_it_is(model: &Model, records: &[Record], motor: &MotorFile) -> Result<Problem> {
    let mut problem = problem_of(model, records, motor)?;
    problem.fixed.clear();
    Ok(problem)
}

/// The records with the first speeds of a rough base model, and that model: where a fit begins. Speeds are read as they were when `model` was fitted.
pub fn laid_out(model: &Model, records: &[Record], motor: &MotorFile) -> (Problem, Values) {
    let (mut problem, start) = setup::problem_of(records, motor, model.rig.speed_reading);
    problem.rig = model.rig(problem.rig.step_s);
    problem.prior = model.prior();
    (problem, start)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::Quantity;

    #[test]
    fn speeds_are_read_as_they_were_when_the_model_was_fitted() {
        let time_s: Vec<f64> = (0..400).map(|k| 0.01 * f64::from(k)).collect();
        let voltage_v: Vec<f64> = time_s.iter().map(|t| 6.0 * (2.0 * t).sin()).collect();
        let mut speed = 0.0;
        let run = voltage_v.iter().map(|v| {
            let now = speed;
            speed += 0.1 * (1.5 * v - speed);
            now
        });
        let speed_rad_s = Some(run.collect());
        let (records, file) =
            ([Record { time_s, voltage_v, speed_rad_s, ..Record::default() }], MotorFile::default());
        let (problem, values) = setup::problem(&records, &file);
        let mut model = Model::fitted(&values, &problem, crate::model_file::Origin::default());
        assert_eq!(model.rig.speed_reading, problem.speeds());
        for reading in [Quantity::Speed, Quantity::MeanSpeed, Quantity::WindowSpeed(0.05)] {
            model.rig.speed_reading = Some(reading);
            assert_eq!(problem_of(&model, &records, &file).unwrap().speeds(), Some(reading));
        }
    }
}
