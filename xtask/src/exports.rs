//! Exported models in the tools that they are for: MuJoCo, and a Modelica compiler.
//!
//! Neither is in Debian's archive (OpenModelica has one of its own), so both come from Python's registry into a
//! virtual environment: MuJoCo itself, and rumoca, which compiles and simulates Modelica.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::report::Count;
use crate::{apt, process};

const PYTHON: [&str; 2] = ["mujoco", "rumoca"];

/// Runs the tests that need the tools.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["python3-venv", "gcc"])?;
    let python = environment(&process::root().join("target/exports/venv"), &PYTHON)?;
    process::run_tests(
        process::cargo()
            .args(["test", "--package", "motorlens", "--test", "export_tools", "--locked"])
            .env("MOTORLENS_EXPORT_PYTHON", python),
    )
}

/// A Python of its own with `modules`, made on first use.
pub fn environment(directory: &Path, modules: &[&str]) -> Result<PathBuf> {
    let python = directory.join("bin/python");
    let imports: String = modules.iter().map(|name| format!("import {name}\n")).collect();
    let ready = Command::new(&python).args(["-c", &imports]).output();
    if !ready.is_ok_and(|output| output.status.success()) {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(directory))?;
        process::run(Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(modules))?;
    }
    Ok(python)
}
