//! `device`: asks the board, fits on it, stops it, flashes it.

use std::path::PathBuf;
use std::process::Command;

use motorlens_shared::link::{Capabilities, FromBoard, ToBoard};
use motorlens_shared::quickfit::{QuickFit, Request};
use serde_json::json;

use super::Console;
use crate::device::{Fault, Inquiry, Port};
use crate::error::{BadInput, Error, Result};
use crate::motor_file;

/// Options of `device`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens device check --port /dev/ttyACM0
  motorlens device fit --port /dev/ttyACM0 --counts-per-rev 5000 --coulomb")]
pub struct Args {
    #[command(subcommand)]
    pub action: Action,
}

/// What to do with the board.
#[derive(Debug, clap::Subcommand)]
pub enum Action {
    /// Who is there, and what can it do?
    #[command(after_help = "Example:
  motorlens device hello --port /dev/ttyACM0")]
    Hello(At),
    /// Fit the samples that the board keeps of its last run, on the board
    Fit(FitArgs),
    /// Is everything wired right? Turns the motor slowly both ways for eight seconds
    Check(super::device_check::Args),
    /// Stop the motor
    #[command(after_help = "Example:
  motorlens device stop --port /dev/ttyACM0")]
    Stop(At),
    /// Leave the firmware for the chip's own boot loader, to flash over USB or serial without a debugger
    #[command(after_help = "Example:
  motorlens device bootloader --port /dev/ttyACM0")]
    Bootloader(At),
    /// Write a firmware image to the board, through its debugger
    Flash(FlashArgs),
}

/// Where the board is.
#[derive(Debug, clap::Args)]
pub struct At {
    /// A serial port, or tcp://host:port
    #[arg(long)]
    pub port: String,
}

/// Options of `device fit`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Examples:
  motorlens device fit --port /dev/ttyACM0 --counts-per-rev 5000 --coulomb
  motorlens device fit --port tcp://bench.local:4000 -m motor.toml --population 32")]
pub struct FitArgs {
    #[command(flatten)]
    pub at: At,
    /// Fit Coulomb friction too
    #[arg(long)]
    pub coulomb: bool,
    /// Chromosomes
    #[arg(long, default_value_t = 16, value_parser = clap::value_parser!(u8).range(2..=64))]
    pub population: u8,
    /// Generations
    #[arg(long, default_value_t = 40, value_parser = clap::value_parser!(u16).range(1..=1000))]
    pub generations: u16,
    /// The same seed gives the same result
    #[arg(long, default_value_t = 1)]
    pub seed: u32,
    /// Counts per turn of the output shaft, after x4 and gearing
    #[arg(long, value_name = "COUNTS")]
    pub counts_per_rev: Option<f64>,
    /// What is known of the motor
    #[arg(short, long, value_name = "motor.toml")]
    pub motor: Option<PathBuf>,
}

/// Options of `device flash`.
#[derive(Debug, clap::Args)]
#[command(after_help = "Example:
  motorlens device flash target/arm/thumbv7em-none-eabihf/release/motorlens-nucleo-f446re")]
pub struct FlashArgs {
    /// The image, an ELF file; `cargo xtask sizes` builds each board's: target/arm/thumbv7em-none-eabihf/release/motorlens-*
    pub image: PathBuf,
    /// The chip
    #[arg(long, default_value = "STM32F446RETx")]
    pub chip: String,
}

/// Does it.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    match &args.action {
        Action::Hello(at) => hello(at, console),
        Action::Fit(args) => fit(args, console),
        Action::Check(args) => super::device_check::run(args, console),
        Action::Stop(at) => stop(at, console),
        Action::Bootloader(at) => bootloader(at, console),
        Action::Flash(args) => flash(args, console),
    }
}

fn ask(port: &mut Port, mut inquiry: Inquiry, console: &Console) -> Result<Vec<FromBoard>> {
    let mut said = 0;
    let answers = port.converse(|now, received, send| {
        inquiry.receive(received, now);
        inquiry.poll(now, send);
        if let Some(progress) = inquiry.progress().filter(|progress| progress.generation > said) {
            said = progress.generation;
            console.say(format!("generation {said} of {}, IAE {:.4}", progress.generations, progress.iae));
        }
        inquiry.take_outcome()
    })?;
    Ok(answers?)
}

fn hello(at: &At, console: &Console) -> Result<()> {
    let mut port = Port::open(&at.port)?;
    let answers = ask(&mut port, Inquiry::new([ToBoard::Capabilities, ToBoard::Status]), console)?;
    let [FromBoard::Hello(hello), FromBoard::Capabilities(can), FromBoard::Status(status)] = &answers[..]
    else {
        return Err(Fault::Confused.into());
    };
    let names = (0..can.effects).map(|index| ToBoard::EffectName { index });
    let effects: Vec<String> = ask(&mut port, Inquiry::new(names), console)?
        .into_iter()
        .filter_map(|answer| match answer {
            FromBoard::EffectName(name) => Some(name.to_string()),
            _ => None,
        })
        .collect();
    let unique: String = hello.unique.iter().map(|byte| format!("{byte:02x}")).collect();
    let version = hello.firmware.map(|part| part.to_string()).join(".");
    let document = json!({
        "schema": 1, "firmware": version, "unique": unique,
        "link": { "oldest": hello.oldest, "newest": hello.newest },
        "capabilities": can, "effects": effects, "status": status,
    });
    console.answer(&document, || {
        format!(
            "firmware {version} on board {unique}, core {} MHz, PWM {} kHz\n\
             {}; log of {} samples, fit of {}\nstate: {:?}, run {}, {} samples\neffects: {}",
            can.core_hz / 1_000_000,
            can.pwm_hz / 1000,
            measures(can),
            can.log_samples,
            can.fit_samples,
            status.state,
            status.run,
            status.next,
            effects.join(" "),
        )
    });
    console.next("check the wiring", &format!("motorlens device check --port {}", at.port));
    Ok(())
}

