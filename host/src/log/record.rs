//! One log in memory: SI units, angles and speeds of the output shaft.

use std::path::PathBuf;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Metadata;
use super::labels::Labels;
use super::mapping::{Mapping, Source};
use super::motion::mean;
use super::servo::Servo;
use super::units::Quantity;

/// What the voltage does between two samples.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Hold {
    /// Stays as it was until the next sample, as a drive holds its command.
    #[default]
    Zero,
    /// Runs straight from one sample to the next, as an amplifier does.
    First,
}

impl FromStr for Hold {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "zero" => Ok(Hold::Zero),
            "first" => Ok(Hold::First),
            other => Err(format!("hold \"{other}\" is neither \"zero\" nor \"first\"")),
        }
    }
}

/// A data quality problem that did not stop the reading.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Warning {
    /// File, and line or column where one is to blame.
    #[serde(rename = "where")]
    pub place: String,
    /// What the problem is.
    #[serde(rename = "fault")]
    pub what: String,
    /// What the user can do.
    pub fix: String,
}

impl Warning {
    /// The problem, as people read it: programs look for the `kind_of_fault:` before some of them.
    pub fn told(&self) -> String {
        match self.what.split_once(": ") {
            Some((kind, rest)) if kind.bytes().all(|b| b == b'_' || b.is_ascii_lowercase()) => {
                format!("{}: {rest}", kind.replace('_', " "))
            }
            _ => self.what.clone(),
        }
    }
}

/// One run of one motor.
///
/// All present columns have the length of `time_s`; times rise strictly; all numbers are finite. Times and angles
/// keep the origin that the file gave them.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Record {
    /// Short name for messages and plots: the file's stem, and the test's name where a file holds several.
    pub name: String,
    /// Where it was read from, as the user named it.
    pub path: PathBuf,
    /// Sample times, s.
    pub time_s: Vec<f64>,
    /// Voltage at the driver's output, V.
    pub voltage_v: Vec<f64>,
    /// Angle of the output shaft, rad.
    pub angle_rad: Option<Vec<f64>>,
    /// Speed of the output shaft, rad/s.
    pub speed_rad_s: Option<Vec<f64>>,
    /// Motor current, A.
    pub current_a: Option<Vec<f64>>,
    /// Supply of the driver, V.
    pub supply_v: Option<Vec<f64>>,
    /// What the log says about itself, completed by the motor file.
    pub meta: Metadata,
    /// What the voltage does between samples.
    pub hold: Hold,
    /// What a column of words beside the numbers says, where there is one.
    pub labels: Option<Labels>,
    /// The position loop that drives the motor, where the log has a target and no voltage.
    pub servo: Option<Servo>,
    /// The mapping by which it was read, where one was given.
    pub map: Option<Mapping>,
    /// Oddities met while reading.
    pub warnings: Vec<Warning>,
}

impl Record {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// Whether there is no sample at all.
    pub fn is_empty(&self) -> bool {
        self.time_s.is_empty()
    }

    /// Where the mapping takes a quantity from; none where it does not say.
    pub(crate) fn source(&self, quantity: Quantity) -> Option<&Source> {
        self.map.as_ref()?.source(quantity)
    }

    /// The unit that a quantity was read in, as `--map` writes it: that of SI where none was written.
    pub(super) fn unit_of(&self, quantity: Quantity) -> &str {
        let written = self.source(quantity).map(|source| source.written.as_str());
        written.filter(|unit| !unit.is_empty()).unwrap_or(quantity.si())
    }

    /// Whether a position loop made the voltage: it holds the shaft where it is, as a stop or a hand does.
    pub(super) fn is_of_position_loop(&self) -> bool {
        self.servo.is_some() || self.meta.get("kp").is_some()
    }

    /// Time from the first to the last sample, s.
    pub fn duration_s(&self) -> f64 {
        match (self.time_s.first(), self.time_s.last()) {
            (Some(first), Some(last)) => last - first,
            _ => 0.0,
        }
    }

    /// Voltage of the supply, V: the mean of what was logged of it, else what a duty was multiplied by or what was stated; none where nothing tells it.
    pub fn mean_supply_v(&self) -> Option<f64> {
        let logged = self.supply_v.as_deref().map(mean);
        logged.or_else(|| self.meta.supply_behind_duty()).or_else(|| self.meta.supply_volts())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_unit_of_a_quantity_is_the_one_that_its_mapping_says_or_else_that_of_si() {
        let record = Record { map: Some("time=t:ms,angle=x".parse().unwrap()), ..Record::default() };
        let units =
            [Quantity::Time, Quantity::Angle, Quantity::Speed].map(|quantity| record.unit_of(quantity));
        assert_eq!(units, ["ms", "rad", "rad/s"]);
        assert!(record.source(Quantity::Angle).is_some() && record.source(Quantity::Speed).is_none());
    }

    #[test]
    fn duration_does_not_depend_on_the_origin_of_time() {
        let record = Record { time_s: vec![100.0, 100.5, 102.0], ..Record::default() };
        assert_eq!(record.duration_s(), 2.0);
        assert_eq!(Record::default().duration_s(), 0.0);
    }
}
