//! Where the cells of an Excel 97 workbook say that they stand: a reader makes room for all cells between the farthest two, and one damaged
//! number asks for more memory than there is.
//!
//! Records of \[MS-XLS\] (Excel Binary File Format, Microsoft): a type and a length of two bytes each, and so many bytes.

use std::collections::HashSet;

use super::Fault;
use super::bytes::{u16_at, u32_at};

/// Columns and rows of a sheet.
const COLUMNS: u32 = 256;
const ROWS: u32 = 65_536;

/// The first bytes of a sheet's record.
const BOUND_SHEET: u16 = 0x0085;
const DIMENSIONS: u16 = 0x0200;
/// Several numbers side by side.
const NUMBERS: u16 = 0x00BD;
/// Formula, text of a table, formatted text, number, text, truth or error, short number.
const CELLS: [u16; 7] = [0x0006, 0x00FD, 0x00D6, 0x0203, 0x0204, 0x0205, 0x027E];

/// Refuses the workbook `stream` where a cell stands beyond the sheet.
///
/// # Errors
/// A fault that names the place in the stream.
pub fn check(stream: &[u8]) -> Result<(), Fault> {
    let mut seen = HashSet::new();
    for (_, kind, record) in records(stream, 0) {
        if let (BOUND_SHEET, Some(place)) = (kind, u32_at(record, 0)) {
            check_sheet(stream, place as usize, &mut seen)?;
        }
    }
    Ok(())
}

/// The same for the sheet that begins at `place`, and whatever stands behind it that was not `seen`.
fn check_sheet(stream: &[u8], place: usize, seen: &mut HashSet<usize>) -> Result<(), Fault> {
    for (at, kind, record) in records(stream, place) {
        if !seen.insert(at) {
            break;
        }
        let beyond = match kind {
            DIMENSIONS => {
                let [rows, columns] = match record.len() {
                    10 => [u16_at(record, 2).map(u32::from), u16_at(record, 6).map(u32::from)],
                    _ => [u32_at(record, 4), u16_at(record, 10).map(u32::from)],
                };
                let cells = u64::from(rows.unwrap_or(0)) * u64::from(columns.unwrap_or(0));
                cells > u64::from(ROWS * COLUMNS)
            }
            NUMBERS => {
                let last = u16_at(record, record.len().saturating_sub(2));
                [u16_at(record, 2), last].iter().flatten().any(|column| u32::from(*column) >= COLUMNS)
            }
            _ if CELLS.contains(&kind) => {
                u16_at(record, 2).is_some_and(|column| u32::from(column) >= COLUMNS)
            }
            _ => false,
        };
        if beyond {
            return Err(Fault::broken(at as u64, "where a cell stands beyond the 256 columns of a sheet"));
        }
    }
    Ok(())
}

/// Place, type and bytes of the records of `stream` from `place` on.
fn records(stream: &[u8], place: usize) -> impl Iterator<Item = (usize, u16, &[u8])> {
    let at = move |at: usize| {
        let (kind, length) = (u16_at(stream, at)?, u16_at(stream, at + 2)?);
        Some((at, kind, stream.get(at + 4..at + 4 + usize::from(length))?))
    };
    std::iter::successors(at(place), move |(before, _, record)| at(before + 4 + record.len()))
}

#[cfg(test)]
mod tests {
    use super::super::chains::Chains;
    use super::*;

    const SHEET: &[u8] = include_bytes!("../../../tests/formats/sheet.xls");

    #[test]
    fn a_cell_beyond_the_sheet_is_refused_before_anyone_makes_room_for_it() {
        let book = Chains::of(SHEET).unwrap().stream(&["Workbook", "Book"]).unwrap();
        assert_eq!(check(&book), Ok(()));
        let cells: Vec<usize> = records(&book, 0)
            .filter(|(_, kind, _)| CELLS.contains(kind) || *kind == NUMBERS)
            .map(|(at, _, _)| at)
            .collect();
        // Records of sheets stand behind those of the workbook, whose end is a record too.
        assert!(!cells.is_empty());
        for at in cells {
            let mut damaged = book.clone();
            damaged[at + 7] = 0x40;
            let fault = check(&damaged).unwrap_err();
            assert!(fault.why.contains("256 columns"), "{fault:?}");
        }
    }

    #[test]
    fn more_rows_than_a_sheet_has_are_refused() {
        let mut book = Chains::of(SHEET).unwrap().stream(&["Workbook", "Book"]).unwrap();
        let (at, _, record) = records(&book, 0).find(|(_, kind, _)| *kind == DIMENSIONS).unwrap();
        assert_eq!(record.len(), 14);
        book[at + 4 + 7] = 0x7F;
        assert!(check(&book).is_err());
    }
}
