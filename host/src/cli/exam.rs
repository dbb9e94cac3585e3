//! `exam`: how often the diagnosis is right, on motors whose effects are known.

use std::path::PathBuf;

use motorlens_virtual_motor::Kind;
use serde::Serialize;

use super::{Console, watch};
use crate::atomic_file;
use crate::error::{Error, Result};
use crate::exam::{Answer, Marks, Paper, benches, examine, picture, table};

/// Options of `exam`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens exam
  motorlens exam --singles 3 --nothing 100 --pairs 40 --outside 20 --out exam")]
pub struct Args {
    /// First seed: develop on some, report on others
    #[arg(long, value_name = "SEED", default_value_t = 1)]
    from: u64,
    /// Cases of every effect alone
    #[arg(long, value_name = "N", default_value_t = 1)]
    singles: u64,
    /// Cases with nothing missing, half of them under a torque disturbance
    #[arg(long, value_name = "N", default_value_t = 10)]
    nothing: u64,
    /// Cases with two effects
    #[arg(long, value_name = "N", default_value_t = 5)]
    pairs: u64,
    /// Cases with an effect that the library is robbed of
    #[arg(long, value_name = "N", default_value_t = 5)]
    outside: u64,
    /// Share of cases with a torque disturbance of 1-5 % of stall
    #[arg(long, value_name = "SHARE", default_value_t = 0.25)]
    disturbed: f64,
    /// Share of cases with noise on the logged voltage, of those that begin in motion, and of those that jitter
    #[arg(long, value_name = "SHARE", default_value_t = 0.15)]
    spoilt: f64,
    /// Hide only these effects
    #[arg(long, value_name = "EFFECTS", value_delimiter = ',')]
    only: Vec<String>,
    /// Realistic benches around a second plant instead, told by kind of bench
    #[arg(long)]
    benches: bool,
    /// Cases of each kind of bench
    #[arg(long, value_name = "N", default_value_t = 4, requires = "benches")]
    cases: u64,
    /// Only these kinds: protocol, sysid, duty-on-battery, servo-pendulum, few-decimals, weak-sines
    #[arg(long, value_name = "KINDS", value_delimiter = ',', requires = "benches")]
    bench: Vec<String>,
    /// Write the cases of the benches as folders (logs, motor.toml, truth.json) and ask nothing
    #[arg(long, value_name = "DIR", requires = "benches")]
    write: Option<PathBuf>,
    /// Threads; 1 for honest times
    #[arg(long, value_name = "N", default_value_t = std::thread::available_parallelism().map_or(1, usize::from))]
    threads: usize,
    /// Directory for table.md, confusion.svg and answers.json
    #[arg(short, long, value_name = "DIR")]
    out: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    paper: Paper,
    marks: &'a Marks,
    answers: &'a [Answer],
}

/// Asks, marks, and writes what came out.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    if args.benches {
        return on_benches(args, console);
    }
    let paper = Paper {
        from: args.from,
        singles: args.singles,
        nothing: args.nothing,
        pairs: args.pairs,
        outside: args.outside,
        disturbed: args.disturbed,
        spoilt: args.spoilt,
    };
    let only = args.only.iter().map(|name| by_name(name)).collect::<Result<Vec<Kind>>>()?;
    let questions = paper.questions(&only);
    let bar = watch::bar(console, questions.len() as u64, "cases");
    let answers = examine(&questions, args.threads, &mut |answer| {
        bar.inc(1);
        bar.suspend(|| console.say(line(answer)));
    })?;
    bar.finish_and_clear();
    let marks = Marks::new(&answers);
    let document = Document { schema: 1, paper, marks: &marks, answers: &answers };
    if let Some(directory) = &args.out {
        let made = std::fs::create_dir_all(directory);
        made.map_err(|source| Error::Io { doing: format!("cannot make {}", directory.display()), source })?;
        atomic_file::write(&directory.join("table.md"), table(&answers))?;
        atomic_file::write(&directory.join("confusion.svg"), picture(&answers)?)?;
        let json = serde_json::to_string_pretty(&document).unwrap_or_default();
        atomic_file::write(&directory.join("answers.json"), json)?;
    }
    console.answer(&document, || table(&answers));
    next(args, console);
    Ok(())
}

