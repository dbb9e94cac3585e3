//! From records to a problem and a first base model.

use std::time::Instant;

use motorlens_shared::effects::Kind;

use super::{Searched, fast};
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

/// Records laid out for a model.
pub(super) struct Prepared {
    pub problem: Problem,
    /// The base model that was fitted to them.
    pub base: Values,
    /// What the fast method finds, and in how many seconds, where it was asked on the way.
    pub known: Option<(Searched, f64)>,
}

/// The same for a model of `effects`: speeds are read as such a model says.
///
/// # Errors
/// Records that no fit can use.
pub(super) fn prepare_for(records: &[Record], motor: &MotorFile, effects: &[Kind]) -> Result<Prepared> {
    let (problem, base) = prepare(records, motor)?;
    if effects.is_empty() || problem.speeds().is_none() {
        return Ok(Prepared { problem, base, known: None });
    }
    let known = timed(|| fast::search(&problem, &base, effects));
    Ok(match problem.read_otherwise(&known.0.values) {
        Some(otherwise) => {
            let (problem, base) = with_base(setup::problem_of(records, motor, Some(otherwise)));
            Prepared { problem, base, known: None }
        }
        None => Prepared { problem, base, known: Some(known) },
    })
}

/// What `search` returns, and the seconds that it took.
pub(super) fn timed<T>(search: impl FnOnce() -> T) -> (T, f64) {
    let begun = Instant::now();
    let found = search();
    (found, begun.elapsed().as_secs_f64())
}

fn with_base((mut problem, start): (Problem, Values)) -> (Problem, Values) {
    let (layout, x) = problem.fit_base(&start);
    let base = layout.unpack(&x);
    (problem, base)
}
