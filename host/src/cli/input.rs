//! What most verbs begin with: logs, the motor file, models.

use std::cell::OnceCell;
use std::path::PathBuf;

use super::{Console, prose};
use crate::error::Result;
use crate::fit::fixed;
use crate::formula::Library;
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
    /// The model that stands before the logs, where the first file is one, and the logs.
    pub fn after_model(&self) -> (Option<Model>, Self) {
        let reading = self.reading.clone();
        let first = self.logs.first().filter(|_| self.logs.len() > 1);
        match first.and_then(|first| Model::read(first).ok()) {
            Some(model) => (Some(model), Self { logs: self.logs[1..].to_vec(), reading }),
            None => (None, Self { logs: self.logs.clone(), reading }),
        }
    }

    /// Reads all logs; the motor file may fix parameters of the effects of `library`.
    pub fn load(&self, library: &Library) -> Result<Logs> {
        let motor = self.reading.motor_file()?;
        if let Some(path) = &self.reading.motor {
            fixed::check(path, &motor.fixed, library)?;
        }
        let Loaded { records, validation, mut warnings } = log::load(&self.logs, &self.reading)?;
        warnings.extend(behind_validate(&self.logs, std::env::args().skip(1)));
        Ok(Logs { warnings, ..Logs::new(records, validation, motor) })
    }
}

/// Says which of `logs` stand right behind a log that is kept out, with others before it: who wrote so wanted them kept out too.
fn behind_validate(logs: &[PathBuf], words: impl Iterator<Item = String>) -> Option<Warning> {
    let (mut before, mut behind, mut near) = (false, Vec::new(), None);
    for word in words {
        // The log that `--validate` takes is 1 word behind it.
        near = match near {
            _ if matches!(word.as_str(), "-v" | "--validate") => Some(0),
            Some(_) if word.starts_with('-') => None,
            Some(at) => Some(at + 1),
            None => None,
        };
        let is_log = logs.iter().any(|log| log.as_os_str() == word.as_str());
        match near {
            Some(at) if at > 1 && before && is_log => behind.push(word),
            Some(_) => {}
            None => before |= is_log,
        }
    }
    (!behind.is_empty()).then(|| Warning {
        place: behind.join(", "),
        what: "fitted, although it stands behind --validate, which takes one log".into(),
        fix: "write --validate before each log that is to be kept out; else put this one before --validate"
            .into(),
    })
}

impl Logs {
    /// Logs to fit, logs to judge by, and what is known of their motor.
    pub fn new(records: Vec<Record>, validation: Vec<Record>, motor: MotorFile) -> Self {
        Self { records, validation, motor, warnings: Vec::new(), faults: OnceCell::new() }
    }

    /// Data quality problems of the logs; sought once.
    pub fn faults(&self) -> &[Warning] {
        self.faults.get_or_init(|| {
            let of_content = log::data_faults(self.records.iter().chain(&self.validation));
            log::together(self.warnings.iter().cloned().chain(of_content))
        })
    }

    /// Tells the data quality problems of the logs.
    pub fn warn(&self, console: &Console) {
        for fault in self.faults() {
            console.say(prose::fault(fault));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn told(words: &str, logs: &[&str]) -> Option<String> {
        let logs: Vec<PathBuf> = logs.iter().map(PathBuf::from).collect();
        behind_validate(&logs, words.split(' ').map(str::to_owned)).map(|warning| warning.place)
    }

    #[test]
    fn logs_that_a_pattern_put_behind_validate_are_named() {
        let words = "discover a.csv b.csv --validate h1.csv h2.csv h3.csv --motor m.toml";
        assert_eq!(told(words, &["a.csv", "b.csv", "h2.csv", "h3.csv"]).as_deref(), Some("h2.csv, h3.csv"));
        assert_eq!(told("discover -v h1.csv a.csv b.csv", &["a.csv", "b.csv"]), None);
        assert_eq!(told("discover a.csv -v h1.csv -v h2.csv", &["a.csv"]), None);
        assert_eq!(told("discover a.csv --validate=h1.csv b.csv", &["a.csv", "b.csv"]), None);
    }
}
