//! `add`: one effect more, and whether it is worth it.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::discover::unit;
use super::input::LogArgs;
use super::{Console, next, prose, watch, wrap};
use crate::atomic_file;
use crate::diagnose::discover::Progress;
use crate::error::Result;
use crate::estimate::{Addition, add, effect_by_name};
use crate::estimate::{Errors, Moved};
use crate::findings::{Action, NextStep};
use crate::fit::uncertainty::Estimate;
use crate::formula::Library;
use crate::model_file::Model;
use crate::report::words;

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
    supposes: Option<&'a str>,
}

/// Adds, writes, tells.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    args.out.as_deref().map_or(Ok(()), atomic_file::may_write)?;
    let effect = effect_by_name(&args.effect, library)?;
    let model = Model::read(&args.model)?;
    let logs = args.input.load(&library.and_those_of(&model.values().kinds()))?;
    logs.warn(console);
    // As it is, and with the effect: the story tells both.
    let bar = watch::bar(console, 2, "fits");
    let mut progress = |progress: Progress| match progress {
        Progress::Rung(_) => bar.inc(1),
        Progress::Trying { effect, .. } => bar.set_message(format!("trying {effect}")),
        Progress::Anew(_) => {}
    };
    let done = add(&model, effect, &logs.records, &logs.validation, &logs.motor, &mut progress);
    bar.finish_and_clear();
    let done = done?;
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
        supposes: done.supposed.sentences(),
    };
    console.answer(&document, || story(&done, unit(&logs.records)));
    if let Some(path) = &args.out {
        console.say(format!("model: {}", path.display()));
    }
    if !console.json() {
        // What is not worth adding is not built upon: the model that was there is.
        let base = args.out.as_ref().filter(|_| done.worth).unwrap_or(&args.model);
        let next = NextStep::new(Action::Diagnose, None);
        console.say(next::told(&next, Some(base), &args.input.logs));
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
    text += &done.supposed.sentences().map_or_else(String::new, |sentences| format!("{sentences}\n\n"));
    text += &moved(&done.moved, wrap::width());
    let new = &done.parameters[done.moved.len()..];
    text + &prose::parameters(new)
}

/// The parameters before and after; on a narrow terminal in narrower columns, then below their names.
fn moved(list: &[Moved], width: usize) -> String {
    let row = |m: &Moved, [name, number]: [usize; 2], gap: &str| {
        let (before, after) = (prose::figure(m.before), prose::figure(m.after));
        let unit = words::unit(&m.unit);
        let row = format!("{:<name$}{gap}{before:>number$} -> {after:<number$} {unit}", m.name);
        row.trim_end().to_owned() + "\n"
    };
    let longest = list.iter().map(|m| m.name.chars().count()).max().unwrap_or(0);
    // The line's end takes no column.
    let fits = |columns: &[usize; 2]| list.iter().all(|m| row(m, *columns, " ").chars().count() <= width + 1);
    let columns = [[28, 11], [longest, 9]].into_iter().find(fits);
    let told = |m: &Moved| columns.map_or_else(|| row(m, [0, 0], "\n    "), |columns| row(m, columns, " "));
    list.iter().map(told).collect()
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_change_keeps_its_unit_at_any_width() {
        let gain = Moved { name: "gain".into(), unit: "rad/s/V".into(), before: 6.9, after: 6.9 };
        let share = Moved { name: "viscous_share".into(), unit: "1".into(), before: 0.1, after: 0.07 };
        for (width, lines) in [(80, 2), (60, 2), (40, 4)] {
            let told = moved(&[gain.clone(), share.clone()], width);
            assert!(told.lines().all(|line| line.len() <= width), "{told}");
            let short = told.split_whitespace().collect::<Vec<_>>().join(" ");
            assert!(short.contains("6.900 -> 6.900 rad/s/V") && short.ends_with("0.07000"), "{told}");
            assert_eq!(told.lines().count(), lines, "{told}");
        }
    }
}
