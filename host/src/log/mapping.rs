//! `--map time=t:ms,voltage=u,speed=y:deg/s`: which column of a foreign file is what, and in which unit.
//!
//! Grammar: `QUANTITY=COLUMN[:UNIT]`, joined by commas. QUANTITY is time, interval (the time since the row before), voltage, duty,
//! target (of a position servo), angle, speed, current or supply. `time=SECONDS+REST:ns` adds up two columns, `duty=IN1-IN2:255` takes one
//! side of a bridge from the other. COLUMN is a header or a
//! 0-based number. UNIT is a unit of the quantity (if left out, that which the header says, or SI), then any number of
//! `*factor` or `/divisor`; for duty it is the number that means full duty, or those of none and full (`1500..2000`). Where duty is
//! given instead of voltage, the voltage is duty times the supply column, or times `--supply-volts`. `only=COLUMN:VALUE` reads those rows alone
//! that have the value there.

use std::str::FromStr;

use super::only::Only;
use super::units::{Quantity, Unit};

/// Where one quantity comes from.
#[derive(Debug, Clone, PartialEq)]
pub struct Source {
    /// What the column measures.
    pub quantity: Quantity,
    /// Header of the column, or its 0-based number.
    pub column: String,
    /// Its unit and scale.
    pub unit: Unit,
    /// The unit as it was written; empty where none was.
    pub written: String,
}

impl Source {
    /// The names that it may mean: its column, or two columns with a plus or a minus between them.
    pub fn columns(&self) -> impl Iterator<Item = &str> {
        let pairs = self.column.match_indices(['+', '-']).map(|(at, _)| self.column.split_at(at));
        let halves = pairs.flat_map(|(one, other)| [one.trim(), other[1..].trim()]);
        std::iter::once(self.column.as_str()).chain(halves)
    }
}

/// The meaning of the columns of a file.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Mapping {
    sources: Vec<Source>,
    only: Option<Only>,
}

impl Mapping {
    /// Where `quantity` comes from, if the mapping says.
    pub fn source(&self, quantity: Quantity) -> Option<&Source> {
        self.sources.iter().find(|source| source.quantity == quantity)
    }

    /// All of it.
    pub(super) fn sources(&self) -> &[Source] {
        &self.sources
    }

    /// Which rows alone are read, where not all are.
    pub(crate) fn only(&self) -> Option<&Only> {
        self.only.as_ref()
    }

    /// The same for these rows alone.
    pub(crate) fn with_only(&self, only: Only) -> Self {
        Self { only: Some(only), ..self.clone() }
    }

    /// The same without one quantity.
    pub(super) fn without(&self, quantity: Quantity) -> Self {
        let kept = |source: &&Source| source.quantity != quantity;
        Self { sources: self.sources.iter().filter(kept).cloned().collect(), only: self.only.clone() }
    }

    /// The mapping as it is written.
    pub fn written(&self) -> String {
        let unit = |unit: &str| if unit.is_empty() { String::new() } else { format!(":{unit}") };
        let one = |source: &Source| format!("{}={}{}", source.quantity, source.column, unit(&source.written));
        self.sources.iter().map(one).chain(self.only().map(Only::written)).collect::<Vec<_>>().join(",")
    }

    /// Whether any angle or speed is mapped; then canonical columns of that kind are not taken on top.
    pub fn names_motion(&self) -> bool {
        self.source(Quantity::Angle).is_some() || self.source(Quantity::Speed).is_some()
    }

    /// Whether every column is given by number, so that the file may lack a header.
    pub fn is_by_number(&self) -> bool {
        !self.sources.is_empty()
            && self.sources.iter().all(|source| {
                source.column.split(['+', '-']).all(|column| column.trim().parse::<usize>().is_ok())
            })
    }
}

impl Mapping {
    /// This mapping with the units that `told` knows of a column where none was written.
    pub(super) fn with_units(&self, told: impl Fn(&Source) -> Option<String>) -> Mapping {
        let mut mapping = self.clone();
        for source in mapping.sources.iter_mut().filter(|source| source.written.is_empty()) {
            if let Some(written) = told(source)
                && let Ok(unit) = Unit::parse(source.quantity, &written)
            {
                (source.unit, source.written) = (unit, written);
            }
        }
        mapping
    }
}

