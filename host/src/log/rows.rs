//! Lines of a table on their way to samples.

use std::path::Path;

use super::between::Between;
use super::choice::{Columns, TimeSource, Wanted};
use super::clock::Clock;
use super::direction;
use super::fields::{Splitter, trimmed};
use super::labels::Labels;
use super::numbers::{OfFile, in_brackets, number};
use super::only::Chosen;
use super::other_clock::other_clock;
use super::preamble::{self, Preamble};
use super::samples::{Place, Samples};
use super::several::Several;
use super::stamped::moment_of;
use super::structure::Structure;
use super::ticks::Ticks;
use super::units::Quantity;
use crate::error::Result;

/// Rows on their way from lines to samples.
pub(super) struct Rows<'a> {
    wanted: &'a Columns,
    splitter: Splitter,
    /// The names in the header; empty where there is none.
    names: Vec<String>,
    /// Their number, where there are any.
    width: Option<usize>,
    clock: &'a mut Clock,
    pub samples: Samples,
    pub structure: Structure,
    /// A column of words, by its place.
    pub labels: Option<(usize, Labels)>,
    /// The row in SI, time first.
    numbers: Vec<f64>,
    between: Between,
    pub several: Several,
    /// The rows that are read, where not all are.
    pub chosen: Option<Chosen>,
    /// The last value of each column, and how many blanks it stood for.
    last: Vec<Option<f64>>,
    pub held: Vec<Blanks>,
    /// How the numbers are written, of the time (0) and of each column (from 1).
    written: OfFile,
    /// Fields in brackets that are read as negative numbers.
    pub bracketed: Blanks,
    /// The count of a clock in whole ticks, or the number of a row.
    pub ticks: Ticks,
    /// The first and the last number of a row, where they are numbered.
    pub numbered: Option<(f64, f64)>,
    /// The last row's line, where lines have times, and whether it stood there a second time; the rows that did.
    last_line: Option<(String, bool)>,
    pub twice: Blanks,
    /// Rows so far, and the time that intervals add up to.
    count: u64,
    elapsed_s: f64,
    interval_s: f64,
}

/// The blanks of a column, or other fields that are to be told.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Blanks {
    /// How many.
    pub count: usize,
    /// The line of the first.
    pub first: Option<u64>,
}

impl Blanks {
    fn saw(&mut self, line: u64) {
        self.count += 1;
        self.first.get_or_insert(line);
    }
}

/// Whether a field is blank, or says that nothing was read; a dash is a direction.
fn is_blank(text: &str, of: Quantity) -> bool {
    text.is_empty() || of != Quantity::Direction && means_nothing(text)
}

/// Whether a field is blank, or says that it has no value.
fn means_nothing(text: &str) -> bool {
    const WORDS: [&str; 9] = ["nan", "null", "none", "na", "n/a", "nil", "-", "--", "#n/a"];
    match text.as_bytes() {
        [] => true,
        [b'0'..=b'9' | b'.', ..] | [b'-' | b'+', b'0'..=b'9', ..] => false,
        _ => WORDS.iter().any(|word| word.eq_ignore_ascii_case(text)),
    }
}

/// Why a row is no sample: a column, and what is wrong there.
enum Unread<'w> {
    /// Nothing is wrong: the column is logged less often.
    Blank,
    Bad(&'w str, String),
}

impl<'a> Rows<'a> {
    pub fn new(path: &'a Path, wanted: &'a Columns, head: &Preamble, clock: &'a mut Clock) -> Self {
        let headers = [wanted.time.header().to_owned()];
        let headers = headers.into_iter().chain(wanted.values.iter().map(|column| column.header.clone()));
        let count = wanted.values.len();
        Rows {
            wanted,
            splitter: head.splitter(),
            names: head.headers.clone().unwrap_or_default(),
            width: head.headers.as_ref().map(Vec::len),
            clock,
            samples: Samples::new(path, headers.collect())
                .cut_at_text(matches!(wanted.time, TimeSource::Rate(_)))
                .beside_clock(other_clock(head, wanted)),
            structure: Structure::default(),
            labels: Labels::sought(head, |k| wanted.reads(k)),
            numbers: vec![0.0; count + 1],
            between: Between::new(&wanted.values),
            several: Several::default(),
            chosen: wanted.only.clone().map(|(place, only)| Chosen::new(place, only)),
            last: vec![None; count],
            held: vec![Blanks::default(); count],
            written: OfFile::with_thousands(head.thousands),
            bracketed: Blanks::default(),
            ticks: match wanted.time {
                TimeSource::Numbered(..) => Ticks::of_rows(),
                _ => Ticks::default(),
            },
            numbered: None,
            // Without a time of their own equal lines are those of a motor that stands still.
            last_line: matches!(
                wanted.time,
                TimeSource::Column(_) | TimeSource::Columns(..) | TimeSource::Stamps
            )
            .then(Default::default),
            twice: Blanks::default(),
            count: 0,
            elapsed_s: 0.0,
            interval_s: 0.0,
        }
    }

