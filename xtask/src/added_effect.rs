//! Adds an effect to a copy of the sources as a newcomer would, by a file and a row, and looks that it is found.

use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::process;

/// The effect's file, and a program that must find it.
const EFFECT: &str = include_str!("added_effect/eddy_brake.rs");
const FINDS: &str = include_str!("added_effect/finds_eddy_brake.rs");

/// The row before the new one, and the new one.
const BEFORE: &str = "    quadratic_drag QuadraticDrag,\n";
const ROW: &str = "    eddy_brake EddyBrake,\n";

/// Adds it, runs the tests that hold for every row, and the program.
pub fn check() -> Result<()> {
    let (root, copy) = (process::root(), process::root().join("target/added-effect"));
    copy_sources(&root, &copy)?;
    let effects = copy.join("shared/src/effects");
    let registry = std::fs::read_to_string(effects.join("mod.rs"))?;
    ensure!(
        registry.contains(BEFORE),
        "the registry has no row {BEFORE:?}: name another in xtask/src/added_effect.rs"
    );
    std::fs::write(effects.join("mod.rs"), registry.replace(BEFORE, &format!("{BEFORE}{ROW}")))?;
    std::fs::write(effects.join("eddy_brake.rs"), EFFECT)?;
    std::fs::write(copy.join("host/examples/finds_eddy_brake.rs"), FINDS)?;
    // Cargo does not tell the crates of two copies of a workspace apart, so they must not share what they build.
    let cargo = || {
        let mut cargo = process::cargo();
        cargo.current_dir(&copy).env("CARGO_TARGET_DIR", root.join("target/added-effect-built"));
        cargo
    };
    process::run(cargo().args(["test", "--locked", "-p", "motorlens-shared", "--lib", "effects"]))?;
    process::run(cargo().args([
        "run",
        "--locked",
        "-p",
        "motorlens",
        "--no-default-features",
        "--example",
        "finds_eddy_brake",
    ]))
}

/// What git knows of, as it stands in the working tree.
fn copy_sources(root: &Path, copy: &Path) -> Result<()> {
    if copy.exists() {
        std::fs::remove_dir_all(copy)?;
    }
    let mut git = std::process::Command::new("git");
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
