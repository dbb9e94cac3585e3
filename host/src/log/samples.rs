//! Collecting samples row by row, with one policy for holes and clocks whatever the file format.
//!
//! A row with an unreadable field is left out with a warning if at most 2 % of the rows are such; a row that repeats
//! the time before it likewise up to 10 %. Lines after the last sample that are no rows at all (a logger's closing
//! words) are left out with a warning. A row that came one row late is put where its time belongs. Time that runs backwards
//! otherwise is an error, because which half is right is not for a program to guess.

use std::path::{Path, PathBuf};

use super::Warning;
use super::bursts::bursts;
use super::guess::Proposal;
use crate::error::{BadInput, Result};

/// A third-order model has three numbers and three initial states; fewer rows than this cannot check a fit of it.
pub const FEWEST_SAMPLES: usize = 20;
const BAD_SHARE: f64 = 0.02;
const REPEAT_SHARE: f64 = 0.10;
/// Rows that come one row late in a log, or this share of them, may be put in order.
const FEW_LATE: usize = 2;
const LATE_SHARE: f64 = 0.002;
/// A row that comes late leaves a gap no longer than this many intervals behind.
const LATE_GAP: f64 = 3.0;
/// Bad rows that are reported one by one; the rest is summed up.
const LISTED: usize = 3;
/// A clock that goes back to within this share of the way from its beginning starts anew.
const NEAR_BEGINNING: f64 = 0.05;
/// Times that are all below this, s, and alike within this factor, are perhaps intervals.
const LONGEST_INTERVAL_S: f64 = 1.0;
const ALIKE: f64 = 20.0;
/// What the warning of a pause begins with.
pub(super) const MISSING: &str = "samples are missing";
/// A pause is worth a warning from this many median intervals on.
const GAP_INTERVALS: f64 = 10.0;

/// Where a row stands in its file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    /// A line of text, from 1.
    Line(u64),
    /// An entry of a JSON array, from 0.
    Entry(usize),
}

impl Place {
    fn in_words(self) -> String {
        match self {
            Place::Line(line) => format!("line {line}"),
            Place::Entry(entry) => format!("entry {entry}"),
        }
    }

    /// Puts the place into a fault: JSON has no line of its own, so an entry goes into the cause.
    pub fn mark(self, mut fault: BadInput) -> BadInput {
        match self {
            Place::Line(line) => fault.at_line(line),
            Place::Entry(entry) => {
                fault.why = format!("entry {entry}: {}", fault.why);
                fault
            }
        }
    }
}

#[derive(Debug)]
struct BadField {
    place: Place,
    column: String,
    why: String,
}

/// Rows as they come in. The first column is time.
#[derive(Debug)]
pub struct Samples {
    path: PathBuf,
    headers: Vec<String>,
    columns: Vec<Vec<f64>>,
    places: Places,
    rows: usize,
    bad: Vec<BadField>,
    bad_count: usize,
    /// The first of the lines since the last row that are no rows, and their number.
    strays: Option<(BadField, usize)>,
    repeats: usize,
    first_repeat: Option<Place>,
    restarts: Vec<usize>,
    late: Vec<Late>,
    /// The row before which the first one was left out.
    stale: Option<Late>,
}

/// A row that came after one of a later time, `before`, s.
#[derive(Debug)]
struct Late {
    place: Place,
    before: f64,
    time: f64,
}

/// The last place seen, and that of the longest pause so far.
#[derive(Debug, Default)]
struct Places {
    last: Option<Place>,
    longest_pause: Option<(f64, Place)>,
}

impl Samples {
    /// Starts a record with these columns, time first.
    pub fn new(path: &Path, headers: Vec<String>) -> Self {
        Samples {
            path: path.to_owned(),
            columns: vec![Vec::new(); headers.len()],
            headers,
            places: Places::default(),
            rows: 0,
            bad: Vec::new(),
            bad_count: 0,
            strays: None,
            repeats: 0,
            first_repeat: None,
            restarts: Vec::new(),
            late: Vec::new(),
            stale: None,
        }
    }

    /// Takes a row of finite numbers, in the order of the columns.
    ///
    /// # Errors
    /// Bad input if time runs backwards.
    pub fn accept(&mut self, place: Place, row: &[f64]) -> Result<()> {
        self.count_strays();
        self.rows += 1;
        let previous = self.places.last.replace(place);
        if self.rows == 2 {
            self.leave_out_stale_first(previous, place, row[0]);
        }
        if let Some(&before) = self.columns[0].last() {
            let step = row[0] - before;
            if step < 0.0 && self.is_late(row[0]) {
                let at = self.len() - 1;
                self.late.push(Late { place, before, time: row[0] });
                self.columns.iter_mut().zip(row).for_each(|(column, &value)| column.insert(at, value));
                return Ok(());
            }
            if step < 0.0 && self.starts_anew(row[0], before) {
                self.restarts.push(self.len());
            } else if step < 0.0 {
                // Times that go on falling began to with the first.
                let late = self.stale.take().unwrap_or(Late { place, before, time: row[0] });
                return Err(self.backwards(&late).into());
            }
            if step == 0.0 {
                self.repeats += 1;
                self.first_repeat.get_or_insert(place);
                return Ok(());
            }
            if self.places.longest_pause.is_none_or(|(longest, _)| step > longest) {
                self.places.longest_pause = Some((step, place));
            }
        }
        for (column, &value) in self.columns.iter_mut().zip(row) {
            column.push(value);
        }
        Ok(())
    }

