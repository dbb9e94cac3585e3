//! A column of words beside the numbers, a logger's command or status: what it says where the motor did not follow its drive.

use super::fields::Splitter;
use super::layout::is_number;
use super::preamble::Preamble;

/// More changes than this are those of no state.
const MOST: usize = 200;

/// What a column of words says, and since when.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Labels {
    /// The name of the column.
    pub column: String,
    /// The words, each with the time of the first sample that has them, s; empty where nothing is known.
    pub since: Vec<(f64, String)>,
}

impl Labels {
    /// The first column of words alone in the first rows of a table, of those that no mapping `reads`, and its place.
    pub(super) fn sought(head: &Preamble, reads: impl Fn(usize) -> bool) -> Option<(usize, Labels)> {
        let names = head.headers.as_ref()?;
        let mut splitter = head.splitter();
        let mut are_words = vec![!head.rows.is_empty(); names.len()];
        for (_, row) in &head.rows {
            splitter.split(row);
            // A line that is shorter is no row.
            if splitter.len() >= names.len() {
                are_words.iter_mut().enumerate().for_each(|(k, are)| *are &= is_word(&splitter, k));
            }
        }
        let column = (0..names.len()).find(|k| are_words[*k] && !names[*k].is_empty() && !reads(*k))?;
        Some((column, Labels { column: names[column].clone(), since: Vec::new() }))
    }

    /// Takes what stands in the row of the sample at `time_s`.
    pub(super) fn saw(&mut self, time_s: f64, text: &str) {
        if self.since.len() <= MOST && self.since.last().is_none_or(|(_, last)| last != text) {
            self.since.push((time_s, text.to_owned()));
        }
    }

    /// The same where its words are few enough for states, and its clock never goes back.
    pub(super) fn usable(self) -> Option<Labels> {
        let rises = self.since.is_sorted_by(|(one, _), (next, _)| one < next);
        (self.since.len() <= MOST && rises).then_some(self)
    }

    /// What stands there at `time_s`.
    fn at(&self, time_s: f64) -> Option<&str> {
        let place = self.since.partition_point(|(since_s, _)| *since_s <= time_s);
        self.since.get(place.checked_sub(1)?).map(|(_, text)| text.as_str())
    }

    /// What it says in the first of these ranges of times, s, in whose middle it says anything else than at its beginning, as a clause in
    /// brackets; empty where it tells nothing of them.
    pub(super) fn of(labels: Option<&Labels>, ranges: &[(f64, f64)]) -> String {
        let said = |labels: &Labels| {
            let other = |(from, to): &(f64, f64)| {
                let (begin, middle) = (labels.at(*from)?, labels.at(0.5 * (from + to))?);
                (begin != middle && !middle.is_empty()).then(|| middle.to_owned())
            };
            let text = ranges.iter().find_map(other)?;
            Some(format!(" (the column \"{}\" says \"{text}\" there)", labels.column))
        };
        labels.and_then(said).unwrap_or_default()
    }
}

/// Whether the field of column `k` is a word, and neither a number nor a time.
fn is_word(row: &Splitter, k: usize) -> bool {
    row.get(k).is_some_and(|text| text.contains(char::is_alphabetic) && !is_number(text))
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::file;
    use super::super::{ReadOptions, read, suspicions};
    use super::*;

    #[test]
    fn what_a_column_of_words_says_is_told_where_it_changes() {
        let since = [(0.0, "idle"), (1.0, "run"), (3.0, "stop")].map(|(t, text)| (t, text.to_owned()));
        let labels = Labels { column: "command".into(), since: since.to_vec() };
        let said = |from: f64, to: f64| Labels::of(Some(&labels), &[(from, to)]);
        assert_eq!(said(2.8, 5.0), " (the column \"command\" says \"stop\" there)");
        assert_eq!((said(3.5, 5.0), Labels::of(None, &[(0.0, 5.0)])), (String::new(), String::new()));
    }

    #[test]
    fn a_driver_that_was_off_is_told_with_what_the_log_says_of_it() {
        let (mut x, mut w) = (0.0, 0.0);
        let row = |k: u32| {
            let (duty, command) =
                (20 * (1 + k / 40), if k < 180 { format!("run{}", k / 40) } else { "stop".into() });
            w += 0.5 * (if k < 180 { 0.1 * f64::from(duty) } else { 0.0 } - w);
            x += 0.1 * w;
            format!("{:.1},{duty},{x:.4},{command}\n", 0.1 * f64::from(k))
        };
        let text = format!("t,duty,x,command\n{}", (0..200).map(row).collect::<String>());
        let (_directory, path) = file(text.as_bytes());
        let map = Some("time=t:s,duty=duty:100,angle=x:rad".parse().unwrap());
        let options = ReadOptions { map, supply_volts: Some(10.0), ..ReadOptions::default() };
        let records = read(&path, &options).unwrap();
        let told = suspicions(&records);
        let off = told.iter().find(|warning| warning.what.starts_with("switched_off")).unwrap();
        assert!(off.what.contains("the column \"command\" says \"stop\" there"), "{}", off.what);
    }
}
