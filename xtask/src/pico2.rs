//! The Pico 2's unmodified image on an emulated RP2350 (tests/pico2).

use std::path::PathBuf;

use anyhow::Result;

use crate::report::Count;
use crate::{arm, process, uf2};

/// Writes the UF2 file and runs the emulator's own tests on it.
pub fn tests() -> Result<Count> {
    let image = uf2::write(&arm::PICOS[1])?;
    let mut tests = process::cargo();
    tests.current_dir(directory()).env("MOTORLENS_PICO2", image);
    process::run_tests(tests.args(["test", "--release", "--locked", "--no-fail-fast"]))
}

/// The directory of the emulated Pico 2's own workspace.
pub fn directory() -> PathBuf {
    process::root().join("tests/pico2")
}
