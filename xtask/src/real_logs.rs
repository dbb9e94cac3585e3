//! `motorlens discover` on published logs of real motors, beside the usual kS-kV-kA fit, as tables.
//!
//! The logs are no part of this project; `--data` names the directory that holds them. Records kept out are kept out of everything:
//! each model is fitted and written first, and then run over them by `motorlens compare`, so that all errors are measured alike.

mod cases;

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde_json::Value;

use crate::process;
use cases::{CASES, Case};

/// Where the logs are, and with what to read them.
#[derive(Args)]
pub struct Options {
    /// Directory with emps, undcmotor-jl, micromouse ... in it
    #[arg(long, default_value = "../shared/data")]
    data: PathBuf,
    /// A built motorlens; built from this checkout if absent
    #[arg(long)]
    program: Option<PathBuf>,
    /// Only rigs whose name contains this
    #[arg(long, default_value = "")]
    only: String,
}

/// What came out for a rig.
struct Row {
    case: &'static Case,
    found: Value,
    unseen: f64,
    unit: String,
    usual: Result<f64>,
    seconds: f64,
}

/// Runs every rig and prints the tables.
pub fn print(options: &Options) -> Result<()> {
    ensure!(options.data.is_dir(), "no logs at {}: give --data DIR", options.data.display());
    let program = match &options.program {
        Some(program) => program.clone(),
        None => {
            process::run(process::cargo().args(["build", "--quiet", "--release", "--package", "motorlens"]))?;
            process::root().join("target/release/motorlens")
        }
    };
    let scratch = std::env::temp_dir().join(format!("motorlens-real-logs-{}", std::process::id()));
    std::fs::create_dir_all(&scratch).with_context(|| format!("cannot make {}", scratch.display()))?;
    let asked = || CASES.iter().filter(|case| case.name.contains(&options.only));
    for case in asked().filter(|case| !options.data.join(case.folder).is_dir()) {
        eprintln!("left out: no {} in {}", case.folder, options.data.display());
    }
    let here = asked().filter(|case| options.data.join(case.folder).is_dir());
    let rows: Result<Vec<Row>> = here.map(|case| row(case, &options.data, &program, &scratch)).collect();
    // Nothing there is worth a failure.
    let _ = std::fs::remove_dir_all(&scratch);
    let rows = rows?;
    ensure!(!rows.is_empty(), "no rig of that name in {}", options.data.display());
    print!("{}\n{}\n{}", errors(&rows), ratios(&rows), parameters(&rows));
    Ok(())
}

fn row(case: &'static Case, data: &Path, program: &Path, scratch: &Path) -> Result<Row> {
    eprintln!("{} ...", case.name);
    let model = scratch.join(format!("{}.json", case.name.replace([' ', ','], "-")));
    let begun = Instant::now();
    let found = learn(case, data, program, &["discover"], &model)?;
    let seconds = begun.elapsed().as_secs_f64();
    let (unseen, unit) = judge(case, data, program, &model)?;
    let usual = learn(case, data, program, &["fit", "--method", "feedforward"], &model)
        .and_then(|_| Ok(judge(case, data, program, &model)?.0));
    Ok(Row { case, found, unseen, unit, usual, seconds })
}

/// Fits with `verb` and writes the model.
fn learn(case: &Case, data: &Path, program: &Path, verb: &[&str], model: &Path) -> Result<Value> {
    let mut command = Command::new(program);
    command.args(verb).arg("--out").arg(model);
    command.args(case.train.iter().map(|log| data.join(case.folder).join(log)));
    answer(case, data, command)
}

/// Runs the model over the records kept out: its error, and the unit.
fn judge(case: &Case, data: &Path, program: &Path, model: &Path) -> Result<(f64, String)> {
    let mut command = Command::new(program);
    command.arg("compare").arg(model);
    command.args(case.unseen.iter().map(|log| data.join(case.folder).join(log)));
    let compared = answer(case, data, command)?;
    let error = compared["pooled"]["rmse"].as_f64().context("compare told no pooled.rmse")?;
    Ok((error, compared["unit"].as_str().unwrap_or("").to_owned()))
}

