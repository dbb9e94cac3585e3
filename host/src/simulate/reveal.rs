//! The answer behind a hidden simulation.

use std::fmt;

use motorlens_virtual_motor::Motor;
use serde::{Deserialize, Serialize};

use super::custom::Custom;
use super::{RevealArgs, SEALED_FILE, Scenario, sealed};
use crate::error::{BadInput, Error, Result};

/// Which effects a simulation has: prose by `Display`, a JSON document by `Serialize`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    schema: u32,
    /// The names, in the order of the simulation; empty where nothing is missing.
    pub effects: Vec<String>,
    /// The same with their sizes to four digits, as they could be typed.
    pub sizes: Vec<String>,
    /// Steady output speed per volt of the motor without effects, rad/s per V.
    pub gain: f64,
    /// Its mechanical time constant, s.
    pub mechanical_time_constant_s: f64,
    /// Its electrical time constant, s.
    pub electrical_time_constant_s: f64,
}

impl Answer {
    /// The answer to a scenario.
    pub fn of(scenario: &Scenario) -> Self {
        let motor: &Motor = &scenario.motor;
        Self {
            schema: 1,
            effects: {
                let library = scenario.effects.iter().map(|effect| effect.name());
                library.chain(scenario.formulas.iter().map(Custom::name)).map(str::to_owned).collect()
            },
            sizes: scenario.effect_texts().iter().map(|text| typed(text)).collect(),
            gain: motor.gain(),
            mechanical_time_constant_s: motor.mechanical_time_constant(),
            electrical_time_constant_s: motor.electrical_time_constant(),
        }
    }
}

/// An effect such as `coulomb=0.37021538,asymmetry=-0.4084` with as many digits as somebody would type.
fn typed(text: &str) -> String {
    let short = |word: &str| match (word.split_once('='), word.rsplit('=').next().map(str::parse::<f64>)) {
        (Some((name, _)), Some(Ok(x))) => {
            let rounded: f64 = format!("{x:.3e}").parse().unwrap_or(x);
            format!("{name}={rounded}")
        }
        _ => word.to_owned(),
    };
    text.split(',').map(short).collect::<Vec<_>>().join(",")
}

/// The verb `reveal`: opens the sealed answer.
///
/// # Errors
/// Bad input where there is no sealed answer or it was changed.
pub fn reveal(args: &RevealArgs) -> Result<Answer> {
    let path = args.directory.join(SEALED_FILE);
    let remedy = "give a directory that motorlens simulate has written";
    let text = match std::fs::read_to_string(&path) {
        Ok(text) => text,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Err(BadInput::new(&path, "there is no sealed answer", remedy).into());
        }
        Err(source) => return Err(Error::Io { doing: format!("cannot read {}", path.display()), source }),
    };
    sealed::open(&text)
        .ok_or_else(|| BadInput::new(&path, "this is not a sealed answer, or it was changed", remedy).into())
}

impl fmt::Display for Answer {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.sizes.is_empty() {
            writeln!(f, "effects: none; nothing is missing from the base model")?;
        } else {
            writeln!(f, "effects: {}", self.sizes.join("  "))?;
        }
        writeln!(
            f,
            "motor:   {:.4} rad/s per V, mechanical {:.1} ms, electrical {:.2} ms",
            self.gain,
            1e3 * self.mechanical_time_constant_s,
            1e3 * self.electrical_time_constant_s
        )
    }
}
