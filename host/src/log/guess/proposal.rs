//! The options that a guess proposes, and what a person has to put in the place of what it assumes.

use std::fmt::Write as _;

use super::columns::Part;
use super::{clocks, duty_range, quoted, vocabulary, words};
use crate::log::sample::Sample;

/// Options that would read a table, and what they would make of it.
#[derive(Debug, Clone, PartialEq, Eq, Default, serde::Serialize)]
pub struct Proposal {
    /// The value of `--map`.
    pub map: String,
    /// The supply that is assumed, V, where the table has a duty only.
    pub supply_volts: Option<String>,
    /// The counts per turn of the output shaft that are assumed, where the table counts edges.
    pub counts_per_rev: Option<String>,
    /// The metres per turn of the output shaft that are assumed, where the table tells the way of a linear axis.
    pub metres_per_rev: Option<String>,
    /// The rate that is assumed, Hz, where no column tells the time.
    pub rate: Option<String>,
    /// A line for every column, with its range as it would be read.
    pub preview: Vec<String>,
    /// What is asked of columns whose unit is not known.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub unknown_units: Vec<String>,
}

impl Proposal {
    /// The options, quoted for any shell.
    pub fn options(&self) -> String {
        let map = (!self.map.is_empty()).then(|| format!(" --map {}", quoted(&self.map)));
        let mut text = map.unwrap_or_default();
        for (option, value) in [
            ("--supply-volts", &self.supply_volts),
            ("--counts-per-rev", &self.counts_per_rev),
            ("--metres-per-rev", &self.metres_per_rev),
            ("--rate", &self.rate),
        ] {
            if let Some(value) = value {
                let _ = write!(text, " {option} {value}");
            }
        }
        text.trim_start().to_owned()
    }

    /// The same where the person told some of it: what is `known` needs no assumption, and a supply that was told none that is guessed.
    #[must_use]
    pub fn with_known(mut self, known: Known) -> Self {
        let assumed = [
            (known.supply_volts, &mut self.supply_volts),
            (known.counts_per_rev, &mut self.counts_per_rev),
            (known.metres_per_rev, &mut self.metres_per_rev),
            (known.rate, &mut self.rate),
        ];
        for (_, assumption) in assumed.into_iter().filter(|(known, _)| *known) {
            *assumption = None;
        }
        if known.supply_volts {
            let parts: Vec<&str> = self.map.split(',').filter(|part| !part.starts_with("supply=")).collect();
            self.map = parts.join(",");
        }
        self
    }

    /// The same at the rate that a table tells, where one is assumed, or that its rows tell, where the times of these `parts` cannot.
    pub(super) fn at_the_rate_of(mut self, sample: &Sample, parts: &[Part]) -> Self {
        if let (Some(rate), Some(told)) = (&mut self.rate, sample.rate_hz()) {
            *rate = told.to_string();
        }
        if let Some(rate) = clocks::rate_of_coarse(parts, &sample.rows) {
            self.rate = Some(rate.to_string());
        }
        self
    }

    /// The options, and in brackets what a person has to put in the place of an assumption.
    pub fn told(&self) -> String {
        let assumptions = self.assumptions();
        if assumptions.is_empty() { self.options() } else { format!("{} ({assumptions})", self.options()) }
    }

    /// What a person has to put in the place of an assumption.
    pub fn assumptions(&self) -> String {
        let mut all = self.unknown_units.clone();
        if let Some(volts) = &self.supply_volts {
            all.push(format!("put your supply's voltage in the place of {volts}"));
        }
        all.extend(self.scales());
        if let Some(counts) = &self.counts_per_rev {
            all.push(format!(
                "put the encoder's counts per turn of the output shaft (after x4 and gearing) in the place of {counts}"
            ));
        }
        if let Some(metres) = &self.metres_per_rev {
            all.push(format!(
                "put the metres per turn of the output shaft (a screw's lead, a wheel's circumference) in the place of {metres}"
            ));
        }
        if let Some(rate) = &self.rate {
            all.push(format!("put your samples per second in the place of {rate}"));
        }
        all.join("; ")
    }

    /// What a person has to put in the place of a scale that is assumed in the mapping itself: full duty, pole pairs, steps of a turn.
    fn scales(&self) -> Vec<String> {
        let mut all = Vec::new();
        let duty = self.map.split(',').find_map(|part| part.strip_prefix("duty=")?.rsplit_once(':'));
        // Percent where the column says so; else a pulse-width register may have any number for full duty.
        let is_told = |column: &str, full: &str| {
            full == "1"
                || full == "100" && words::said(column).unit == Some(full)
                || duty_range::told(column).is_some_and(|told| told.to_string() == full)
        };
        if let Some((_, full)) = duty.filter(|(column, full)| !is_told(column, full)) {
            all.push(match full.split_once("..") {
                Some(_) => format!("put the pulses of no and of full duty, us, in the place of {full}"),
                None => {
                    let number = full.rsplit_once('/').map_or(full, |(_, number)| number);
                    format!("put the number that is full duty in the place of {number}")
                }
            });
        }
        if self.map.contains(&format!(":{}", vocabulary::ELECTRICAL)) {
            all.push("put the motor's pole pairs in the place of 7".into());
        }
        if self.map.contains(":rev/4096") {
            all.push("put the steps of one turn of the servo in the place of 4096".into());
        }
        all
    }

    /// What is asked of the columns themselves; supply, counts, metres and rate have options of their own.
    pub(super) fn questions(&self) -> Vec<String> {
        [self.unknown_units.clone(), self.scales()].concat()
    }
}

/// What a person told beside the table, so that nothing is assumed in its place.
#[derive(Debug, Clone, Copy, Default)]
pub struct Known {
    /// The supply's voltage.
    pub supply_volts: bool,
    /// The counts per turn of the output shaft.
    pub counts_per_rev: bool,
    /// The metres per turn of the output shaft.
    pub metres_per_rev: bool,
    /// The samples per second.
    pub rate: bool,
}
