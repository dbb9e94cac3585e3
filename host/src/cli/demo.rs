//! `demo`: the whole loop on a motor with a hidden effect.

use std::path::PathBuf;

use clap::{Args as _, FromArgMatches};
use serde::Serialize;

use super::discover::{self, search};
use super::input::Logs;
use super::{Console, next, prose};
use crate::compare::failure_map;
use crate::compare::free_run::free_runs;
use crate::diagnose::discover::Options;
use crate::error::{Error, Result};
use crate::estimate;
use crate::findings::Findings;
use crate::formula::Library;
use crate::log::{self, ReadArgs};
use crate::report::{self, Story};
use crate::simulate::{self, RevealArgs, SimulateArgs};

/// Options of `demo`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens demo -o demo")]
pub struct Args {
    /// Which hidden effects: any number
    #[arg(long, value_name = "SEED", default_value_t = Args::default().hidden)]
    hidden: u64,
    /// Directory for logs, model and report
    #[arg(short, long, value_name = "DIR", default_value = "motorlens-demo")]
    out: PathBuf,
}

impl Default for Args {
    fn default() -> Self {
        Self { hidden: simulate::DEMO, out: "motorlens-demo".into() }
    }
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    truth: &'a [String],
    found: &'a Findings,
    model: PathBuf,
    report: PathBuf,
}

/// Simulates, fits, compares, discovers, reveals, and writes the report.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    console.say(format!(
        "1. A virtual motor with an effect picked by {}; logs go to {}.",
        args.hidden,
        args.out.display()
    ));
    let simulated = simulate::run(&simulation(args)?)?;
    let reading = ReadArgs { motor: Some(simulated.motor.clone()), ..ReadArgs::default() };
    let training = [simulated.training.as_slice(), &simulated.repeats].concat();
    let logs = Logs::new(
        log::load(&training, &reading)?.records,
        log::load(&simulated.held_out, &reading)?.records,
        reading.motor_file()?,
    );

    let (problem, base) = estimate::prepare(&logs.records, &logs.motor)?;
    let map = failure_map(&free_runs(&problem, &base), &problem.rig);
    console.say("2. The textbook model is fitted. Its error is made here:");
    let telling = map.slices.iter().filter(|slice| slice.reading != "evenly spread");
    let rows: Vec<(&str, &str)> = telling.map(|slice| (slice.title, slice.reading.as_str())).collect();
    if !rows.is_empty() {
        console.say(prose::beside(&rows));
    }

    console.say("3. Every effect is tried on it; what held-out data confirm is added:");
    let options = Options { library: library.kinds().to_vec(), ..Options::default() };
    let (found, findings) = search(&logs, &options, console)?;
    console.say(prose::headed(&findings.standing(), &discover::story(&found, &findings, &logs.records)));
    let model = args.out.join("model.json");
    found.model.write(&model)?;

    let answer = simulate::reveal(&RevealArgs { directory: args.out.clone() })?;
    console.say(format!("\n4. What was hidden: {}", prose::effects(&answer.sizes)));
    let right = answer.effects.len() == found.effects.len()
        && found.effects.iter().all(|k| answer.effects.iter().any(|name| name == k.name()));
    console.say(if right { "   Found right." } else { "   Not what was found." });
    let report = args.out.join("report.html");
    let mut story = Story::of(&found, &findings, &logs.records);
    story.standing.next.command = next::commands(&story.standing.next, Some(&model), &training).join("\n");
    report::write(&story, &report)?;
    let document =
        Document { schema: 1, truth: &answer.effects, found: &findings, model, report: report.clone() };
    console.answer(&document, || {
        let next = next::told(&findings.next_step, Some(&document.model), &training);
        format!("report: {}\n(or see it live: motorlens serve)\n{next}", report.display())
    });
    Ok(())
}

fn simulation(args: &Args) -> Result<SimulateArgs> {
    let command = SimulateArgs::augment_args(clap::Command::new("simulate"));
    let (out, hidden) = (args.out.clone().into_os_string(), args.hidden.to_string().into());
    let words = ["simulate".into(), "--out".into(), out, "--hidden".into(), hidden];
    command
        .try_get_matches_from(words)
        .and_then(|m| SimulateArgs::from_arg_matches(&m))
        .map_err(|e| Error::usage(e.to_string(), "see motorlens demo --help"))
}
