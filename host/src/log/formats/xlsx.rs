//! Spreadsheets (`.xlsx`): the first sheet that holds a header and numbers below it. Dates are seconds since the first of them.

use std::io::Cursor;

use calamine::{DataRef, Reader, Xlsx};
use zip::ZipArchive;

use super::table::{Column, Table, Values};
use super::{Content, Fault, LARGEST};

/// A sheet has no more rows than this, and a log no more columns.
const MOST_ROWS: usize = 1 << 20;
const MOST_COLUMNS: usize = 1000;
/// More cells than this are no sheet that a person opens.
const MOST_CELLS: usize = 1 << 25;
/// Rows above the header in which a title or remarks may stand.
const MOST_TITLES: usize = 50;
const DAY_S: f64 = 86_400.0;

/// A cell as a log needs it.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Cell {
    Nothing,
    Number(f64),
    /// Days.
    Date(f64),
    Text(String),
}

/// Reads the first sheet that is a table.
///
/// # Errors
/// A fault where the file is damaged, unpacked larger than any log, or no sheet is a table.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let damaged = |why: &dyn std::fmt::Display| {
        Fault::new(format!("the spreadsheet is damaged: {why}"), "save it anew as .xlsx or as CSV (UTF-8)")
    };
    // The crate below unpacks before it looks: what the archive says of its sizes is believed up to a limit.
    let mut archive = ZipArchive::new(Cursor::new(all)).map_err(|why| damaged(&why))?;
    let mut unpacked = 0_u64;
    for index in 0..archive.len() {
        unpacked = unpacked.saturating_add(archive.by_index_raw(index).map_err(|why| damaged(&why))?.size());
    }
    if unpacked > LARGEST {
        return Err(Fault::new("unpacked it is larger than 1 GiB", "save the sheet of the log alone as CSV"));
    }
    let mut book = Xlsx::new(Cursor::new(all)).map_err(|why| damaged(&why))?;
    let sheets = book.sheet_names();
    first_table(&sheets, |sheet| rows(&mut book, sheet))
}

/// The first sheet that is a table, where `rows` gives the rows of a sheet.
///
/// # Errors
/// What `rows` says; a fault where no sheet is a table.
pub(super) fn first_table(
    sheets: &[String],
    mut rows: impl FnMut(&str) -> Result<Vec<Vec<Cell>>, Fault>,
) -> Result<Content, Fault> {
    let mut without = Vec::new();
    for (number, sheet) in sheets.iter().enumerate() {
        let Some(columns) = columns(&rows(sheet)?) else {
            without.push(sheet.clone());
            continue;
        };
        let mut left_out: Vec<String> = without.iter().map(|name| format!("the sheet {name}")).collect();
        left_out.extend(sheets[number + 1..].iter().map(|name| format!("the sheet {name}")));
        return Ok(Content::Table(Table::of(columns, left_out)?));
    }
    let why = format!("no sheet ({}) has names of columns with numbers below them", without.join(", "));
    Err(Fault::new(why, "put the names of the columns above the numbers, a name for every column"))
}

/// The cells of a sheet, as far as they are near to each other.
#[derive(Default)]
pub(super) struct Grid {
    rows: Vec<Vec<Cell>>,
    count: usize,
}

impl Grid {
    /// Puts a cell in its place; what is far from the others is not taken.
    ///
    /// # Errors
    /// A fault where the sheet has more cells than a log.
    pub fn put(&mut self, sheet: &str, row: usize, column: usize, value: Cell) -> Result<(), Fault> {
        if row >= MOST_ROWS || column >= MOST_COLUMNS {
            return Ok(());
        }
        self.count += 1
            + row.saturating_sub(self.rows.len())
            + column.saturating_sub(self.rows.get(row).map_or(0, Vec::len));
        if self.count > MOST_CELLS {
            return Err(Fault::new(
                format!("the sheet {sheet} has more cells than a log"),
                "save the columns that show the motor alone as CSV",
            ));
        }
        if self.rows.len() <= row {
            self.rows.resize(row + 1, Vec::new());
        }
        if self.rows[row].len() <= column {
            self.rows[row].resize(column + 1, Cell::Nothing);
        }
        self.rows[row][column] = value;
        Ok(())
    }

    /// The rows.
    pub fn into_rows(self) -> Vec<Vec<Cell>> {
        self.rows
    }
}