    /// Leaves out the only row so far, at `previous`, where the next, at `place`, has an earlier `time`: what a serial port still held when
    /// the board was reset.
    fn leave_out_stale_first(&mut self, previous: Option<Place>, place: Place, time: f64) {
        let &[before] = self.columns[0].as_slice() else { return };
        if time < before {
            self.columns.iter_mut().for_each(Vec::clear);
            let why = format!("its time, {before} s, is later than that of the next row");
            let column = self.headers[0].clone();
            self.bad_count += 1;
            self.bad.push(BadField { place: previous.unwrap_or(place), column, why });
            self.stale = Some(Late { place, before, time });
        }
    }

    /// Puts `value` in a column of the last row.
    pub fn correct_last(&mut self, column: usize, value: f64) {
        if let Some(last) = self.columns[column].last_mut() {
            *last = value;
        }
    }

    /// The fault of a time that goes back.
    fn backwards(&self, late: &Late) -> BadInput {
        let fault = BadInput::new(
            &self.path,
            format!("time goes backwards, from {} s to {} s", late.before, late.time),
            self.or_intervals(
                late.time,
                "sort the rows by time, or cut the file where the clock was reset and give both parts",
            ),
        );
        late.place.mark(fault).in_column(&self.headers[0])
    }

    /// Whether `time` belongs between the last two rows, as that of a row which its logger wrote one row late.
    fn is_late(&self, time: f64) -> bool {
        let begin = self.restarts.last().copied().unwrap_or(0);
        let times = &self.columns[0][begin..];
        let Some((last, before)) = times.split_last() else { return false };
        let Some(&second) = before.last() else { return false };
        // A single time from the future is no row that others come late after.
        let usual = (second - before[0]) / (before.len() - 1).max(1) as f64;
        time > second && (before.len() < 3 || last - second <= LATE_GAP * usual)
    }

    /// What to do about a clock that does not rise, whose next time is `next`: times that stay about the same are perhaps none.
    fn or_intervals(&self, next: f64, remedy: &str) -> String {
        let times = self.columns[0].iter().copied().chain([next]);
        let (low, high) = times.fold((f64::MAX, 0.0), |(low, high): (f64, f64), t| (low.min(t), high.max(t)));
        if low > 0.0 && high < LONGEST_INTERVAL_S && high < ALIKE * low {
            let column = &self.headers[0];
            return format!(
                "if this is the time since the row before, say --map interval={column}:s (or its unit); otherwise {remedy}"
            );
        }
        remedy.to_owned()
    }

    /// Whether a clock that goes from `before` back to `now` starts anew, as for another test: it is nearer to the beginning than to
    /// the end, and there are samples for a record behind it.
    fn starts_anew(&self, now: f64, before: f64) -> bool {
        let begin = self.restarts.last().copied().unwrap_or(0);
        let first = self.columns[0][begin];
        self.len() - begin >= FEWEST_SAMPLES && now - first < NEAR_BEGINNING * (before - first)
    }

    /// Rows per second by the first and the last time, to three digits; none where too few times tell it.
    fn rate(&self) -> Option<f64> {
        let (first, last) = (self.columns[0].first()?, self.columns[0].last()?);
        let rate = (self.rows - 1) as f64 / (last - first);
        let digits = 10_f64.powf(rate.log10().floor() - 2.0);
        let rounded = (rate / digits).round() * digits;
        (self.len() >= FEWEST_SAMPLES && rounded.is_finite() && rounded > 0.0)
            .then(|| if digits >= 1.0 { rounded } else { (rounded * 1e6).round() / 1e6 })
    }

    /// Number of samples taken.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// The samples with which the clock starts anew.
    pub fn restarts(&self) -> &[usize] {
        &self.restarts
    }

    /// Leaves out a row that has an unreadable field.
    pub fn reject(&mut self, place: Place, column: &str, why: String) {
        self.count_strays();
        self.places.last = Some(place);
        self.note(BadField { place, column: column.to_owned(), why }, 1);
    }

    /// Leaves out a line that has not the shape of a row: a fault between rows, a footer after the last.
    pub fn stray(&mut self, place: Place, column: &str, why: String) {
        match &mut self.strays {
            Some((_, count)) => *count += 1,
            None => {
                let first = BadField { place, column: column.to_owned(), why };
                self.strays = Some((first, 1));
            }
        }
    }

    /// Strays with a row after them are bad rows.
    fn count_strays(&mut self) {
        if let Some((first, count)) = self.strays.take() {
            self.note(first, count);
        }
    }

    fn note(&mut self, first: BadField, count: usize) {
        self.rows += count;
        self.bad_count += count;
        if self.bad.len() < LISTED {
            self.bad.push(first);
        }
    }

    /// Ends the record: its columns, and its data quality problems.
    ///
    /// # Errors
    /// Bad input if too many rows had to be left out or too few are left.
    pub fn finish(mut self, header: Option<Place>) -> Result<(Vec<Vec<f64>>, Vec<Warning>)> {
        if self.strays.as_ref().is_some_and(|(_, count)| *count > self.columns[0].len()) {
            self.count_strays();
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
        let kept = self.columns[0].len();
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
            let even = rate.map(|rate| {
                format!("{remedy}; if the rows came evenly, --rate {rate} (rows per second) tells the time in the place of this column")
            });
            let remedy = self.or_intervals(
                self.columns[0].last().copied().unwrap_or(0.0),
                even.as_deref().unwrap_or(remedy),
            );
            let proposal = rate.map(|rate| Proposal { rate: Some(rate.to_string()), ..Proposal::default() });
            let fault = BadInput::new(&self.path, why, remedy).proposing(proposal);
            return Err(first.mark(fault).in_column(&self.headers[0]).into());
        }
        if kept < FEWEST_SAMPLES {
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
                what: format!("{}; the row was left out", bad.why),
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
        if let Some((first, count)) = &self.strays {
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
        let median = super::timing::median_interval(&self.columns[0]);
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
