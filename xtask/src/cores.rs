//! The library on the boards' other cores, emulated.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::{apt, arm, process};

/// The emulator may take so long, s.
const PATIENCE_S: &str = "600";

/// A Cortex-M0 has no floating-point unit, no divider and little memory; what runs there runs on the Pico's M0+.
pub fn cortex_m0() -> Result<()> {
    run(arm::CORTEX_M0, "microbit")
}

/// The Pico 2's core, by an emulator that knows all its instructions, as that of the whole chip does not ([`crate::pico2`]): the logic of the
/// boards' program plays a run on hardware of memory.
pub fn cortex_m33() -> Result<()> {
    run(arm::CORTEX_M33, "mps2-an505")
}

/// Builds the program for the core of `machine` and runs it; it compares what it does with the host's and fails when a bit differs.
fn run(target: &'static str, machine: &str) -> Result<()> {
    apt::ensure_apt(&["qemu-system-arm"])?;
    let program = arm::build_program(target, &directory(), "motorlens-cores")?;
    let machine = ["qemu-system-arm", "-M", machine, "-nographic", "-monitor", "none", "-serial", "none"];
    process::run(
        Command::new("timeout")
            .arg(PATIENCE_S)
            .args(machine)
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(program),
    )
}

/// The directory of the program's own workspace.
fn directory() -> PathBuf {
    process::root().join("tests/cores")
}