    /// Takes a line.
    pub fn take(&mut self, number: u64, line: &str, state: Option<usize>) -> Result<()> {
        let place = Place::Line(number);
        let text = trimmed(line);
        if preamble::remark_in(text.trim_start()).is_some() || preamble::is_nothing(text) {
            return Ok(());
        }
        let header = self.wanted.time.header();
        if !self.splitter.split(text) {
            self.stray(place, header, "a quotation mark is not closed".into(), text);
            return Ok(());
        }
        let short = self.width.is_some_and(|width| self.splitter.len() < width);
        if let Some(chosen) = self.chosen.as_mut().filter(|_| !short)
            && self.splitter.get(chosen.place()).is_some_and(|text| !chosen.takes(text))
        {
            return Ok(());
        }
        if let Some(whose) = self.several.column().and_then(|column| self.splitter.get(column))
            && !short
            && self.several.saw(whose)
            && self.samples.begin_anew()
        {
            self.last.fill(None);
            self.between = Between::new(&self.wanted.values);
        }
        match self.numbers(number) {
            Ok(()) if self.is_again(text) => {
                self.twice.saw(number);
                self.samples.saw_again();
            }
            Ok(()) => {
                for (column, mean) in self.between.take(&self.numbers, true) {
                    self.samples.correct_last(column, mean);
                }
                if let Err(fault) = self.samples.accept(place, &self.numbers) {
                    self.several.goes_back();
                    return Err(fault);
                }
                if let Some(state) = state.and_then(|index| self.splitter.get(index)) {
                    self.structure.saw(self.samples.len().saturating_sub(1), state);
                }
                if let Some((column, labels)) = &mut self.labels
                    && let Some(text) = self.splitter.get(*column)
                {
                    labels.saw(self.numbers[0], text);
                }
            }
            Err(Unread::Blank) => {
                self.between.take(&self.numbers, false);
            }
            Err(Unread::Bad(column, why)) if short || self.is_header() => {
                self.stray(place, column, why, text);
            }
            Err(Unread::Bad(column, why)) => self.samples.reject(place, column, why),
        }
        Ok(())
    }

    /// Leaves out the line that was split, which is no row.
    fn stray(&mut self, place: Place, column: &str, why: String, text: &str) {
        let is_text = self.splitter.iter().all(|field| number(field).is_none());
        let why = if is_text { format!("\"{}\" is no row", shown(text)) } else { why };
        self.samples.stray(place, column, why, is_text);
    }

    /// Whether the line that was split is the header once more.
    fn is_header(&self) -> bool {
        self.splitter.iter().eq(self.names.iter().map(String::as_str))
    }

    /// Whether a line says once more what the one before it says; what stands there more often is a clock that stands still.
    fn is_again(&mut self, text: &str) -> bool {
        let Some((last, is_second)) = &mut self.last_line else { return false };
        *is_second = !*is_second && last == text;
        if !*is_second {
            text.clone_into(last);
        }
        *is_second
    }

