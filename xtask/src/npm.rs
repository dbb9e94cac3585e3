//! Packages of npm that a part of the test run needs.

use std::path::Path;
use std::process::Command;

use anyhow::Result;

use crate::{apt, process};

/// Installs what the lock file of `directory` names, on first use.
pub fn ensure_modules(directory: &Path) -> Result<()> {
    if directory.join("node_modules").is_dir() {
        return Ok(());
    }
    apt::ensure_program("npm", &["nodejs", "npm"])?;
    process::run(Command::new("npm").current_dir(directory).args(["ci", "--no-audit", "--no-fund"]))
}
