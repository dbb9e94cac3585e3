//! What most verbs begin with: logs, the motor file, models.

use std::cell::OnceCell;
use std::path::{Path, PathBuf};

use super::{Console, prose};
use crate::compare::problem_of;
use crate::error::Result;
use crate::fit::fixed;
use crate::fit::search::Problem;
use crate::log::{self, Loaded, ReadArgs, Record, Warning};
use crate::model_file::Model;
use crate::motor_file::MotorFile;

/// Logs and how to read them.
#[derive(Debug, clap::Args)]
pub struct LogArgs {
    /// Log files; each is one record
    #[arg(required = true, value_name = "LOG")]
    pub logs: Vec<PathBuf>,
    #[command(flatten)]
    pub reading: ReadArgs,
}

/// Logs in memory; they do not change.
#[derive(Debug)]
pub struct Logs {
    /// To fit.
    pub records: Vec<Record>,
    /// To judge by.
    pub validation: Vec<Record>,
    /// What is known of the motor.
    pub motor: MotorFile,
    /// What the reader said that belongs to no record above.
    warnings: Vec<Warning>,
    faults: OnceCell<Vec<Warning>>,
}

impl LogArgs {
    /// Reads all logs.
    pub fn load(&self) -> Result<Logs> {
        let motor = self.reading.motor_file()?;
        if let Some(path) = &self.reading.motor {
            fixed::check(path, &motor.fixed)?;
        }
        let Loaded { records, validation, warnings } = log::load(&self.logs, &self.reading)?;
        Ok(Logs { warnings, ..Logs::new(records, validation, motor) })
    }
}

impl Logs {
    /// Logs to fit, logs to judge by, and what is known of their motor.
    pub fn new(records: Vec<Record>, validation: Vec<Record>, motor: MotorFile) -> Self {
        Self { records, validation, motor, warnings: Vec::new(), faults: OnceCell::new() }
    }

    /// What is odd about the logs; sought once.
    pub fn faults(&self) -> &[Warning] {
        self.faults.get_or_init(|| {
            let of_content = log::data_faults(self.records.iter().chain(&self.validation));
            log::together(self.warnings.iter().cloned().chain(of_content))
        })
    }

    /// Tells what is odd about the logs.
    pub fn warn(&self, console: &Console) {
        for fault in self.faults() {
            console.say(prose::fault(fault));
        }
    }
}

/// A model, and records laid out for it.
pub fn model_and_problem(model: &Path, records: &[Record], motor: &MotorFile) -> Result<(Model, Problem)> {
    let model = Model::read(model)?;
    let mut problem = problem_of(&model, records, motor)?;
    // Nothing is fitted here: the model's own values stand.
    problem.fixed.clear();
    Ok((model, problem))
}
