//! `cargo xtask peers`: the paper's search beside that of others, installed from their registries.

use std::path::PathBuf;

use anyhow::Result;
use std::process::Command;

use crate::{apt, process};

/// What the comparison needs from PyPI.
const PYTHON: [&str; 4] = ["scipy", "pygad", "pymoo", "deap"];

/// Sets up Python and Octave, builds the comparison, runs it. Takes some minutes; best on a quiet machine.
pub fn run() -> Result<()> {
    apt::ensure_apt(&["octave", "octave-control", "python3-venv"])?;
    let directory = process::root().join("target/peers");
    std::fs::create_dir_all(&directory)?;
    let python = python(&directory.join("venv"))?;
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

/// A Python of its own with what is needed, made on first use.
fn python(directory: &std::path::Path) -> Result<PathBuf> {
    let python = directory.join("bin/python");
    let modules = PYTHON.map(|name| format!("import {name}")).join("; ");
    let ready = Command::new(&python).args(["-c", &modules]).output();
    if !ready.is_ok_and(|output| output.status.success()) {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(directory))?;
        process::run(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(PYTHON))?;
    }
    Ok(python)
}
