//! Logs from the virtual motor, with effects that are known or hidden.
//!
//! A [`Scenario`] is a motor with its effects and how it is recorded; it makes [`Record`]s in memory. [`run`] writes
//! them as a directory of canonical logs with a `motor.toml`, and a sealed answer that [`reveal`] opens.

mod args;
mod custom;
mod excitation;
mod hidden;
mod nameplate;
mod reveal;
mod scenario;
mod sealed;

pub use args::{MotorChoice, RevealArgs, SimulateArgs};
pub use custom::Custom;
pub use excitation::{Excitation, Play, Role, plays};
pub use hidden::{alike, hidden};
pub use reveal::{Answer, reveal};
pub use scenario::Scenario;

use std::fmt;
use std::path::{Path, PathBuf};

use serde::Serialize;

use crate::error::{Error, Result};
use crate::log::{Record, write_canonical};
use crate::motor_file::MotorFile;
use crate::{atomic_file, motor_file};

/// Picks what the demo hides.
pub const DEMO: u64 = 25;

/// The name of the motor file in the directory of a simulation.
pub const MOTOR_FILE: &str = "motor.toml";
/// The name of the sealed answer there.
pub const SEALED_FILE: &str = "sealed";

/// What [`run`] wrote: prose by `Display`, a JSON document by `Serialize`.
#[derive(Debug, Clone, Serialize)]
pub struct Simulated {
    schema: u32,
    /// The directory.
    pub out: PathBuf,
    /// The motor file.
    pub motor: PathBuf,
    /// Logs to fit on.
    pub training: Vec<PathBuf>,
    /// Logs that repeat one of them, for the noise floor.
    pub repeats: Vec<PathBuf>,
    /// Logs to judge by.
    pub held_out: Vec<PathBuf>,
    /// Time on all logs together, s.
    pub recorded_s: f64,
    /// The effects, as they could be typed; absent where they are hidden.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub effects: Option<Vec<String>>,
}

/// What a data sheet tells of the motor of `scenario`, as its `motor.toml` has it.
///
/// # Errors
/// None that a user can cause.
pub fn data_sheet(scenario: &Scenario) -> Result<MotorFile> {
    motor_file::parse(Path::new(MOTOR_FILE), &nameplate::text(&scenario.motor, scenario.seed))
}

/// The verb `simulate`: writes logs, motor file and sealed answer.
///
/// # Errors
/// Wrong usage (an effect or programme that cannot be), or the machine's refusal to write.
pub fn run(args: &SimulateArgs) -> Result<Simulated> {
    let scenario = args.scenario()?;
    let plays = args.plays(scenario.motor.nominal_v)?;
    let records = scenario.records(&plays)?;
    std::fs::create_dir_all(&args.out).map_err(|source| Error::Io {
        doing: format!("cannot make the directory {}", args.out.display()),
        source,
    })?;
    let mut simulated = Simulated {
        schema: 1,
        out: args.out.clone(),
        motor: args.out.join(MOTOR_FILE),
        training: Vec::new(),
        repeats: Vec::new(),
        held_out: Vec::new(),
        recorded_s: records.iter().map(Record::duration_s).sum(),
        effects: args.hidden.is_none().then(|| scenario.effect_texts()),
    };
    for (play, record) in plays.iter().zip(&records) {
        let path = write(record, &args.out)?;
        match play.role {
            Role::Training => simulated.training.push(path),
            Role::Repeat => simulated.repeats.push(path),
            Role::HeldOut => simulated.held_out.push(path),
        }
    }
    data_sheet(&scenario)?;
    atomic_file::write(&simulated.motor, nameplate::text(&scenario.motor, scenario.seed))?;
    atomic_file::write(&args.out.join(SEALED_FILE), sealed::seal(&Answer::of(&scenario)))?;
    Ok(simulated)
}

fn write(record: &Record, directory: &Path) -> Result<PathBuf> {
    let path = directory.join(&record.name).with_extension("csv");
    write_canonical(record, &path)?;
    Ok(path)
}

impl fmt::Display for Simulated {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let names = |paths: &[PathBuf]| {
            let names = paths.iter().map(|path| path.display().to_string());
            names.collect::<Vec<_>>().join(" ")
        };
        writeln!(f, "{:.0} s of logs in {}", self.recorded_s, self.out.display())?;
        writeln!(f, "  motor:    {}", self.motor.display())?;
        writeln!(f, "  training: {}", names(&self.training))?;
        writeln!(f, "  repeat:   {}", names(&self.repeats))?;
        writeln!(f, "  held out: {}", names(&self.held_out))?;
        match &self.effects {
            None => writeln!(
                f,
                "  effects:  hidden; motorlens reveal {} tells, once you have your answer",
                self.out.display()
            ),
            Some(effects) if effects.is_empty() => writeln!(f, "  effects:  none"),
            Some(effects) => writeln!(f, "  effects:  {}", effects.join("  ")),
        }
    }
}

#[cfg(test)]
mod tests;
