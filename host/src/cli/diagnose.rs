//! `diagnose`: which effects a model is missing.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;

use super::discover::{or_bad_data, unit};
use super::input::LogArgs;
use super::{Console, prose, watch};
use crate::diagnose::discover::{Discovery, diagnose};
use crate::error::Result;
use crate::findings::Findings;
use crate::model_file::Model;

/// Options of `diagnose`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens diagnose model.json run1.csv run2.csv -v unseen.csv --json")]
pub struct Args {
    /// The model
    model: PathBuf,
    #[command(flatten)]
    input: LogArgs,
}

/// Refits the model's own parameters, tries every effect on it, tells.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    let model = or_bad_data(Model::read(&args.model), &[], console)?;
    let logs = or_bad_data(args.input.load(), &[], console)?;
    logs.warn(console);
    let bar = watch::bar(console, Kind::ALL.len() as u64, "effects");
    let unit = unit(&logs.records);
    let mut progress = watch::climb(console, &bar, unit);
    let found = diagnose(&model, &logs.records, &logs.validation, &logs.motor, &mut progress);
    bar.finish_and_clear();
    let found = or_bad_data(found, logs.faults(), console)?;
    let findings = Findings::of_diagnosis(&found, model.values().effects.len(), logs.faults());
    console.answer(&findings, || story(&found, &findings, unit));
    if !console.json() {
        console.say(prose::standing(&findings.standing(), Some(&args.model), &args.input.logs));
    }
    Ok(())
}

fn story(found: &Discovery, findings: &Findings, unit: &str) -> String {
    let mut text = String::new();
    for (k, c) in found.candidates.iter().enumerate() {
        let unseen = c
            .validation
            .map_or(String::new(), |v| format!("   validation rmse {} {unit}", prose::figure(v.rmse)));
        text += &format!("{:>2}. {:<20} {:>4.0} %{unseen}\n", k + 1, c.effect.name(), 100.0 * c.score);
        text += &format!("      {}\n      look for: {}\n", c.evidence, c.effect.spec().signature);
    }
    text += match findings.effects.first() {
        Some(_) => "\nThe first is worth adding.\n",
        None => "\nNo effect is worth adding to this model.\n",
    };
    for set in found.open_sets() {
        let names: Vec<&str> = set.iter().map(|k| k.name()).collect();
        text += &format!("These records cannot tell apart: {}.\n", names.join(", "));
    }
    text += &prose::experiments(findings);
    for fault in findings.later_faults() {
        text += &format!("\n{}\n", prose::fault(fault));
    }
    text + &format!("{:.1} s, {} simulations", found.seconds, found.simulations)
}
