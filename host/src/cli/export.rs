//! `export`: the model for other tools.

use std::path::PathBuf;

use serde::Serialize;

use super::Console;
use crate::atomic_file;
use crate::error::Result;
use crate::export::{Format, Options, export};
use crate::model_file::Model;

/// Options of `export`.
#[derive(Debug, clap::Args)]
pub struct Args {
    /// The model
    model: PathBuf,
    /// The target
    #[arg(long, value_enum)]
    format: Format,
    /// Write it here
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
    /// Step of a C or Python program, in seconds
    #[arg(long, value_name = "SECONDS", default_value_t = 1e-3, value_parser = step)]
    step: f64,
    /// Stall torque per volt at the output shaft in N m/V, for MuJoCo [default: torques in volts]
    #[arg(long, value_name = "TORQUE", default_value_t = 1.0, hide_default_value = true, value_parser = positive)]
    torque_per_volt: f64,
}

#[derive(Serialize)]
struct Document<'a> {
    schema: u32,
    format: Format,
    out: &'a PathBuf,
    left_out: &'a [String],
}

/// Writes the file and says what it does not have.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    let model = Model::read(&args.model)?;
    let options = Options { step_s: args.step, torque_per_volt: args.torque_per_volt };
    let exported = export(&model, args.format, &options);
    atomic_file::write(&args.out, &exported.text)?;
    let document = Document { schema: 1, format: args.format, out: &args.out, left_out: &exported.left_out };
    console.answer(&document, || {
        let said: String = exported.left_out.iter().map(|s| format!("  {s}\n")).collect();
        format!("{}\n{said}", args.out.display())
    });
    Ok(())
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
