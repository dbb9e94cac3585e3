//! What most verbs begin with: logs, the motor file, models.

use std::path::{Path, PathBuf};

use super::Console;
use crate::compare::problem_of;
use crate::error::Result;
use crate::fit::fixed;
use crate::fit::search::Problem;
use crate::log::{self, ReadArgs, Record};
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

/// Logs in memory.
#[derive(Debug)]
pub struct Logs {
    /// To fit.
    pub records: Vec<Record>,
    /// To judge by.
    pub validation: Vec<Record>,
    /// What is known of the motor.
    pub motor: MotorFile,
}

impl LogArgs {
    /// Reads all logs.
    pub fn load(&self) -> Result<Logs> {
        let motor = self.reading.motor_file()?;
        if let Some(path) = &self.reading.motor {
            fixed::check(path, &motor.fixed)?;
        }
        Ok(Logs {
            records: log::load(&self.logs, &self.reading)?,
            validation: log::load_validation(&self.reading)?,
            motor,
        })
    }
}

impl Logs {
    /// Tells what is odd about the logs.
    pub fn warn(&self, console: &Console) {
        let odd = log::suspicions(&self.records);
        let read = self.records.iter().chain(&self.validation).flat_map(|r| &r.warnings);
        for warning in read.chain(&odd) {
            console.say(format!("data: {}: {}\n  do: {}", warning.place, warning.what, warning.fix));
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
