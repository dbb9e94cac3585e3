//! Data problems that change the answer: what is found beside one of them may be the problem and no physics, so it is mended first.

use serde::Serialize;

use crate::log::Warning;

/// What a data problem is mended with.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Mend {
    /// Another mapping of the columns, or another figure of the rig.
    Columns,
    /// Seconds that are left out.
    Range,
    /// Another record.
    Record,
}

/// The problems by their names, each with what mends it; the reader's own repairs and what only limits the answer are not among them.
const MENDS: [(Mend, &[&str]); 3] = [
    (
        Mend::Columns,
        &[
            "perhaps_duty",
            "unsigned_voltage",
            "unsigned_motion",
            "angle_as_speed",
            "speed_as_angle",
            "locked_antiphase",
            "wrong_counts_per_rev",
            "sign_flipped",
            "wrong_units",
            "wrong_gear_ratio",
            "records_disagree",
        ],
    ),
    (Mend::Range, &["hard_stop", "frozen_sensor"]),
    (Mend::Record, &["shifted_samples", "lost_counts", "clipped_voltage"]),
];

impl Mend {
    /// What the first of `faults` that changes the answer is mended with, and where it is.
    pub fn first(faults: &[Warning]) -> Option<(Self, &str)> {
        let named = |fault: &Warning, names: &[&str]| {
            fault.what.split_once(':').is_some_and(|(name, _)| names.contains(&name))
        };
        MENDS.into_iter().find_map(|(mend, names)| {
            faults.iter().find(|fault| named(fault, names)).map(|fault| (mend, fault.place.as_str()))
        })
    }

    /// As a button says it.
    pub fn label(self) -> &'static str {
        match self {
            Self::Columns => "Check the columns",
            Self::Range => "Leave the bad seconds out",
            Self::Record => "See the data problems",
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
        let all = ["wrapped_angle", "hard_stop", "perhaps_duty"].map(fault);
        assert_eq!(Mend::first(&all), Some((Mend::Columns, "perhaps_duty")));
        assert_eq!(Mend::first(&all[..2]), Some((Mend::Range, "hard_stop")));
        assert_eq!(Mend::first(&all[..1]), None);
    }
}
