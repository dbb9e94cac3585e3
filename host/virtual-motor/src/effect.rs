//! A physical effect with its parameters, as users write it and as random draws make it.

use crate::motor::{EncoderShaft, Motor};
use crate::noise::{between, geometric};
use crate::table::{Kind, Parameter, ROWS};
use rand::{Rng, RngExt};
use std::fmt;

const MOST_PARAMETERS: usize = 4;

/// One effect and its size. See [`Kind::row`] for parameters, units and equations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Effect {
    kind: Kind,
    values: [f64; MOST_PARAMETERS],
}

/// Why a text is not an effect.
#[derive(Debug, Clone, PartialEq)]
pub enum EffectError {
    /// No effect has this name.
    UnknownEffect(String),
    /// The effect has no such parameter.
    UnknownParameter(Kind, String),
    /// Not a number.
    NotANumber(Kind, String),
    /// Outside the parameter's bounds.
    OutOfBounds(Kind, &'static str, f64),
}

impl fmt::Display for EffectError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let keys = |kind: &Kind| {
            let parameters = kind.row().parameters.iter();
            parameters.map(|p| format!("{} ({})", p.key, p.unit)).collect::<Vec<_>>().join(", ")
        };
        match self {
            Self::UnknownEffect(name) => {
                let names: Vec<_> = ROWS.iter().map(|row| row.name).collect();
                write!(f, "no effect is called '{name}'; choose from {}", names.join(", "))
            }
            Self::UnknownParameter(kind, key) => {
                write!(f, "{} has no parameter '{key}'; it has {}", kind.row().name, keys(kind))
            }
            Self::NotANumber(kind, text) => {
                let name = kind.row().name;
                write!(
                    f,
                    "'{text}' is not a number; write for example {}",
                    Effect::typical(*kind).example(name)
                )
            }
            Self::OutOfBounds(kind, key, value) => {
                let bounds = kind.row().parameters.iter().find(|p| p.key == *key).map(|p| p.bounds);
                let (low, high) = bounds.unwrap_or_default();
                write!(f, "{}: {key} = {value} is outside {low} to {high}", kind.row().name)
            }
        }
    }
}

impl std::error::Error for EffectError {}

impl Effect {
    /// The effect at its typical size.
    pub fn typical(kind: Kind) -> Self {
        let mut values = [0.0; MOST_PARAMETERS];
        for (value, parameter) in values.iter_mut().zip(kind.row().parameters) {
            *value = parameter.default;
        }
        Self { kind, values }
    }

    /// Reads `coulomb`, `coulomb=0.3` or `stribeck=0.3,speed=0.02`: the first number is the size, further ones
    /// are named; what is not named is typical.
    ///
    /// # Errors
    /// Unknown names, what is not a number, and values outside the bounds.
    pub fn parse(text: &str) -> Result<Self, EffectError> {
        let mut pieces = text.split(',').map(str::trim);
        let head = pieces.next().unwrap_or_default();
        let (name, size) = match head.split_once('=') {
            Some((name, size)) => (name.trim(), Some(size)),
            None => (head, None),
        };
        let row = ROWS
            .iter()
            .find(|row| row.name == name)
            .ok_or_else(|| EffectError::UnknownEffect(name.to_owned()))?;
        let mut effect = Self::typical(row.kind);
        if let Some(size) = size {
            effect.assign(0, size)?;
        }
        for piece in pieces {
            let (key, value) = piece.split_once('=').unwrap_or((piece, ""));
            let index = row
                .parameters
                .iter()
                .position(|parameter| parameter.key == key.trim())
                .ok_or_else(|| EffectError::UnknownParameter(row.kind, key.trim().to_owned()))?;
            effect.assign(index, value)?;
        }
        Ok(effect)
    }

    fn assign(&mut self, index: usize, text: &str) -> Result<(), EffectError> {
        let value: f64 =
            text.trim().parse().map_err(|_| EffectError::NotANumber(self.kind, text.trim().to_owned()))?;
        let parameter = &self.kind.row().parameters[index];
        if !(parameter.bounds.0..=parameter.bounds.1).contains(&value) {
            return Err(EffectError::OutOfBounds(self.kind, parameter.key, value));
        }
        self.values[index] = value;
        Ok(())
    }

    /// The effect at a random realistic size, from weak but visible to strong, on this motor.
    pub fn random(kind: Kind, rng: &mut impl Rng, motor: &Motor) -> Self {
        let strength = rng.random::<f64>();
        Self::graded(kind, strength, rng, motor)
    }

