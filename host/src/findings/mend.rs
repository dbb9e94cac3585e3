//! Data problems that change the answer: what is found beside one of them may be the problem and no physics, so it is mended first.

use serde::Serialize;

use crate::log::{BEFORE_ITS_VOLTAGE, BEYOND_SUPPLY, Warning};

/// What a data problem is mended with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mend {
    /// Another mapping of the columns, or another figure of the rig.
    Columns,
    /// Seconds that are left out.
    Range,
    /// The voltage that did drive the motor: what was logged is another one.
    Voltage,
}

/// The problems by their names, each with what mends it. What may be as the owner wants it, what an effect of the library explains as well (late or
/// lost readings), the reader's own repairs and what only limits the answer are not among them: good data are not to be refused.
const MENDS: [(Mend, &[&str]); 2] = [
    (
        Mend::Columns,
        &[
            "unsigned_voltage",
            "unsigned_motion",
            "unsigned_byte",
            "angle_as_speed",
            "speed_as_angle",
            "locked_antiphase",
            "inverted_duty",
            "beyond_full_duty",
            "wrong_counts_per_rev",
            "sign_flipped",
            "wrong_units",
            "wrong_gear_ratio",
            "supply_as_drive",
        ],
    ),
    (Mend::Range, &["hard_stop", "frozen_sensor", "switched_off", "turned_from_outside"]),
];

/// Whether the voltage that was logged is surely not what drove the motor: held in the file and not by the drive, or more than the supply
/// has. A duty times the supply of which one number is known is nearly that, and good enough.
fn drove_nothing(fault: &Warning) -> bool {
    let name = name(fault);
    name == "stale_voltage" || name == "commanded_voltage" && fault.what.contains(BEYOND_SUPPLY)
}

/// Whether the voltage of a row acts before the row: no effect acts before its cause.
fn comes_late(fault: &Warning) -> bool {
    name(fault) == "shifted_samples" && fault.what.contains(BEFORE_ITS_VOLTAGE)
}

/// The name of the fault.
fn name(fault: &Warning) -> &str {
    fault.what.split_once(':').map_or("", |(name, _)| name)
}

impl Mend {
    /// What the first of `faults`, that of a voltage which drove nothing before all others, that changes the answer is mended with, and where it is.
    pub fn first(faults: &[Warning]) -> Option<(Self, &str)> {
        let voltage = faults.iter().find(|fault| drove_nothing(fault));
        voltage.map(|fault| (Self::Voltage, fault.place.as_str())).or_else(|| {
            MENDS.into_iter().find_map(|(mend, names)| {
                let is_mended = |fault: &&Warning| {
                    names.contains(&name(fault)) || mend == Mend::Columns && comes_late(fault)
                };
                let fault = faults.iter().find(is_mended)?;
                Some((mend, fault.place.as_str()))
            })
        })
    }

    /// What a sentence goes on with where this comes first.
    pub(super) fn first_of_all(self) -> &'static str {
        match self {
            Self::Columns | Self::Range => "; mend the data first, for their problem may be what is found",
            Self::Voltage => {
                "; but the logged voltage is not what drove the motor, so nothing is explained before the right one is given"
            }
        }
    }

    /// Where one of `faults` asks whether the columns mean what they were read as.
    pub fn asked(faults: &[Warning]) -> Option<(Self, &str)> {
        let asks = faults.iter().find(|fault| name(fault).starts_with("perhaps_"))?;
        Some((Self::Columns, asks.place.as_str()))
    }

    /// As a button says it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Columns => "Check the columns",
            Self::Range => "Leave the bad seconds out",
            Self::Voltage => "Give the voltage that drove the motor",
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn columns_are_mended_before_seconds_and_what_changes_nothing_not_at_all() {
        let fault =
            |what: &str| Warning { place: what.into(), what: format!("{what}: why"), fix: "do".into() };
        let all = ["wrapped_angle", "perhaps_duty", "hard_stop", "wrong_units"].map(fault);
        assert_eq!(Mend::first(&all), Some((Mend::Columns, "wrong_units")));
        assert_eq!(Mend::first(&all[..3]), Some((Mend::Range, "hard_stop")));
        assert_eq!(Mend::first(&all[..2]), None, "volts as small as a duty are no fault");
        assert_eq!(Mend::asked(&all), Some((Mend::Columns, "perhaps_duty")));
    }

    #[test]
    fn a_voltage_that_is_logged_late_is_mended_first_and_a_motion_that_comes_late_may_be_an_effect() {
        let shifted = |what: &str| {
            let what = format!("shifted_samples: the motion comes 12 ms {what}");
            [Warning { place: "run".into(), what, fix: "do".into() }]
        };
        assert_eq!(Mend::first(&shifted(BEFORE_ITS_VOLTAGE)), Some((Mend::Columns, "run")));
        assert_eq!(Mend::first(&shifted("after its voltage")), None);
    }

    #[test]
    fn a_voltage_that_drove_nothing_comes_first_and_one_of_a_duty_and_its_supply_drove_something() {
        let fault = |what: &str| Warning { place: "run".into(), what: what.into(), fix: "do".into() };
        let beyond = fault(&format!("commanded_voltage: 9 samples {BEYOND_SUPPLY}, so"));
        let stale = fault("stale_voltage: a new voltage comes only every 100 ms");
        let units = fault("wrong_units: degrees");
        assert_eq!(Mend::first(&[units.clone(), stale]), Some((Mend::Voltage, "run")));
        assert_eq!(Mend::first(&[units, beyond]), Some((Mend::Voltage, "run")));
        let of_duty = fault("commanded_voltage: the voltage was not measured: it is the duty times 12 V");
        assert_eq!(Mend::first(&[of_duty]), None);
    }
}
