//! The rows of one motor, out of a table that holds those of several: `--map only=id:3`.

use std::collections::BTreeSet;
use std::path::Path;

use super::numbers::number;
use crate::error::BadInput;

/// More values than this are not named.
const NAMED: usize = 8;

/// Which rows of a table are wanted: those that have this value in that column.
#[derive(Debug, Clone, PartialEq)]
pub struct Only {
    /// Header of the column, or its 0-based number.
    pub column: String,
    /// What stands there.
    pub value: String,
}

impl Only {
    /// Of what a mapping says behind `only=`.
    pub(super) fn parse(text: &str) -> Result<Self, String> {
        let halves = text.rsplit_once(':').map(|(column, value)| (column.trim(), value.trim()));
        let (column, value) = halves
            .filter(|(column, value)| !column.is_empty() && !value.is_empty())
            .ok_or_else(|| format!("\"only={text}\" names no value: write for example only=id:3"))?;
        Ok(Self { column: column.to_owned(), value: value.to_owned() })
    }

    /// As a mapping says it.
    pub(super) fn written(&self) -> String {
        format!("only={}:{}", self.column, self.value)
    }

    /// Whether a field says the value, as a text or as a number.
    fn is(&self, text: &str) -> bool {
        text == self.value || number(text).is_some_and(|one| number(&self.value) == Some(one))
    }
}

/// Rows as they are chosen.
#[derive(Debug)]
pub(super) struct Chosen {
    place: usize,
    only: Only,
    found: bool,
    others: BTreeSet<String>,
}

impl Chosen {
    /// By what stands in the column at `place`.
    pub fn new(place: usize, only: Only) -> Self {
        Self { place, only, found: false, others: BTreeSet::new() }
    }

    /// Where the column stands.
    pub fn place(&self) -> usize {
        self.place
    }

    /// Whether a row is read that says this there.
    pub fn takes(&mut self, text: &str) -> bool {
        let takes = self.only.is(text);
        self.found |= takes;
        if !takes && self.others.len() <= NAMED && !self.others.contains(text) {
            self.others.insert(text.to_owned());
        }
        takes
    }

    /// The fault of a value that no row has.
    pub fn fault(&self, path: &Path) -> Option<BadInput> {
        let Only { column, value } = &self.only;
        let others: Vec<&str> = self.others.iter().take(NAMED).map(String::as_str).collect();
        (!self.found && !others.is_empty()).then(|| {
            let why = format!("no row has \"{value}\" in this column");
            let fix = format!("take one of the values that stand there: {}", others.join(", "));
            BadInput::new(path, why, fix).in_column(column)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::super::{ReadOptions, read};

    fn mapped(map: &str) -> ReadOptions {
        ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() }
    }

    /// Rows of the motors 1 and 2 in turn; the first turns at 1 rad/s, the second at 2.
    fn rows() -> String {
        let row = |k: u32| {
            let (t, id) = (0.01 * f64::from(k / 2), k % 2 + 1);
            format!("{t:.2},{id}.0,{:.2},{:.4}\n", (3.0 * t).sin(), f64::from(id) * t)
        };
        format!("time_s,id,voltage_v,angle_rad\n{}", (0..400).map(row).collect::<String>())
    }

    #[test]
    fn the_rows_of_one_motor_are_read_alone() {
        let (_directory, path) = file(rows().as_bytes());
        for (map, end_rad) in
            [("only=id:1", 1.99), ("only=id:2.0", 3.98), ("angle=angle_rad:rad,only=1:2", 3.98)]
        {
            let records = read(&path, &mapped(map)).unwrap();
            let angle = records[0].angle_rad.as_ref().unwrap();
            assert_eq!((records.len(), angle.len()), (1, 200), "{map}");
            assert!((angle[199] - end_rad).abs() < 1e-9, "{map}: {}", angle[199]);
            let written = records[0].map.as_ref().unwrap().written();
            assert!(written.ends_with(&map[map.find("only=").unwrap()..]), "{written}");
        }
    }

    #[test]
    fn a_value_that_no_row_has_and_a_column_that_there_is_not_are_told_with_those_there_are() {
        let (_directory, path) = file(rows().as_bytes());
        assert_bad(
            &read(&path, &mapped("only=id:9")).unwrap_err(),
            "column id",
            "no row has \"9\"",
            "1.0, 2.0",
        );
        let refused = read(&path, &mapped("only=servo:1")).unwrap_err();
        assert_bad(&refused, "column servo", "no column \"servo\"", "time_s, id");
    }

    #[test]
    fn what_is_asked_of_rows_in_turn_is_answered_as_it_says() {
        let (_directory, path) = file(rows().as_bytes());
        let asked = read(&path, &ReadOptions::default()).unwrap_err();
        assert_bad(&asked, "column id", "several motors in turn", "--map only=id:1.0");
        let map = "time=time_s:s,voltage=voltage_v:V,angle=angle_rad:rad";
        let asked = read(&path, &mapped(map)).unwrap_err();
        assert_bad(&asked, "column id", "several motors in turn", &format!("--map {map},only=id:1.0"));
    }
}
