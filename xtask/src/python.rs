//! The Python package: its wheel, in a fresh virtual environment, with its tests.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::report::Count;
use crate::{apt, process};

/// Where the package lives.
fn directory() -> PathBuf {
    process::root().join("python")
}

/// Builds the wheel, installs it with what its tests need where nothing else is installed, and runs them.
pub fn tests() -> Result<Count> {
    apt::ensure_apt(&["python3-venv"])?;
    let made = process::root().join("target/python");
    let wheels = made.join("wheels");
    if wheels.is_dir() {
        std::fs::remove_dir_all(&wheels).context("cannot remove the old wheels")?;
    }
    let fresh = made.join("venv");
    process::run(Command::new("python3").args(["-m", "venv", "--clear"]).arg(&fresh))?;
    let python = fresh.join("bin/python");
    let install = || {
        let mut pip = Command::new(&python);
        pip.args(["-m", "pip", "install", "--quiet"]);
        pip
    };
    process::run(install().args(["maturin>=1.16,<2"]))
        .context("maturin, which builds the wheel, comes from PyPI, and that could not be reached")?;
    let mut maturin = Command::new(&python);
    maturin.args(["-m", "maturin", "build", "--locked", "--out"]).arg(&wheels).current_dir(directory());
    // As the host's own tests were built, so that what both depend on is there already.
    process::run(maturin.env("CARGO_TARGET_DIR", process::target()))?;
    let wheel = std::fs::read_dir(&wheels)?.flatten().next().context("maturin made no wheel")?.path();
    // One wheel for every Python from 3.9 on.
    ensure!(name(&wheel).contains("-abi3-"), "{} is for one Python alone", name(&wheel));
    process::run(install().arg(format!("{}[tables,plots,test]", wheel.display())))?;
    let output = Command::new(&python)
        .args(["-m", "pytest", "--quiet", "-rsfE", "-p", "no:cacheprovider"])
        .current_dir(directory())
        .output()
        .context("cannot start pytest")?;
    let said = String::from_utf8_lossy(&output.stdout);
    println!("{said}{}", String::from_utf8_lossy(&output.stderr));
    let mut count = counted(said.lines().last().unwrap_or_default());
    let why: Vec<&str> = said.lines().filter_map(|line| line.strip_prefix("SKIPPED ")).collect();
    if count.skipped > 0 {
        println!("{} skipped: {}", count.skipped, why.join("; "));
    }
    let failed = said.lines().filter(|line| line.starts_with("FAILED ") || line.starts_with("ERROR "));
    count.failures.extend(failed.map(|line| vec![line.to_owned()]));
    if !output.status.success() {
        count.failed = count.failed.max(1);
    }
    Ok(count)
}

/// The numbers in pytest's closing line, such as "1 failed, 13 passed in 9.41s".
fn counted(line: &str) -> Count {
    let words: Vec<&str> = line.split([' ', ',']).filter(|word| !word.is_empty()).collect();
    let of = |what: &str| {
        words
            .windows(2)
            .find(|pair| pair[1].starts_with(what))
            .and_then(|pair| pair[0].parse().ok())
            .unwrap_or(0)
    };
    Count {
        passed: of("passed"),
        failed: of("failed") + of("error"),
        skipped: of("skipped"),
        ..Count::default()
    }
}

/// A file's name without its directory.
fn name(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn pytests_closing_line_is_counted() {
        let count = counted("1 failed, 13 passed, 2 skipped in 9.41s");
        assert_eq!((count.passed, count.failed, count.skipped), (13, 1, 2));
        assert_eq!(counted("no tests ran in 0.01s").passed, 0);
    }
}
