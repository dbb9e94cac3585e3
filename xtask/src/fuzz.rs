//! `cargo xtask fuzz`: coverage-guided fuzzing of all readers of logs and of the link's decoders, by cargo-fuzz and libFuzzer.
//!
//! Takes as long as it is told to and is no part of `cargo xtask test`. Works with stable Rust: no sanitizer is asked for, since the
//! readers hold no unsafe code; a panic, a stack that overflows, an answer that no reader may give, half a minute or more than 1 GiB
//! for one input ends it.

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use anyhow::{Context, Result, bail};
use clap::Args;

use crate::process;

/// How long to fuzz, and what.
#[derive(Args)]
pub struct Options {
    /// Inputs over all readers together
    #[arg(long, default_value_t = 10_000_000)]
    inputs: u64,
    /// Only families of readers whose name contains this
    #[arg(long)]
    only: Option<String>,
    /// Guide by what the readers compare, too; takes twice the time, and the dictionaries have most of it
    #[arg(long)]
    compares: bool,
}

/// A family of readers: the target that feeds it, its words, its share of the inputs, and the longest of them, B.
struct Family {
    name: &'static str,
    target: &'static str,
    words: &'static str,
    share: u64,
    longest: u32,
}

/// Small files are read more often, and a text shows all that it can in a few lines; binary ones are as long as their seeds.
const fn family(name: &'static str, target: &'static str, share: u64) -> Family {
    Family { name, target, words: "files", share, longest: 16_384 }
}

const fn text(name: &'static str, share: u64) -> Family {
    Family { name, target: "text", words: "text", share, longest: 2048 }
}

/// Text is what most logs are.
const FAMILIES: [Family; 10] = [
    text("text", 4),
    text("json", 1),
    family("wpilog", "files", 2),
    family("matlab", "files", 2),
    family("arrays", "files", 2),
    family("parquet", "files", 2),
    family("mcap", "files", 2),
    family("sheets", "files", 1),
    family("packed", "packed", 1),
    // Twice the longest frame.
    Family { name: "link", target: "link", words: "files", share: 2, longest: 1024 },
];

/// The most memory of a target, MiB, and the longest time for one input, s.
const MOST_MEMORY_MIB: u32 = 1024;
const LONGEST_S: u32 = 30;

/// Builds the targets, writes the seeds, runs every family, and prints what was run.
pub fn run(options: &Options) -> Result<()> {
    let installed = process::output(process::cargo().args(["fuzz", "--version"]));
    installed.context("cargo-fuzz is not installed: cargo install cargo-fuzz --locked")?;
    let build = ["fuzz", "build", "--fuzz-dir", "tests/fuzz", "--sanitizer", "none", "--release"];
    let plain = (!options.compares).then_some("--no-trace-compares");
    process::run(process::cargo().args(build).args(plain))?;
    let kept = process::root().join("target/fuzz");
    let seeds = kept.join("seeds");
    process::run(Command::new(program("text")?).env("MOTORLENS_FUZZ_SEEDS", &seeds))?;
    let wanted = |family: &&Family| options.only.as_deref().is_none_or(|only| family.name.contains(only));
    let families: Vec<&Family> = FAMILIES.iter().filter(wanted).collect();
    let shares: u64 = families.iter().map(|family| family.share).sum();
    if shares == 0 {
        bail!("no family is called so; there are {}", FAMILIES.map(|family| family.name).join(", "));
    }
    let (next, results) = (AtomicUsize::new(0), Mutex::new(Vec::new()));
    let workers = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..workers {
            scope.spawn(|| {
                while let Some(family) = families.get(next.fetch_add(1, Ordering::Relaxed)) {
                    let runs = (options.inputs * family.share).div_ceil(shares);
                    let result = fuzz(family, runs, &kept, &seeds);
                    match &result {
                        Ok(count) => println!("{:<8} {count:>10} inputs, none of them a fault", family.name),
                        Err(error) => println!("{:<8} {error:#}", family.name),
                    }
                    if let Ok(mut results) = results.lock() {
                        results.push(result);
                    }
                }
            });
        }
    });
    let results = results.into_inner().unwrap_or_default();
    let faults = results.iter().filter(|result| result.is_err()).count();
    println!("{} inputs in all", results.iter().flatten().sum::<u64>());
    if faults > 0 {
        bail!("{faults} families have an input that ends the reader");
    }
    Ok(())
}

/// Runs `runs` inputs of a family and returns how many there were.
fn fuzz(family: &Family, runs: u64, kept: &Path, seeds: &Path) -> Result<u64> {
    let (corpus, failed) = (kept.join("corpus").join(family.name), kept.join("failed").join(family.name));
    std::fs::create_dir_all(&corpus)?;
    std::fs::create_dir_all(&failed)?;
    let program = program(family.target)?;
    let output = Command::new(&program)
        .arg(format!("-runs={runs}"))
        .arg(format!("-rss_limit_mb={MOST_MEMORY_MIB}"))
        .arg(format!("-timeout={LONGEST_S}"))
        .arg(format!(
            "-dict={}",
            process::root().join(format!("tests/fuzz/words/{}.dict", family.words)).display()
        ))
        .arg(format!("-artifact_prefix={}/", failed.display()))
        .arg(format!("-max_len={}", family.longest))
        .args(["-print_final_stats=1", "-verbosity=0"])
        .arg(&corpus)
        .arg(seeds.join(family.name))
        .stdin(Stdio::null())
        .output()
        .with_context(|| format!("cannot start {}", program.display()))?;
    let told = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        let lines: Vec<&str> = told.lines().collect();
        let end = lines[lines.len().saturating_sub(30)..].join("\n");
        bail!(
            "{}; read it again with {} INPUT, the last of {}\n{end}",
            output.status,
            program.display(),
            failed.display()
        );
    }
    let count = told.lines().find_map(|line| line.strip_prefix("stat::number_of_executed_units:"));
    count.and_then(|count| count.trim().parse().ok()).context("libFuzzer does not say how many inputs it ran")
}

/// Where cargo-fuzz puts a target.
fn program(name: &str) -> Result<PathBuf> {
    let version = process::output(Command::new("rustc").arg("-vV"))?;
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).context("rustc tells no host")?;
    Ok(directory().join("target").join(host).join("release").join(name))
}

/// Where the targets live: a workspace of its own.
fn directory() -> PathBuf {
    process::root().join("tests/fuzz")
}
