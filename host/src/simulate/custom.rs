//! A user's effect in the virtual motor: the formula itself, evaluated there in its own small steps.

use std::fmt;

use motorlens_shared::effects::{Entry, Kind, Quantity, UserDefined};
use motorlens_virtual_motor::{Law, LawPort, Moment};

use crate::error::{Error, Result};
use crate::formula::{self, Library};

/// An effect of the user's own with its parameters.
#[derive(Debug, Clone, PartialEq)]
pub struct Custom {
    kind: Kind,
    values: Vec<f64>,
}

impl Custom {
    /// Reads `fan`, `fan=0.02` or `fan=0.02,start=1`, as for the library's effects: the first number is the first
    /// parameter. None where no effect of the user's own in `library` has this name.
    ///
    /// # Errors
    /// Wrong usage: no such parameter, no number, or one out of bounds.
    pub fn parse(text: &str, library: &Library) -> Result<Option<Self>> {
        let name = text.split(['=', ',']).next().unwrap_or_default().trim();
        let Some(kind @ Kind::Formula(_)) = library.by_name(name) else { return Ok(None) };
        let parameters = kind.spec().parameters;
        let mut values: Vec<f64> = parameters.iter().map(|p| p.typical).collect();
        let wrong = |why: String| {
            Error::usage(format!("--effect {text}: {why}"), format!("see motorlens effects {name}"))
        };
        for (place, piece) in text.split(',').enumerate() {
            let (key, value) = piece.split_once('=').unwrap_or((piece, ""));
            if place == 0 && value.is_empty() {
                continue;
            }
            let key = if place == 0 { parameters[0].name } else { key.trim() };
            let Some(k) = parameters.iter().position(|p| p.name == key) else {
                return Err(wrong(format!("{name} has no parameter {key}")));
            };
            let x: f64 = value.trim().parse().map_err(|_| wrong(format!("\"{value}\" is not a number")))?;
            let (low, high) = (parameters[k].low, parameters[k].high);
            if !(low..=high).contains(&x) {
                return Err(wrong(format!("{key} = {x} is outside {low} to {high}")));
            }
            values[k] = x;
        }
        Ok(Some(Self { kind, values }))
    }

    /// Its name.
    pub fn name(&self) -> &'static str {
        self.kind.name()
    }

    /// The equation that the virtual motor obeys.
    pub fn law(&self) -> Law {
        let Kind::Formula(UserDefined(definition)) = self.kind else {
            unreachable!("only formulas become laws")
        };
        let values = self.values.clone();
        let port = match definition.entry() {
            Entry::Torque => LawPort::Torque,
            Entry::Friction => LawPort::Friction,
            Entry::Voltage => LawPort::Voltage,
            Entry::Drop => LawPort::Drop,
            Entry::Resistance => LawPort::Resistance,
            Entry::Sensor => LawPort::Sensor,
        };
        let value = move |m: &Moment| {
            formula::value(definition, &values, &|quantity| match quantity {
                Quantity::Voltage | Quantity::Command => m.voltage,
                Quantity::Current => m.current,
                Quantity::Speed => m.speed,
                Quantity::Angle => m.angle,
                Quantity::MotorSpeed => m.motor_speed,
                Quantity::MotorAngle => m.motor_angle,
                Quantity::Time => m.time,
            })
        };
        Law { port, value: Box::new(value) }
    }
}

/// As [`Custom::parse`] reads it.
impl fmt::Display for Custom {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.name(), self.values[0])?;
        for (parameter, value) in self.kind.spec().parameters.iter().zip(&self.values).skip(1) {
            write!(f, ",{}={value}", parameter.name)?;
        }
        Ok(())
    }
}
