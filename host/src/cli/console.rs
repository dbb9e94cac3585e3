//! Where answers, prose and errors go.
//!
//! With `--json` standard output carries exactly one JSON document: the answer, or the error. Prose, progress
//! and errors go to standard error. A reader that goes away is no failure.

use std::cell::Cell;
use std::io::{IsTerminal, Write};

use serde::Serialize;

use super::{next, wrap};
use crate::error::Error;

/// The two streams, and who listens.
#[derive(Debug)]
pub struct Console {
    json: bool,
    quiet: bool,
    answered: Cell<bool>,
}

impl Console {
    /// `json`: a program listens; `quiet`: no prose.
    pub fn new(json: bool, quiet: bool) -> Self {
        Self { json, quiet, answered: Cell::new(false) }
    }

    /// Whether a program listens.
    pub fn json(&self) -> bool {
        self.json
    }

    /// Whether progress bars make sense.
    pub fn shows_progress(&self) -> bool {
        !self.quiet && std::io::stderr().is_terminal()
    }

    /// Prose for the person who watches.
    pub fn say(&self, text: impl AsRef<str>) {
        if !self.quiet {
            let text = text.as_ref().trim_end_matches('\n');
            let text =
                wrap::known_width().map_or_else(|| text.to_owned(), |width| wrap::wrapped(text, width));
            let _ = writeln!(std::io::stderr(), "{text}");
        }
    }

    /// What can be done next, for a person.
    pub fn next(&self, what: &str, command: &str) {
        if !self.json {
            self.say(next::then(what, command));
        }
    }

    /// The answer: a document for a program, prose for a person.
    pub fn answer(&self, document: &impl Serialize, prose: impl FnOnce() -> String) {
        if self.json {
            self.document(document);
        } else {
            self.say(prose());
        }
    }

    /// A list that people pipe into other programs: on standard output also without `--json`.
    pub fn list(&self, document: &impl Serialize, text: impl FnOnce() -> String) {
        if self.json {
            self.document(document);
        } else {
            let _ = writeln!(std::io::stdout(), "{}", text().trim_end_matches('\n'));
        }
    }

    /// An error, to the person always and to the program unless it has its document already.
    pub fn fail(&self, error: &Error) {
        let text = format!("error: {error}");
        let text = match wrap::known_width() {
            Some(width) => wrap::fault(&text, width),
            None => text,
        };
        let _ = writeln!(std::io::stderr(), "{text}");
        if self.json && !self.answered.get() {
            self.document(&error.to_json());
        }
    }

    fn document(&self, document: &impl Serialize) {
        self.answered.set(true);
        let mut out = std::io::stdout().lock();
        if let Ok(text) = serde_json::to_string_pretty(document) {
            let _ = writeln!(out, "{text}");
        }
        let _ = out.flush();
    }
}
