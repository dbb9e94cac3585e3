//! Spreadsheets of other programs and times: Excel 97 (`.xls`), OpenDocument (`.ods`), read as those of today are.

use std::io::Cursor;

use calamine::{Data, Ods, Range, Reader, Xls};

use super::chains::Chains;
use super::xlsx::{Cell, Grid, first_table};
use super::{Content, Fault, biff};

/// Reads the first sheet of an Excel 97 workbook that is a table.
///
/// # Errors
/// A fault where the file is damaged or no workbook, or no sheet is a table.
pub fn xls(all: &[u8]) -> Result<Content, Fault> {
    if let Some(book) = Chains::of(all)?.stream(&["Workbook", "Book"]) {
        biff::check(&book)?;
    }
    let mut book = Xls::new(Cursor::new(all)).map_err(|why| damaged(&why))?;
    let sheets = book.sheet_names();
    first_table(&sheets, |sheet| rows(sheet, &book.worksheet_range(sheet).map_err(|why| damaged(&why))?))
}

/// Reads the first sheet of an OpenDocument spreadsheet that is a table.
///
/// # Errors
/// As [`xls`].
pub fn ods(all: &[u8]) -> Result<Content, Fault> {
    let mut book = Ods::new(Cursor::new(all)).map_err(|why| damaged(&why))?;
    let sheets = book.sheet_names();
    first_table(&sheets, |sheet| rows(sheet, &book.worksheet_range(sheet).map_err(|why| damaged(&why))?))
}

fn damaged(why: &dyn std::fmt::Display) -> Fault {
    Fault::new(
        format!("the spreadsheet is damaged or another document: {why}"),
        "save it anew as .xlsx or as CSV (UTF-8)",
    )
}

fn rows(sheet: &str, range: &Range<Data>) -> Result<Vec<Vec<Cell>>, Fault> {
    let mut grid = Grid::default();
    for (row, column, value) in range.used_cells() {
        let value = match value {
            Data::Int(number) => Cell::Number(*number as f64),
            Data::Float(number) => Cell::Number(*number),
            Data::Bool(truth) => Cell::Number(f64::from(u8::from(*truth))),
            Data::DateTime(date) => Cell::Date(date.as_f64()),
            Data::String(text) | Data::DateTimeIso(text) | Data::DurationIso(text) => {
                Cell::Text(text.clone())
            }
            _ => continue,
        };
        grid.put(sheet, row, column, value)?;
    }
    Ok(grid.into_rows())
}
