//! The guess as a dialogue shows it: what is in the file, and for every column what it would be read as.

use std::path::Path;

use serde::Serialize;

use super::super::preamble;
use super::super::table;
use super::super::text;
use super::super::units::Quantity;
use super::{Proposal, parts, propose_for};
use crate::error::Result;

/// Rows that are shown.
const SHOWN: usize = 1000;

/// The beginning of a table, and what its columns look like.
#[derive(Debug, Serialize)]
pub struct Look {
    /// Names of the columns; their numbers where the file has no header.
    pub names: Vec<String>,
    /// The first rows as they stand in the file.
    pub rows: Vec<Vec<String>>,
    /// For every column `QUANTITY:UNIT` as `--map` writes it, `time+:UNIT` for the fraction of a second beside whole ones; empty where
    /// the column is not used.
    pub kinds: Vec<String>,
    /// The columns have their canonical names and need no mapping.
    pub canonical: bool,
    /// What the command line would propose; none where the columns are canonical or too little is recognised.
    pub proposal: Option<Proposal>,
}

/// Looks at the table at `path`.
///
/// # Errors
/// Bad input where the file is no text or no table.
pub fn look(path: &Path) -> Result<Look> {
    let mut input = text::open(path)?;
    let head = preamble::read(path, &mut input, true)?;
    let sample = table::sample(path, &mut input, &head, SHOWN)?;
    let width = sample.texts.first().map_or(0, Vec::len).max(sample.names.len());
    let mut kinds = vec![String::new(); width];
    let place =
        |quantity: Quantity| sample.names.iter().position(|name| quantity.canonical() == Some(name.as_str()));
    let is_there = |quantity| place(quantity).is_some();
    let canonical = (is_there(Quantity::Time) || sample.stamped)
        && ((is_there(Quantity::Voltage) && (is_there(Quantity::Angle) || is_there(Quantity::Speed)))
            || (is_there(Quantity::Target) && is_there(Quantity::Angle)));
    if canonical {
        for quantity in Quantity::ALL {
            if let Some(index) = place(quantity) {
                kinds[index] = format!("{quantity}:{}", quantity.si());
            }
        }
    } else {
        for part in parts(&sample.with_units, &sample.rows) {
            let whole = if part.rest.is_some() { Quantity::Time.si() } else { &part.unit };
            kinds[part.index] = format!("{}:{whole}", part.quantity);
            if let Some(rest) = part.rest {
                kinds[rest] = format!("{}+:{}", part.quantity, part.unit);
            }
        }
    }
    let proposal = if canonical { None } else { propose_for(&sample) };
    let names = (0..width).map(|k| sample.names.get(k).cloned().unwrap_or_else(|| k.to_string())).collect();
    Ok(Look { names, rows: sample.texts, kinds, canonical, proposal })
}

#[cfg(test)]
mod tests {
    use super::super::super::read_tests::file;
    use super::*;

    fn looked(text: &str) -> Look {
        let (_directory, path) = file(text.as_bytes());
        look(&path).unwrap()
    }

    #[test]
    fn every_column_shows_what_the_proposal_says_of_it() {
        let rows: String = (0..60).map(|k| format!("{};{};{}\n", 10 * k, k % 7 * 30, k * k)).collect();
        let look = looked(&format!("boot\nt_ms;pwm;enc\n{rows}"));
        assert_eq!(look.kinds, ["time:ms", "duty:255", "angle:counts"]);
        assert_eq!(
            (look.names.as_slice(), look.rows.len()),
            (["t_ms", "pwm", "enc"].map(String::from).as_slice(), 60)
        );
        let proposal = look.proposal.unwrap();
        assert_eq!(proposal.map, "time=t_ms:ms,duty=pwm:255,angle=enc:counts");
        assert!(proposal.supply_volts.is_some() && proposal.counts_per_rev.is_some());
    }

    #[test]
    fn canonical_columns_need_no_mapping_and_numbers_alone_are_shown_by_their_place() {
        let look = looked("time_s,note,voltage_v,angle_rad\n0,a,1,2\n1,b,2,3\n2,c,3,4\n");
        assert!(look.canonical && look.proposal.is_none());
        assert_eq!(look.kinds, ["time:s", "", "voltage:V", "angle:rad"]);
        assert_eq!(looked("0,1,2\n1,2,3\n2,3,4\n").names, ["0", "1", "2"]);
    }

    #[test]
    fn a_time_in_two_columns_is_shown_in_both() {
        let rows: String =
            (0..300).map(|k| format!("{},{},{},{}\n", k / 100, k % 100 * 10_000_000, k % 5, k)).collect();
        let look = looked(&format!("sec,nanosec,u,theta\n{rows}"));
        assert_eq!(look.kinds, ["time:s", "time+:ns", "voltage:V", "angle:deg"]);
    }
}
