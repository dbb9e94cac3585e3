//! A refusal never has for its remedy the very line that it refuses: pasted, that would be refused with the same words again.

use super::guess::Proposal;
use super::mapping::{Mapping, Source};
use crate::error::{BadInput, Error};

/// What is to be done where the remedy would be the line that was refused.
const NO_REMEDY: &str = "the mapping that was given is all that is known of these columns, and they cannot be read so: compare each of them with its \
                         numbers, give another column, unit or scale for what is named here, or leave it out of the mapping where it can be spared";

/// `error` without a remedy that is the mapping under which the file was refused.
pub(super) fn other_than_refused(error: Error, refused: Option<&Mapping>) -> Error {
    match (error, refused) {
        (Error::BadInput(fault), Some(refused)) => other_remedy(*fault, refused).into(),
        (error, _) => error,
    }
}

fn other_remedy(mut fault: BadInput, refused: &Mapping) -> BadInput {
    let repeats = |proposal: &Proposal| adds_nothing(proposal) && is_same(&proposal.map, refused);
    let is_proposed = fault.proposal.as_deref().is_some_and(repeats);
    if is_proposed || mappings(&fault.remedy).any(|map| is_same(map, refused)) {
        fault.remedy = NO_REMEDY.into();
        fault.proposal = None;
    }
    fault
}

/// Whether a proposal is a mapping and no other option.
fn adds_nothing(proposal: &Proposal) -> bool {
    let Proposal { supply_volts, counts_per_rev, metres_per_rev, rate, .. } = proposal;
    [supply_volts, counts_per_rev, metres_per_rev, rate].iter().all(|option| option.is_none())
}

/// The mappings in a text that no other option follows.
fn mappings(text: &str) -> impl Iterator<Item = &str> {
    text.split("--map ").skip(1).filter_map(|rest| {
        let (map, behind) = match rest.strip_prefix('"') {
            Some(quoted) => quoted.split_once('"')?,
            None => rest.split_at(rest.find([' ', ';', ')']).unwrap_or(rest.len())),
        };
        (!behind.starts_with(" --")).then_some(map.trim_end_matches(','))
    })
}

/// Whether a mapping means what another one does, however its units are written.
fn is_same(written: &str, refused: &Mapping) -> bool {
    let Ok(map) = written.parse::<Mapping>() else { return false };
    let alike = |one: &Source, other: &Source| {
        one.quantity == other.quantity && one.column == other.column && one.unit == other.unit
    };
    let all_in = |one: &Mapping, other: &Mapping| {
        one.sources().iter().all(|a| other.sources().iter().any(|b| alike(a, b)))
    };
    all_in(&map, refused) && all_in(refused, &map) && map.only() == refused.only()
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    #[test]
    fn a_remedy_is_another_line_than_the_one_that_was_refused() {
        let refused: Mapping = "time=t:s,voltage=my u,speed=w:rad/s".parse().unwrap();
        let remedy = |text: &str| {
            other_remedy(BadInput::new(Path::new("log.csv"), "it is odd", text), &refused).remedy
        };
        for same in [
            "say --map \"time=t:s,voltage=my u:V,speed=w:rad/s\" (a guess)",
            "if it is so, --map \"speed=w,time=t:s,voltage=my u:V\", and of a duty: --map duty=pwm:255",
        ] {
            assert_eq!(remedy(same), NO_REMEDY, "{same}");
        }
        for other in [
            "say --map \"time=t:ms,voltage=my u:V,speed=w:rad/s\"",
            "say --map \"time=t:s,voltage=my u:V,speed=w:rad/s\" --rate 100",
            "say --map \"time=t:s,voltage=my u:V,speed=w:rad/s,only=id:1\"",
            "pick by number: --map time=0:s,...",
        ] {
            assert_eq!(remedy(other), other);
        }
        let proposal = |rate: Option<&str>| Proposal {
            map: refused.written(),
            rate: rate.map(str::to_owned),
            ..Proposal::default()
        };
        for (rate, kept) in [(None, false), (Some("100"), true)] {
            let fault = BadInput::new(Path::new("log.csv"), "", "").proposing(Some(proposal(rate)));
            assert_eq!(other_remedy(fault, &refused).proposal.is_some(), kept);
        }
    }
}
