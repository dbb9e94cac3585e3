//! What a log says about itself: `# key: value` lines before the header.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use super::Hold;
use super::numbers::number;
use super::units::PerTurn;

/// Where the encoder sits. Faults of its disc repeat once per turn of that shaft.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum EncoderShaft {
    /// Before the gears.
    #[default]
    Motor,
    /// After the gears.
    Output,
}

impl fmt::Display for EncoderShaft {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            EncoderShaft::Motor => "motor",
            EncoderShaft::Output => "output",
        })
    }
}

impl FromStr for EncoderShaft {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        match text {
            "motor" => Ok(EncoderShaft::Motor),
            "output" => Ok(EncoderShaft::Output),
            other => Err(format!("encoder_shaft \"{other}\" is neither \"motor\" nor \"output\"")),
        }
    }
}

/// Key and value pairs of a record. The keys that the program understands are checked on entry, so the typed
/// accessors cannot fail; all others are kept as text.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[serde(transparent)]
pub struct Metadata(BTreeMap<String, String>);

/// How a voltage is told that is a duty times one number.
pub(super) const BEHIND_DUTY: &str = "it is the duty times ";

impl Metadata {
    /// Stores a pair.
    ///
    /// # Errors
    /// Says why, where the key is one the program understands and the value does not fit it.
    pub fn insert(&mut self, key: &str, value: &str) -> Result<(), String> {
        match key {
            "gear_ratio" | "counts_per_rev" | "metres_per_rev" | "no_load_rad_s_per_v" | "voltage_lead_s" => {
                match value.parse::<f64>() {
                    Ok(number) if number.is_finite() && number > 0.0 => {}
                    _ => return Err(format!("{key} \"{value}\" is not a positive number")),
                }
            }
            "hold" => drop(value.parse::<Hold>()?),
            "encoder_shaft" => drop(value.parse::<EncoderShaft>()?),
            _ => {}
        }
        self.0.insert(key.to_owned(), value.to_owned());
        Ok(())
    }

    /// The text behind any key.
    pub fn get(&self, key: &str) -> Option<&str> {
        self.0.get(key).map(String::as_str)
    }

    /// All pairs in the order of their keys.
    pub fn iter(&self) -> impl Iterator<Item = (&str, &str)> {
        self.0.iter().map(|(key, value)| (key.as_str(), value.as_str()))
    }

    /// Turns of the motor shaft per turn of the output shaft.
    pub fn gear_ratio(&self) -> Option<f64> {
        self.typed("gear_ratio")
    }

    /// Encoder counts per turn of the output shaft, after x4 decoding and gearing.
    pub fn counts_per_rev(&self) -> Option<f64> {
        self.typed("counts_per_rev")
    }

    /// Way of a linear axis per turn of the output shaft, m.
    pub fn metres_per_rev(&self) -> Option<f64> {
        self.typed("metres_per_rev")
    }

    /// What one turn of the output shaft is of a number that is none of turns.
    pub(super) fn one_turn(&self, per_turn: PerTurn) -> Option<f64> {
        match per_turn {
            PerTurn::Counts => self.counts_per_rev(),
            PerTurn::Metres => self.metres_per_rev(),
        }
    }

    /// Speed of the output shaft per volt without load by the name plate, rad/s per V.
    pub fn no_load_gain(&self) -> Option<f64> {
        self.typed("no_load_rad_s_per_v")
    }

    /// The supply's voltage by which a duty was multiplied, V, where the log had none: as the metadata tell it.
    pub fn supply_behind_duty(&self) -> Option<f64> {
        self.get("voltage")?.strip_prefix(BEHIND_DUTY)?.split(' ').next()?.parse().ok()
    }

    /// The supply's voltage that was stated beside a log in volts, V. Loggers write such a remark too, in words of their own: with its unit it is
    /// read, and what is no positive number of volts tells nothing.
    pub fn supply_volts(&self) -> Option<f64> {
        let text = self.get("supply_volts")?;
        let with_unit = || {
            let (size, unit) = text.split_at(text.find(char::is_alphabetic)?);
            let volts = match unit {
                "V" | "v" | "volt" | "volts" | "Volt" | "Volts" => 1.0,
                "mV" => 1e-3,
                _ => return None,
            };
            number(size.trim_end()).map(|size| size * volts)
        };
        let stated = number(text).or_else(with_unit);
        stated.filter(|volts| volts.is_finite() && *volts > 0.0)
    }

    /// Where the encoder sits, if the log says.
    pub fn encoder_shaft(&self) -> Option<EncoderShaft> {
        self.typed("encoder_shaft")
    }

    /// What the voltage does between samples, if the log says.
    pub fn hold(&self) -> Option<Hold> {
        self.typed("hold")
    }

    /// How long before its row a voltage acts, s, if the log says.
    pub fn voltage_lead_s(&self) -> Option<f64> {
        self.typed("voltage_lead_s")
    }

    /// The excitation that made the record, as whoever wrote it put it.
    pub fn programme(&self) -> Option<&str> {
        self.get("programme")
    }

    fn typed<T: FromStr>(&self, key: &str) -> Option<T> {
        self.get(key)?.parse().ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn known_keys_are_typed_and_unknown_ones_are_kept() {
        let mut meta = Metadata::default();
        for (key, value) in [("gear_ratio", "104"), ("hold", "first"), ("operator", "Ada")] {
            meta.insert(key, value).unwrap();
        }
        assert_eq!(meta.gear_ratio(), Some(104.0));
        assert_eq!(meta.hold(), Some(Hold::First));
        assert_eq!(meta.counts_per_rev(), None);
        assert_eq!(meta.get("operator"), Some("Ada"));
    }

    #[test]
    fn a_supply_is_read_with_its_unit_and_a_remark_that_is_no_voltage_is_kept_as_text() {
        let told = |value: &str| {
            let mut meta = Metadata::default();
            meta.insert("supply_volts", value).unwrap();
            assert_eq!(meta.get("supply_volts"), Some(value));
            meta.supply_volts()
        };
        for text in ["12", "12.0", "12 V", "12V", "12,0 volts", "12000 mV"] {
            assert_eq!(told(text), Some(12.0), "{text}");
        }
        for text in ["", "-12", "0", "inf", "12 V nominal", "11 to 12", "3S LiPo", "battery"] {
            assert_eq!(told(text), None, "{text}");
        }
    }

    #[test]
    fn a_known_key_with_an_impossible_value_is_refused() {
        let mut meta = Metadata::default();
        for (key, value) in [
            ("gear_ratio", "-3"),
            ("counts_per_rev", "many"),
            ("hold", "second"),
            ("encoder_shaft", "wheel"),
            ("voltage_lead_s", "-0.01"),
        ] {
            assert!(meta.insert(key, value).unwrap_err().contains(value), "{key}");
        }
        assert_eq!(meta, Metadata::default());
    }
}
