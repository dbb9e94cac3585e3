//! The options of `simulate` and `reveal`.

use std::path::PathBuf;

use clap::{Args, ValueEnum};
use motorlens_virtual_motor::{Effect, Motor, Run};

use super::custom::Custom;
use super::excitation::{self, Excitation, Play};
use super::{Scenario, hidden};
use crate::error::{Error, Result};
use crate::formula::Library;

/// Which motor is simulated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum MotorChoice {
    /// Gear 104, 5000 counts on the output shaft, like the paper's
    Paper,
    /// Gear 30, 48 counts on the motor shaft
    Small,
    /// Any motor with a gear of 5 to 104, picked by the seed
    Random,
}

/// Make logs from the virtual motor.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  motorlens simulate -e coulomb=0.3 -e backlash -o logs
  motorlens simulate --hidden 5 -o logs && motorlens reveal logs")]
pub struct SimulateArgs {
    /// Directory for the logs, motor.toml and the sealed answer
    #[arg(short, long, value_name = "DIR", default_value = "simulated")]
    pub out: PathBuf,
    /// An effect, at its typical size or a given one: coulomb, coulomb=0.3, stribeck=0.3,speed=0.02; repeatable
    #[arg(short, long = "effect", value_name = "NAME[=SIZE]", conflicts_with = "hidden")]
    pub effects: Vec<String>,
    /// Let this number pick effects (and a motor, without --motor) and tell nobody
    #[arg(long, value_name = "SEED")]
    pub hidden: Option<u64>,
    /// The motor [default: paper; random with --hidden]
    #[arg(long, value_enum)]
    pub motor: Option<MotorChoice>,
    /// What the motor is asked to do
    #[arg(long, value_enum, default_value_t)]
    pub excitation: Excitation,
    /// Length of every log, in seconds [default: 8; 12 for paper]
    #[arg(long, value_name = "SECONDS", value_parser = positive)]
    pub seconds: Option<f64>,
    /// Largest voltage of a single shape [default: three quarters of the supply]
    #[arg(long, value_name = "VOLTS", value_parser = positive)]
    pub amplitude: Option<f64>,
    /// Samples per second
    #[arg(long, value_name = "HZ", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=50_000))]
    pub rate: u32,
    /// Picks all noise, the order of staircases, the phases of multisines and a random motor
    #[arg(long, default_value_t = 1)]
    pub seed: u64,
    /// Torque disturbance, as a share of the stall torque (0.01 is 1 %)
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub disturbance: f64,
    /// Noise on the logged voltage, in volts
    #[arg(long, value_name = "VOLTS", default_value_t = 0.0, value_parser = not_negative)]
    pub voltage_noise: f64,
    /// The logged voltage is late by this many samples (early if negative)
    #[arg(long, value_name = "SAMPLES", default_value_t = 0, allow_negative_numbers = true)]
    pub voltage_shift: i32,
    /// Jitter of the sampling instants, as a share of their period
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub jitter: f64,
    /// Share of the rows that are missing
    #[arg(long, value_name = "SHARE", default_value_t = 0.0, value_parser = share)]
    pub missing: f64,
    /// Start every log in motion, after half a second at this voltage
    #[arg(long, value_name = "VOLTS", default_value_t = 0.0, allow_negative_numbers = true)]
    pub start_volts: f64,
    /// Keep the motor warm from log to log, with this pause between them, in seconds
    #[arg(long, value_name = "PAUSE", value_parser = not_negative)]
    pub warm: Option<f64>,
    /// Log the current too
    #[arg(long)]
    pub current: bool,
    /// Log the supply voltage too
    #[arg(long)]
    pub supply: bool,
    /// The effects that a name may mean.
    #[arg(skip)]
    pub library: Library,
}

/// Tell which effects `simulate --hidden` picked.
#[derive(Debug, Clone, Args)]
#[command(after_help = "Examples:
  motorlens reveal logs")]
pub struct RevealArgs {
    /// The directory that simulate wrote
    #[arg(value_name = "DIR", default_value = "simulated")]
    pub directory: PathBuf,
}

impl SimulateArgs {
    /// The motor, its effects and how it is recorded.
    ///
    /// # Errors
    /// Wrong usage where an effect cannot be understood.
    pub fn scenario(&self) -> Result<Scenario> {
        let choice = self.motor.unwrap_or(match self.hidden {
            Some(_) => MotorChoice::Random,
            None => MotorChoice::Paper,
        });
        let motor = match choice {
            MotorChoice::Paper => Motor::paper(),
            MotorChoice::Small => Motor::small(),
            MotorChoice::Random => Motor::hidden(self.hidden.unwrap_or(self.seed)),
        };
        let (effects, formulas) = match self.hidden {
            Some(seed) => (hidden(seed, &motor), Vec::new()),
            None => self.named_effects()?,
        };
        let run = Run {
            disturbance: self.disturbance,
            voltage_noise_v: self.voltage_noise,
            voltage_shift: self.voltage_shift,
            start_v: self.start_volts,
            jitter: self.jitter,
            missing: self.missing,
            pause_s: self.warm,
            ..Run::at(f64::from(self.rate))
        };
        Ok(Scenario {
            motor,
            effects,
            formulas,
            run,
            rate_hz: self.rate,
            seed: self.seed,
            current: self.current,
            supply: self.supply,
        })
    }

    /// The programmes to play.
    ///
    /// # Errors
    /// Wrong usage where one cannot be played at this rate or exceeds the supply.
    pub fn plays(&self, supply_v: f64) -> Result<Vec<Play>> {
        let plays = excitation::plays(
            self.excitation,
            self.amplitude.unwrap_or(0.75 * supply_v) as f32,
            supply_v as f32,
            self.seconds.map(|seconds| seconds as f32),
            self.seed as u32,
        );
        for play in &plays {
            play.programme.validate(supply_v as f32).map_err(|error| unplayable(play, &error))?;
        }
        Ok(plays)
    }

    fn named_effects(&self) -> Result<(Vec<Effect>, Vec<Custom>)> {
        let mut effects: Vec<Effect> = Vec::new();
        let mut formulas: Vec<Custom> = Vec::new();
        for text in self.effects.iter().filter(|text| *text != "none") {
            if let Some(own) = Custom::parse(text, &self.library)? {
                formulas.push(own);
                continue;
            }
            let effect = Effect::parse(text).map_err(|error| {
                Error::usage(format!("--effect {text}: {error}"), "see motorlens effects")
            })?;
            if effects.iter().any(|other| other.kind() == effect.kind()) {
                let why = format!("--effect {} is given twice", effect.name());
                return Err(Error::usage(why, "give each effect once"));
            }
            effects.push(effect);
        }
        Ok((effects, formulas))
    }
}

/// The wrong usage behind a programme that cannot be played.
pub(super) fn unplayable(play: &Play, error: &dyn std::error::Error) -> Error {
    Error::usage(
        format!("the programme {} cannot be played: {error}", play.programme.name),
        "change --seconds, --rate or --amplitude",
    )
}

fn number(text: &str, legal: impl Fn(f64) -> bool, wanted: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if value.is_finite() && legal(value) => Ok(value),
        _ => Err(format!("give {wanted}")),
    }
}

fn positive(text: &str) -> Result<f64, String> {
    number(text, |value| value > 0.0, "a positive number")
}

fn not_negative(text: &str) -> Result<f64, String> {
    number(text, |value| value >= 0.0, "a number that is not negative")
}

fn share(text: &str) -> Result<f64, String> {
    number(text, |value| (0.0..=0.9).contains(&value), "a share from 0 to 0.9")
}
