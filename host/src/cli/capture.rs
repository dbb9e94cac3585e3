//! `capture`: runs programmes on the board and saves the logs.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{SystemTime, UNIX_EPOCH};

use clap::ValueEnum;
use motorlens_shared::excitation::Programme;
use motorlens_shared::link::{Cause, DriveMode, Setup};
use serde::Serialize;

use super::interrupt::interrupted;
use super::strip::Strip;
use super::{Console, next};
use crate::device::{Capture, Captured, Port, Shaft, WAITING, record, remedy, wiring};
use crate::error::{BadInput, Error, Result};
use crate::log::write_canonical;
use crate::motor_file;
use crate::simulate::{Excitation, Play, Role, plays};

/// How the driver is driven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Drive {
    /// Direction pins and PWM; the motor is shorted in the off part
    Brake,
    /// Direction pins and PWM; the motor floats in the off part
    Coast,
    /// The PWM reverses the bridge; half duty is no voltage
    AntiPhase,
    /// Two PWM inputs (DRV8833, DRV8871, BTS7960); the motor is shorted in the off part
    InIn,
    /// Two PWM inputs (DRV8833, DRV8871); the motor floats in the off part
    InInCoast,
}

impl Drive {
    /// As the board is told.
    pub(super) const fn mode(self) -> DriveMode {
        match self {
            Self::Brake => DriveMode::SignMagnitudeBrake,
            Self::Coast => DriveMode::SignMagnitudeCoast,
            Self::AntiPhase => DriveMode::LockedAntiPhase,
            Self::InIn => DriveMode::InInBrake,
            Self::InInCoast => DriveMode::InInCoast,
        }
    }
}

/// What is wired to the board's converter.
#[derive(Debug, Clone, Copy, Default, clap::Args)]
pub struct Wired {
    /// A divider from the supply to the board's supply input, by what it divides (11 for 10 kOhm over 1 kOhm): the supply is measured
    #[arg(long, value_name = "RATIO")]
    pub divider: Option<f32>,
    /// A current amplifier that rests at half of 3.3 V, at the board's current input, in mV per ampere (100 for an INA240A2 over 2 mOhm; no
    /// sensor on 5 V, which rests at 2.5 V and can harm the input): the current is measured
    #[arg(long, value_name = "MV_PER_A")]
    pub amplifier: Option<f32>,
}

/// Options of `capture`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens capture --port /dev/ttyACM0 --programme default --counts-per-rev 5000 --out logs
  motorlens capture --listen --port /dev/ttyACM0 --supply 12 --counts-per-rev 1320 --out logs")]
pub struct Args {
    /// A serial port, or tcp://host:port
    #[arg(long)]
    pub port: String,
    /// Save what the board prints as lines of text (docs/LINE_PROTOCOL.md): it plays its own programmes
    #[arg(long, conflicts_with_all = ["programme", "rate", "seconds", "amplitude", "drive", "duty_limit", "current_limit", "divider", "amplifier", "stall_voltage", "stall_time", "keep_every", "pwm_frequency", "seed"])]
    pub listen: bool,
    /// Speed of the line with --listen
    #[arg(long, default_value_t = 250_000, requires = "listen")]
    pub baud: u32,
    /// What to play: default, paper, sine, multisine, chirp, staircase, triangle, prbs, pulse, or a programme as JSON (FILE)
    #[arg(long, value_name = "NAME|FILE.json", default_value = "default")]
    pub programme: String,
    /// Directory for the logs
    #[arg(short, long, value_name = "DIR", default_value = "captured")]
    pub out: PathBuf,
    /// What is known of the motor; counts_per_rev turns counts into angles
    #[arg(short, long, value_name = "motor.toml")]
    pub motor: Option<PathBuf>,
    /// Counts per turn of the output shaft, after x4 and gearing, where no motor file says it
    #[arg(long, value_name = "COUNTS")]
    pub counts_per_rev: Option<f64>,
    /// Samples per second: 100 to 2000, a divisor of a million
    #[arg(long, value_name = "HZ", default_value_t = 1000)]
    pub rate: u16,
    /// Length of every log in seconds [default: the programme's own]
    #[arg(long, value_name = "SECONDS")]
    pub seconds: Option<f32>,
    /// Largest voltage of a single shape [default: three quarters of the supply]
    #[arg(long, value_name = "VOLTS")]
    pub amplitude: Option<f32>,
    /// How the driver is driven
    #[arg(long, value_enum, default_value = "brake")]
    pub drive: Drive,
    /// Supply of the driver in volts; where the board measures it (--divider), half to one and a half of it is allowed
    #[arg(long, value_name = "VOLTS", default_value_t = 12.0)]
    pub supply: f32,
    #[command(flatten)]
    pub wired: Wired,
    /// Largest share of the supply that is ever applied, 0.001 to 1
    #[arg(long, value_name = "SHARE", default_value_t = 1.0)]
    pub duty_limit: f32,
    /// Stop above this current in amperes, where the board measures it (--amplifier)
    #[arg(long, value_name = "AMPERES", default_value_t = 0.0)]
    pub current_limit: f32,
    /// Stop when the encoder stands while at least this is applied, in volts; `device check` measures where the motor breaks
    /// away, which belongs below it [default: a third of the supply]
    #[arg(long, value_name = "VOLTS")]
    pub stall_voltage: Option<f32>,
    /// And stands for so long, in seconds; 0 never stops a stalled motor
    #[arg(long, value_name = "SECONDS", default_value_t = 0.5)]
    pub stall_time: f32,
    /// Keep one sample of so many for the fit on the board
    #[arg(long, value_name = "N", default_value_t = 5)]
    pub keep_every: u16,
    /// Frequency of the PWM, 5000 to 50000; the board takes the nearest that divides the time between samples [default: 20000]
    #[arg(long, value_name = "HZ")]
    pub pwm_frequency: Option<u32>,
    /// Picks phases and orders
    #[arg(long, default_value_t = 1)]
    pub seed: u32,
}