    /// The effect at `strength` from 0 (weak but visible) to 1 (strong), its other parameters random.
    pub fn graded(kind: Kind, strength: f64, rng: &mut impl Rng, motor: &Motor) -> Self {
        let mut effect = Self::typical(kind);
        let parameters = kind.row().parameters;
        let (weak, strong) = parameters[0].drawn;
        effect.values[0] = weak * (strong / weak).powf(strength);
        for (value, parameter) in effect.values.iter_mut().zip(parameters).skip(1) {
            *value = draw(parameter, rng);
        }
        match kind {
            Kind::ConstantLoad if rng.random() => effect.values[0] = -effect.values[0],
            Kind::CoulombAsymmetric if rng.random() => effect.values[1] = -effect.values[1],
            Kind::SensorLag => effect.values[1] = effect.values[1].round(),
            Kind::Cogging => {
                effect.values[1] = [3.0, 5.0, 6.0, 10.0, 12.0][rng.random_range(0..5)];
            }
            // A disc cannot be off centre by more than a third of its radius.
            Kind::Eccentricity => {
                effect.values[0] = effect.values[0].min(0.3 * motor.encoder_counts / std::f64::consts::TAU);
            }
            // Where the encoder sits before the gear, it sees of a gap only that the rotor is free in it.
            Kind::Backlash => {
                let counts = match motor.encoder_shaft {
                    EncoderShaft::Motor => 6.0,
                    EncoderShaft::Output => 4.0,
                };
                let visible = (counts * motor.count_rad().to_degrees()).min(8.0);
                effect.values[0] = effect.values[0].max(visible);
            }
            _ => {}
        }
        effect
    }

    /// Which effect.
    pub fn kind(&self) -> Kind {
        self.kind
    }

    /// Its name, as in the contract.
    pub fn name(&self) -> &'static str {
        self.kind.row().name
    }

    /// Its size: the first parameter.
    pub fn size(&self) -> f64 {
        self.values[0]
    }

    /// The parameters in the order of the row.
    pub(crate) fn values(&self) -> [f64; MOST_PARAMETERS] {
        self.values
    }

    fn example(&self, name: &str) -> String {
        format!("{name}={}", self.values[0])
    }
}

fn draw(parameter: &Parameter, rng: &mut impl Rng) -> f64 {
    let (low, high) = parameter.drawn;
    if low > 0.0 { geometric(rng, low, high) } else { between(rng, low, high) }
}

/// As [`Effect::parse`] reads it.
impl fmt::Display for Effect {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name(), self.values[0])?;
        for (parameter, value) in self.kind.row().parameters.iter().zip(self.values).skip(1) {
            write!(f, ",{}={value}", parameter.key)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::SeedableRng;
    use rand::rngs::ChaCha8Rng;

    #[test]
    fn reads_sizes_names_and_what_it_wrote() {
        assert_eq!(Effect::parse("coulomb").unwrap().size(), 0.3);
        assert_eq!(Effect::parse("coulomb=0.7").unwrap().size(), 0.7);
        let stribeck = Effect::parse("stribeck = 0.4 , speed = 0.05").unwrap();
        assert_eq!(stribeck.values, [0.4, 0.25, 0.05, 1.3]);
        assert_eq!(Effect::parse(&stribeck.to_string()).unwrap(), stribeck);
    }

    #[test]
    fn faults_say_what_would_be_right() {
        let fault = |text| Effect::parse(text).unwrap_err().to_string();
        assert!(fault("friction").contains("choose from coulomb, coulomb_asymmetric"));
        assert!(fault("backlash=1,width=3").contains("it has gap (deg), share (1)"));
        assert!(fault("coulomb=much").contains("write for example coulomb=0.3"));
        assert!(fault("coulomb=-1").contains("level = -1 is outside 0 to 6"));
        assert!(fault("coulomb=nan").contains("outside"));
    }

    #[test]
    fn random_effects_are_legal_on_every_motor() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        for seed in 0..100 {
            let motor = Motor::hidden(seed);
            for kind in Kind::all() {
                let effect = Effect::random(kind, &mut rng, &motor);
                assert_eq!(Effect::parse(&effect.to_string()), Ok(effect));
            }
        }
    }

    #[test]
    fn strength_grades_the_size() {
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let motor = Motor::paper();
        let size =
            |strength, rng: &mut ChaCha8Rng| Effect::graded(Kind::DeadZone, strength, rng, &motor).size();
        assert!((size(0.0, &mut rng) - 0.08).abs() < 1e-12);
        assert!((size(1.0, &mut rng) - 1.2).abs() < 1e-12);
    }
}
