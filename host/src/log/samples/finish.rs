//! The end of a record: refused where too much of it was left out, else with its data quality problems.

use super::strays::Strays;
use super::{FEWEST_SAMPLES, LISTED, MISSING, Place, Samples};
use crate::error::{BadInput, Result};
use crate::log::Warning;
use crate::log::bursts::bursts;
use crate::log::guess::Proposal;
use crate::log::timing::median_interval;

const BAD_SHARE: f64 = 0.02;
/// More samples than this share that repeat the time of the one before make a clock none.
pub const REPEAT_SHARE: f64 = 0.10;
/// Rows that come one row late in a log, or this share of them, may be put in order.
const FEW_LATE: usize = 2;
const LATE_SHARE: f64 = 0.002;
/// A pause is worth a warning from this many median intervals on.
const GAP_INTERVALS: f64 = 10.0;

impl Samples {
    /// Ends the record: its columns, and its data quality problems.
    ///
    /// # Errors
    /// Bad input if too many rows had to be left out or too few are left.
    pub fn finish(mut self, header: Option<Place>) -> Result<(Vec<Vec<f64>>, Vec<Warning>)> {
        // More of them than rows are no footer, and no one interruption.
        let kept = self.columns[0].len();
        if let Some(Strays { first, count, .. }) = self.strays.take_if(|strays| strays.count > kept) {
            self.note(first, count);
        }
        if self.rows == 0 {
            let fault = BadInput::new(
                &self.path,
                "there is a header but no sample below it",
                "check that the logger was started, and record at least a few seconds",
            );
            return Err(header.map_or(fault.clone(), |place| place.mark(fault)).into());
        }
        // One is none too many for a log that is not too short anyway: a speed that was divided by no time at first.
        let most = if self.rows >= FEWEST_SAMPLES { 1.0_f64 } else { 0.0 }.max(BAD_SHARE * self.rows as f64);
        if self.bad_count as f64 > most {
            let first = &self.bad[0];
            let fault = BadInput::new(
                &self.path,
                format!("{} ({} of {} rows are unreadable)", first.why, self.bad_count, self.rows),
                "remove these rows or repair the logger; one row and up to 2 % of them may be unreadable",
            );
            return Err(first.place.mark(fault).in_column(&first.column).into());
        }
        let most_late = FEW_LATE.max((LATE_SHARE * self.rows as f64) as usize);
        if let Some(first) = self.late.first().filter(|_| self.late.len() > most_late) {
            return Err(self.backwards(first).into());
        }
        if let Some(first) = self.first_repeat
            && self.repeats as f64 > REPEAT_SHARE * self.rows as f64
        {
            let why = format!("{} of {} rows repeat the time of the row before", self.repeats, self.rows);
            let remedy = "log the time with more digits, or log each sample once";
            let rate = self.rate();
            let rows = rate.map_or_else(|| "N".into(), |rate| rate.to_string());
            let even = format!(
                "{remedy}; if the rows came evenly, --rate {rows} (rows per second) tells the time in the place of this column"
            );
            let remedy = self.or_intervals(self.columns[0].last().copied().unwrap_or(0.0), &even);
            let proposal = rate.map(|rate| Proposal { rate: Some(rate.to_string()), ..Proposal::default() });
            let fault = BadInput::new(&self.path, why, remedy).proposing(proposal);
            return Err(first.mark(fault).in_column(&self.headers[0]).into());
        }
        if kept < self.fewest {
            let fault = BadInput::new(
                &self.path,
                format!("{kept} samples are too few to fit a motor"),
                format!(
                    "record at least {FEWEST_SAMPLES} samples, better some seconds with changing voltage"
                ),
            );
            return Err(self.places.last.map_or(fault.clone(), |place| place.mark(fault)).into());
        }
        let warnings = self.warnings();
        Ok((self.columns, warnings))
    }

    fn warnings(&self) -> Vec<Warning> {
        let file = self.path.display();
        let mut warnings: Vec<Warning> = self
            .bad
            .iter()
            .map(|bad| Warning {
                place: format!("{file}, {}, column {}", bad.place.in_words(), bad.column),
                what: format!("{}; left out", bad.why),
                fix: "remove the row".into(),
            })
            .collect();
        if self.bad_count > LISTED {
            warnings.push(Warning {
                place: file.to_string(),
                what: format!("{} more unreadable rows were left out", self.bad_count - LISTED),
                fix: "repair the logger".into(),
            });
        }
        if let Some(Strays { first, count, .. }) = &self.strays {
            warnings.push(Warning {
                place: format!("{file}, {}", first.place.in_words()),
                what: format!("{count} lines at the end are no samples and were left out"),
                fix: "remove them".into(),
            });
        }
        if let Some(first) = self.first_repeat {
            warnings.push(Warning {
                place: format!("{file}, {}, column {}", first.in_words(), self.headers[0]),
                what: format!("{} rows repeat the time before them and were left out", self.repeats),
                fix: "log the time with more digits, or log each sample once".into(),
            });
        }
        if let Some(first) = self.late.first() {
            let all: Vec<String> = self.late.iter().take(LISTED).map(|late| late.place.in_words()).collect();
            let more = if self.late.len() > LISTED { " and later" } else { "" };
            warnings.push(Warning {
                place: format!("{file}, {}, column {}", first.place.in_words(), self.headers[0]),
                what: format!(
                    "{} rows are earlier than the row before them and were put in order by their time: {}{more}",
                    self.late.len(),
                    all.join(", ")
                ),
                fix: "nothing, if the logger wrote them late; otherwise leave them out".into(),
            });
        }
        if let (Some(came), Some(rate)) = (bursts(&self.columns[0]), self.rate()) {
            warnings.push(Warning {
                place: format!("{file}, column {}", self.headers[0]),
                what: format!(
                    "stamped_in_bursts: {:.0} rows come at once and then none for {:.3} s, time and again: they were stamped when they arrived, not \
                     when they were measured",
                    came.rows, came.every_s
                ),
                fix: format!(
                    "if the rows were measured evenly, --rate {rate} (rows per second) tells the time in the place of this column; better log the \
                     board's own time (millis() or micros())"
                ),
            });
            return warnings;
        }
        let median = median_interval(&self.columns[0]);
        if let Some((pause, place)) = self.places.longest_pause
            && pause > GAP_INTERVALS * median
        {
            warnings.push(Warning {
                place: format!("{file}, {}", place.in_words()),
                what: format!("{MISSING} for {pause:.3} s before this row"),
                fix: "log without pauses, or cut the file there and give both parts".into(),
            });
        }
        warnings
    }
}
