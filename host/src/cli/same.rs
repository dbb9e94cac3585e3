//! `same`: do two sets of records come from one motor?

use std::path::PathBuf;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::prose::{self, figure};
use super::table::{Row, table};
use super::wrap::known_width;
use super::{Console, next, watch};
use crate::diagnose::discover::{self, discover};
use crate::error::{Error, Result};
use crate::estimate::effect_by_name;
use crate::formula::Library;
use crate::log::{self, ReadArgs, Warning};
use crate::model_file::Model;
use crate::same::{Comparison, Verdict, same};

/// Options of `same`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens same monday-1.csv monday-2.csv -- friday.csv
  motorlens same left/*.csv --model left.json -m motor.toml -- right/*.csv")]
pub struct Args {
    /// Logs of the first set; those of the second follow after --
    #[arg(required = true, value_name = "LOG")]
    first: Vec<PathBuf>,
    /// Logs of the second set
    #[arg(last = true, required = true, value_name = "LOG")]
    second: Vec<PathBuf>,
    /// Take the effects of this model [default: what discover finds on the first set]
    #[arg(long, value_name = "MODEL", conflicts_with = "effects")]
    model: Option<PathBuf>,
    /// Take these effects; none for the base model
    #[arg(short, long, value_delimiter = ',', value_name = "EFFECTS")]
    effects: Option<Vec<String>>,
    #[command(flatten)]
    reading: ReadArgs,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    #[serde(flatten)]
    comparison: Comparison,
    data_faults: Vec<Warning>,
}

/// Fits, compares, and tells.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    if let Some(option) = args.second.iter().find(|path| path.to_string_lossy().starts_with('-')) {
        let why = format!("{} stands after --, where only logs of the second set may", option.display());
        return Err(Error::usage(why, "give the options before --"));
    }
    let motor = args.reading.motor_file()?;
    let [first, second] = [log::load(&args.first, &args.reading)?, log::load(&args.second, &args.reading)?];
    // Each set by itself: two motors may disagree.
    let of_content = [&first.records, &second.records].into_iter().flat_map(log::data_faults);
    let data_faults = log::together(of_content.chain(first.warnings).chain(second.warnings));
    data_faults.iter().for_each(|fault| console.say(prose::fault(fault)));
    let (first, second) = (first.records, second.records);
    let effects: Vec<Kind> = if let Some(path) = &args.model {
        Model::read(path)?.values().kinds()
    } else if let Some(names) = &args.effects {
        let named = names.iter().filter(|name| *name != "none");
        named.map(|name| effect_by_name(name, library)).collect::<Result<_>>()?
    } else {
        console.say("Looking for the effects on the first set ...");
        let options = discover::Options { library: library.kinds().to_vec(), ..discover::Options::default() };
        discover(&first, &[], &motor, &options, &mut |_| {})?.effects
    };
    let bar = watch::bar(console, 100, "% of the fits");
    let compared = same(&first, &second, &motor, &effects, &|share| bar.set_position((100.0 * share) as u64));
    bar.finish_and_clear();
    let document = Document { schema: 1, comparison: compared?, data_faults };
    console.answer(&document, || text(&document.comparison));
    let list = |paths: &[PathBuf]| paths.iter().map(|path| next::shell(path)).collect::<Vec<_>>().join(" ");
    let (first, second, read) = (list(&args.first), list(&args.second), next::as_read());
    match document.comparison.verdict {
        Verdict::Same => {
            let all = format!("motorlens discover {first} {second}{read} --out model.json");
            console.next("fit one model to both sets", &all);
        }
        Verdict::Different => {
            let other = format!("motorlens discover {second}{read} --out second.json");
            console.next("find what the second motor is", &other);
        }
        Verdict::Open => {
            let plan = format!("motorlens plan {first}{read} --out programme.json");
            console.next("choose an experiment to repeat on both", &plan);
        }
    }
    Ok(())
}

fn text(c: &Comparison) -> String {
    let verdict = match c.verdict {
        // Two motors that are alike as far as these records tell would show none either.
        Verdict::Same => "No difference shows",
        Verdict::Different => "Two motors",
        Verdict::Open => "Not settled",
    };
    let names: Vec<&str> = c.effects.iter().map(|k| k.name()).collect();
    let not_compared = if c.verdict == Verdict::Same && !c.open.is_empty() {
        format!(" What these records do not compare: {}.", c.open.join(", "))
    } else {
        String::new()
    };
    let mut text = format!(
        "{verdict}: {}.{not_compared}\n\nModel with {}\n",
        c.why,
        if names.is_empty() { "no effects".into() } else { names.join(", ") }
    );
    let width = known_width().unwrap_or(usize::MAX);
    let errors = ["first set", "second set"].into_iter().zip(&c.errors).map(|(name, e)| Row {
        name: name.into(),
        cells: [e.own, e.both, e.other].map(figure).into(),
        remark: String::new(),
    });
    let heads = ["own model", "model of both", "other's model"];
    text += &table(&format!("rms, {}", c.unit), &heads, &errors.collect::<Vec<_>>(), width);
    // A 95 % interval, as half its width.
    let cell =
        |[value, low, high]: [f64; 3]| format!("{} \u{b1} {}", figure(value), figure(0.5 * (high - low)));
    let parameters = c.parameters.iter().map(|p| Row {
        name: format!("{} / {}", p.name, p.unit),
        cells: vec![cell(p.first), cell(p.second), format!("{:.1}", p.deviations)],
        remark: if p.differs { "differs".into() } else { String::new() },
    });
    text.push('\n');
    text += &table("parameter", &["first", "second", "deviations"], &parameters.collect::<Vec<_>>(), width);
    if !c.open.is_empty() && not_compared.is_empty() {
        text += &format!("Not determined by both: {}.\n", c.open.join(", "));
    }
    text
}