#[derive(Serialize)]
struct Saved {
    log: PathBuf,
    ended: String,
    samples: usize,
    missing: u32,
    finished: bool,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    logs: Vec<Saved>,
    damaged_frames: u64,
}

/// Runs every programme; each log is saved whole before the next begins.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    if args.listen {
        return super::listen::run(args, console);
    }
    let shaft = shaft(args)?;
    let setup = setup(args)?;
    let plays = programmes(args)?;
    for play in &plays {
        let limit = args.supply * args.duty_limit;
        play.programme.validate(limit).map_err(|error| {
            Error::usage(
                format!("{}: {error}", play.programme.name),
                "lower --amplitude or raise --duty-limit",
            )
        })?;
    }
    std::fs::create_dir_all(&args.out)
        .map_err(|source| Error::Io { doing: format!("cannot make {}", args.out.display()), source })?;
    let mut port = Port::open(&args.port)?;
    let interrupted = interrupted();
    let mut document = Document { schema: 1, logs: Vec::new(), damaged_frames: 0 };
    let mut run = run_number();
    for (index, play) in plays.iter().enumerate() {
        // The run before may have left a pendulum swinging.
        let mut capture = Capture::new(setup, &play.programme, run).patient();
        let outcome = converse(
            &mut port,
            &mut capture,
            &play.log_name(),
            play.programme.seconds(),
            Some(&shaft),
            &interrupted,
            console,
        );
        run = capture.run().wrapping_add(1);
        // What came before the line was lost is worth keeping too.
        let captured = outcome.as_ref().ok().cloned().or_else(|| capture.so_far());
        document.damaged_frames += capture.damaged();
        // A run that did not begin leaves no log.
        let logged = captured.as_ref().filter(|captured| !captured.samples.is_empty());
        if let Some(captured) = logged {
            document.logs.push(save(captured, &shaft, play, &args.out)?);
            if let (0, Some(other)) = (index, other_frequency(args.pwm_frequency, captured)) {
                console.say(other);
            }
        }
        let cause = outcome.map_err(|error| told(error, logged, &args.out, play))?.cause;
        if cause != Cause::Finished {
            let reset = captured.as_ref().map(|captured| captured.status.reset);
            let because = reset.filter(|reset| cause == Cause::Watchdog && reset.lost_control());
            let because = because.map_or(String::new(), |reset| format!(", because {reset}"));
            let kept = kept(logged, &args.out, play);
            let why = format!("{}: {cause}{because} ({kept})", play.programme.name);
            return Err(Error::device(why, remedy(cause)));
        }
    }
    console.answer(&document, || {
        let lines = document.logs.iter().map(|saved| {
            format!("{}: {} samples, {} missing", saved.log.display(), saved.samples, saved.missing)
        });
        lines.collect::<Vec<_>>().join("\n")
    });
    discover_next(document.logs.iter().map(|saved| saved.log.as_path()), console);
    Ok(())
}

/// Names the command for logs that are new: those held out judge.
pub(super) fn discover_next<'a>(logs: impl Iterator<Item = &'a Path>, console: &Console) {
    let held_out =
        |log: &&Path| log.file_name().is_some_and(|name| name.to_string_lossy().starts_with("holdout-"));
    let (judge, fit): (Vec<&Path>, Vec<&Path>) = logs.partition(held_out);
    let fit: Vec<String> = fit.into_iter().map(next::shell).collect();
    let judge = judge.into_iter().map(|log| format!(" --validate {}", next::shell(log)));
    if !fit.is_empty() {
        let command =
            format!("motorlens discover {}{} --out model.json", fit.join(" "), judge.collect::<String>());
        console.next("find what is missing", &command);
    }
}

/// Any number but the board's last one: the time is never the same again.
pub(super) fn run_number() -> u32 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(1, |since| since.as_millis() as u32)
}

/// Writes a run's log, whole or not at all.
fn save(captured: &Captured, shaft: &Shaft, play: &Play, directory: &Path) -> Result<Saved> {
    let log = directory.join(format!("{}.csv", play.log_name()));
    let record = record(captured, shaft, &play.programme)
        .map_err(|why| Error::usage(why, "give the programme a name without line breaks"))?;
    write_canonical(&record, &log)?;
    Ok(Saved {
        log,
        ended: captured.cause.to_string(),
        samples: captured.samples.len(),
        missing: captured.holes.iter().map(|hole| hole.end - hole.start).sum(),
        finished: captured.cause == Cause::Finished,
    })
}

