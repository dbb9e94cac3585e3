//! The live page and the report, driven in a headless browser.

use std::path::PathBuf;

use anyhow::Result;

use crate::report::Count;
use crate::{apt, npm, process};

/// Sets up the browser, builds the program, runs the tests on both. Screenshots stay in `target/screenshots`.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["chromium"])?;
    npm::ensure_modules(&directory())?;
    let program = process::program()?;
    process::run_tests(
        process::cargo()
            .current_dir(directory())
            .args(["test", "--locked", "--", "--test-threads=1", "--show-output"])
            .env("CARGO_TARGET_DIR", process::target().join("browser"))
            .env("MOTORLENS", program),
    )
}

/// The directory of the tests' own workspace.
fn directory() -> PathBuf {
    process::root().join("tests/browser")
}