    /// Fills `self.numbers` from the line that was split.
    fn numbers(&mut self, number: u64) -> Result<(), Unread<'a>> {
        let wanted = self.wanted;
        if let Some(width) = self.width
            && self.splitter.len() > width
            && self.splitter.iter().skip(width).any(|extra| !extra.is_empty())
        {
            let why = format!("the row has {} fields under {width} headers", self.splitter.len());
            return Err(Unread::Bad(wanted.time.header(), why));
        }
        if self.width.is_none_or(|width| self.splitter.len() >= width) {
            self.count += 1;
        }
        self.numbers[0] = self.time().map_err(|(column, why)| Unread::Bad(column, why))?;
        let mut blank = false;
        for (k, column) in wanted.values.iter().enumerate() {
            let less = column.less.map(|index| self.splitter.get(index).unwrap_or_default());
            // A line that is shorter than a row has no blanks but ends too early.
            let text = match self.splitter.get(column.index) {
                Some(text)
                    if (is_blank(text, column.quantity) || less.is_some_and(means_nothing))
                        && is_blank_permitted(&self.splitter, self.width) =>
                {
                    self.held[k].saw(number);
                    match self.last[k].filter(|_| is_held(column.quantity)) {
                        Some(value) => self.numbers[k + 1] = value,
                        None => blank = true,
                    }
                    continue;
                }
                text => text.unwrap_or_default(),
            };
            if in_brackets(text).is_some() {
                self.bracketed.saw(number);
            }
            let value = match column.quantity {
                Quantity::Direction => direction(text),
                _ => field(text, self.written.read(k + 1, text)).map(|value| column.unit.to_si(value)),
            };
            let value = value
                .and_then(|value| less.map_or(Ok(value), |text| Ok(value - in_si(text, column)?)))
                .map_err(|why| Unread::Bad(column.header.as_str(), why))?;
            self.last[k] = Some(value);
            self.numbers[k + 1] = value;
        }
        if blank { Err(Unread::Blank) } else { Ok(()) }
    }

    /// The time of the line that was split, s, or the column to blame and why.
    fn time(&mut self) -> Result<f64, (&'a str, String)> {
        match &self.wanted.time {
            TimeSource::Rate(rate) => Ok((self.count.saturating_sub(1)) as f64 / rate),
            TimeSource::Numbered(column, per_row, rate) => {
                let text = self.splitter.get(column.index).unwrap_or_default();
                let number = field(text, number(text)).map_err(|why| (column.header.as_str(), why))?;
                let number = self.ticks.read(number);
                let (first, _) = *self.numbered.get_or_insert((number, number));
                self.numbered = Some((first, number));
                Ok((number - first) / per_row / rate)
            }
            TimeSource::Stamps => {
                let stamp = self.splitter.stamp().unwrap_or_default();
                moment_of(stamp, self.clock).ok_or_else(|| {
                    (self.wanted.time.header(), "no stamp tells when this line was received".into())
                })
            }
            TimeSource::Column(column) => self.moment(column, column.unit.factor),
            TimeSource::Columns(seconds, rest) => {
                let whole = self.moment(seconds, 1.0)?;
                let text = self.splitter.get(rest.index).unwrap_or_default();
                Ok(whole
                    + field(text, number(text)).map_err(|why| (rest.header.as_str(), why))?
                        * rest.unit.factor)
            }
            TimeSource::Intervals(column) => {
                let text = self.splitter.get(column.index).unwrap_or_default();
                let interval = field(text, self.written.read(0, text)).and_then(|dt| {
                    if dt < 0.0 {
                        Err(format!("\"{text}\" is no time since the row before"))
                    } else {
                        Ok(dt * column.unit.factor)
                    }
                });
                // Of a row that cannot be read the time passes all the same.
                self.interval_s = *interval.as_ref().unwrap_or(&self.interval_s);
                self.elapsed_s += self.interval_s;
                interval.map(|_| self.elapsed_s).map_err(|why| (column.header.as_str(), why))
            }
        }
    }

    fn moment(&mut self, column: &'a Wanted, unit_s: f64) -> Result<f64, (&'a str, String)> {
        let text = self.splitter.get(column.index).unwrap_or_default();
        let number = self.written.read(0, text);
        let number = number.map(|count| self.ticks.read(count));
        if number.is_some_and(|value| value.is_finite())
            && let Some(time) = self.clock.read(text, unit_s, number)
        {
            return Ok(time);
        }
        let time = if number.is_none() { self.clock.read(text, unit_s, None) } else { None };
        time.ok_or_else(|| (column.header.as_str(), field(text, number).err().unwrap_or_default()))
    }
}

/// Whether a quantity stays as it was while nothing new is logged of it; where the shaft is does not.
pub(super) fn is_held(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::Angle | Quantity::Speed)
}

/// A row of full width has blanks; of values with names those that are absent are blank.
fn is_blank_permitted(splitter: &Splitter, width: Option<usize>) -> bool {
    width.is_some_and(|width| splitter.len() >= width)
}

/// The finite number in a field, read as `number`, or why there is none.
fn field(text: &str, number: Option<f64>) -> Result<f64, String> {
    match number {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("\"{text}\" is not a number a fit can use")),
        None if text.is_empty() => Err("the field is empty".into()),
        None => Err(format!("\"{}\" is not a number", shown(text))),
    }
}

/// As much of a field as a message holds.
fn shown(text: &str) -> String {
    text.chars().take(40).collect()
}

/// The number in a field in SI, by the unit of `column`.
fn in_si(text: &str, column: &Wanted) -> Result<f64, String> {
    field(text, number(text)).map(|value| column.unit.to_si(value))
}

/// What a field of a column of directions says, or why it says nothing.
fn direction(text: &str) -> Result<f64, String> {
    let none =
        |_| format!("\"{}\" is no direction (F, R, stop, 1, -1, CW, CCW and their like are)", shown(text));
    direction::named(text).map_or_else(|| field(text, number(text)).map_err(none), Ok)
}
