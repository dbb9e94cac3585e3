//! `cargo xtask peers`: the paper's search beside that of others, installed from their registries.

use std::path::PathBuf;

use anyhow::Result;

use crate::{apt, exports, process};

/// What the comparison needs from PyPI.
const PYTHON: [&str; 4] = ["scipy", "pygad", "pymoo", "deap"];

/// Sets up Python and Octave, builds the comparison, runs it. Takes some minutes; best on a quiet machine.
pub fn run() -> Result<()> {
    apt::ensure_apt(&["octave", "octave-control", "python3-venv"])?;
    let directory = process::root().join("target/peers");
    std::fs::create_dir_all(&directory)?;
    let python = exports::environment(&directory.join("venv"), &PYTHON.map(|name| (name, name)))?;
    process::run(
        process::cargo()
            .current_dir(crate_directory())
            .args(["run", "--release", "--bin", "motorlens-peers", "--"])
            .arg(&directory)
            .arg(python)
            .arg("octave"),
    )
}

/// Where the comparison lives: a workspace of its own.
pub fn crate_directory() -> PathBuf {
    process::root().join("tests/peers")
}