impl FromStr for Mapping {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let mut mapping = Mapping::default();
        for part in text.split(',').map(str::trim).filter(|part| !part.is_empty()) {
            let (key, place) = part
                .split_once('=')
                .ok_or_else(|| format!("\"{part}\" lacks an equals sign: write for example voltage=u:V"))?;
            if key.trim() == "only" {
                if mapping.only.replace(Only::parse(place)?).is_some() {
                    return Err("only is there twice: the rows of one value are read".into());
                }
                continue;
            }
            let quantity = quantity_named(key.trim())?;
            // A path behind a colon is no unit: `NT:/arm/velocity`.
            let (column, written) =
                place.rsplit_once(':').filter(|(_, unit)| !is_path(unit)).unwrap_or((place, ""));
            let unit = if written.is_empty() { Unit::SI } else { Unit::parse(quantity, written.trim())? };
            if column.trim().is_empty() {
                return Err(format!("\"{part}\" names no column: write for example {quantity}=3"));
            }
            if mapping.source(quantity).is_some() {
                return Err(format!("{quantity} is mapped twice"));
            }
            let (column, written) = (column.trim().to_owned(), written.trim().to_owned());
            mapping.sources.push(Source { quantity, column, unit, written });
        }
        if mapping.source(Quantity::Duty).is_some() && mapping.source(Quantity::Voltage).is_some() {
            return Err(
                "voltage and duty are both mapped: keep the one that was measured nearer to the motor".into(),
            );
        }
        if mapping.source(Quantity::Time).is_some() && mapping.source(Quantity::Interval).is_some() {
            return Err("time and interval are both mapped: keep the time, which adds up no errors".into());
        }
        if mapping.sources.is_empty() && mapping.only.is_none() {
            return Err("the mapping is empty: write for example time=t:ms,voltage=u,speed=y:deg/s".into());
        }
        Ok(mapping)
    }
}

/// Whether a text that should be a unit goes on as a path does and no divisor does.
fn is_path(text: &str) -> bool {
    text.trim().strip_prefix('/').is_some_and(|rest| rest.starts_with(char::is_alphabetic))
}

fn quantity_named(key: &str) -> Result<Quantity, String> {
    Quantity::ALL
        .into_iter()
        .find(|quantity| quantity.key() == key || quantity.canonical() == Some(key))
        .ok_or_else(|| {
            let keys = Quantity::ALL.map(Quantity::key).join(", ");
            format!("\"{key}\" is nothing that a log can hold: use {keys}")
        })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_example_of_the_help_is_understood() {
        let mapping: Mapping = "time=t:ms,voltage=u,speed=y:deg/s".parse().unwrap();
        assert_eq!(mapping.source(Quantity::Time).unwrap().unit.factor, 1e-3);
        assert_eq!(mapping.source(Quantity::Voltage).unwrap().column, "u");
        assert!(mapping.names_motion() && !mapping.is_by_number());
    }

    #[test]
    fn columns_may_be_numbers() {
        let mapping: Mapping = "time=0:ms, voltage=1, angle=3:counts".parse().unwrap();
        assert!(mapping.is_by_number());
        assert!(mapping.source(Quantity::Angle).unwrap().unit.per_turn.is_some());
    }

    #[test]
    fn each_mistake_is_answered_with_the_right_form() {
        for (text, answer) in [
            ("time", "lacks an equals sign"),
            ("weight=3", "nothing that a log can hold"),
            ("time=a,time=b", "mapped twice"),
            ("voltage=u,duty=d:255", "both mapped"),
            ("time=t,interval=dt:ms", "both mapped"),
            ("speed=y:knots", "no unit of speed"),
            ("speed=:rpm", "names no column"),
            ("only=id", "only=id:3"),
            ("only=id:1,only=id:2", "only is there twice"),
            ("", "empty"),
        ] {
            let error = text.parse::<Mapping>().unwrap_err();
            assert!(error.contains(answer), "{text}: {error}");
        }
    }
}
