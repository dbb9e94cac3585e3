//! `discover`: the loop by itself.

use std::path::PathBuf;

use super::input::{LogArgs, Logs};
use super::{Console, next, prose, watch};
use crate::atomic_file;
use crate::diagnose::discover::{Discovery, Options, discover};
use crate::error::{Error, Result};
use crate::estimate::feedforward;
use crate::findings::Findings;
use crate::fit::grid::Quantity;
use crate::formula::Library;
use crate::log::{Record, Warning};

/// Options of `discover`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens discover run1.csv run2.csv -v unseen.csv -m motor.toml -o model.json
  motorlens discover logs/*.csv --map time=t:ms,voltage=u,speed=y:rpm --json")]
pub struct Args {
    #[command(flatten)]
    pub input: LogArgs,
    /// Most effects to add
    #[arg(short = 'n', long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u8).range(0..=6))]
    pub most: u8,
    /// Write the model here
    #[arg(short, long, value_name = "MODEL.json")]
    pub out: Option<PathBuf>,
}

/// Runs the loop and tells what it found.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    args.out.as_deref().map_or(Ok(()), atomic_file::may_write)?;
    let logs = or_bad_data(args.input.load(library), &[], console)?;
    let options = Options { library: library.kinds().to_vec(), most: usize::from(args.most) };
    let (found, findings) = or_bad_data(search(&logs, &options, console), logs.faults(), console)?;
    if let Some(path) = &args.out {
        found.model.write(path)?;
    }
    let standing = findings.standing();
    console.answer(&findings, || prose::headed(&standing, &story(&found, &findings, &logs.records)));
    if let Some(path) = &args.out {
        console.say(format!("model: {}", path.display()));
    }
    if !console.json() {
        console.say(next::steps(&standing, args.out.as_deref(), &args.input.logs));
    }
    Ok(())
}

/// The forward selection on `logs`, watched.
pub fn search(logs: &Logs, options: &Options, console: &Console) -> Result<(Discovery, Findings)> {
    logs.warn(console);
    let bar = watch::bar(console, options.library.len() as u64, "effects");
    let unit = unit(&logs.records);
    let mut progress = watch::climb(console, &bar, unit);
    let found = discover(&logs.records, &logs.validation, &logs.motor, options, &mut progress);
    bar.finish_and_clear();
    let found = found?;
    let findings = Findings::new(&found, logs.faults());
    let findings = findings.supposing(&logs.records, &logs.motor, &found.evidence.whole.rig);
    Ok((found, findings))
}

/// A program that asked for findings gets the verdict `bad_data` with the error.
pub fn or_bad_data<T>(result: Result<T>, faults: &[Warning], console: &Console) -> Result<T> {
    if let (Err(error @ Error::BadInput(_)), true) = (&result, console.json()) {
        console.answer(&Findings::bad_data(error, faults), String::new);
    }
    result
}

/// The unit of what is measured.
pub fn unit(records: &[Record]) -> &'static str {
    let angle = records.first().is_some_and(|r| r.angle_rad.is_some());
    if angle { Quantity::Angle.unit() } else { Quantity::Speed.unit() }
}

/// What was found, for people.
pub fn story(found: &Discovery, findings: &Findings, records: &[Record]) -> String {
    let unit = unit(records);
    let mut text = String::new();
    text += &match &found.baseline {
        Some(usual) if usual.train.missed() <= prose::RUN_AWAY => {
            format!("{}\n", watch::errors("kS-kV-kA, the usual model", usual, unit))
        }
        Some(_) => "kS-kV-kA, the usual model, is not determined by these records.\n".to_owned(),
        None => feedforward::why_not(&found.evidence.whole, records)
            .map(|why| format!("No comparison with the usual model: {why}.\n"))
            .unwrap_or_default(),
    };
    text += &format!("The noise level is {} {unit} rms.\n", prose::figure(found.noise_floor));
    if let Some(reading) = &findings.speed_reading {
        text += &format!("Each speed is {reading}.\n");
    }
    text += "\n";
    text += &prose::parameters(&findings.parameters);
    text += "what voltage and motion alone determine:\n";
    text += &prose::parameters(&findings.combinations);
    text += &prose::supposed(findings);
    for set in found.open_sets() {
        let names: Vec<&str> = set.iter().map(|k| k.name()).collect();
        text += &format!("\nThese records cannot tell apart: {}.\n", names.join(", "));
    }
    text += &prose::limits(&findings.detection_limits);
    text += &prose::experiments(findings);
    text += &prose::shown_by_the_fit(findings);
    text + &format!("{:.1} s, {} simulations", found.seconds, found.simulations)
}
