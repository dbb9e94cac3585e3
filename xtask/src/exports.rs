//! Exported models in the tools that they are for: MuJoCo, a Modelica compiler, FMPy, WPILib's mathematics, a URDF reader, BAM, and the
//! actuators of Isaac Lab.
//!
//! None is in Debian's archive (OpenModelica has one of its own), so all come from Python's registry into a virtual
//! environment; rumoca is the one that compiles and simulates Modelica.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::Result;

use crate::report::Count;
use crate::{apt, process};

/// What is imported, and what to install for it.
const PYTHON: [(&str, &str); 5] = [
    ("mujoco", "mujoco>=4"),
    ("rumoca", "rumoca"),
    ("fmpy", "fmpy"),
    ("wpimath.controller", "robotpy-wpimath"),
    ("yourdfpy", "yourdfpy"),
];

/// Isaac Lab's sources alone: its simulator needs a graphics card, and what it asks for is gigabytes. The package is marked for one version of
/// Python on Linux; its actuators run on others too.
const ISAAC_LAB: [&str; 7] = [
    "--no-deps",
    "--python-version",
    "3.11",
    "--platform",
    "manylinux_2_35_x86_64",
    "--only-binary=:all:",
    "isaaclab==2.3.2",
];

/// Runs the tests that need the tools.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["python3-venv", "gcc", "g++"])?;
    apt::ensure_program("javac", &["default-jdk-headless"])?;
    let home = process::root().join("target/exports/venv");
    let python = environment(&home, &PYTHON)?;
    let there = Command::new(&python).args(["-c", "import bam.simulate"]).output();
    if !there.is_ok_and(|output| output.status.success()) {
        // BAM asks for Python 3.12, and its simulator runs on older ones; what else it asks for talks to servos.
        let words = ["-m", "pip", "install", "--quiet", "--no-deps", "--ignore-requires-python"];
        process::run(Command::new(&python).args(words).args(["better-actuator-models>=1", "colorama"]))?;
    }
    // Where `host/tests/exported/isaac_lab.py` looks for it.
    let lab = home.join("isaaclab");
    if !lab.join("isaaclab").is_dir() {
        let words = ["-m", "pip", "install", "--quiet", "--target"];
        process::run(Command::new(&python).args(words).arg(&lab).args(ISAAC_LAB))?;
    }
    process::run_tests(
        process::cargo()
            .args([
                "test",
                // As the host's own tests were built, so that nothing is compiled again.
                "--workspace",
                "--test",
                "export_tools",
                "--test",
                "export_errors",
                "--locked",
            ])
            .env("MOTORLENS_LONG_TESTS", "1")
            .env("MOTORLENS_EXPORT_PYTHON", python),
    )
}

/// A Python of its own with `modules` (each with its package), made on first use.
pub fn environment(directory: &Path, modules: &[(&str, &str)]) -> Result<PathBuf> {
    let python = directory.join("bin/python");
    let imports: String = modules.iter().map(|(name, _)| format!("import {name}\n")).collect();
    let ready = Command::new(&python).args(["-c", &imports]).output();
    if !ready.is_ok_and(|output| output.status.success()) {
        process::run(Command::new("python3").args(["-m", "venv"]).arg(directory))?;
        process::run(
            Command::new(&python).args(["-m", "pip", "install", "--quiet"]).args(modules.iter().map(|m| m.1)),
        )?;
    }
    Ok(python)
}
