//! Instructions per sample of the host's kernels, counted by callgrind, and of the firmware, counted by the emulator, held
//! against recorded figures.
//!
//! Counts do not depend on what else the machine does, so a slip of a tenth shows on any of them.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::process::Command;

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::{apt, bench, peers, process};

/// A kernel may cost this much more than recorded.
const ALLOWED: f64 = 1.10;
/// Level and kernel, as the counted program calls them.
const KERNELS: [(&str, &str); 5] = [
    ("avx2", "linear"),
    ("avx2", "nonlinear"),
    ("baseline", "linear"),
    ("baseline", "linear-scalar"),
    ("baseline", "nonlinear"),
];

/// Whether to compare or to record.
#[derive(Args, Default)]
pub struct Options {
    /// Write the counts down as the new figures instead of comparing with the old
    #[arg(long)]
    pub record: bool,
    /// Count on the emulated board (docs/board-instructions.json) instead of on the host
    #[arg(long)]
    pub board: bool,
}

/// Counts; fails where something costs more than a tenth over its recorded figure.
pub fn check(options: &Options) -> Result<()> {
    let (file, counts) = if options.board {
        ("docs/board-instructions.json", bench::instructions()?)
    } else {
        ("docs/instructions.json", kernels()?)
    };
    let path = process::root().join(file);
    if options.record {
        let text: Vec<String> = counts.iter().map(|(k, n)| format!("  \"{k}\": {n:.2}")).collect();
        std::fs::write(&path, format!("{{\n{}\n}}\n", text.join(",\n")))?;
        println!("wrote {}", path.display());
        return Ok(());
    }
    let again = if options.board { "--board --record" } else { "--record" };
    let recorded = recorded(&path)?;
    let mut risen = Vec::new();
    for (name, now) in &counts {
        let before = recorded.get(name).with_context(|| {
            format!("{} has no \"{name}\"; run cargo xtask instructions {again}", path.display())
        })?;
        println!("{name:<32} {now:>9.2} instructions, recorded {before:.2}");
        if *now > ALLOWED * before {
            risen.push(format!("{name} from {before:.2} to {now:.2}"));
        }
    }
    if !risen.is_empty() {
        bail!(
            "instructions rose by more than a tenth: {}; find out why, or accept it with \
             cargo xtask instructions {again}",
            risen.join(", ")
        );
    }
    Ok(())
}

/// Instructions per sample of the host's kernels, by name.
fn kernels() -> Result<BTreeMap<String, f64>> {
    apt::ensure_apt(&["valgrind"])?;
    let program = build()?;
    let mut counts = BTreeMap::new();
    for (level, kernel) in KERNELS {
        counts.insert(format!("{level} {kernel}"), count(&program, level, kernel)?);
    }
    Ok(counts)
}

fn build() -> Result<PathBuf> {
    let target = process::root().join("target/instructions");
    process::run(
        process::cargo().current_dir(peers::crate_directory()).env("CARGO_TARGET_DIR", &target).args([
            "build",
            "--release",
            "--no-default-features",
            "--bin",
            "instructions",
        ]),
    )?;
    Ok(target.join("release/instructions"))
}

/// The figures of the file: lines of `"name": number`.
fn recorded(path: &std::path::Path) -> Result<BTreeMap<String, f64>> {
    let text = std::fs::read_to_string(path).with_context(|| format!("cannot read {}", path.display()))?;
    let line = |line: &str| {
        let (name, number) = line.trim().trim_end_matches(',').rsplit_once(':')?;
        Some((name.trim().trim_matches('"').to_owned(), number.trim().parse().ok()?))
    };
    Ok(text.lines().filter_map(line).collect())
}

/// Instructions per sample: what ten more times cost, so that start and end do not count.
fn count(program: &std::path::Path, level: &str, kernel: &str) -> Result<f64> {
    let (few, _) = callgrind(program, level, kernel, 2)?;
    let (many, samples) = callgrind(program, level, kernel, 12)?;
    Ok((many - few) / (10.0 * samples))
}

/// All instructions of a run, and the samples that one time has.
fn callgrind(program: &std::path::Path, level: &str, kernel: &str, times: u32) -> Result<(f64, f64)> {
    let output = Command::new("valgrind")
        .args(["--tool=callgrind", "--callgrind-out-file=/dev/null"])
        .arg(program)
        .args([level, kernel, &times.to_string()])
        .output()
        .context("cannot start valgrind")?;
    let (told, counted) = (String::from_utf8_lossy(&output.stdout), String::from_utf8_lossy(&output.stderr));
    if !output.status.success() {
        bail!("{level} {kernel} under valgrind: {counted}");
    }
    let collected = counted
        .lines()
        .find_map(|line| line.split_once("Collected :"))
        .and_then(|(_, number)| number.trim().parse().ok())
        .with_context(|| format!("valgrind told no count: {counted}"))?;
    let samples = told.trim().parse().with_context(|| format!("no number of samples: {told}"))?;
    Ok((collected, samples))
}
