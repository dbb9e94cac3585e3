//! The live page and the report, driven in a headless browser.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::report::Count;
use crate::{apt, process};

/// Sets up the browser, builds the program, runs the tests on both. Screenshots stay in `target/screenshots`.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["chromium"])?;
    if !directory().join("node_modules").is_dir() {
        // Not everybody's npm is Debian's.
        if Command::new("npm").arg("--version").output().is_err() {
            apt::ensure_apt(&["nodejs", "npm"])?;
        }
        process::run(Command::new("npm").current_dir(directory()).args(["ci", "--no-audit", "--no-fund"]))?;
    }
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
pub fn directory() -> PathBuf {
    process::root().join("tests/browser")
}
