//! The generated part of the book: a page and a plot of every effect, from the registry.

use anyhow::Result;

use crate::process;

/// The sources of the book.
const PAGES: &str = "docs/book/src";

/// Writes them again; what people wrote below the generated part stays.
pub fn write() -> Result<()> {
    let program = ["run", "--release", "--locked", "-p", "motorlens", "--", "effects", "--book", PAGES];
    process::run(process::cargo().args(program))
}
