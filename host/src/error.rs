//! What went wrong, where, and what the user can do about it.
//!
//! Every failure of the program is one [`Error`]. It decides the exit status (2 wrong usage, 3 bad input,
//! 4 the device, 1 the machine itself) and prints as two lines: the cause with its place, and the remedy.

use std::fmt;
use std::path::{Path, PathBuf};

use serde_json::{Value, json};

use crate::log::guess::Proposal;

/// Result of anything that can fail with a user-visible message.
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// A failure, with the exit status it leads to.
#[derive(Debug, thiserror::Error)]
pub enum Error {
    /// Options that contradict each other or cannot be understood; exit status 2.
    #[error("{why}\n  do: {remedy}")]
    Usage {
        /// What is wrong with the command line.
        why: String,
        /// What to type instead.
        remedy: String,
    },
    /// A file whose content cannot be used; exit status 3.
    #[error(transparent)]
    BadInput(#[from] Box<BadInput>),
    /// A board that is absent, silent or refuses; exit status 4.
    #[error("{why}\n  do: {remedy}")]
    Device {
        /// What the device did or failed to do.
        why: String,
        /// What to check or change.
        remedy: String,
    },
    /// Whoever watched a search stopped it; exit status 1.
    #[error("stopped")]
    Cancelled,
    /// The machine refused an operation that is no fault of the input (a full disk, say); exit status 1.
    #[error("{doing}: {source}")]
    Io {
        /// What the program was doing, with the path.
        doing: String,
        /// What the operating system answered.
        source: std::io::Error,
    },
}

/// Which column of which kind of file is meant.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Column {
    /// A column of a table, by its header (or by its 0-based number where there is no header).
    Name(String),
    /// A character position in a line of text, counted from 1.
    Character(usize),
}

impl fmt::Display for Column {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Column::Name(name) => write!(f, "{name}"),
            Column::Character(position) => write!(f, "{position}"),
        }
    }
}

/// Where in the user's input the fault lies, why it is one, and what to do.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct BadInput {
    /// The file, as the user named it.
    pub file: PathBuf,
    /// Line, counted from 1.
    pub line: Option<u64>,
    /// Column, where one is to blame.
    pub column: Option<Column>,
    /// The cause, as a clause without a full stop.
    pub why: String,
    /// What to do, as an instruction.
    pub remedy: String,
    /// Options under which the file could be read, where the program has a guess.
    pub proposal: Option<Box<Proposal>>,
}

impl BadInput {
    /// A fault of the whole file.
    pub fn new(file: &Path, why: impl Into<String>, remedy: impl Into<String>) -> Self {
        BadInput {
            file: file.to_owned(),
            line: None,
            column: None,
            why: why.into(),
            remedy: remedy.into(),
            proposal: None,
        }
    }

    /// The same fault, at a line counted from 1.
    #[must_use]
    pub fn at_line(mut self, line: u64) -> Self {
        self.line = Some(line);
        self
    }

    /// The same fault, in a named column of a table.
    #[must_use]
    pub fn in_column(mut self, name: impl Into<String>) -> Self {
        self.column = Some(Column::Name(name.into()));
        self
    }

    /// The same fault, with options that would read the file.
    #[must_use]
    pub fn proposing(mut self, proposal: Option<Proposal>) -> Self {
        self.proposal = proposal.map(Box::new);
        self
    }

    /// The same fault, at a character of its line, counted from 1.
    #[must_use]
    pub fn at_character(mut self, position: usize) -> Self {
        self.column = Some(Column::Character(position));
        self
    }
}

impl fmt::Display for BadInput {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.file.display())?;
        if let Some(line) = self.line {
            write!(f, ", line {line}")?;
        }
        if let Some(column) = &self.column {
            write!(f, ", column {column}")?;
        }
        write!(f, ": {}.\n  do: {}", self.why, self.remedy)?;
        if let Some(proposal) = &self.proposal {
            proposal.preview.iter().try_for_each(|line| write!(f, "\n      {line}"))?;
        }
        Ok(())
    }
}

impl std::error::Error for BadInput {}

impl From<BadInput> for Error {
    fn from(fault: BadInput) -> Self {
        Error::BadInput(Box::new(fault))
    }
}

impl Error {
    /// Wrong usage, with what to type instead.
    pub fn usage(why: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error::Usage { why: why.into(), remedy: remedy.into() }
    }

    /// A device that did not answer or refused, with what to check.
    pub fn device(why: impl Into<String>, remedy: impl Into<String>) -> Self {
        Error::Device { why: why.into(), remedy: remedy.into() }
    }

    /// The status the process ends with: 2 usage, 3 bad input, 4 device, 1 the machine itself.
    pub fn exit_code(&self) -> u8 {
        match self {
            Error::Usage { .. } => 2,
            Error::BadInput(_) => 3,
            Error::Device { .. } => 4,
            Error::Cancelled | Error::Io { .. } => 1,
        }
    }

    /// The same failure for programs that asked for `--json`.
    pub fn to_json(&self) -> Value {
        let mut error = json!({ "exit": self.exit_code() });
        match self {
            Error::Usage { why, remedy } => {
                error["kind"] = json!("usage");
                error["why"] = json!(why);
                error["remedy"] = json!(remedy);
            }
            Error::BadInput(fault) => {
                error["kind"] = json!("bad_input");
                error["file"] = json!(fault.file.display().to_string());
                error["line"] = json!(fault.line);
                error["column"] = json!(fault.column.as_ref().map(Column::to_string));
                error["why"] = json!(fault.why);
                error["remedy"] = json!(fault.remedy);
                error["proposal"] = json!(fault.proposal);
            }
            Error::Device { why, remedy } => {
                error["kind"] = json!("device");
                error["why"] = json!(why);
                error["remedy"] = json!(remedy);
            }
            Error::Cancelled => {
                error["kind"] = json!("cancelled");
                error["why"] = json!(self.to_string());
            }
            Error::Io { .. } => {
                error["kind"] = json!("io");
                error["why"] = json!(self.to_string());
            }
        }
        json!({ "schema": 1, "error": error })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn nan_in_run3() -> Error {
        BadInput::new(Path::new("run3.csv"), "\"NaN\" is not a number a fit can use", "remove the row")
            .at_line(17)
            .in_column("voltage_v")
            .into()
    }

    #[test]
    fn a_bad_field_prints_file_line_column_cause_and_remedy() {
        assert_eq!(
            nan_in_run3().to_string(),
            "run3.csv, line 17, column voltage_v: \"NaN\" is not a number a fit can use.\n  do: remove the row"
        );
    }

    #[test]
    fn json_carries_the_same_facts_as_the_text() {
        let value = nan_in_run3().to_json();
        assert_eq!(value["schema"], 1);
        assert_eq!(value["error"]["file"], "run3.csv");
        assert_eq!(value["error"]["line"], 17);
        assert_eq!(value["error"]["column"], "voltage_v");
        assert_eq!(value["error"]["exit"], 3);
    }

    #[test]
    fn each_kind_of_failure_has_its_exit_status() {
        let full_disk =
            Error::Io { doing: "cannot write model.json".into(), source: std::io::Error::other("no space") };
        assert_eq!(Error::usage("a", "b").exit_code(), 2);
        assert_eq!(nan_in_run3().exit_code(), 3);
        assert_eq!(Error::device("a", "b").exit_code(), 4);
        assert_eq!(full_disk.exit_code(), 1);
    }
}
