//! `fit`: parameters of a model with given effects.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::discover::unit;
use super::input::LogArgs;
use super::{Console, next, prose, watch};
use crate::atomic_file;
use crate::compare::measures::Measures;
use crate::error::Result;
use crate::estimate::{Fit, Identifiability, Method, Options, Profile, effect_by_name, fit};
use crate::findings::{NextStep, Standing, named, shown_by_fit};
use crate::fit::uncertainty::Estimate;
use crate::formula::Library;
use crate::log::Warning;
use crate::report::words;

/// Options of `fit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens fit run1.csv run2.csv -e coulomb,backlash -m motor.toml -o model.json
  motorlens fit run1.csv --method ga --seed 7")]
pub struct Args {
    #[command(flatten)]
    input: LogArgs,
    /// How to search
    #[arg(long, value_enum, default_value_t)]
    method: Method,
    /// Effects of the model, separated by commas
    #[arg(short, long, value_name = "NAMES", value_delimiter = ',')]
    effects: Vec<String>,
    /// Chromosomes of the genetic algorithm
    #[arg(long, default_value_t = 80, value_parser = clap::value_parser!(u16).range(2..=1024))]
    population: u16,
    /// Generations of the genetic algorithm
    #[arg(long, default_value_t = 800, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    generations: u32,
    /// Seed of the genetic algorithm; the same seed gives the same answer
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Write the model here
    #[arg(short, long, value_name = "MODEL.json")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    method: Method,
    effects: Vec<Kind>,
    parameters: &'a [Estimate],
    combinations: &'a [Estimate],
    profiles: &'a [Profile],
    identifiability: &'a Identifiability,
    data_faults: Vec<Warning>,
    train: Measures,
    validation: Option<Measures>,
    objective_history: &'a [f64],
    seed: u64,
    evaluations: u64,
    seconds: f64,
    noise_level: f64,
    supposes: Option<&'a str>,
    headline: &'a str,
    next_step: &'a NextStep,
}

/// Fits, writes, tells.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    let effects = args
        .effects
        .iter()
        .filter(|n| *n != "none")
        .map(|n| effect_by_name(n, library))
        .collect::<Result<Vec<_>>>()?;
    let options = Options {
        method: args.method,
        effects,
        population: usize::from(args.population),
        generations: args.generations,
        seed: args.seed,
    };
    args.out.as_deref().map_or(Ok(()), atomic_file::may_write)?;
    let logs = args.input.load(library)?;
    logs.warn(console);
    let bar = watch::bar(console, u64::from(args.generations), "generations");
    let fitted = fit(&logs.records, &logs.validation, &logs.motor, &options, &mut |generation, iae| {
        bar.set_position(u64::from(generation));
        bar.set_message(format!("IAE {}", prose::figure(iae)));
    });
    bar.finish_and_clear();
    let fitted = fitted?;
    if let Some(path) = &args.out {
        fitted.model.write(path)?;
    }
    let mut faults = logs.faults().to_vec();
    let lacking = shown_by_fit::too_little_excitation(&fitted.parameters);
    if let Some(warning) = &lacking {
        console.say(prose::fault(warning));
    }
    faults.extend(lacking);
    let standing = standing(&fitted);
    let document = Document {
        schema: 1,
        method: options.method,
        effects: fitted.model.values().kinds(),
        parameters: &fitted.parameters,
        combinations: &fitted.combinations,
        profiles: &fitted.profiles,
        identifiability: &fitted.identifiability,
        data_faults: faults,
        train: fitted.train,
        validation: fitted.validation,
        objective_history: &fitted.objective_history,
        seed: options.seed,
        evaluations: fitted.evaluations,
        seconds: fitted.seconds,
        noise_level: fitted.noise_level,
        supposes: fitted.supposed.sentences(),
        headline: &standing.headline,
        next_step: &standing.next,
    };
    console.answer(&document, || prose::headed(&standing, &story(&fitted, unit(&logs.records))));
    if let Some(path) = &args.out {
        console.say(format!("model: {}", path.display()));
    }
    if !console.json() {
        console.say(next::told(&standing.next, args.out.as_deref(), &args.input.logs));
    }
    Ok(())
}

/// Whether the model is enough, what its effects suppose, and what to do next.
fn standing(fit: &Fit) -> Standing {
    let effects = named(&fit.model.values().kinds(), &fit.parameters);
    let errors = fit.validation.unwrap_or(fit.train);
    let standing = Standing::simulated(&errors, fit.noise_level, &effects, &fit.ended);
    Standing { headline: standing.headline + &fit.supposed.text, ..standing }
}

fn story(fit: &Fit, unit: &str) -> String {
    let mut text =
        format!("{}\n{}", prose::effects(&fit.model.values().kinds()), prose::parameters(&fit.parameters));
    text += "what voltage and motion alone determine:\n";
    text += &prose::parameters(&fit.combinations);
    text += &doubts(&fit.profiles);
    text += &open(&fit.identifiability);
    let usual = fit.usual.as_ref();
    let of_both = [
        ("records fitted", Some(&fit.train), usual.map(|(train, _)| train)),
        ("validation records", fit.validation.as_ref(), usual.and_then(|(_, unseen)| unseen.as_ref())),
    ];
    text += "\n";
    for (name, errors, usual) in of_both {
        let lines = errors.map(|m| prose::measures(name, m, unit)).into_iter();
        text +=
            &lines.chain(usual.map(|m| prose::usual(m, unit))).map(|line| line + "\n").collect::<String>();
    }
    text += &fit.no_usual.as_ref().map(|why| prose::no_usual(why) + "\n").unwrap_or_default();
    text + &format!("{:.2} s, {} simulations", fit.seconds, fit.evaluations)
}

/// Intervals that were walked, where they differ from those above.
fn doubts(profiles: &[Profile]) -> String {
    let mut text = String::new();
    for p in profiles.iter().filter(|p| p.curvature_misleads) {
        let (low, high) = (prose::figure(p.low), prose::figure(p.high));
        let range = match (p.open_below, p.open_above) {
            (false, false) => format!("{low} .. {high}"),
            (true, false) => format!("at most {high}"),
            (false, true) => format!("at least {low}"),
            (true, true) => words::NOT_DETERMINED.to_owned(),
        };
        let unit = if p.open_below && p.open_above { "" } else { words::unit(&p.unit) };
        let range = format!("{range} {unit}");
        text += &format!("{:<28} by profile {}\n", p.name, range.trim_end());
    }
    if !text.is_empty() {
        text += "(where a profile is given, the quadratic (Wald) interval above misleads)\n";
    }
    text
}

/// What these data leave open.
fn open(what: &Identifiability) -> String {
    let mut text = format!("\nof the eight parameters of a motor: {}\n", what.meaning);
    for answer in &what.eight_parameters {
        let numbers: Vec<String> =
            answer.parameters.iter().map(|p| format!("{} {}", p.symbol, prose::figure(p.value))).collect();
        text += &format!("  {}\n    ({})\n", numbers.join("  "), answer.chosen);
    }
    for unlock in &what.unlock {
        text += &format!("  to know {}: {}\n", unlock.determines.join(", "), unlock.measure);
    }
    text
}
