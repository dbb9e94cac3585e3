//! `diagnose`: which effects a model is missing.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;

use super::discover::{or_bad_data, unit};
use super::input::{LogArgs, Logs};
use super::{Console, next, prose, watch};
use crate::diagnose::discover::{Discovery, diagnose};
use crate::diagnose::ladder::Ranked;
use crate::error::Result;
use crate::findings::{Action, Findings};
use crate::formula::Library;
use crate::model_file::Model;
use crate::report::Suspect;
use crate::report::missing::{self, Setting};
use crate::sentence::capital;

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
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    let model = or_bad_data(Model::read(&args.model), &[], console)?;
    let known = library.and_those_of(&model.values().kinds());
    let logs = or_bad_data(args.input.load(&known), &[], console)?;
    let diagnosis = diagnosed(&model, &logs, library, console);
    let (found, findings) = or_bad_data(diagnosis, logs.faults(), console)?;
    let mut standing = findings.standing();
    if standing.next.action == Action::Experiment {
        standing.next.command = "motorlens plan MODEL LOG... --out programme.json".into();
    }
    let unit = unit(&logs.records);
    console.answer(&findings, || prose::headed(&standing, &story(&found, &findings, unit)));
    if !console.json() {
        console.say(next::steps(&standing, Some(&args.model), &args.input.logs));
    }
    Ok(())
}

/// What of `library` the `model` is missing on `logs`, watched.
pub fn diagnosed(
    model: &Model,
    logs: &Logs,
    library: &Library,
    console: &Console,
) -> Result<(Discovery, Findings)> {
    logs.warn(console);
    let bar = watch::bar(console, library.kinds().len() as u64, "effects");
    let mut progress = watch::climb(console, &bar, unit(&logs.records));
    let kinds = library.kinds();
    let found = diagnose(model, &logs.records, &logs.validation, &logs.motor, kinds, &mut progress);
    bar.finish_and_clear();
    let found = found?;
    let findings = Findings::of_diagnosis(&found, model.values().effects.len(), logs.faults());
    let findings = findings.supposing(&logs.records, &logs.motor, &found.evidence.whole.rig);
    Ok((found, findings))
}

/// The candidates as a table, best first: those that the records cannot tell apart share a place.
fn ranking(candidates: &[Ranked], rivals: &[Vec<Kind>], unit: &str) -> String {
    let suspects: Vec<Suspect> =
        candidates.iter().map(|c| Suspect { ranked: c.clone(), figures: Vec::new() }).collect();
    let (cards, _) = missing::cards(&suspects, &Setting { rivals, in_model: Vec::new() });
    let judged = candidates.iter().any(|c| c.validation.is_some());
    let mut text = format!("rank  {:<20} {:>5}", "effect", "gain");
    text += &if judged { format!("   validation rmse, {unit}\n") } else { "\n".to_owned() };
    for card in &cards {
        text += &format!("{:>4}  {:<20} {:>3.0} %", card.rank, card.effect, card.gain_percent);
        let own = candidates.iter().find(|c| c.effect.name() == card.effect);
        let unseen = own.and_then(|c| c.validation);
        text += &unseen.map_or_else(String::new, |v| format!("   {:>10}", prose::figure(v.rmse)));
        text += "\n";
    }
    for set in rivals {
        let names: Vec<&str> = set.iter().map(|k| k.name()).collect();
        text += &format!("These records cannot tell apart: {}.\n", names.join(", "));
    }
    text
}

fn story(found: &Discovery, findings: &Findings, unit: &str) -> String {
    let mut text = ranking(&findings.candidates, &findings.rivals, unit);
    if let Some(best) = findings.candidates.first() {
        text += &format!("\n{}.\n", capital(&best.evidence));
        text += &format!("Look for: {}.\n", best.effect.spec().signature);
    }
    text += &match findings.effects.first() {
        Some(effect) => format!("\n{} is worth adding.\n", capital(effect.name())),
        None => "\nNo effect is worth adding to this model.\n".to_owned(),
    };
    text += &prose::experiments(findings);
    text += &prose::shown_by_the_fit(findings);
    text + &format!("{:.1} s, {} simulations", found.seconds, found.simulations)
}
