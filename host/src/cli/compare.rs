//! `compare`: model against measurement, and where it fails.

use std::path::PathBuf;

use motorlens_shared::effects::Kind;
use serde::Serialize;

use super::input::LogArgs;
use super::{Console, next, prose};
use crate::compare::free_run::{FreeRun, free_runs, pooled};
use crate::compare::measures::Measures;
use crate::compare::{FailureMap, Slice, failure_map, problem_as_it_is, write_trace};
use crate::diagnose::discover::noise_floor;
use crate::error::Result;
use crate::estimate::feedforward;
use crate::findings::Standing;
use crate::findings::shown_by_fit::ended_of;
use crate::formula::Library;
use crate::log::Record;
use crate::model_file::{DISCOVERED, Model};

/// Options of `compare`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens compare model.json unseen.csv -m motor.toml -t run.csv")]
pub struct Args {
    /// The model
    model: PathBuf,
    #[command(flatten)]
    input: LogArgs,
    /// Write the simulations here: record,time_s,measured,simulated
    #[arg(short, long, value_name = "FILE.csv")]
    trace: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    effects: Vec<Kind>,
    unit: &'static str,
    /// All records together.
    pooled: Measures,
    records: Vec<OfRecord>,
    failures: Vec<Slice>,
}

#[derive(Serialize)]
struct OfRecord {
    record: String,
    #[serde(flatten)]
    measures: Measures,
    /// The speed at which the run begins, rad/s.
    first_speed_rad_s: f64,
}

/// Runs the model over every log, those of `--validate` too: nothing is fitted here.
pub fn run(args: &Args, library: &Library, console: &Console) -> Result<()> {
    let model = Model::read(&args.model)?;
    let logs = args.input.load(&library.and_those_of(&model.values().kinds()))?;
    logs.warn(console);
    let all: Vec<Record> = logs.records.iter().chain(&logs.validation).cloned().collect();
    let problem = problem_as_it_is(&model, &all, &logs.motor)?;
    let runs = free_runs(&problem, &model.values());
    if let Some(path) = &args.trace {
        write_trace(path, &runs)?;
    }
    let map = failure_map(&runs, &problem.rig);
    let together = pooled(&runs).unwrap_or_default();
    let of = |run: &FreeRun| OfRecord {
        record: run.record.clone(),
        measures: run.measures(),
        first_speed_rad_s: run.first_speed_rad_s,
    };
    let document = Document {
        schema: 1,
        effects: model.values().kinds(),
        unit: map.unit,
        pooled: together,
        records: runs.iter().map(of).collect(),
        failures: map.slices.clone(),
    };
    let noise = noise_floor(&all, &[], &problem);
    let effects: Vec<String> = model.values().kinds().iter().map(ToString::to_string).collect();
    let ended = ended_of(&problem, &model.values());
    let standing = if model.origin.method == DISCOVERED {
        Standing::compared(&together, noise, &effects, &ended)
    } else {
        Standing::simulated(&together, noise, &effects, &ended)
    };
    console.answer(&document, || {
        let usual = feedforward::errors(&problem, &all, None).map(|(usual, _)| usual);
        let usual = usual.ok_or_else(|| feedforward::why_not(&problem, &all).unwrap_or_default());
        prose::headed(&standing, &story(&document, &map, usual))
    });
    if let Some(path) = &args.trace {
        console.say(format!("trace: {}", path.display()));
    }
    if !console.json() {
        console.say(next::told(&standing.next, Some(&args.model), &args.input.logs));
    }
    Ok(())
}

/// `usual` is what kS-kV-kA leaves when it is fitted to these records, or why it cannot be.
fn story(document: &Document, map: &FailureMap, usual: Result<Measures, String>) -> String {
    let mut text =
        format!("{}, simulated over every record by itself\n\n", prose::effects(&document.effects));
    for r in &document.records {
        text += &format!("{}\n", prose::measures(&r.record, &r.measures, map.unit));
    }
    text += &format!("{}\n", prose::measures("all", &document.pooled, map.unit));
    text += &match usual {
        Ok(usual) => format!(
            "{}\n(kS-kV-kA is fitted to these records; the model is as it is)\n",
            prose::usual(&usual, map.unit)
        ),
        Err(why) => prose::no_usual(&why) + "\n",
    };
    text += "\nwhere it fails, the clearest first, by\n";
    let slices = map.by_concentration();
    let rows: Vec<(&str, &str)> = slices.iter().map(|slice| (slice.title, slice.reading.as_str())).collect();
    text + &prose::beside(&rows)
}