fn answer(case: &Case, data: &Path, mut command: Command) -> Result<Value> {
    command.args(["--json", "--quiet"]).args(case.reading);
    let motor = data.join(case.folder).join("motor.toml");
    if motor.is_file() {
        command.arg("--motor").arg(motor);
    }
    let output = command.output().context("cannot run motorlens")?;
    let told = || String::from_utf8_lossy(&output.stderr).trim().to_owned();
    ensure!(output.status.success(), "{}: {}", case.name, told());
    serde_json::from_slice(&output.stdout).with_context(|| format!("{}: {}", case.name, told()))
}

fn words(list: &Value) -> Vec<&str> {
    list.as_array().into_iter().flatten().filter_map(Value::as_str).collect()
}

impl Row {
    fn ratio(&self) -> Option<f64> {
        self.usual.as_ref().ok().map(|usual| self.unseen / usual)
    }

    /// Of each thing that the owners know one name is accepted, or a rival of what is.
    fn as_owners_know(&self) -> bool {
        let rivals = self.found["rivals"].as_array().into_iter().flatten().flat_map(words);
        let named: Vec<&str> = words(&self.found["effects"]).into_iter().chain(rivals).collect();
        self.case.knows.iter().all(|names| names.iter().any(|name| named.contains(name)))
    }

    /// A number in the unit that people use for this rig.
    fn error(&self, value: f64) -> String {
        if self.case.metres { format!("{:.2} mm", 1e3 * value) } else { format!("{value:.4} {}", self.unit) }
    }
}

fn errors(rows: &[Row]) -> String {
    let mut text = String::from(
        "| rig | owners know | found | rivals | verdict | unseen rmse | kS-kV-kA | ratio | s |\n|---|---|---|---|---|---|---|---|---|\n",
    );
    for row in rows {
        let found = words(&row.found["effects"]);
        let sets: Vec<String> =
            row.found["rivals"].as_array().into_iter().flatten().map(|set| words(set).join(" or ")).collect();
        text += &format!(
            "| {} | {} ({}) | {} | {} | {} | {} | {} | {} | {:.1} |\n",
            row.case.name,
            row.case.owners,
            if row.as_owners_know() { "found" } else { "not found" },
            if found.is_empty() { "none".into() } else { found.join(", ") },
            sets.join("; "),
            row.found["verdict"].as_str().unwrap_or("?"),
            row.error(row.unseen),
            row.usual.as_ref().map_or_else(|e| format!("refused: {e}"), |usual| row.error(*usual)),
            row.ratio().map_or("-".into(), |ratio| format!("{ratio:.2}")),
            row.seconds,
        );
    }
    text
}

fn ratios(rows: &[Row]) -> String {
    let known: Vec<f64> = rows.iter().filter_map(Row::ratio).collect();
    let mean = (known.iter().map(|r| r.ln()).sum::<f64>() / known.len() as f64).exp();
    let worst = known.iter().copied().fold(f64::NAN, f64::max);
    let as_known = rows.iter().filter(|row| row.as_owners_know()).count();
    format!(
        "Unseen error over kS-kV-kA's: geometric mean {mean:.3}, worst {worst:.2}, of {} rigs. As their owners know them: {as_known} of {}.\n",
        known.len(),
        rows.len()
    )
}

/// Parameters beside those that owners or papers give.
fn parameters(rows: &[Row]) -> String {
    let mut text =
        String::from("| rig | parameter | found | interval | owners say |\n|---|---|---|---|---|\n");
    for row in rows {
        let all = ["parameters", "combinations"]
            .map(|list| row.found[list].as_array().cloned().unwrap_or_default());
        for (name, owners) in row.case.figures {
            let of = |p: &&Value| p["name"].as_str() == Some(name);
            let value = all.iter().flatten().find(of);
            let number = |p: &Value, key: &str| p[key].as_f64().map_or("?".into(), |x| format!("{x:.4}"));
            let (found, interval) = match value {
                Some(p) => (
                    format!("{} {}", number(p, "value"), p["unit"].as_str().unwrap_or("")),
                    format!("{} .. {}", number(p, "low"), number(p, "high")),
                ),
                None => ("not in the model".into(), String::new()),
            };
            text += &format!("| {} | {name} | {found} | {interval} | {owners} |\n", row.case.name);
        }
    }
    text
}
