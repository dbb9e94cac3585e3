//! Reading a table of samples: canonical logs, and foreign ones by `--map`.

use std::io::BufRead;
use std::path::Path;

use super::choice::{Choice, Columns, TimeSource, Wanted};
use super::clock::Clock;
use super::fields::Splitter;
use super::guess;
use super::mapping::Mapping;
use super::preamble::{self, Preamble};
use super::samples::{Place, Samples};
use super::servo::Servo;
use super::structure::{self, Structure};
use super::text::cannot_read;
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record, Warning};
use crate::error::Result;

/// The columns of a table that are wanted.
#[derive(Debug)]
pub(super) struct Read {
    /// Times, s.
    pub time_s: Vec<f64>,
    /// The others, in the units of a record; a duty is a fraction.
    pub values: Vec<(Quantity, Vec<f64>)>,
    pub meta: Metadata,
    pub structure: Structure,
    pub warnings: Vec<Warning>,
}

/// Reads the record (or the tests) from `input`, which stands at the beginning of the file at `path`.
///
/// # Errors
/// Bad input, with line and column; wrong usage where an option is missing to make sense of the mapping.
pub fn read(path: &Path, input: impl BufRead, options: &ReadOptions) -> Result<Vec<Record>> {
    let read = columns(path, input, options, &mut Clock::default(), false)?;
    let structure = read.structure.clone();
    Ok(structure.tests(record(path, super::stem(path), read, options)?))
}

/// Reads the columns; `partial` permits that some are in another file, whose clock is `clock`.
///
/// # Errors
/// As [`read`].
pub(super) fn columns(
    path: &Path,
    mut input: impl BufRead,
    options: &ReadOptions,
    clock: &mut Clock,
    partial: bool,
) -> Result<Read> {
    let by_number = options.map.as_ref().is_some_and(Mapping::is_by_number);
    let mut head = preamble::read(path, &mut input, by_number)?;
    let mut meta = std::mem::take(&mut head.meta);
    options.complete(path, &mut meta)?;
    let names = head.headers.clone().unwrap_or_default();
    let choice = Choice {
        path,
        line: head.line,
        names: &names,
        units: &head.units,
        stamped: head.stamped,
        meta: &meta,
        partial,
    };
    let wanted = match choice.columns(options)? {
        Ok(wanted) => wanted,
        Err(missing) => return Err(choice.refusal(&missing, proposal(path, input, &head)?)),
    };
    let state = structure::state_column(&names)
        .filter(|k| wanted.values.iter().all(|column| column.index != *k))
        .filter(|k| !matches!(&wanted.time, TimeSource::Column(time) if time.index == *k));
    let mut rows = Rows::new(path, &wanted, &head, clock);
    for (number, line) in std::mem::take(&mut head.rows) {
        rows.take(number, &line, state)?;
    }
    let (mut number, mut line) = (head.read, String::new());
    while input.read_line(&mut line).map_err(|error| cannot_read(path, &error))? > 0 {
        number += 1;
        rows.take(number, &line, state)?;
        line.clear();
    }
    let Rows { samples, mut structure, held, .. } = rows;
    structure.restarts = samples.restarts().to_vec();
    let (mut columns, mut warnings) = samples.finish(Some(Place::Line(head.line)))?;
    let file = path.display();
    let mut say =
        |place: String, what: String, fix: &str| warnings.push(Warning { place, what, fix: fix.into() });
    if head.skipped > 0 {
        say(
            format!("{file}, line {}", head.line),
            format!("{} lines of text before the header were left out", head.skipped),
            "nothing, if the header is right",
        );
    }
    for (column, count) in wanted.values.iter().zip(held).filter(|(_, count)| *count > 0) {
        let (what, fix) = if is_held(column.quantity) {
            (
                format!("{count} blank fields hold the value before them"),
                "nothing, if this is logged when it changes or less often",
            )
        } else {
            (
                format!(
                    "{count} rows with a blank here were left out; what drives the motor holds through them"
                ),
                "nothing, if this is logged less often",
            )
        };
        say(format!("{file}, column {}", column.header), what, fix);
    }
    if matches!(wanted.time, TimeSource::Stamps) {
        say(
            file.to_string(),
            "the times are those at which the serial monitor received the lines, some ms late and uneven"
                .into(),
            "print millis() or micros() in every line",
        );
    }
    if wanted.rate_unused {
        say(
            format!("{file}, column {}", wanted.time.header()),
            "--rate is not used, because this tells the time".into(),
            "leave --rate out, or remove the column if it is wrong",
        );
    }
    let time_s = columns.remove(0);
    let values = wanted.values.iter().map(|column| column.quantity).zip(columns).collect();
    Ok(Read { time_s, values, meta, structure, warnings })
}

