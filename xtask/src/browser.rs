//! The live page and the report, driven in a headless browser.

use std::path::PathBuf;

use anyhow::Result;

use crate::report::Count;
use crate::{apt, process};

/// Sets up the browser, builds the program, runs the tests on both. Screenshots stay in `target/screenshots`.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["chromium"])?;
    process::run(process::cargo().args(["build", "-p", "motorlens", "--locked"]))?;
    let target =
        std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| process::root().join("target"), PathBuf::from);
    process::run_tests(
        process::cargo()
            .current_dir(directory())
            .args(["test", "--locked", "--", "--test-threads=1", "--show-output"])
            .env("MOTORLENS", target.join("debug/motorlens"))
            .env("CARGO_TARGET_DIR", target.join("browser")),
    )
}

/// The directory of the tests' own workspace.
pub fn directory() -> PathBuf {
    process::root().join("tests/browser")
}
