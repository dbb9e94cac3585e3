//! The virtual bench: the unmodified image on an emulated STM32F4 with a simulated motor.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Result, ensure};
use clap::Args;

use crate::report::Count;
use crate::{arm, process};

/// How the bench is set up.
#[derive(Args)]
pub struct Options {
    /// Passed on to the bench; `cargo xtask bench -- --help` lists them.
    #[arg(trailing_var_arg = true, allow_hyphen_values = true)]
    arguments: Vec<String>,
}

/// Builds the image and the bench, then serves until interrupted.
pub fn serve(options: &Options) -> Result<()> {
    let image = arm::build_image()?;
    process::run(bench_cargo("run").arg("--").arg("--image").arg(image).args(&options.arguments))
}

/// Runs the bench's own tests on the image, and the host program against it.
pub fn tests() -> Result<Count> {
    let image = arm::build_image()?;
    let program = process::program()?;
    let mut tests = bench_cargo("test");
    for (variable, board) in ["MOTORLENS_NUCLEO", "MOTORLENS_BLACKPILL"].iter().zip(&arm::BOARDS[1..]) {
        tests.env(variable, arm::build_image_for(board)?);
    }
    tests.env("MOTORLENS_IMAGE", image).env("MOTORLENS_PROGRAM", program).env("MOTORLENS_SINES", sines()?);
    process::run_tests(tests.args(["--locked", "--no-fail-fast"]))
}

/// Instructions on the emulated core, by name.
pub fn instructions() -> Result<BTreeMap<String, f64>> {
    let image = arm::build_image()?;
    let told = process::output(
        bench_cargo("run").args(["--quiet", "--bin", "instructions", "--"]).arg(image).arg(sines()?),
    )?;
    let count = |line: &str| {
        let (name, count) = line.rsplit_once(' ')?;
        Some((name.to_owned(), count.parse().ok()?))
    };
    let counts: BTreeMap<_, _> = told.lines().filter_map(count).collect();
    ensure!(!counts.is_empty(), "the bench told no counts: {told}");
    Ok(counts)
}

/// Builds the program that counts what a sine costs on the boards' core, and returns its ELF.
fn sines() -> Result<PathBuf> {
    arm::build_program(arm::CORTEX_M4F, &sines_directory(), "motorlens-cortex-m4f")
}

/// The directory of that program's own workspace.
fn sines_directory() -> PathBuf {
    process::root().join("tests/cortex-m4f")
}

/// A cargo command in the bench's workspace. The emulator declares a newer compiler than it needs.
fn bench_cargo(subcommand: &str) -> Command {
    let mut command = process::cargo();
    command.current_dir(directory()).arg(subcommand).args(["--release", "--ignore-rust-version"]);
    command
}

/// The directory of the bench's own workspace.
fn directory() -> PathBuf {
    process::root().join("tests/bench")
}
