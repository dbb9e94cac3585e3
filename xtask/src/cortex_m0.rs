//! The library on a core without a floating-point unit, emulated.

use std::path::PathBuf;
use std::process::Command;

use anyhow::Result;

use crate::{apt, arm, process};

/// The emulator may take so long, s.
const PATIENCE_S: &str = "600";

/// Builds the program for the Cortex-M0 and runs it; it compares its fits with the host's and fails when a bit differs.
pub fn run() -> Result<()> {
    apt::ensure_apt(&["qemu-system-arm"])?;
    let program = arm::build_program(arm::CORTEX_M0, &directory(), "motorlens-cortex-m0")?;
    let machine = ["qemu-system-arm", "-M", "microbit", "-nographic", "-monitor", "none", "-serial", "none"];
    process::run(
        Command::new("timeout")
            .arg(PATIENCE_S)
            .args(machine)
            .args(["-semihosting-config", "enable=on,target=native", "-kernel"])
            .arg(program),
    )
}

/// The directory of the program's own workspace.
pub fn directory() -> PathBuf {
    process::root().join("tests/cortex-m0")
}
