//! Competitors in other languages: they read the records from files and answer in JSON lines.

use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, bail};
use motorlens::search::LinearRecord;
use motorlens_shared::motor::PaperMotor;
use serde_json::json;

use motorlens_peers::peer::{FACTOR, GENERATIONS, POPULATION, Peer};

/// Writes what the others need and returns the file.
pub fn write(directory: &Path, records: &[LinearRecord], centre: &PaperMotor) -> Result<PathBuf> {
    let path = directory.join(format!("records-{}.json", records[0].voltage.len()));
    let voltage: Vec<_> = records.iter().map(|r| &r.voltage).collect();
    let measured: Vec<_> = records.iter().map(|r| &r.measured).collect();
    let document = json!({
        "dt": records[0].dt, "voltage": voltage, "measured": measured,
        "centre": centre.genes(), "gear_ratio": centre.gear_ratio, "factor": FACTOR,
        "population": POPULATION, "generations": GENERATIONS,
    });
    std::fs::write(&path, document.to_string())
        .with_context(|| format!("cannot write {}", path.display()))?;
    Ok(path)
}

/// Runs `program` with `arguments` and takes every line of its output as one competitor.
pub fn run(program: &Path, arguments: &[&str]) -> Result<Vec<Peer>> {
    let output = Command::new(program)
        .args(arguments)
        // One thread for everyone.
        .env("OMP_NUM_THREADS", "1")
        .env("OPENBLAS_NUM_THREADS", "1")
        .output()
        .with_context(|| format!("cannot start {}", program.display()))?;
    if !output.status.success() {
        bail!("{}: {}", program.display(), String::from_utf8_lossy(&output.stderr));
    }
    let text = String::from_utf8(output.stdout)?;
    let lines = text.lines().filter(|line| line.starts_with('{'));
    lines.map(|line| serde_json::from_str(line).with_context(|| line.to_owned())).collect()
}
