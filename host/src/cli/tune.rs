//! `tune`: gains from a model, and what its effects cost under them.

use std::path::PathBuf;

use serde::Serialize;

use super::table::{Row, table};
use super::wrap::known_width;
use super::{Console, next, prose};
use crate::atomic_file;
use crate::error::{Error, Result};
use crate::model_file::Model;
use crate::tune::{Loop, Options, Step, Tracking, Trial, Tuned, plot, tune};

/// Options of `tune`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens tune model.json
  motorlens tune model.json --period 0.02 --phase-margin 50 --plot tune.svg")]
pub struct Args {
    /// The model
    model: PathBuf,
    /// Period of the controller, in seconds
    #[arg(short, long, value_name = "SECONDS", default_value_t = 0.005)]
    period: f64,
    /// Phase margin of both loops, in degrees
    #[arg(long, value_name = "DEGREES", default_value_t = 60.0)]
    phase_margin: f64,
    /// Largest voltage of the controller [default: the model's supply]
    #[arg(long, value_name = "VOLTS")]
    limit: Option<f64>,
    /// Draw the trials here
    #[arg(long, value_name = "FILE.svg")]
    plot: Option<PathBuf>,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    period_s: f64,
    #[serde(flatten)]
    tuned: Tuned,
}

/// Designs, tries, and tells.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    let model = Model::read(&args.model)?;
    let options = Options { period_s: args.period, phase_margin_deg: args.phase_margin, limit_v: args.limit };
    let tuned = tune(&model, &options)?;
    if let Some(path) = &args.plot {
        let drawing = plot(&tuned).map_err(|e| Error::Io {
            doing: format!("cannot draw {}", path.display()),
            source: std::io::Error::other(e.to_string()),
        })?;
        atomic_file::write(path, drawing)?;
    }
    let document = Document { schema: 1, period_s: args.period, tuned };
    console.answer(&document, || text(&document.tuned, args.period));
    let model = next::shell(&args.model);
    console.next("use the model in a program", &format!("motorlens export {model} --format c --out motor.c"));
    Ok(())
}

fn text(tuned: &Tuned, period: f64) -> String {
    let row = |name: &str, l: &Loop, unit: &str| {
        let m = &l.margins;
        format!(
            "{name:<9} kp {:>9.4} {unit:<8} ki {:>9.4}  kd {:>8.5}   crossover {:.2} Hz, phase margin {:.0} deg, gain margin {:.1}, delay margin {:.1} ms\n",
            l.kp,
            l.ki,
            l.kd,
            m.crossover_hz,
            m.phase_deg,
            m.gain,
            1e3 * m.delay_s
        )
    };
    let f = &tuned.feedforward;
    let mut text =
        format!("Period {:.1} ms; the loops are {:.2} ms late.\n", 1e3 * period, 1e3 * tuned.delay_s);
    text += &row("velocity", &tuned.velocity, "V s/rad");
    text += &row("position", &tuned.position, "V/rad");
    text += &format!(
        "feedforward  kS {:.4} V  kV {:.5} V s/rad  kA {:.6} V s^2/rad  kG {:.4} V  dead zone {:.4} V\n",
        f.ks_v, f.kv_v_s_per_rad, f.ka_v_s2_per_rad, f.kg_v, f.dead_zone_v
    );
    for load in &tuned.loads {
        let values: Vec<String> =
            load.parameters.iter().map(|p| format!("{} {:.4} {}", p.name, p.value, p.unit)).collect();
        text += &format!("{}: command -f, {}; {}\n", load.effect, load.equation, values.join(", "));
    }
    let width = known_width().unwrap_or(usize::MAX);
    text.push('\n');
    let heads = ["rms / rad", "worst", "at the end", "rms / rad/s"];
    let rows: Vec<Row> = tuned.trials.iter().map(tracked).collect();
    text += &table("a move there and back", &heads, &rows, width);
    for steps in Step::by_loop(&tuned.steps) {
        let Some(first) = steps.first() else { continue };
        let head = format!("a step of the {} by {} {}", first.of, prose::figure(first.height), first.unit());
        let rows: Vec<Row> = steps.into_iter().map(stepped).collect();
        text.push('\n');
        text += &table(&head, &["rise / s", "beyond", "settled", "left"], &rows, width);
    }
    text + "\n" + &tuned.advice.join("\n") + "\n"
}

/// How a move is followed.
fn tracked(trial: &Trial) -> Row {
    let Tracking { rms, worst, at_the_end } = trial.position;
    let cells = [rms, worst, at_the_end, trial.velocity.rms].map(prose::figure);
    Row { name: trial.compensation.into(), cells: cells.into(), remark: String::new() }
}

/// How a step is answered.
fn stepped(step: &Step) -> Row {
    let time = |time: Option<f64>| time.map_or_else(|| "never".into(), prose::figure);
    let moves = step.limit_cycle.map_or_else(String::new, |cycle| {
        let [amplitude, frequency] = [cycle.amplitude_rad, cycle.frequency_hz].map(prose::figure);
        format!("keeps moving by \u{b1}{amplitude} rad at {frequency} Hz")
    });
    let beyond = format!("{:.0}%", 100.0 * step.overshoot);
    let cells = [time(step.rise_s), beyond, time(step.settling_s), prose::figure(step.left)];
    Row { name: step.compensation.into(), cells: cells.into(), remark: moves }
}
