//! `export`: the model for other tools.

use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use serde::Serialize;

use super::{Console, next, watch};
use crate::api::Event;
use crate::atomic_file;
use crate::error::{Error, Result};
use crate::export::cost::{Cost, cost};
use crate::export::told::{Told, is_simplified, longer_step_s, told};
use crate::export::{Exported, Format, Lost, Options, Stepper, export};
use crate::log::mapping::Mapping;
use crate::log::roles::Range;
use crate::log::{self, Hold, ReadArgs, Record};
use crate::model_file::Model;
use crate::motor_file::MotorFile;

/// Options of `export`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens export model.json -f c -o motor.c
  motorlens export model.json -f mujoco -o motor.xml --torque-per-volt 0.12
  motorlens export model.json -f bam -o m5.json --torque-per-volt 0.12 --allow-missing --on steps.csv")]
pub struct Args {
    /// The model
    model: PathBuf,
    /// The target
    #[arg(short, long, value_enum)]
    format: Format,
    /// Write it here
    #[arg(short, long, value_name = "FILE")]
    out: PathBuf,
    /// Step of a program or of MuJoCo's simulation, in seconds [default: 0.001; MuJoCo 0.00005, with backlash 0.000025]
    #[arg(long, value_name = "SECONDS", value_parser = step)]
    step: Option<f64>,
    /// Stall torque per volt at the output shaft in N m/V [default: unknown; MuJoCo then has torques in volts]
    #[arg(long, value_name = "TORQUE", value_parser = positive)]
    torque_per_volt: Option<f64>,
    /// Name of the joint, or of BAM's actuator
    #[arg(long, value_name = "NAME")]
    name: Option<String>,
    /// Which of BAM's models, 1 to 6 [default: the smallest that holds the effects]
    #[arg(long, value_name = "M", value_parser = clap::value_parser!(u8).range(1..=6))]
    bam_model: Option<u8>,
    /// Write it though the target lacks effects of the model
    #[arg(long)]
    allow_missing: bool,
    /// A record on which to run the export and to tell what it lacks, refused where it errs by more than 1 % above the model; repeatable
    /// [default: a standard programme]; MuJoCo is run by the Python that the variable PYTHON names, else by python3
    #[arg(long, value_name = "LOG")]
    on: Vec<PathBuf>,
    #[command(flatten)]
    reading: Reading,
}

/// How a record of `--on` is read: as `discover` reads it, whose `--format` is of logs.
#[derive(Debug, clap::Args)]
#[command(next_help_heading = "Reading the records of --on, as for motorlens discover")]
struct Reading {
    /// What is known of the motor that made the record
    #[arg(short, long, value_name = "motor.toml")]
    motor: Option<PathBuf>,
    /// Columns of the record, where it is a foreign table
    #[arg(long, value_name = "MAP")]
    map: Option<Mapping>,
    /// What the voltage does between samples: stays (zero) or runs straight to the next (first)
    #[arg(long, value_enum)]
    hold: Option<Hold>,
    /// How many seconds before its row a voltage acts
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    voltage_lead: Option<f64>,
    /// Samples per second, where no column tells the time
    #[arg(long, value_name = "HZ", value_parser = positive)]
    rate: Option<f64>,
    /// Supply of the driver in volts, where the log gives duty only
    #[arg(long, value_name = "VOLTS", value_parser = positive)]
    supply_volts: Option<f64>,
    /// Encoder counts per turn of the output shaft
    #[arg(long, value_name = "COUNTS", value_parser = positive)]
    counts_per_rev: Option<f64>,
    /// Metres that a linear axis goes per turn of the output shaft
    #[arg(long, value_name = "METRES", value_parser = positive)]
    metres_per_rev: Option<f64>,
    /// Seconds to leave out, of all records or of one; repeatable
    #[arg(long, value_name = "[RECORD:]FROM..TO")]
    skip: Vec<Range>,
}

impl Reading {
    fn arguments(&self) -> ReadArgs {
        ReadArgs {
            motor: self.motor.clone(),
            map: self.map.clone(),
            hold: self.hold,
            voltage_lead: self.voltage_lead,
            rate: self.rate,
            supply_volts: self.supply_volts,
            counts_per_rev: self.counts_per_rev,
            metres_per_rev: self.metres_per_rev,
            skip: self.skip.clone(),
            ..ReadArgs::default()
        }
    }
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    format: Format,
    out: &'a Path,
    /// The second file.
    beside: Option<PathBuf>,
    notes: &'a [String],
    /// Sentences for what is lacking, what is left to others, and what else is to be known.
    left_out: Vec<String>,
    lost: &'a [Lost],
    /// Effects that need somebody's doing.
    left: &'a [Lost],
    cost: Option<&'a Cost>,
}

