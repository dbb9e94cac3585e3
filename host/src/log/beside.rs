//! Units that stand beside the numbers themselves: `5.2V`, `12 ms`.

use super::fields::Splitter;
use super::guess::unit_names;
use super::numbers::number;

/// Share of the values of a column that have its unit beside them.
const MOST: f64 = 0.6;

/// The unit behind the number in a field, as it stands there; none where it is no number with a known unit.
pub(super) fn unit(text: &str) -> Option<&str> {
    let end = text.rfind(|c: char| c.is_ascii_digit() || c == '.')? + 1;
    let (value, unit) = (text.get(..end)?, text.get(end..)?.trim());
    (number(value).is_some() && unit_names::unit_named(unit).is_some()).then_some(unit)
}

/// The units that stand beside the numbers of each column.
#[derive(Debug, Default)]
pub(super) struct Units {
    /// Of each column its units so far, with how many fields had them, and how many fields had any value.
    seen: Vec<(Vec<(String, usize)>, usize)>,
}

impl Units {
    /// Looks at the row that was split last.
    pub fn see(&mut self, row: &Splitter) {
        self.seen.resize(self.seen.len().max(row.len()), (Vec::new(), 0));
        for (text, (units, count)) in row.iter().zip(&mut self.seen).filter(|(text, _)| !text.is_empty()) {
            *count += 1;
            let Some(unit) = unit(text) else { continue };
            match units.iter_mut().find(|(known, _)| known == unit) {
                Some((_, times)) => *times += 1,
                None => units.push((unit.to_owned(), 1)),
            }
        }
    }

    /// The unit of each column, as the fields of most rows have it; empty where they have none. All of it is empty where no column has
    /// one.
    pub fn of_columns(self) -> Vec<String> {
        let most = |(units, count): (Vec<(String, usize)>, usize)| {
            let (unit, times) = units.into_iter().max_by_key(|(_, times)| *times)?;
            (times as f64 >= MOST * count as f64).then_some(unit)
        };
        let units: Vec<String> =
            self.seen.into_iter().map(|column| most(column).unwrap_or_default()).collect();
        if units.iter().all(String::is_empty) { Vec::new() } else { units }
    }
}

#[cfg(test)]
mod tests {
    use super::super::fields::Separator;
    use super::*;

    #[test]
    fn the_unit_behind_a_number_is_told_and_a_word_is_none() {
        for (text, expected) in
            [("5.2V", Some("V")), ("-3,1 rad/s", Some("rad/s")), ("45°", Some("°")), ("80 %", Some("%"))]
        {
            assert_eq!(unit(text), expected, "{text}");
        }
        for text in ["5.2", "V", "enc1V", "1e5", "12 apples", "ADC3 mV", ""] {
            assert_eq!(unit(text), None, "{text}");
        }
    }

    #[test]
    fn a_column_has_the_unit_of_most_of_its_fields() {
        let units = |rows: &[&str]| {
            let (mut splitter, mut units) = (Splitter::of(Separator::Byte(b','), false), Units::default());
            for row in rows {
                splitter.split(row);
                units.see(&splitter);
            }
            units.of_columns()
        };
        assert_eq!(units(&["0 ms,5V,1", "1 ms,,2", "2 ms,200mV,3", "3 ms,4.5V,4"]), ["ms", "V", ""]);
        assert!(units(&["1,2", "3,4"]).is_empty());
    }
}
