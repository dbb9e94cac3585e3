//! `add`: one effect more, and whether it is worth it.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::discover::unit;
use super::input::LogArgs;
use super::{Console, prose};
use crate::atomic_file;
use crate::error::Result;
use crate::estimate::{Addition, add, effect_by_name};
use crate::estimate::{Errors, Moved};
use crate::findings::{Action, NextStep};
use crate::fit::uncertainty::Estimate;
use crate::model_file::Model;

/// Options of `add`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens add model.json coulomb run1.csv run2.csv -v unseen.csv -o better.json")]
pub struct Args {
    /// The model to extend
    model: PathBuf,
    /// The effect to add (motorlens effects lists them)
    effect: String,
    #[command(flatten)]
    input: LogArgs,
    /// Write the new model here; without it the old one stays as it is
    #[arg(short, long, value_name = "MODEL.json")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    effect: Kind,
    worth_adding: bool,
    why: &'a str,
    effects: Vec<Kind>,
    given: &'a Errors,
    before: &'a Errors,
    after: &'a Errors,
    moved: &'a [Moved],
    parameters: &'a [Estimate],
}

/// Adds, writes, tells.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    args.out.as_deref().map_or(Ok(()), atomic_file::may_write)?;
    let effect = effect_by_name(&args.effect)?;
    let model = Model::read(&args.model)?;
    let logs = args.input.load()?;
    logs.warn(console);
    let done = add(&model, effect, &logs.records, &logs.validation, &logs.motor)?;
    if let Some(path) = &args.out {
        done.model.write(path)?;
    }
    let document = Document {
        schema: 1,
        effect,
        worth_adding: done.worth,
        why: &done.why,
        effects: done.model.values().kinds(),
        given: &done.given,
        before: &done.before,
        after: &done.after,
        moved: &done.moved,
        parameters: &done.parameters,
    };
    console.answer(&document, || story(&done, unit(&logs.records)));
    if let Some(path) = &args.out {
        console.say(format!("model: {}", path.display()));
    }
    if !console.json() {
        // What is not worth adding is not built upon: the model that was there is.
        let base = args.out.as_ref().filter(|_| done.worth).unwrap_or(&args.model);
        let next = NextStep::new(Action::Diagnose, None);
        console.say(prose::next(&next, Some(base), &args.input.logs));
    }
    Ok(())
}

fn story(done: &Addition, unit: &str) -> String {
    let mut text = verdict(done) + "\n";
    for (name, errors) in
        [("given", &done.given), ("refitted without it", &done.before), ("with it", &done.after)]
    {
        text += &format!("{}\n", prose::measures(name, &errors.train, unit));
        if let Some(m) = &errors.validation {
            text += &format!("{}\n", prose::measures("  on validation records", m, unit));
        }
    }
    text += &format!("\n{}\n\n", done.why);
    for m in &done.moved {
        text += &format!(
            "{:<28} {:>11} -> {:<11} {}\n",
            m.name,
            prose::figure(m.before),
            prose::figure(m.after),
            m.unit
        );
    }
    let new = &done.parameters[done.moved.len()..];
    text + &prose::parameters(new)
}

/// Whether it is worth it, and a rise called a rise.
fn verdict(done: &Addition) -> String {
    let error = |errors: &Errors| errors.validation.unwrap_or(errors.train).rmse;
    let (before, after) = (error(&done.before), error(&done.after));
    let on = if done.after.validation.is_some() { "validation records" } else { "the records fitted" };
    let percent = 100.0 * (after / before.max(1e-300) - 1.0).abs();
    let way = if percent < 0.5 {
        "stays as it was".to_owned()
    } else {
        format!("{} by {percent:.0} %", if after > before { "rises" } else { "falls" })
    };
    let worth = if done.worth {
        "worth adding"
    } else {
        "not worth adding: blocks held out of the records fitted do not confirm it"
    };
    format!("\n{}: {worth}; with it the error on {on} {way}.\n", done.effect)
}