/// The rows of a sheet.
fn rows(book: &mut Xlsx<Cursor<&[u8]>>, sheet: &str) -> Result<Vec<Vec<Cell>>, Fault> {
    let damaged = |why: &dyn std::fmt::Display| {
        Fault::new(format!("the sheet {sheet} is damaged: {why}"), "save it anew as .xlsx or as CSV (UTF-8)")
    };
    let mut cells = match book.worksheet_cells_reader(sheet) {
        Ok(cells) => cells,
        // A sheet of nothing but a chart.
        Err(_) => return Ok(Vec::new()),
    };
    let mut grid = Grid::default();
    while let Some(cell) = cells.next_cell().map_err(|why| damaged(&why))? {
        let (row, column) = cell.get_position();
        let value = match cell.get_value() {
            DataRef::Int(number) => Cell::Number(*number as f64),
            DataRef::Float(number) => Cell::Number(*number),
            DataRef::Bool(truth) => Cell::Number(f64::from(u8::from(*truth))),
            DataRef::DateTime(date) => Cell::Date(date.as_f64()),
            DataRef::String(text) => Cell::Text(text.clone()),
            DataRef::SharedString(text) => Cell::Text((*text).to_owned()),
            DataRef::DateTimeIso(text) | DataRef::DurationIso(text) => Cell::Text(text.clone()),
            DataRef::Error(_) | DataRef::Empty => continue,
        };
        grid.put(sheet, row as usize, column as usize, value)?;
    }
    Ok(grid.into_rows())
}

/// A number that was typed as a text, with a comma perhaps.
fn typed(text: &str) -> Option<f64> {
    text.trim().replace(',', ".").parse().ok()
}

/// The columns below the header: the first row of two texts or more with numbers in the row below, or in the one below that, where units
/// stand in between.
fn columns(rows: &[Vec<Cell>]) -> Option<Vec<Column>> {
    let is_text = |cell: &&Cell| matches!(cell, Cell::Text(text) if typed(text).is_none());
    let is_number = |cell: &&Cell| match cell {
        Cell::Number(_) | Cell::Date(_) => true,
        Cell::Text(text) => typed(text).is_some(),
        Cell::Nothing => false,
    };
    let numbers = |row: &Vec<Cell>| row.iter().filter(is_number).count();
    let header = (0..rows.len().min(MOST_TITLES)).find(|&k| {
        let texts = rows[k].iter().filter(is_text).count();
        texts >= 2 && rows[k + 1..].iter().take(2).any(|below| 2 * numbers(below) >= texts)
    })?;
    let below = &rows[header + 1..];
    let units = below.first().filter(|row| numbers(row) == 0);
    let body = if units.is_some() { &below[1..] } else { below };
    let cell = |row: &'_ Vec<Cell>, column: usize| row.get(column).cloned().unwrap_or(Cell::Nothing);
    let column = |(index, name): (usize, &Cell)| -> Option<Column> {
        let name = match name {
            Cell::Text(name) if !name.trim().is_empty() => name.trim().to_owned(),
            _ => return None,
        };
        let values: Vec<Cell> = body.iter().map(|row| cell(row, index)).collect();
        let dated = values.iter().filter(|v| matches!(v, Cell::Date(_))).count();
        let texts = values.iter().filter(is_text).count();
        if 2 * texts > values.len() {
            let text = |value: Cell| match value {
                Cell::Text(text) => text,
                Cell::Number(number) | Cell::Date(number) => number.to_string(),
                Cell::Nothing => String::new(),
            };
            return Some(Column { name, values: Values::Texts(values.into_iter().map(text).collect()) });
        }
        let first = values.iter().find_map(|v| if let Cell::Date(days) = v { Some(*days) } else { None });
        let number = |value: &Cell| match value {
            Cell::Number(number) => *number,
            Cell::Date(days) => (days - first.unwrap_or(0.0)) * DAY_S,
            Cell::Text(text) => typed(text).unwrap_or(f64::NAN),
            Cell::Nothing => f64::NAN,
        };
        let unit = units.map(|units| cell(units, index));
        let name = match unit {
            _ if 2 * dated > values.len() => format!("{name} [s]"),
            Some(Cell::Text(unit)) => format!("{name} [{}]", unit.trim().trim_matches(['[', ']', '(', ')'])),
            _ => name,
        };
        Some(Column { name, values: Values::Numbers(values.iter().map(number).collect()) })
    };
    Some(rows[header].iter().enumerate().filter_map(column).collect())
}
