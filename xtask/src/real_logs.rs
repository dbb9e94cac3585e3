//! `motorlens discover` on published logs of real motors, beside the usual kS-kV-kA fit, as a table.
//!
//! The logs are no part of this project; `--data` names the directory that holds them.

use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use clap::Args;
use serde_json::Value;

use crate::process;

/// Where the logs are.
#[derive(Args)]
pub struct Options {
    /// Directory with undcmotor-jl, micromouse and bam-sts3250 in it
    #[arg(long, default_value = "../shared/data")]
    data: PathBuf,
}

/// A command line: name, logs to learn from, logs kept out, how to read them.
struct Case {
    name: &'static str,
    logs: &'static [&'static str],
    unseen: &'static str,
    reading: &'static [&'static str],
}

const CASES: [Case; 3] = [
    Case {
        name: "undcmotor-jl, PRBS; unseen: steps",
        logs: &["undcmotor-jl/DCmotor_prbs_open_exp.csv"],
        unseen: "undcmotor-jl/DCmotor_step_open_exp.csv",
        reading: &["--map", "time=t,voltage=u,speed=y:deg/s"],
    },
    Case {
        name: "micromouse, left wheel, 3 runs; unseen: a fourth",
        logs: &[
            "micromouse/controllerDelayImpact1ms.csv",
            "micromouse/controllerDelayImpact2ms.csv",
            "micromouse/controllerDelayImpact10ms.csv",
        ],
        unseen: "micromouse/controllerDelayImpact5ms.csv",
        reading: &["--map", "time=time:ms,duty=leftCommand:255,speed=leftSpeed:rpm", "--supply-volts", "7.9"],
    },
    Case {
        name: "bam-sts3250, 3 runs; unseen: a fourth",
        logs: &[
            "bam-sts3250/2024-10-26_12h23m27.json",
            "bam-sts3250/2024-10-26_12h23m42.json",
            "bam-sts3250/2024-10-26_12h24m55.json",
        ],
        unseen: "bam-sts3250/2024-10-26_12h27m27.json",
        reading: &["--format", "bam-json"],
    },
];

/// Runs every case and prints the table.
pub fn print(options: &Options) -> Result<()> {
    ensure!(options.data.is_dir(), "no logs at {}: give --data DIR", options.data.display());
    println!(
        "| log | effects | unseen rmse, kS-kV-kA | linear model | with effects | rivals |\n|---|---|---|---|---|---|"
    );
    for case in &CASES {
        let found = run(case, &options.data, &["discover"])?;
        let usual = run(case, &options.data, &["fit", "--method", "feedforward"])?;
        let ladder = found["ladder"].as_array().context("a ladder")?;
        let unseen =
            |rung: Option<&Value>| rung.and_then(|r| r["validation"]["rmse"].as_f64()).unwrap_or(f64::NAN);
        println!(
            "| {} | {} | {:.4} | {:.4} | {:.4} | {} |",
            case.name,
            words(&found["effects"]),
            unseen(Some(&usual)),
            unseen(ladder.first()),
            unseen(ladder.last()),
            words(&found["rivals"][0])
        );
    }
    Ok(())
}

fn words(list: &Value) -> String {
    let names: Vec<&str> = list.as_array().into_iter().flatten().filter_map(Value::as_str).collect();
    if names.is_empty() { "none".into() } else { names.join(", ") }
}

fn run(case: &Case, data: &Path, verb: &[&str]) -> Result<Value> {
    let mut command = process::cargo();
    command.args(["run", "--quiet", "--release", "--package", "motorlens", "--"]).args(verb);
    command.args(["--json", "--quiet"]).args(case.logs.iter().map(|log| data.join(log)));
    command.arg("--validate").arg(data.join(case.unseen)).args(case.reading);
    let output = command.output().context("cannot run motorlens")?;
    serde_json::from_slice(&output.stdout)
        .with_context(|| format!("{}: {}", case.name, String::from_utf8_lossy(&output.stderr)))
}