/// Writes the file, or refuses where the target lacks effects, and says what that costs.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    let model = Model::read(&args.model)?;
    let options = Options {
        step_s: args.step,
        torque_per_volt: args.torque_per_volt,
        name: args.name.clone(),
        bam_model: args.bam_model,
    };
    let format = args.format;
    let exported = export(&model, format, &options)?;
    // A target of a few numbers may have less of the model than all of it, though it names no effect as lost.
    let price = if !is_simplified(&exported, &model) && args.on.is_empty() {
        None
    } else {
        let reading = args.reading.arguments();
        let records = log::load(&args.on, &reading)?.records;
        Some(watched_cost(&model, &exported, &records, &reading.motor_file()?, console)?)
    };
    let Told { lacking, mut to_know } = told(&exported, &model, format, &options, price.as_ref());
    if price.is_some() && args.on.is_empty() {
        // A target of which nothing is lost but numbers may be as good as the model, or not, on what the motor is to do.
        to_know
            .push("--on LOG tells what that costs on a log of yours, beside the model's own error.".into());
    }
    let too_high = price.as_ref().is_some_and(Cost::is_too_high);
    if (!exported.lost.is_empty() || too_high) && !args.allow_missing {
        let why = lacking.join("\n  ");
        let otherwise = match price.as_ref().and_then(Cost::better_step_s) {
            Some(step_s) if exported.lost.is_empty() => format!("--step {step_s}"),
            _ => "take another format".into(),
        };
        let remedy = format!("give --allow-missing to write it all the same, or {otherwise}");
        return Err(Error::usage(why, remedy));
    }
    atomic_file::write(&args.out, &exported.content)?;
    let beside = exported.beside.as_ref().map(|(ending, _)| args.out.with_extension(ending));
    if let (Some(path), Some((_, text))) = (&beside, &exported.beside) {
        atomic_file::write(path, text)?;
    }
    let document = Document {
        schema: 1,
        format,
        out: &args.out,
        beside: beside.clone(),
        notes: &exported.notes,
        left_out: lacking.iter().chain(&to_know).cloned().collect(),
        lost: &exported.lost,
        left: &exported.left,
        cost: price.as_ref(),
    };
    console.answer(&document, || {
        let files = [Some(&args.out), beside.as_ref()].into_iter().flatten();
        let files: Vec<String> = files.map(|path| path.display().to_string()).collect();
        let said: String = lacking.iter().chain(&to_know).map(|s| format!("  {s}\n")).collect();
        let is_slower = longer_step_s(&model, format, &options).is_some();
        let kept = kept(&exported, &model, price.as_ref(), is_slower).map(|s| format!("  {s}\n"));
        format!("{}\n{said}{}", files.join(", "), kept.unwrap_or_default())
    });
    console.next("get gains for a controller", &format!("motorlens tune {}", next::shell(&args.model)));
    Ok(())
}

/// That nothing of `model` is lost, where that was measured or holds by construction; what was not run elsewhere is not said to cost nothing there.
fn kept(exported: &Exported, model: &Model, price: Option<&Cost>, is_slower: bool) -> Option<String> {
    if exported.carried != model.values() || price.is_some_and(Cost::is_too_high) {
        return None;
    }
    match (exported.stepper, price) {
        (Stepper::Mujoco(_), None) => Some(
            "Every effect of the model is written; --on LOG runs it in MuJoCo and tells what its own steps cost."
                .into(),
        ),
        (Stepper::Mujoco(_), Some(price)) if price.tool.is_none() => {
            Some("Every effect of the model is written.".into())
        }
        (_, Some(price)) if price.errors.is_some() => {
            let there = price.tool.map_or(String::new(), |tool| format!(" in {tool}"));
            Some(format!("Nothing is lost{there}: {}.", price.clause()))
        }
        (Stepper::Program(_), None) if !is_slower => {
            Some("Nothing is lost: its steps are those of the model itself.".into())
        }
        _ => None,
    }
}

/// What it costs, with a bar while MuJoCo runs.
fn watched_cost(
    model: &Model,
    exported: &Exported,
    records: &[Record],
    motor: &MotorFile,
    console: &Console,
) -> Result<Cost> {
    if records.is_empty() || !matches!(exported.stepper, Stepper::Mujoco(_)) {
        return cost(model, exported, records, motor, None, &mut |_| ControlFlow::Continue(()));
    }
    console.say("Running MuJoCo on the records ...");
    let bar = watch::bar(console, 100, "% of their steps");
    let price = cost(model, exported, records, motor, Some(&python()), &mut |event| {
        if let Event::Running { share } = event {
            bar.set_position((100.0 * share) as u64);
        }
        ControlFlow::Continue(())
    });
    bar.finish_and_clear();
    price
}

/// The Python that is asked for MuJoCo, as CC names the compiler of an FMU.
fn python() -> PathBuf {
    std::env::var_os("PYTHON").map_or_else(|| "python3".into(), PathBuf::from)
}

fn positive(text: &str) -> Result<f64, String> {
    text.parse()
        .ok()
        .filter(|x: &f64| x.is_finite() && *x > 0.0)
        .ok_or_else(|| "give a positive number".into())
}

/// The exact map holds up to some dozens of electrical time constants.
fn step(text: &str) -> Result<f64, String> {
    positive(text).and_then(|s| if s <= 0.01 { Ok(s) } else { Err("give at most 0.01 s".into()) })
}
