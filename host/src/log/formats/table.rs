//! Columns on one clock, and the way from there to records: as the text that they would be in a CSV, made row by row.

use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::io::{self, BufRead, BufReader, Read};
use std::path::Path;

use super::Fault;
use super::interval::{self, Clock};
use crate::error::{Error, Result};
use crate::log::table::Part;
use crate::log::units::Quantity;
use crate::log::{ReadOptions, Record, Warning, table};

/// More columns than this are never looked through.
const MOST_COLUMNS: usize = 1000;

/// What a column holds.
#[derive(Debug, Clone, PartialEq)]
pub enum Values {
    /// Numbers; NaN where there is none.
    Numbers(Vec<f64>),
    /// Texts, as those of a state.
    Texts(Vec<String>),
}

impl Values {
    /// Number of rows.
    pub fn len(&self) -> usize {
        match self {
            Values::Numbers(numbers) => numbers.len(),
            Values::Texts(texts) => texts.len(),
        }
    }
}

/// A named column.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name; a unit may follow in brackets.
    pub name: String,
    /// Its values.
    pub values: Values,
}

/// The columns of a matrix whose numbers stand column after column; time runs along the longer side.
#[allow(dead_code)] // not every build has every reader
pub fn matrix(name: &str, rows: usize, width: usize, numbers: &[f64]) -> Vec<Column> {
    let turned = width > rows;
    let (long, short) = if turned { (width, rows) } else { (rows, width) };
    let column = |column: usize| {
        let cell = |row: usize| numbers[if turned { row * rows + column } else { column * rows + row }];
        let name = if short == 1 { name.to_owned() } else { format!("{name}({})", column + 1) };
        Column { name, values: Values::Numbers((0..long).map(cell).collect()) }
    };
    (0..short).map(column).collect()
}

/// Columns of one length.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Table {
    columns: Vec<Column>,
    /// What of the file is no column, for messages.
    left_out: Vec<String>,
    /// What made the last column, which tells the time where the file has none that does.
    clock: Option<Clock>,
    /// What else a message about the columns should say.
    hint: String,
    /// What drives the motor has rows of its own, without a motion.
    own_stamps: bool,
    /// Each column was a line of the file.
    is_turned: bool,
}

impl Table {
    /// The columns of a file. Where they have different lengths, those of the length that most of them have are the log (of equals,
    /// the longest) and the rest are parameters, one of which may tell the time of the rows.
    ///
    /// # Errors
    /// A fault where no column has two rows.
    pub fn of(columns: Vec<Column>, mut left_out: Vec<String>) -> Result<Table, Fault> {
        let mut lengths = BTreeMap::new();
        for column in columns.iter().filter(|column| column.values.len() > 1) {
            *lengths.entry(column.values.len()).or_insert(0) += 1;
        }
        let Some((&rows, _)) = lengths.iter().max_by_key(|(rows, count)| (**count, **rows)) else {
            let inside = if left_out.is_empty() {
                "it holds no column of numbers".to_owned()
            } else {
                format!("it holds no column of numbers, but {}", listed(&left_out))
            };
            return Err(Fault::new(
                inside,
                "save time, voltage and angle or speed as vectors of equal length, or export a CSV",
            ));
        };
        let (mut kept, others): (Vec<_>, Vec<_>) = columns.into_iter().partition(|c| c.values.len() == rows);
        let clock = interval::clock(&kept, &others);
        left_out.extend(others.into_iter().map(|column| match column.values.len() {
            1 => format!("{} (one value)", column.name),
            several => format!("{} ({several} values)", column.name),
        }));
        left_out.extend(kept.drain(kept.len().min(MOST_COLUMNS)..).map(|column| column.name));
        kept.extend(clock.as_ref().map(|clock| clock.times(rows)));
        Ok(Table { columns: kept, left_out, clock, ..Table::default() })
    }

    /// Adds a sentence to what a message about the columns advises.
    #[must_use]
    pub fn hinting(mut self, hint: String) -> Table {
        self.hint = hint;
        self
    }

    /// Says whether what drives the motor has rows of its own, which no file leaves blank in its motion.
    #[must_use]
    pub fn with_own_stamps(mut self, own_stamps: bool) -> Table {
        self.own_stamps = own_stamps;
        self
    }

    /// Says that each column was a line of the file.
    #[must_use]
    pub fn turned_round(self) -> Table {
        let hint = format!("{}, and its lines are the columns here, from the first on", self.turned());
        Table { is_turned: true, ..self.hinting(hint) }
    }

    fn turned(&self) -> String {
        format!("each line of the file is a signal of {} values", self.rows())
    }

    fn rows(&self) -> usize {
        self.columns.first().map_or(0, |column| column.values.len())
    }

