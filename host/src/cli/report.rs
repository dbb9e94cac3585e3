//! `report`: the loop by itself, told in one HTML file.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::discover::search;
use super::input::LogArgs;
use super::{Console, next, prose};
use crate::atomic_file;
use crate::diagnose::discover::Options;
use crate::error::{Error, Result};
use crate::findings::Verdict;
use crate::formula::Library;
use crate::report::{self, Story, words};

/// Options of `report`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens report run1.csv run2.csv -v unseen.csv -m motor.toml -o report.html")]
pub struct Args {
    #[command(flatten)]
    pub input: LogArgs,
    /// Most effects to add
    #[arg(short = 'n', long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(0..=6))]
    pub most: u8,
    /// Write the report here
    #[arg(short, long, value_name = "FILE.html", default_value = "motorlens-report.html")]
    pub out: PathBuf,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    report: PathBuf,
    bytes: u64,
    summary: String,
    verdict: Verdict,
    effects: Vec<Kind>,
}

/// Discovers, and writes what was found.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    atomic_file::may_write(&args.out)?;
    let logs = args.input.load(library)?;
    let options = Options { library: library.kinds().to_vec(), most: usize::from(args.most) };
    let (found, findings) = search(&logs, &options, console)?;
    let mut story = Story::of(&found, &findings, &logs.records);
    story.standing.next.command = next::commands(&story.standing.next, None, &args.input.logs).join("\n");
    report::write(&story, &args.out)?;
    let size = std::fs::metadata(&args.out)
        .map_err(|source| Error::Io { doing: format!("cannot look at {}", args.out.display()), source })?;
    let document = Document {
        schema: 1,
        report: args.out.clone(),
        bytes: size.len(),
        summary: words::summary(&story.ladder, story.floor, story.unit, &story.standing),
        verdict: findings.verdict,
        effects: found.effects.clone(),
    };
    console.answer(&document, || {
        let next = next::steps(&findings.standing(), None, &args.input.logs);
        let faults = prose::shown_by_the_fit(&findings);
        let told = format!("{}\n{faults}report: {}\n{next}", document.summary, args.out.display());
        prose::headed(&story.standing, &told)
    });
    Ok(())
}