/// Rows on their way from lines to samples.
struct Rows<'a> {
    wanted: &'a Columns,
    splitter: Splitter,
    /// Number of columns, where a header tells.
    width: Option<usize>,
    clock: &'a mut Clock,
    samples: Samples,
    structure: Structure,
    /// The row in SI, time first.
    numbers: Vec<f64>,
    /// The last value of each column, and how many blanks it stood for.
    last: Vec<Option<f64>>,
    held: Vec<usize>,
    /// Rows so far, and the time that intervals add up to.
    count: u64,
    elapsed_s: f64,
    interval_s: f64,
}

/// Why a row is no sample: a column, and what is wrong there.
enum Unread<'w> {
    /// Nothing is wrong: the column is logged less often.
    Blank,
    Bad(&'w str, String),
}

impl<'a> Rows<'a> {
    fn new(path: &'a Path, wanted: &'a Columns, head: &Preamble, clock: &'a mut Clock) -> Self {
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
            last: vec![None; count],
            held: vec![0; count],
            count: 0,
            elapsed_s: 0.0,
            interval_s: 0.0,
        }
    }

    /// Takes a line.
    fn take(&mut self, number: u64, line: &str, state: Option<usize>) -> Result<()> {
        let place = Place::Line(number);
        let text = line.trim();
        if text.starts_with('#') || preamble::is_nothing(text) {
            return Ok(());
        }
        let header = self.wanted.time.header();
        if !self.splitter.split(text) {
            self.samples.stray(place, header, "a quotation mark is not closed".into());
            return Ok(());
        }
        let short = self.width.is_some_and(|width| self.splitter.len() < width);
        match self.numbers() {
            Ok(()) => {
                self.samples.accept(place, &self.numbers)?;
                if let Some(state) = state.and_then(|index| self.splitter.get(index)) {
                    self.structure.saw(self.samples.len().saturating_sub(1), state);
                }
            }
            Err(Unread::Blank) => {}
            Err(Unread::Bad(column, why)) if short => self.samples.stray(place, column, why),
            Err(Unread::Bad(column, why)) => self.samples.reject(place, column, why),
        }
        Ok(())
    }

    /// Fills `self.numbers` from the line that was split.
    fn numbers(&mut self) -> Result<(), Unread<'a>> {
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
            // A line that is shorter than a row has no blanks but ends too early.
            let text = match self.splitter.get(column.index) {
                Some("") if is_blank_permitted(&self.splitter, self.width) => {
                    self.held[k] += 1;
                    match self.last[k].filter(|_| is_held(column.quantity)) {
                        Some(value) => self.numbers[k + 1] = value,
                        None => blank = true,
                    }
                    continue;
                }
                text => text.unwrap_or_default(),
            };
            let value = field(text).map_err(|why| Unread::Bad(column.header.as_str(), why))? * column.factor;
            self.last[k] = Some(value);
            self.numbers[k + 1] = value;
        }
        if blank { Err(Unread::Blank) } else { Ok(()) }
    }

    /// The time of the line that was split, s, or the column to blame and why.
    fn time(&mut self) -> Result<f64, (&'a str, String)> {
        match &self.wanted.time {
            TimeSource::Rate(rate) => Ok((self.count.saturating_sub(1)) as f64 / rate),
            TimeSource::Stamps => {
                let stamp = self.splitter.stamp().unwrap_or_default();
                self.clock.read(stamp, 1.0, None).ok_or_else(|| {
                    (self.wanted.time.header(), "no stamp tells when this line was received".into())
                })
            }
            TimeSource::Column(column) => self.moment(column, column.factor),
            TimeSource::Columns(seconds, rest) => {
                let whole = self.moment(seconds, 1.0)?;
                let text = self.splitter.get(rest.index).unwrap_or_default();
                Ok(whole + field(text).map_err(|why| (rest.header.as_str(), why))? * rest.factor)
            }
            TimeSource::Intervals(column) => {
                let text = self.splitter.get(column.index).unwrap_or_default();
                let interval = field(text).and_then(|dt| {
                    if dt < 0.0 {
                        Err(format!("\"{text}\" is no time since the row before"))
                    } else {
                        Ok(dt * column.factor)
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
        let number = number(text);
        if number.is_some_and(|value| value.is_finite())
            && let Some(time) = self.clock.read(text, unit_s, number)
        {
            return Ok(time);
        }
        let time = if number.is_none() { self.clock.read(text, unit_s, None) } else { None };
        time.ok_or_else(|| (column.header.as_str(), field(text).err().unwrap_or_default()))
    }
}

/// Whether a quantity stays as it was while nothing new is logged of it; where the shaft is does not.
fn is_held(quantity: Quantity) -> bool {
    !matches!(quantity, Quantity::Angle | Quantity::Speed)
}

/// A row of full width has blanks; of values with names those that are absent are blank.
fn is_blank_permitted(splitter: &Splitter, width: Option<usize>) -> bool {
    width.is_some_and(|width| splitter.len() >= width)
}

/// The finite number in a field, or why there is none.
fn field(text: &str) -> Result<f64, String> {
    match number(text) {
        Some(value) if value.is_finite() => Ok(value),
        Some(_) => Err(format!("\"{text}\" is not a number a fit can use")),
        None if text.is_empty() => Err("the field is empty".into()),
        None => {
            let shown: String = text.chars().take(40).collect();
            Err(format!("\"{shown}\" is not a number"))
        }
    }
}

/// The number in a field; a comma within a field is a decimal one, since it separates nothing.
fn number(text: &str) -> Option<f64> {
    text.parse::<f64>().ok().or_else(|| {
        let decimal_comma = text.contains(',');
        decimal_comma.then(|| text.replacen(',', ".", 1).parse().ok()).flatten()
    })
}

/// The record of the columns.
///
/// # Errors
/// Wrong usage where a duty has no supply.
pub(super) fn record(path: &Path, name: String, read: Read, options: &ReadOptions) -> Result<Record> {
    let mut record = Record {
        name,
        path: path.to_owned(),
        hold: options.hold.or(read.meta.hold()).unwrap_or_default(),
        map: options.map.clone(),
        meta: read.meta,
        warnings: read.warnings,
        time_s: read.time_s,
        ..Record::default()
    };
    let (mut duty, mut target) = (None, None);
    for (quantity, values) in read.values {
        match quantity {
            Quantity::Time | Quantity::Interval => {}
            Quantity::Voltage => record.voltage_v = values,
            Quantity::Duty => duty = Some(values),
            Quantity::Target => target = Some(values),
            Quantity::Angle => record.angle_rad = Some(values),
            Quantity::Speed => record.speed_rad_s = Some(values),
            Quantity::Current => record.current_a = Some(values),
            Quantity::Supply => record.supply_v = Some(values),
        }
    }
    if let Some(duty) = duty {
        record.voltage_v = match (&record.supply_v, options.supply_volts) {
            (Some(supply), _) => duty.iter().zip(supply).map(|(duty, supply)| duty * supply).collect(),
            (None, Some(volts)) => {
                let how = format!("it is the duty times {volts} V, whatever the supply did");
                record.meta.insert("voltage", &how).expect("this key takes any text");
                duty.iter().map(|duty| duty * volts).collect()
            }
            (None, None) => {
                return Err(crate::error::Error::usage(
                    "duty alone does not give a voltage",
                    "add --supply-volts 7.9, or map the supply: --map ...,supply=COLUMN:V",
                ));
            }
        };
    }
    if let Some(target_rad) = target.filter(|_| record.voltage_v.is_empty()) {
        let volts = options.supply_volts;
        if let (None, Some(volts)) = (&record.supply_v, volts) {
            record.supply_v = Some(vec![volts; target_rad.len()]);
        }
        record.voltage_v = vec![0.0; target_rad.len()];
        let (gain, damping) = (options.servo_gain, options.servo_damping);
        record.servo = Some(Servo { target_rad, gain, damping });
    }
    Ok(record)
}

/// Rows from which a mapping is guessed.
const GUESSED_FROM: usize = 2000;

/// The first rows of a table, for a guess at its columns.
#[derive(Debug)]
pub(super) struct Sample {
    pub names: Vec<String>,
    /// The names with the units of the row below them.
    pub with_units: Vec<String>,
    /// The numbers, times in seconds; NaN where a field is none.
    pub rows: Vec<Vec<f64>>,
    /// The fields as they stand there.
    pub texts: Vec<Vec<String>>,
    pub stamped: bool,
}

/// Reads on behind the head of a table; of the texts only the first `shown` rows are kept.
///
/// # Errors
/// What reading says.
pub(super) fn sample(path: &Path, mut input: impl BufRead, head: &Preamble, shown: usize) -> Result<Sample> {
    let mut splitter = head.splitter();
    let names = head.headers.clone().unwrap_or_default();
    let mut sample = Sample {
        with_units: names.clone(),
        names,
        rows: Vec::new(),
        texts: Vec::new(),
        stamped: head.stamped,
    };
    let mut clocks: Vec<Clock> = Vec::new();
    let mut clocked: Vec<bool> = Vec::new();
    let mut take = |line: &str, sample: &mut Sample| {
        let text = line.trim();
        if text.is_empty() || text.starts_with('#') || !splitter.split(text) {
            return;
        }
        clocks.resize(clocks.len().max(splitter.len()), Clock::default());
        clocked.resize(clocked.len().max(splitter.len()), false);
        let value = |(k, text): (usize, &str)| {
            number(text)
                .or_else(|| clocks[k].read(text, 1.0, None).inspect(|_| clocked[k] = true))
                .unwrap_or(f64::NAN)
        };
        sample.rows.push(splitter.iter().enumerate().map(value).collect());
        if sample.texts.len() < shown {
            sample.texts.push(splitter.iter().map(str::to_owned).collect());
        }
    };
    for (_, line) in &head.rows {
        take(line, &mut sample);
    }
    let mut line = String::new();
    while sample.rows.len() < GUESSED_FROM
        && input.read_line(&mut line).map_err(|error| cannot_read(path, &error))? > 0
    {
        take(&line, &mut sample);
        line.clear();
    }
    for (k, name) in sample.with_units.iter_mut().enumerate() {
        let unit = head.units.get(k).map(String::as_str).filter(|unit| !unit.is_empty());
        // A clock time tells its unit itself.
        let unit = if clocked.get(k) == Some(&true) { Some("s") } else { unit };
        if let Some(unit) = unit {
            *name = format!("{name} [{unit}]");
        }
    }
    Ok(sample)
}

fn proposal(path: &Path, input: impl BufRead, head: &Preamble) -> Result<Option<guess::Proposal>> {
    Ok(guess::propose_for(&sample(path, input, head, 0)?))
}