    /// The table as the CSV that it would be.
    pub fn text(&self) -> impl BufRead {
        BufReader::with_capacity(1 << 16, Text { table: self, row: None, line: Vec::new(), at: 0 })
    }

    /// The records in it.
    ///
    /// # Errors
    /// Those of a CSV with these columns; places are rows, from 1.
    pub fn records(mut self, path: &Path, options: &ReadOptions) -> Result<Vec<Record>> {
        let part = if self.own_stamps { Part::OwnStamps } else { Part::Whole };
        let mut options = options.clone();
        let mut clock = self.clock.take().filter(|_| options.map.as_ref().is_none_or(interval::is_read_by));
        // A rate that a person states goes before a number of the file.
        if options.rate_hz.is_some() && clock.take().is_some() {
            self.columns.pop();
            options.map = options.map.map(|map| map.without(Quantity::Time));
        }
        let read = table::read(path, self.text(), &options, part);
        let mut records = read.map_err(|error| self.in_rows(error))?;
        records.iter_mut().flat_map(|record| &mut record.warnings).for_each(place_in_rows);
        let turned = self.is_turned.then(|| Warning {
            place: path.display().to_string(),
            what: format!("{}, so it was turned round", self.turned()),
            fix: "nothing, if that is right; better write a row for each instant".into(),
        });
        if let Some(record) = records.first_mut() {
            record.warnings.extend(clock.map(|clock| clock.said(path)).into_iter().chain(turned));
        }
        Ok(records)
    }

    /// The fault with the row in place of the line, and with what else the file holds.
    fn in_rows(&self, error: Error) -> Error {
        let Error::BadInput(mut fault) = error else { return error };
        match fault.line.take() {
            Some(line) if line > 1 => fault.why = format!("row {}: {}", line - 1, fault.why),
            Some(_) if !self.left_out.is_empty() => {
                let _ = write!(fault.why, "; no columns are {}", listed(&self.left_out));
            }
            _ => {}
        }
        if !self.hint.is_empty() {
            fault.remedy = format!("{}; {}", fault.remedy, self.hint);
        }
        Error::BadInput(fault)
    }
}

/// The first few of a list.
fn listed(all: &[String]) -> String {
    const SHOWN: usize = 12;
    let mut text = all.iter().take(SHOWN).cloned().collect::<Vec<_>>().join(", ");
    if all.len() > SHOWN {
        let _ = write!(text, " and {} more", all.len() - SHOWN);
    }
    text
}

/// `x.mat, line 12` becomes `x.mat, row 11`.
fn place_in_rows(warning: &mut Warning) {
    let Some((file, rest)) = warning.place.split_once(", line ") else { return };
    let end = rest.find(|c: char| !c.is_ascii_digit()).unwrap_or(rest.len());
    if let Ok(line) = rest[..end].parse::<u64>() {
        warning.place = format!("{file}, row {}{}", line.saturating_sub(1), &rest[end..]);
    }
}

/// A table as its CSV, one line at a time.
struct Text<'t> {
    table: &'t Table,
    /// The row of `line`; the header before the first.
    row: Option<usize>,
    line: Vec<u8>,
    at: usize,
}

impl Text<'_> {
    fn next_line(&mut self) {
        let row = if self.line.is_empty() { None } else { Some(self.row.map_or(0, |row| row + 1)) };
        self.line.clear();
        self.at = 0;
        if row.is_some_and(|row| row >= self.table.rows()) {
            return;
        }
        self.row = row;
        let mut text = String::new();
        for (number, column) in self.table.columns.iter().enumerate() {
            if number > 0 {
                text.push(',');
            }
            match (&column.values, row) {
                (_, None) => quote(&mut text, &column.name),
                // What is not there is blank.
                (Values::Numbers(numbers), Some(row)) if numbers[row].is_nan() => {}
                (Values::Numbers(numbers), Some(row)) => {
                    let _ = write!(text, "{:?}", numbers[row]);
                }
                (Values::Texts(texts), Some(row)) => quote(&mut text, &texts[row]),
            }
        }
        text.push('\n');
        self.line = text.into_bytes();
    }
}

/// A field in quotes, on one line whatever is in it.
fn quote(text: &mut String, field: &str) {
    text.push('"');
    for c in field.chars() {
        match c {
            '"' => text.push_str("\"\""),
            c if c.is_control() => text.push(' '),
            c => text.push(c),
        }
    }
    text.push('"');
}

impl Read for Text<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if self.at == self.line.len() {
            if self.row.is_some_and(|row| row + 1 >= self.table.rows()) {
                return Ok(0);
            }
            self.next_line();
        }
        let count = buffer.len().min(self.line.len() - self.at);
        buffer[..count].copy_from_slice(&self.line[self.at..self.at + count]);
        self.at += count;
        Ok(count)
    }
}
