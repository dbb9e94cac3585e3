//! `effects`: the registry, for reading and for programs.

use std::path::PathBuf;

use motorlens_shared::effects::{Kind, Port};
use serde::Serialize;

use super::{Console, wrap};
use crate::atomic_file;
use crate::book;
use crate::error::{Error, Result};
use crate::estimate::effect_by_name;
use crate::formula::Library;
use crate::glossary;

/// Options of `effects`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens effects
  motorlens effects stribeck backlash
  motorlens effects stribeck --plot stribeck.svg")]
pub struct Args {
    /// Tell all about these only
    #[arg(value_name = "EFFECT")]
    names: Vec<String>,
    /// Draw what the one effect named does to a standard programme
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
    /// Write the generated part of the book's pages, and the plots, into this directory
    #[arg(long, value_name = "DIR", hide = true)]
    book: Option<PathBuf>,
}

#[derive(Serialize)]
struct Row {
    name: &'static str,
    port: Port,
    title: &'static str,
    equation: &'static str,
    source: &'static str,
    signature: &'static str,
    contains: Vec<&'static str>,
    parameters: Vec<Parameter>,
}

#[derive(Serialize)]
struct Parameter {
    name: &'static str,
    unit: &'static str,
    meaning: &'static str,
    /// Whether zero switches the effect off.
    strength: bool,
}

#[derive(Serialize)]
struct Registry {
    schema: u32,
    /// The base model, which every effect is added to.
    base_equations: [&'static str; 4],
    /// Its parameters, and those of the effects.
    terms: Vec<glossary::Term>,
    effects: Vec<Row>,
}

/// Lists the effects.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    let kinds = match args.names.as_slice() {
        [] => library.kinds().to_vec(),
        names => names.iter().map(|n| effect_by_name(n, library)).collect::<Result<_>>()?,
    };
    let registry = Registry {
        schema: 1,
        base_equations: glossary::BASE_EQUATIONS,
        terms: glossary::terms(&kinds),
        effects: kinds.iter().map(|k| row(*k)).collect(),
    };
    if let Some(path) = &args.plot {
        let [kind] = kinds.as_slice() else {
            return Err(Error::usage(
                "--plot draws one effect",
                "name it: motorlens effects coulomb --plot coulomb.svg",
            ));
        };
        atomic_file::write(path, book::plot(*kind)?)?;
        console.say(format!("wrote {}", path.display()));
    }
    if let Some(directory) = &args.book {
        let files = book::write(directory)?;
        console.say(format!("wrote {} files into {}", files.len(), directory.display()));
        return Ok(());
    }
    console.list(&registry, || {
        let text =
            if args.names.is_empty() { base() + &table(&registry.effects) } else { pages(&registry.effects) };
        wrap::listed(&text)
    });
    Ok(())
}

fn row(kind: Kind) -> Row {
    let spec = kind.spec();
    let parameter = |p: &motorlens_shared::effects::Parameter| Parameter {
        name: p.name,
        unit: p.unit,
        meaning: p.meaning,
        strength: p.strength,
    };
    Row {
        name: spec.name,
        port: spec.port,
        title: spec.title,
        equation: spec.equation,
        source: spec.source,
        signature: spec.signature,
        contains: spec.contains.iter().map(|(simpler, _)| *simpler).collect(),
        parameters: spec.parameters.iter().map(parameter).collect(),
    }
}

/// The base model's equations and parameters.
fn base() -> String {
    let equations = glossary::BASE_EQUATIONS.map(|line| format!("  {line}\n")).concat();
    let parameters: String = glossary::terms(&[])
        .iter()
        .map(|t| format!("  {:<14} {:<12} {}\n", t.symbol, t.unit, t.meaning))
        .collect();
    format!("base model\n{equations}  {}\n{parameters}\n", glossary::SYMBOLS)
}

/// Every effect with its equation and its parameters.
fn table(rows: &[Row]) -> String {
    let mut text = String::new();
    for row in rows {
        text += &format!("{} ({}): {}\n  {}\n", row.name, row.port.name(), row.title, row.equation);
        for p in &row.parameters {
            text += &format!("  {:<14} {:<12} {}\n", p.name, p.unit, p.meaning);
        }
    }
    text + "\nmotorlens effects NAME tells what to look for in data and where the equation is from."
}

fn pages(rows: &[Row]) -> String {
    let page = |row: &Row| {
        let parameters: String = row
            .parameters
            .iter()
            .map(|p| format!("  {:<14} {:<12} {}\n", p.name, p.unit, p.meaning))
            .collect();
        format!(
            "{} ({}): {}\n  {}\n  in data: {}\n  source: {}\n{parameters}",
            row.name,
            row.port.name(),
            row.title,
            row.equation,
            row.signature,
            row.source
        )
    };
    rows.iter().map(page).collect::<Vec<_>>().join("\n")
}