/// Whether a board measures supply and current. One that cannot be told what is wired says what is built in.
fn measures(can: &Capabilities) -> String {
    if can.converter {
        return "measures supply and current where --divider and --amplifier say what is wired".into();
    }
    let supply = if can.measures_supply { "measured" } else { "stated" };
    let current = if can.measures_current { "measured" } else { "not measured" };
    format!("supply {supply}, current {current}")
}

fn fit(args: &FitArgs, console: &Console) -> Result<()> {
    let motor = args.motor.as_deref().map_or_else(|| Ok(Default::default()), motor_file::read)?;
    let counts =
        args.counts_per_rev.or(motor.counts_per_rev).filter(|counts| *counts > 0.0).ok_or_else(|| {
            Error::usage(
                "how many encoder counts make a turn of the output shaft?",
                "give --counts-per-rev N, or --motor motor.toml with counts_per_rev",
            )
        })?;
    let request = Request {
        population: args.population,
        generations: args.generations,
        seed: args.seed,
        coulomb: args.coulomb,
        rad_per_count: (std::f64::consts::TAU / counts) as f32,
    };
    let mut port = Port::open(&args.at.port)?;
    let answers = ask(&mut port, Inquiry::new([ToBoard::QuickFit(request)]), console)?;
    let Some(FromBoard::Fit(Some(fit))) = answers.last() else {
        return Err(Error::device(
            "the board found nothing to fit: the motor did not move",
            "capture a run that moves the motor first",
        ));
    };
    console.answer(&json!({ "schema": 1, "fit": fit, "seed": args.seed }), || prose(fit));
    console.next("find what this model is missing", "motorlens discover LOG... --out model.json");
    Ok(())
}

fn prose(fit: &QuickFit) -> String {
    let row = |name: &str, unit: &str, estimate: motorlens_shared::quickfit::Estimate| {
        format!("{name:8} {:>12.6} +- {:<10.2e} {unit}\n", estimate.value, estimate.standard_error)
    };
    let mut text =
        row("gain", "rad/s per V", fit.gain) + &row("tau_m", "s", fit.tau_m) + &row("tau_e", "s", fit.tau_e);
    if let Some(coulomb) = fit.coulomb {
        text += &row("coulomb", "V", coulomb);
    }
    text + &format!(
        "rmse {:.5} rad, IAE {:.4} rad s on {} samples, in {:.3} s on the board",
        fit.rmse,
        fit.iae,
        fit.samples,
        f64::from(fit.micros) * 1e-6
    )
}

fn stop(at: &At, console: &Console) -> Result<()> {
    let mut port = Port::open(&at.port)?;
    ask(&mut port, Inquiry::new([ToBoard::Stop]), console)?;
    console.answer(&json!({ "schema": 1, "stopped": true }), || "stopped: the bridge is off".to_owned());
    console.next("see what the board says of itself", &format!("motorlens device hello --port {}", at.port));
    Ok(())
}

fn bootloader(at: &At, console: &Console) -> Result<()> {
    let mut port = Port::open(&at.port)?;
    ask(&mut port, Inquiry::new([ToBoard::Bootloader]), console)?;
    console.answer(&json!({ "schema": 1, "bootloader": true }), || {
        "the chip's boot loader runs; an STM32: write the image with dfu-util or stm32flash, then reset the board; a Pico: drag its UF2 \
         file (cargo xtask uf2) onto the drive that appears"
            .to_owned()
    });
    Ok(())
}

fn flash(args: &FlashArgs, console: &Console) -> Result<()> {
    if !args.image.is_file() {
        let remedy = "build it with `cargo xtask sizes`, which leaves each board's image as \
                      target/arm/thumbv7em-none-eabihf/release/motorlens-stm32f407, -nucleo-f446re, -blackpill-f411";
        return Err(BadInput::new(&args.image, "there is no such image", remedy).into());
    }
    let remedy = "install it with `cargo install probe-rs-tools` and connect the board's debugger; or use \
                  `motorlens device bootloader` and dfu-util, or at a Pico its UF2 file (`cargo xtask uf2`)";
    let status = Command::new("probe-rs")
        .args(["download", "--chip", &args.chip])
        .arg(&args.image)
        .stdout(std::process::Stdio::null())
        .status()
        .map_err(|error| Error::device(format!("cannot run probe-rs: {error}"), remedy))?;
    if !status.success() {
        return Err(Error::device(
            format!("probe-rs could not flash {}", args.image.display()),
            "see its message above; check chip name, debugger and image",
        ));
    }
    console.answer(&json!({ "schema": 1, "flashed": args.image }), || "flashed; reset the board".to_owned());
    console.next("see whether it answers", "motorlens device hello --port PORT");
    Ok(())
}
