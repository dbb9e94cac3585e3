//! Lines that have not the shape of a row: half a row, a footer, or what a board or its terminal prints when it starts again.

use super::{BadField, LISTED, Place, Samples};

/// The lines since the last row that are no rows.
#[derive(Debug)]
pub(super) struct Strays {
    pub(super) first: BadField,
    last: Place,
    pub(super) count: usize,
    /// None of them holds a number.
    are_text: bool,
}

impl Samples {
    /// Cuts the record where several lines of text stand between its rows: of rows without a clock nothing else tells a pause.
    pub fn cut_at_text(self, cut_at_text: bool) -> Self {
        Samples { cut_at_text, ..self }
    }

    /// Leaves out a line that has not the shape of a row; `is_text` where no field of it is a number.
    pub fn stray(&mut self, place: Place, column: &str, why: String, is_text: bool) {
        match &mut self.strays {
            Some(strays) => {
                strays.count += 1;
                strays.last = place;
                strays.are_text &= is_text;
            }
            None => {
                let first = BadField { place, column: column.to_owned(), why };
                self.strays = Some(Strays { first, last: place, count: 1, are_text: is_text });
            }
        }
    }

    /// Strays with a row after them are bad rows; several lines of text interrupt the log once, however many they are. Tells whether they
    /// were that.
    pub(super) fn count_strays(&mut self) -> bool {
        let Some(Strays { first, last, count, are_text }) = self.strays.take() else { return false };
        let is_text = are_text && count > 1;
        if is_text {
            let why = format!("{}, nor is what stands below it up to {}", first.why, last.in_words());
            self.note(BadField { why, ..first }, 1);
        } else {
            self.note(first, count);
        }
        is_text
    }

    pub(super) fn note(&mut self, first: BadField, count: usize) {
        self.rows += count;
        self.bad_count += count;
        if self.bad.len() < LISTED {
            self.bad.push(first);
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::log::read_tests::file;
    use crate::log::{ReadOptions, Record, read};

    const BANNER: &str = "WARNING - terminal: connection broken\n\n   _+=+_\n .-`  .  `-.   888b.  d88P\" \"Y88b\n    \"   Copyright\n\
                          Version: 3.1.6  Uptime: 0.000 s\n";

    /// 60 rows, of which this stands before the row `at`.
    fn log(header: &str, between: &str, at: u32) -> String {
        let row = |k: u32| {
            let before = if k == at { between } else { "" };
            format!(
                "{before}{:.2},{:.3},{:.4}\n",
                0.01 * f64::from(k),
                (0.3 * f64::from(k)).sin(),
                0.02 * f64::from(k)
            )
        };
        format!("{header}\n") + &(0..60).map(row).collect::<String>()
    }

    fn records(text: &str, options: ReadOptions) -> Vec<Record> {
        let (_directory, path) = file(text.as_bytes());
        read(&path, &options).unwrap()
    }

    #[test]
    fn a_second_banner_and_header_interrupt_the_log_once_and_are_named() {
        let header = "time_s,voltage_v,angle_rad";
        let records = records(&log(header, &format!("{BANNER}{header}\n"), 30), ReadOptions::default());
        assert_eq!(records.iter().map(Record::len).sum::<usize>(), 60);
        let said = records[0].warnings.iter().find(|warning| warning.place.contains("line 32")).unwrap();
        assert!(
            said.what.contains("\"WARNING") && said.what.contains("up to line 38; left out"),
            "{}",
            said.what
        );
    }

    #[test]
    fn rows_without_a_clock_are_cut_where_text_stands_between_them() {
        let header = "temp,u,x";
        let options = ReadOptions {
            map: Some("voltage=u:V,angle=x:rad".parse().unwrap()),
            rate_hz: Some(100.0),
            ..ReadOptions::default()
        };
        let cut = records(&log(header, &format!("{BANNER}{header}\n"), 30), options.clone());
        assert_eq!(cut.iter().map(Record::len).collect::<Vec<_>>(), [30, 30]);
        assert!(cut[0].warnings.iter().any(|w| w.what.contains("lines that are no rows stand between them")));
        // A header alone is none.
        assert_eq!(records(&log(header, &format!("{header}\n"), 30), options).len(), 1);
    }

    #[test]
    fn halves_of_rows_are_bad_rows_each() {
        let text = log("time_s,voltage_v,angle_rad", "0.3,1\n0.3\n", 30);
        let (_directory, path) = file(text.as_bytes());
        let said = read(&path, &ReadOptions::default()).unwrap_err().to_string();
        assert!(said.contains("2 of 62 rows are unreadable"), "{said}");
    }
}