/// Where the log so far is, in words.
fn kept(captured: Option<&Captured>, directory: &Path, play: &Play) -> String {
    captured.map_or_else(
        || "nothing was logged".to_owned(),
        |captured| {
            let log = directory.join(format!("{}.csv", play.log_name()));
            format!("the {} samples so far are in {}", captured.samples.len(), log.display())
        },
    )
}

/// A failure of the line, with what became of the log.
fn told(error: Error, captured: Option<&Captured>, directory: &Path, play: &Play) -> Error {
    match error {
        Error::Device { why, remedy } => {
            Error::Device { why: format!("{why} ({})", kept(captured, directory, play)), remedy }
        }
        other => other,
    }
}

/// Follows one run to its end. Ctrl-C stops the motor at once; the log so far still comes.
pub(super) fn converse(
    port: &mut Port,
    capture: &mut Capture,
    name: &str,
    seconds: f32,
    shaft: Option<&Shaft>,
    interrupted: &AtomicBool,
    console: &Console,
) -> Result<Captured> {
    let total = (seconds * f32::from(capture.setup().rate_hz)).round() as u64;
    let mut strip = Strip::new(name, total, shaft, console);
    let mut told = false;
    let outcome = port.converse(|now, received, send| {
        capture.receive(received, now);
        if interrupted.swap(false, Ordering::Relaxed) {
            capture.stop(now);
        }
        capture.poll(now, send);
        if capture.waits() && !std::mem::replace(&mut told, true) {
            strip.aside(|| console.say(WAITING));
        }
        strip.show(capture, now);
        capture.take_outcome()
    });
    strip.clear();
    Ok(outcome??)
}

/// The words for a PWM that is not at the frequency asked for, by more than the board's rounding to whole periods in a sample.
fn other_frequency(asked: Option<u32>, captured: &Captured) -> Option<String> {
    let (asked, has) = (asked?, captured.capabilities.pwm_hz);
    // At 2000 samples a second whole periods lie 2 kHz apart.
    (has.abs_diff(asked) > 1_000 + asked / 20).then(|| {
        format!(
            "the board's PWM runs at {has} Hz and not at the {asked} Hz asked for: its firmware is older than the choice\n  do: \
             flash the firmware that belongs to this program, or leave --pwm-frequency away"
        )
    })
}

fn setup(args: &Args) -> Result<Setup> {
    let Wired { divider, amplifier } = args.wired;
    let setup = Setup {
        rate_hz: args.rate,
        drive: args.drive.mode(),
        duty_limit: (args.duty_limit * 1000.0).round() as u16,
        stall_mv: (args.stall_voltage.unwrap_or(args.supply / 3.0) * 1000.0).round() as u16,
        stall_ms: (args.stall_time * 1000.0).round() as u16,
        keep_every: args.keep_every,
        pwm_hz: args.pwm_frequency.unwrap_or(0),
        // Half a second, or less where the board's log would not last for twice that.
        link_timeout_ms: (500_000 / u32::from(args.rate.max(1))).clamp(1, 500) as u16,
        ..wiring::setup(args.supply, divider, amplifier, args.current_limit)?
    };
    // The board checks again, with its own log and sensors.
    setup
        .check(1024, true)
        .map_err(|fault| Error::usage(fault.to_string(), "see motorlens capture --help"))?;
    Ok(setup)
}

fn programmes(args: &Args) -> Result<Vec<Play>> {
    if let Ok(excitation) = Excitation::from_str(&args.programme, true) {
        let amplitude = args.amplitude.unwrap_or(0.75 * args.supply);
        return Ok(plays(excitation, amplitude, args.supply, args.seconds, args.seed));
    }
    let path = Path::new(&args.programme);
    let remedy = "name one of default, paper, sine, multisine, chirp, staircase, triangle, prbs, pulse, or a JSON file";
    let text =
        std::fs::read_to_string(path).map_err(|error| BadInput::new(path, error.to_string(), remedy))?;
    let programme: Programme =
        serde_json::from_str(&text).map_err(|error| BadInput::new(path, error.to_string(), remedy))?;
    Ok(vec![Play { role: Role::Training, programme }])
}

/// What turns counts into angles, from the options and the motor file.
pub(super) fn shaft(args: &Args) -> Result<Shaft> {
    let motor = args.motor.as_deref().map_or_else(|| Ok(Default::default()), motor_file::read)?;
    let counts = args.counts_per_rev.or(motor.counts_per_rev).filter(|counts| *counts > 0.0);
    let counts_per_rev = counts.ok_or_else(|| {
        Error::usage(
            "how many encoder counts make a turn of the output shaft?",
            "give --counts-per-rev N, or --motor motor.toml with counts_per_rev",
        )
    })?;
    Ok(Shaft { counts_per_rev, gear_ratio: motor.gear_ratio, encoder: motor.encoder_shaft })
}
