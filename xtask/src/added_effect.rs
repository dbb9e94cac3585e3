//! Adds an effect to a copy of the sources as a newcomer would, by a file and a row, and looks that it is found.

use std::path::Path;
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::process;

/// The effect's file, and a program that must find it.
const EFFECT: &str = include_str!("added_effect/eddy_brake.rs");
const FINDS: &str = include_str!("added_effect/finds_eddy_brake.rs");

/// The row before the new one, and the new one.
const BEFORE: &str = "    quadratic_drag QuadraticDrag,\n";
const ROW: &str = "    eddy_brake EddyBrake,\n";

/// The version of the sources, and that of the copy: cargo tells the crates of two workspaces apart by it, so that both may share what else
/// they build.
const VERSION: &str = concat!("version = \"", env!("CARGO_PKG_VERSION"), "\"\n");
const ADDED: &str = concat!("version = \"", env!("CARGO_PKG_VERSION"), "-added\"\n");

/// Adds it, runs the tests that hold for every row, and the program.
pub fn check() -> Result<()> {
    let (root, copy) = (process::root(), process::root().join("target/added-effect"));
    copy_sources(&root, &copy)?;
    let effects = copy.join("shared/src/effects");
    replace(&effects.join("mod.rs"), BEFORE, &format!("{BEFORE}{ROW}"))?;
    replace(&copy.join("Cargo.toml"), VERSION, ADDED)?;
    std::fs::write(effects.join("eddy_brake.rs"), EFFECT)?;
    std::fs::write(copy.join("host/examples/finds_eddy_brake.rs"), FINDS)?;
    let cargo = || {
        let mut cargo = process::cargo();
        cargo.current_dir(&copy).env("CARGO_TARGET_DIR", process::target());
        cargo
    };
    // Offline, not locked: the lock file still has the version of before.
    process::run(cargo().args(["test", "--offline", "-p", "motorlens-shared", "--lib", "effects"]))?;
    // With the features that `cargo test --workspace` chooses, so that what it built is used again.
    // The library's inner loop is a crate of its own; the rest need not be fast here.
    let quick = ["--config", "profile.dev.package.motorlens.opt-level=1"];
    process::run(
        cargo().args(["build", "--offline", "--workspace", "--example", "finds_eddy_brake"]).args(quick),
    )?;
    process::run(&mut Command::new(process::target().join("debug/examples/finds_eddy_brake")))
}

/// Writes `after` in the place of `before` in a file.
fn replace(file: &Path, before: &str, after: &str) -> Result<()> {
    let text = std::fs::read_to_string(file)?;
    ensure!(
        text.contains(before),
        "{} has no line {before:?}: say another in xtask/src/added_effect.rs",
        file.display()
    );
    Ok(std::fs::write(file, text.replacen(before, after, 1))?)
}

/// What git knows of, as it stands in the working tree.
fn copy_sources(root: &Path, copy: &Path) -> Result<()> {
    if copy.exists() {
        std::fs::remove_dir_all(copy)?;
    }
    let mut git = Command::new("git");
    let listed = process::output(git.current_dir(root).args([
        "ls-files",
        "-z",
        "--cached",
        "--others",
        "--exclude-standard",
    ]))?;
    for name in listed.split('\0').filter(|name| !name.is_empty() && root.join(name).is_file()) {
        let to = copy.join(name);
        std::fs::create_dir_all(to.parent().context("a file stands in a directory")?)?;
        std::fs::copy(root.join(name), to)?;
    }
    Ok(())
}
