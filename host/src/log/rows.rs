//! Lines of a table on their way to samples.

use std::path::Path;

use super::between::Between;
use super::choice::{Columns, TimeSource, Wanted};
use super::clock::Clock;
use super::direction;
use super::fields::{Splitter, trimmed};
use super::preamble::{self, Preamble};
use super::samples::{Place, Samples};
use super::several::Several;
use super::structure::Structure;
use super::ticks::Ticks;
use super::units::Quantity;
use crate::error::Result;

/// Rows on their way from lines to samples.
pub(super) struct Rows<'a> {
    wanted: &'a Columns,
    splitter: Splitter,
    /// Number of columns, where a header tells.
    width: Option<usize>,
    clock: &'a mut Clock,
    pub samples: Samples,
    pub structure: Structure,
    /// The row in SI, time first.
    numbers: Vec<f64>,
    between: Between,
    pub several: Several,
    /// The last value of each column, and how many blanks it stood for.
    last: Vec<Option<f64>>,
    pub held: Vec<Blanks>,
    /// Of the time and of each column, whether its whole numbers have points or commas between their thousands.
    whole: Vec<Whole>,
    /// Fields in brackets that are read as negative numbers.
    pub bracketed: Blanks,
    /// The count of a clock in whole ticks, or the number of a row.
    pub ticks: Ticks,
    /// The first and the last number of a row, where they are numbered.
    pub numbered: Option<(f64, f64)>,
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
            width: head.headers.as_ref().map(Vec::len),
            clock,
            samples: Samples::new(path, headers.collect()),
            structure: Structure::default(),
            numbers: vec![0.0; count + 1],
            between: Between::new(&wanted.values),
            several: Several::default(),
            last: vec![None; count],
            held: vec![Blanks::default(); count],
            whole: vec![Whole::default(); count + 1],
            bracketed: Blanks::default(),
            ticks: match wanted.time {
                TimeSource::Numbered(..) => Ticks::of_rows(),
                _ => Ticks::default(),
            },
            numbered: None,
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
            self.samples.stray(place, header, "a quotation mark is not closed".into());
            return Ok(());
        }
        if let Some(whose) = self.several.column().and_then(|column| self.splitter.get(column)) {
            self.several.saw(whose);
        }
        let short = self.width.is_some_and(|width| self.splitter.len() < width);
        match self.numbers(number) {
            Ok(()) => {
                for (column, mean) in self.between.take(&self.numbers, true) {
                    self.samples.correct_last(column, mean);
                }
                self.samples.accept(place, &self.numbers)?;
                if let Some(state) = state.and_then(|index| self.splitter.get(index)) {
                    self.structure.saw(self.samples.len().saturating_sub(1), state);
                }
            }
            Err(Unread::Blank) => {
                self.between.take(&self.numbers, false);
            }
            Err(Unread::Bad(column, why)) if short => self.samples.stray(place, column, why),
            Err(Unread::Bad(column, why)) => self.samples.reject(place, column, why),
        }
        Ok(())
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
                _ => field(text, self.whole[k + 1].read(text)).map(|value| column.unit.to_si(value)),
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
                // A board counts milliseconds, ROS seconds with their fraction, a serial monitor reads a clock.
                let unit_s = if stamp.contains('.') { 1.0 } else { 1e-3 };
                self.clock.read(stamp, unit_s, stamp.parse().ok()).ok_or_else(|| {
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
                let interval = field(text, self.whole[0].read(text)).and_then(|dt| {
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
        let number = self.whole[0].read(text);
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

/// Whole numbers of one column, row by row: `990`, then `1.000` or `1,000`, where another row's would be a decimal sign.
#[derive(Debug, Clone, Copy)]
pub(super) struct Whole {
    /// All so far were plain whole numbers.
    only: bool,
    last: Option<f64>,
    between: Option<char>,
}

impl Default for Whole {
    fn default() -> Self {
        Self { only: true, last: None, between: None }
    }
}

impl Whole {
    /// The number in `text`. Thousands are told from decimals by what came before: the numbers go on, or they jump to a thousandth.
    pub fn read(&mut self, text: &str) -> Option<f64> {
        if !self.only && self.between.is_none() {
            return number(text);
        }
        let grouped = |sign: char| {
            let thousands = text.contains(sign) && !text.starts_with('0') && is_grouped(text, &[sign]);
            thousands.then(|| text.replace(sign, "").parse::<f64>().ok()).flatten()
        };
        if let Some(value) = self.between.and_then(grouped) {
            self.last = Some(value);
            return Some(value);
        }
        let plain = number(text)?;
        let is_whole = text.bytes().all(|b| b.is_ascii_digit() || b == b'-' || b == b'+');
        if let (true, false, Some(last)) = (self.only, is_whole, self.last) {
            let goes_on = |value: f64| (value - last).abs() < (plain - last).abs();
            for sign in ['.', ','] {
                if let Some(value) = grouped(sign).filter(|value| goes_on(*value)) {
                    (self.between, self.last) = (Some(sign), Some(value));
                    return Some(value);
                }
            }
        }
        self.only &= is_whole;
        self.last = Some(plain);
        Some(plain)
    }
}

/// The finite number in a field, read as `number`, or why there is none.
fn field(text: &str, number: Option<f64>) -> Result<f64, String> {
    match number {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("\"{text}\" is not a number a fit can use")),
        None if text.is_empty() => Err("the field is empty".into()),
        None => {
            let shown: String = text.chars().take(40).collect();
            Err(format!("\"{shown}\" is not a number"))
        }
    }
}

/// The number in a field in SI, by the unit of `column`.
fn in_si(text: &str, column: &Wanted) -> Result<f64, String> {
    field(text, number(text)).map(|value| column.unit.to_si(value))
}

/// What a field of a column of directions says, or why it says nothing.
fn direction(text: &str) -> Result<f64, String> {
    direction::named(text).map_or_else(|| field(text, number(text)), Ok)
}

/// The number in a field; a comma within a field is a decimal one, since it separates nothing, and thousands may stand apart.
pub(super) fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().or_else(|| {
        let decimal_comma = text.contains(',');
        let point = decimal_comma.then(|| text.replacen(',', ".", 1));
        let plain = point.as_deref().unwrap_or(text);
        let with_point = point.as_ref().and_then(|text| text.parse().ok());
        with_point
            .or_else(|| with_thousands(plain))
            .or_else(|| points_and_comma(text))
            .or_else(|| twice_grouped(text))
            .or_else(|| hex(text))
            .or_else(|| one_of(text))
            .or_else(|| in_brackets(text))
            .or_else(|| typeset(text))
    })
}

/// The only number of an array, `[0.5]` or `(0.5,)`, as messages of ROS with one joint are exported.
fn one_of(text: &str) -> Option<f64> {
    let inside = text.strip_prefix('[').and_then(|text| text.strip_suffix(']'));
    let inside = inside.or_else(|| text.strip_prefix('(')?.strip_suffix(",)"));
    inside?.trim().trim_end_matches(',').parse().ok()
}

/// `(3.25)`, as accountants and their spreadsheets write -3.25.
fn in_brackets(text: &str) -> Option<f64> {
    let inside = text.strip_prefix('(')?.strip_suffix(')')?.trim();
    (inside.starts_with(|c: char| c.is_ascii_digit() || c == '.')).then(|| number(inside))?.map(|size| -size)
}

/// A minus as books have it (`\u{2212}0.5`), and Fortran's exponent (`1.5D-03`).
fn typeset(text: &str) -> Option<f64> {
    let plain = text.replace('\u{2212}', "-").replace(['D', 'd'], "e");
    (plain != text).then(|| plain.parse().ok()).flatten()
}

/// `1'234.5`, as Swiss spreadsheets and pocket calculators write it, and the same with a narrow blank.
fn with_thousands(text: &str) -> Option<f64> {
    const BETWEEN: [char; 4] = ['\'', '\u{2019}', '\u{A0}', '\u{202F}'];
    if !text.contains(BETWEEN) {
        return None;
    }
    let whole = text.split('.').next().unwrap_or_default();
    is_grouped(whole, &BETWEEN).then(|| text.replace(BETWEEN, "").parse().ok()).flatten()
}

/// `1.234,5` of a German spreadsheet and `1,234.5` of an English one: which of both is decimal is told where both are there.
fn points_and_comma(text: &str) -> Option<f64> {
    let (decimal, between) = if text.rfind(',')? > text.rfind('.')? { (',', '.') } else { ('.', ',') };
    let (whole, part) = text.rsplit_once(decimal)?;
    let plain = || format!("{}.{part}", whole.replace(between, "")).parse().ok();
    is_grouped(whole, &[between]).then(plain).flatten()
}

/// `1.234.567` or `1,234,567`: twice in a number no sign is a decimal one.
fn twice_grouped(text: &str) -> Option<f64> {
    let sign = ['.', ','].into_iter().find(|sign| text.matches(*sign).count() > 1)?;
    is_grouped(text, &[sign]).then(|| text.replace(sign, "").parse().ok()).flatten()
}

/// Whether a whole number has its digits in threes, but for the first.
fn is_grouped(whole: &str, between: &[char]) -> bool {
    let mut groups = whole.trim_start_matches(['-', '+']).split(between);
    let digits = |group: &str| group.bytes().all(|b| b.is_ascii_digit());
    let first = groups.next().is_some_and(|group| (1..=3).contains(&group.len()) && digits(group));
    first && groups.all(|group| group.len() == 3 && digits(group))
}

/// `0x1A3F`; all digits of 32 or 64 bits are those of a number with a sign.
fn hex(text: &str) -> Option<f64> {
    let digits = text.strip_prefix("0x").or_else(|| text.strip_prefix("0X"))?;
    // A sign that is no digit is none.
    let number =
        digits.bytes().all(|b| b.is_ascii_hexdigit()).then(|| u64::from_str_radix(digits, 16).ok())??;
    Some(match digits.len() {
        8 => f64::from(number as u32 as i32),
        16 => number as i64 as f64,
        _ => number as f64,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typeset_minus_and_fortrans_exponent_are_read() {
        assert_eq!(
            ["\u{2212}0.5", "1.5D-03", "-2.0d+01"].map(number),
            [Some(-0.5), Some(0.0015), Some(-20.0)]
        );
        assert_eq!(["d", "D1", "dead"].map(number), [None; 3]);
    }

    #[test]
    fn brackets_are_a_minus_and_an_array_of_one_is_its_number() {
        assert_eq!(["(3.25)", "(1,234.5)", "( 2 )"].map(number), [Some(-3.25), Some(-1234.5), Some(-2.0)]);
        assert_eq!(["[0.5]", "(0.5,)", "[-1]"].map(number), [Some(0.5), Some(0.5), Some(-1.0)]);
        assert_eq!(["(-3)", "(V)", "((3))", "()"].map(number), [None; 4]);
    }

    #[test]
    fn thousands_are_told_from_decimals_by_the_numbers_before() {
        let read = |texts: &[&str]| {
            let mut column = Whole::default();
            texts.iter().map(|text| column.read(text).unwrap_or(f64::NAN)).collect::<Vec<_>>()
        };
        assert_eq!(read(&["980", "990", "1.000", "1.010"]), [980.0, 990.0, 1000.0, 1010.0]);
        assert_eq!(read(&["-990", "-1,000", "-999"]), [-990.0, -1000.0, -999.0]);
        assert_eq!(read(&["999.990", "1.000.000"]), [999.99, 1e6]);
        // Decimals whose zeros were left out.
        assert_eq!(read(&["5", "5", "4.926", "5"]), [5.0, 5.0, 4.926, 5.0]);
        assert_eq!(read(&["0", "1", "1.125", "1.25"]), [0.0, 1.0, 1.125, 1.25]);
        assert_eq!(read(&["0", "0", "0.125"]), [0.0, 0.0, 0.125]);
    }
}
