//! `plan`: the excitation that would tell rivals apart.

use std::path::PathBuf;

use serde::Serialize;

use super::diagnose::diagnosed;
use super::discover::{or_bad_data, search};
use super::input::LogArgs;
use super::{Console, next};
use crate::atomic_file;
use crate::diagnose::discover::Options;
use crate::diagnose::plan::{Limits, SECONDS};
use crate::error::Result;
use crate::findings::{Action, Experiment, Findings, NextExperiment, NextStep, Verdict};
use crate::formula::Library;
use crate::sentence::capital;

/// Options of `plan`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens plan run1.csv run2.csv -m motor.toml -o next.json
  motorlens plan model.json run1.csv run2.csv -o next.json")]
pub struct Args {
    #[command(flatten)]
    input: LogArgs,
    /// Highest voltage that may be played, V (what the logs reached, if not given)
    #[arg(long, value_name = "VOLTS")]
    volts: Option<f64>,
    /// Longest programme, s
    #[arg(long, value_name = "SECONDS", default_value_t = SECONDS)]
    seconds: f64,
    /// Write the programme here, for motorlens capture --programme
    #[arg(short, long, value_name = "PROGRAMME.json")]
    out: Option<PathBuf>,
}

/// The answer in JSON.
#[derive(Debug, Serialize)]
struct Answer {
    schema: u32,
    rivals: Vec<Vec<motorlens_shared::effects::Kind>>,
    next_experiment: Option<NextExperiment>,
    #[serde(skip_serializing_if = "Option::is_none")]
    no_experiment: Option<String>,
}

/// Diagnoses the logs, from a model where one stands before them, and chooses the programme.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    let (model, input) = args.input.after_model();
    let of_model = model.as_ref().map_or_else(Vec::new, |model| model.values().kinds());
    let logs = or_bad_data(input.load(&library.and_those_of(&of_model)), &[], console)?;
    let found = match &model {
        Some(model) => diagnosed(model, &logs, library, console),
        // The experiment is that of the diagnosis that proposed it.
        None => {
            let options = Options { library: library.kinds().to_vec(), ..Options::default() };
            search(&logs, &options, console)
        }
    };
    let (found, findings) = or_bad_data(found, logs.faults(), console)?;
    let volts = args.volts.unwrap_or_else(|| found.evidence.highest_voltage());
    let Experiment { next, none } = found.experiment(Limits { volts, seconds: args.seconds });
    let answer = Answer { schema: 1, rivals: found.open_sets(), next_experiment: next, no_experiment: none };
    if let (Some(path), Some(next)) = (&args.out, &answer.next_experiment) {
        let text = serde_json::to_string_pretty(&next.programme).unwrap_or_default();
        atomic_file::write(path, text + "\n")?;
    }
    console.answer(&answer, || story(&answer, &findings));
    if answer.next_experiment.is_some() {
        let file = args.out.as_deref().map_or_else(|| "programme.json".to_owned(), next::shell);
        if args.out.is_some() {
            let play = format!("--programme {file} --counts-per-rev COUNTS --out next");
            console.next("run it on the motor", &format!("motorlens capture --port PORT {play}"));
        } else if !console.json() {
            let write = NextStep {
                label: "write it down for the board".into(),
                ..NextStep::new(Action::Experiment, None)
            };
            console.say(next::told(&write, None, &args.input.logs));
        }
    } else if !console.json() {
        let first = args.input.logs.first().filter(|_| model.is_some());
        console.say(next::told(&findings.next_step, first.map(PathBuf::as_path), &input.logs));
    }
    Ok(())
}

fn story(answer: &Answer, findings: &Findings) -> String {
    let none = answer.no_experiment.as_ref().map_or_else(String::new, |why| format!("{}.\n", capital(why)));
    match &answer.next_experiment {
        Some(next) => {
            let programme = serde_json::to_string_pretty(&next.programme).unwrap_or_default();
            format!("{none}{}\n{programme}\nDiagnose again with the old logs and the new one.", next.why)
        }
        None => {
            let left = match findings.verdict {
                Verdict::Explained => "",
                _ => {
                    " Much is left all the same: another excitation, data problems or physics outside the library may be behind it."
                }
            };
            let alike = if none.is_empty() {
                "No two models are left that an experiment could tell apart."
            } else {
                none.trim_end()
            };
            format!("{} {alike}{left}", findings.standing().headline)
        }
    }
}