#[derive(Serialize)]
struct BenchDocument<'a> {
    schema: u32,
    paper: benches::Paper,
    marks: Vec<benches::Marks>,
    answers: &'a [benches::Answer],
}

/// The examination on realistic benches, or only its cases as files.
fn on_benches(args: &Args, console: &Console) -> Result<()> {
    let known = || benches::Bench::ALL.map(benches::Bench::name);
    if let Some(unknown) = args.bench.iter().find(|name| !known().contains(&name.as_str())) {
        let why = format!("no kind of bench is called '{unknown}'");
        return Err(Error::usage(why, format!("choose from {}", known().join(", "))));
    }
    let paper = benches::Paper { from: args.from, cases: args.cases, benches: args.bench.clone() };
    let bar = watch::bar(console, paper.questions().len() as u64, "cases");
    if let Some(directory) = &args.write {
        benches::write_cases(&paper, directory, &mut || bar.inc(1))?;
        bar.finish_and_clear();
        console.answer(&paper, || format!("cases written to {}", directory.display()));
        console.next(
            "let the diagnosis answer one of them",
            "motorlens discover CASE/*.csv --motor CASE/motor.toml",
        );
        return Ok(());
    }
    let answers = benches::examine(&paper, args.threads, &mut |a| {
        bar.inc(1);
        let found = if a.found.is_empty() { "none".to_owned() } else { a.found.join(" + ") };
        let judged = if a.exact() { "right" } else { "WRONG" };
        let line = format!(
            "{judged} {} {} {} [{}] found {found}, {}, {:.1} s",
            a.bench, a.seed, a.group, a.sizes, a.verdict, a.seconds
        );
        bar.suspend(|| console.say(line));
    });
    bar.finish_and_clear();
    let document =
        BenchDocument { schema: 1, paper, marks: benches::Marks::all(&answers), answers: &answers };
    if let Some(directory) = &args.out {
        let made = std::fs::create_dir_all(directory);
        made.map_err(|source| Error::Io { doing: format!("cannot make {}", directory.display()), source })?;
        atomic_file::write(&directory.join("benches.md"), benches::table(&answers))?;
        let json = serde_json::to_string_pretty(&document).unwrap_or_default();
        atomic_file::write(&directory.join("benches.json"), json)?;
    }
    console.answer(&document, || benches::table(&answers));
    next(args, console);
    Ok(())
}

/// Where the answers were kept and how to look at such a case, or how to keep them.
fn next(args: &Args, console: &Console) {
    let kind = if args.benches { " --benches" } else { "" };
    match &args.out {
        Some(directory) => {
            console.say(format!("table and answers: {}", directory.display()));
            let case =
                if args.benches { "exam --benches --write cases" } else { "simulate --hidden 1 --out s" };
            console.next("make logs of such motors", &format!("motorlens {case}"));
        }
        None => console.next("keep table and answers", &format!("motorlens exam{kind} --out exam")),
    }
}

/// An answer on a line: what was hidden, what was found, and how the first diagnosis saw it.
fn line(a: &Answer) -> String {
    let list = |names: &[&str]| if names.is_empty() { "none".to_owned() } else { names.join(" + ") };
    let standing = a.ranking.iter().copied().chain(["base"]).zip(&a.errors);
    let shown = a.errors.len().min(4);
    let first: Vec<String> = standing
        .enumerate()
        .filter(|(k, _)| *k < shown || k + 1 == a.errors.len())
        .map(|(_, (name, e))| format!("{name} {e:.2}"))
        .collect();
    format!(
        "{} {:>7} {:<40} found {:<40} {:?} {:.1} -> {:.2} x floor, {:.1} s ({}) | {}",
        if a.exact() { "right" } else { "WRONG" },
        a.seed,
        if a.sizes.is_empty() { "nothing" } else { &a.sizes },
        list(&a.found),
        a.verdict,
        a.before,
        a.after,
        a.seconds,
        a.conditions,
        first.join(" | "),
    )
}

fn by_name(name: &str) -> Result<Kind> {
    let known = || Kind::all().map(|k| k.row().name).collect::<Vec<_>>().join(", ");
    let found = Kind::all().find(|k| k.row().name == name);
    found.ok_or_else(|| {
        Error::usage(format!("no effect is called '{name}'"), format!("choose from {}", known()))
    })
}
