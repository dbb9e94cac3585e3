//! Several mechanisms in one log of SysId are several motors: which there are, and which one is meant.

use std::path::Path;

use super::mapping::Mapping;
use super::sysid_entries::{Entries, Test};
use super::sysid_names::{belongs, motor_of};
use super::units::Quantity;
use crate::error::{BadInput, Result};

/// Whether the tests of this routine are those of some of the motors only.
pub fn is_owned(routine: &str, motors: &[String]) -> bool {
    !routine.is_empty() && motors.iter().any(|motor| belongs(motor, routine))
}

/// The mechanisms that have tests of their own.
fn mechanisms<'t>(tests: &'t [Test], motors: &[String]) -> Vec<&'t str> {
    let routines = tests.iter().map(|test| test.routine.as_str());
    let mut all: Vec<&str> = routines.filter(|routine| is_owned(routine, motors)).collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The motor whose voltage the mapping names; none where all are of one mechanism.
///
/// # Errors
/// Bad input where there are several mechanisms and the mapping names no motor.
pub fn chosen(
    path: &Path,
    motors: &[String],
    tests: &[Test],
    map: Option<&Mapping>,
) -> Result<Option<String>> {
    let column = map.and_then(|map| map.source(Quantity::Voltage)).map(|source| source.column.as_str());
    let motor = column.and_then(|column| motor_of(column, "voltage")).filter(|motor| motors.contains(motor));
    if motor.is_some() {
        return Ok(motor);
    }
    let mechanisms = mechanisms(tests, motors);
    if mechanisms.len() < 2 {
        return Ok(None);
    }
    let of = |mechanism: &&str| {
        let own: Vec<&str> =
            motors.iter().map(String::as_str).filter(|motor| belongs(motor, mechanism)).collect();
        format!("{mechanism} ({})", own.join(", "))
    };
    let why = format!(
        "the log holds tests of several mechanisms: {}",
        mechanisms.iter().map(of).collect::<Vec<_>>().join(", ")
    );
    let first = motors.iter().find(|motor| belongs(motor, mechanisms[0])).map_or("MOTOR", String::as_str);
    Err(BadInput::new(path, why, format!("choose a motor by its voltage: --map voltage=voltage-{first}:V"))
        .into())
}

impl Entries {
    /// What was logged, in a sentence, for whoever is asked whether to use it.
    pub fn sentence(&self) -> String {
        let count = self.tests().len();
        let plural = if count == 1 { "" } else { "s" };
        let axis = if self.has_ways() {
            " The positions are ways of a linear axis: give its metres per output turn."
        } else {
            ""
        };
        format!("{count} test{plural} of SysId, with the motors {}.{axis}", self.motors().join(", "))
    }

    /// The motors of which one has to be chosen; empty where all are of one mechanism.
    pub fn choices(&self) -> Vec<String> {
        let motors = self.motors();
        if mechanisms(&self.tests(), &motors).len() < 2 { Vec::new() } else { motors }
    }
}
