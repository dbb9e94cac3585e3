//! What an answer supposes that no file tells: the unit of the angle, on which the size of an effect rests.
//!
//! A weight hangs once in a turn of the shaft, and so do cogging and an encoder that is off centre. Where degrees are read as counts, what
//! looks like a weight is a spring, or nothing.

use motorlens_shared::effects::Kind;

use crate::log::Record;
use crate::log::guess::{ASSUMED_COUNTS, words};
use crate::log::units::Quantity;
use crate::sentence::listed;

/// What an answer with `effects` that was found on `records` supposes, in a sentence with a blank before it.
pub fn supposes<'a>(effects: &[Kind], records: impl IntoIterator<Item = &'a Record>) -> String {
    unit_of_angle(effects, records).map_or_else(String::new, |text| format!(" {text}."))
}

/// What is said of `effects` found on `records` whose angle is in a unit that only a mapping says; none where a header says it too, or where
/// no effect rests on it.
fn unit_of_angle<'a>(effects: &[Kind], records: impl IntoIterator<Item = &'a Record>) -> Option<String> {
    let resting: Vec<&str> =
        effects.iter().filter(|kind| kind.spec().periodic).map(|kind| kind.name()).collect();
    if resting.is_empty() {
        return None;
    }
    records.into_iter().find_map(|record| {
        let source = record.map.as_ref()?.source(Quantity::Angle)?;
        let name = &source.column;
        let (unit, scale) = source.written.split_at(source.written.find(['*', '/']).unwrap_or(source.written.len()));
        // A factor was worked out and not guessed.
        if !["", "*-1", "/-1"].contains(&scale) {
            return None;
        }
        let counts = ASSUMED_COUNTS.to_string();
        let in_counts = format!("counts of {counts} a turn");
        let (in_words, once_round) = match unit {
            "" | "rad" => ("rad", "6.283"),
            "deg" => ("degrees", "360"),
            "rev" => ("turns", "1"),
            "counts" if record.meta.counts_per_rev() == Some(ASSUMED_COUNTS) => (in_counts.as_str(), counts.as_str()),
            _ => return None,
        };
        let is_told = unit != "counts" && words::told(name).is_some_and(|(of, _)| of == Quantity::Angle);
        (!is_told).then(|| {
            format!(
                "The size of {} supposes that \"{name}\" is in {in_words}, which --map says and no header does: turn the shaft once by hand, by \
                 which it must change by {once_round}, and write the unit into the header; in another unit this is another effect, or none",
                listed(&resting)
            )
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(map: &str) -> Record {
        Record { map: Some(map.parse().unwrap()), ..Record::default() }
    }

    #[test]
    fn what_repeats_with_the_turns_names_the_unit_that_only_the_mapping_says() {
        let said = |effects: &[Kind], map: &str| unit_of_angle(effects, &[record(map)]);
        let guessed = "time=t:s,voltage=u:V,angle=position:deg";
        let text = said(&[Kind::Coulomb, Kind::Gravity], guessed).unwrap();
        assert!(
            text.contains("gravity supposes") && text.contains("degrees") && text.contains("360"),
            "{text}"
        );
        assert_eq!(said(&[Kind::Coulomb], guessed), None);
        assert_eq!(said(&[Kind::Gravity], "time=t:s,voltage=u:V,angle=position_deg:deg"), None);
        assert_eq!(said(&[Kind::Gravity], "time=t:s,voltage=u:V,speed=w:rpm"), None);
        let mut counted = record("time=t:s,voltage=u:V,angle=enc:counts");
        counted.meta.insert("counts_per_rev", "1320").unwrap();
        assert!(unit_of_angle(&[Kind::Cogging], &[counted.clone()]).is_some());
        counted.meta.insert("counts_per_rev", "979.6").unwrap();
        assert_eq!(unit_of_angle(&[Kind::Cogging], &[counted]), None);
        assert_eq!(unit_of_angle(&[Kind::Gravity], &[Record::default()]), None);
    }
}
