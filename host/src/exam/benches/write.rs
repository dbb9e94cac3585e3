//! Cases as folders, so that any build can be run on them: logs, motor file, truth.

use std::fmt::Write as _;
use std::path::Path;

use serde_json::json;

use super::trial::{Paper, group_name};
use super::{case, record};
use crate::atomic_file;
use crate::error::{Error, Result};
use crate::log::write_canonical;
use motorlens_bench_motor::{Case, Known, Log};

/// Writes every case of `paper` to `directory/BENCH-SEED/` with `train/`, `validation/`, `motor.toml` and `truth.json`.
///
/// # Errors
/// The machine's refusal, naming the path.
pub fn write_cases(paper: &Paper, directory: &Path, each: &mut dyn FnMut()) -> Result<()> {
    for (bench, seed) in paper.questions() {
        let case = case(bench, seed);
        let folder = directory.join(format!("{}-{seed}", bench.name()));
        write_logs(&case.training, &folder.join("train"))?;
        write_logs(&case.held_out, &folder.join("validation"))?;
        atomic_file::write(&folder.join("motor.toml"), motor_toml(&case.known))?;
        let text = serde_json::to_string_pretty(&truth(&case)).unwrap_or_default();
        atomic_file::write(&folder.join("truth.json"), text)?;
        each();
    }
    Ok(())
}

fn write_logs(logs: &[Log], folder: &Path) -> Result<()> {
    let made = std::fs::create_dir_all(folder);
    made.map_err(|source| Error::Io { doing: format!("cannot make {}", folder.display()), source })?;
    for (k, log) in logs.iter().enumerate() {
        let name = format!("{}-{}.csv", k + 1, log.name.replace(' ', "-"));
        write_canonical(&record(log), &folder.join(name))?;
    }
    Ok(())
}

fn motor_toml(known: &Known) -> String {
    let mut text = String::new();
    let mut line = |key: &str, value: Option<f64>| {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {value}");
        }
    };
    line("gear_ratio", known.gear_ratio);
    line("counts_per_rev", known.counts_per_rev);
    if let Some(output) = known.encoder_on_output {
        let _ = writeln!(text, "encoder_shaft = \"{}\"", if output { "output" } else { "motor" });
    }
    text += "[nameplate]\n";
    let mut line = |key: &str, value: Option<f64>| {
        if let Some(value) = value {
            let _ = writeln!(text, "{key} = {value}");
        }
    };
    line("voltage_v", known.voltage_v);
    line("no_load_speed_rad_s", known.no_load_speed_rad_s);
    line("stall_current_a", known.stall_current_a);
    line("resistance_ohm", known.resistance_ohm);
    text
}

fn truth(case: &Case) -> serde_json::Value {
    let hidden = case
        .hidden
        .iter()
        .map(|h| json!({ "effect": h.name, "size": h.size, "visibility": h.visibility, "asked": h.asked }));
    json!({
        "schema": 1,
        "bench": case.bench.name(),
        "seed": case.seed,
        "group": group_name(case.group),
        "hidden": hidden.collect::<Vec<_>>(),
        "disturbance": case.disturbance,
        "conditions": case.conditions,
    })
}
