//! Parsing foreign JSON, with the place of a fault.

use std::io::BufRead;
use std::path::Path;

use serde::de::DeserializeOwned;
use serde_json::error::Category;

use super::text::cannot_read;
use crate::error::{BadInput, Result};

/// Parses all of `input`.
///
/// # Errors
/// Bad input with line and character.
pub fn parse<T: DeserializeOwned>(path: &Path, input: impl BufRead) -> Result<T> {
    serde_json::from_reader(input).map_err(|error| {
        let (line, character) = (error.line() as u64, error.column());
        let (why, remedy) = match error.classify() {
            Category::Io => return cannot_read(path, &error.into()),
            Category::Eof => (
                "the JSON ends in the middle".to_owned(),
                "check that the file was copied in full and is complete",
            ),
            Category::Syntax => {
                (format!("this is not JSON: {error}"), "check that --format names the layout of this file")
            }
            Category::Data => (
                format!("this JSON has another layout: {error}"),
                "check that --format names the layout of this file",
            ),
        };
        BadInput::new(path, why, remedy).at_line(line).at_character(character).into()
    })
}
