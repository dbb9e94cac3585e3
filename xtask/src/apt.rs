//! Debian packages that a part of the test run needs.

use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::process;

/// Installs the packages that are not installed yet. Needs Debian (or a relative) and root; otherwise the error says
/// which packages to install by hand.
pub fn ensure_apt(packages: &[&str]) -> Result<()> {
    let missing: Vec<&str> = packages.iter().copied().filter(|package| !installed(package)).collect();
    if missing.is_empty() {
        return Ok(());
    }
    let remedy = || format!("install by hand: apt-get install {}", missing.join(" "));
    println!("installing {}", missing.join(" "));
    // The lists of a fresh machine are empty or old; an update that fails in part may still do.
    let updated = process::run(apt_get().arg("update"));
    let install = process::run(apt_get().args(["install", "-y", "--no-install-recommends"]).args(&missing));
    if let Err(error) = install {
        updated.with_context(remedy)?;
        return Err(error).with_context(remedy);
    }
    for package in &missing {
        if !installed(package) {
            bail!("apt-get left {package} uninstalled; {}", remedy());
        }
    }
    Ok(())
}

/// As [`ensure_apt`] where there is no such program: not everybody's is Debian's.
pub fn ensure_program(program: &str, packages: &[&str]) -> Result<()> {
    if Command::new(program).arg("--version").output().is_ok() { Ok(()) } else { ensure_apt(packages) }
}

fn apt_get() -> Command {
    let mut command = Command::new("apt-get");
    command.arg("-qq").env("DEBIAN_FRONTEND", "noninteractive");
    command
}

fn installed(package: &str) -> bool {
    let query = Command::new("dpkg-query")
        .args(["-W", "-f=${db:Status-Status}", package])
        .stderr(Stdio::null())
        .output();
    query.is_ok_and(|output| output.status.success() && output.stdout == b"installed")
}
