//! Collecting samples row by row, with one policy for holes and clocks whatever the file format.
//!
//! A row with an unreadable field is left out with a warning if at most 2 % of the rows are such; a row that repeats
//! the time before it likewise up to 10 %. Lines after the last sample that are no rows at all (a logger's closing
//! words) are left out with a warning. A row that came one row late is put where its time belongs. Time that runs backwards
//! otherwise is an error, because which half is right is not for a program to guess.

mod finish;
mod strays;

use std::path::{Path, PathBuf};

use super::timing::to_three_digits;
use crate::error::{BadInput, Result};
pub(super) use finish::REPEAT_SHARE;
use strays::Strays;

/// A third-order model has three numbers and three initial states; fewer rows than this cannot check a fit of it.
pub const FEWEST_SAMPLES: usize = 20;
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
    /// Rows that were left out because they say again what the one before them says.
    again: usize,
    bad: Vec<BadField>,
    bad_count: usize,
    /// The lines since the last row that are no rows.
    strays: Option<Strays>,
    cut_at_text: bool,
    /// Fewer samples are refused.
    fewest: usize,
    /// Another column that rises and is called a time.
    other_clock: Option<String>,
    repeats: usize,
    first_repeat: Option<Place>,
    restarts: Vec<usize>,
    /// The next row begins a record, whatever its time.
    begins: bool,
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
            again: 0,
            bad: Vec::new(),
            bad_count: 0,
            strays: None,
            fewest: FEWEST_SAMPLES,
            cut_at_text: false,
            other_clock: None,
            repeats: 0,
            first_repeat: None,
            restarts: Vec::new(),
            begins: false,
            late: Vec::new(),
            stale: None,
        }
    }

    /// Takes so few samples for enough: what drives a motor may be logged where it changes.
    pub fn of_at_least(mut self, fewest: usize) -> Self {
        self.fewest = fewest;
        self
    }

    /// Names a column that may have been meant where the time goes back.
    pub fn beside_clock(mut self, other: Option<String>) -> Self {
        self.other_clock = other;
        self
    }

    /// Takes a row of finite numbers, in the order of the columns.
    ///
    /// # Errors
    /// Bad input if time runs backwards.
    pub fn accept(&mut self, place: Place, row: &[f64]) -> Result<()> {
        let is_interrupted = self.count_strays();
        self.rows += 1;
        let previous = self.places.last.replace(place);
        if self.rows == 2 {
            self.leave_out_stale_first(previous, place, row[0]);
        }
        if std::mem::take(&mut self.begins) {
            self.restarts.push(self.len());
        } else if let Some(&before) = self.columns[0].last() {
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
        if is_interrupted && self.cut_at_text && self.len() > 0 {
            self.restarts.push(self.len());
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

    /// Lets the next row begin another record, where there are samples for one since the last; tells whether there are.
    pub fn begin_anew(&mut self) -> bool {
        self.begins = self.len() - self.restarts.last().copied().unwrap_or(0) >= FEWEST_SAMPLES;
        self.begins
    }

    /// Puts `value` in a column of the last row.
    pub fn correct_last(&mut self, column: usize, value: f64) {
        if let Some(last) = self.columns[column].last_mut() {
            *last = value;
        }
    }

    /// The fault of a time that goes back.
    fn backwards(&self, late: &Late) -> BadInput {
        const SORT: &str =
            "sort the rows by time, or cut the file where the clock was reset and give both parts";
        let remedy = match &self.other_clock {
            Some(other) => {
                format!(
                    "\"{other}\" rises from row to row: if it is the clock, map it as the time; otherwise {SORT}"
                )
            }
            None => self.or_intervals(late.time, SORT),
        };
        let fault = BadInput::new(
            &self.path,
            format!("time goes backwards, from {} s to {} s", late.before, late.time),
            remedy,
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
        let rate = (self.rows + self.again - 1) as f64 / (last - first);
        to_three_digits(rate).filter(|_| self.len() >= FEWEST_SAMPLES)
    }

    /// Counts a row that says again what the one before it says, which is no sample.
    pub fn saw_again(&mut self) {
        self.again += 1;
    }

    /// Number of samples taken.
    pub fn len(&self) -> usize {
        self.columns[0].len()
    }

    /// The samples with which the clock starts anew, or before which text stands.
    pub fn restarts(&self) -> &[usize] {
        &self.restarts
    }

    /// Leaves out a row that has an unreadable field.
    pub fn reject(&mut self, place: Place, column: &str, why: String) {
        self.count_strays();
        self.places.last = Some(place);
        self.note(BadField { place, column: column.to_owned(), why }, 1);
    }
}
