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

/// Cells for which room is made at most: all rows of 64 columns, 350 MB while they are read.
const MOST_ROOM: usize = 1 << 22;

/// The first bytes of a sheet's record.
const BOUND_SHEET: u16 = 0x0085;
const DIMENSIONS: u16 = 0x0200;
/// Several numbers side by side.
const NUMBERS: u16 = 0x00BD;
/// Formula, text of a table, formatted text, number, text, truth or error, short number.
const CELLS: [u16; 7] = [0x0006, 0x00FD, 0x00D6, 0x0203, 0x0204, 0x0205, 0x027E];

/// Refuses the workbook `stream` where a cell stands beyond the sheet, or cells stand so far apart that all between them are too many.
///
/// # Errors
/// A fault that names the place in the stream.
pub fn check(stream: &[u8]) -> Result<(), Fault> {
    let mut seen = HashSet::new();
    let mut room = 0;
    for (_, kind, record) in records(stream, 0) {
        if let (BOUND_SHEET, Some(place)) = (kind, u32_at(record, 0)) {
            room += check_sheet(stream, place as usize, &mut seen)?;
        }
    }
    if room > MOST_ROOM {
        return Err(Fault::new(
            "its cells stand further apart than those of a log",
            "save the columns that show the motor alone as CSV",
        ));
    }
    Ok(())
}

/// The same for the sheet that begins at `place`, and whatever stands behind it that was not `seen`; returns how many cells it makes room for.
fn check_sheet(stream: &[u8], place: usize, seen: &mut HashSet<usize>) -> Result<usize, Fault> {
    let mut taken: Option<[u32; 4]> = None;
    for (at, kind, record) in records(stream, place) {
        if !seen.insert(at) {
            break;
        }
        let Some([top, left, bottom, right]) = region(kind, record) else { continue };
        if top > bottom || left > right || bottom >= ROWS || right >= COLUMNS {
            return Err(Fault::broken(
                at as u64,
                "where a cell stands beyond the 65,536 rows and 256 columns of a sheet",
            ));
        }
        let [t, l, b, r] = taken.unwrap_or([top, left, bottom, right]);
        taken = Some([top.min(t), left.min(l), bottom.max(b), right.max(r)]);
    }
    Ok(taken.map_or(0, |[top, left, bottom, right]| ((bottom - top + 1) * (right - left + 1)) as usize))
}

/// First row and column and last row and column for which a record makes room.
fn region(kind: u16, record: &[u8]) -> Option<[u32; 4]> {
    let short = |at: usize| u16_at(record, at).map(u32::from);
    match kind {
        DIMENSIONS => {
            let [top, end, left, right] = match record.len() {
                10 => [short(0)?, short(2)?, short(4)?, short(6)?],
                _ => [u32_at(record, 0)?, u32_at(record, 4)?, short(8)?, short(10)?],
            };
            // An empty sheet ends before it begins. Columns that do are counted from the first.
            let left = if left >= COLUMNS || left > right { 0 } else { left };
            (end > 0 && right > 0).then(|| [top, left, end - 1, right - 1])
        }
        NUMBERS => Some([short(0)?, short(2)?, short(0)?, short(record.len().checked_sub(2)?)?]),
        _ if CELLS.contains(&kind) => Some([short(0)?, short(2)?, short(0)?, short(2)?]),
        _ => None,
    }
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
        let mut damaged = book.clone();
        damaged[at + 4 + 7] = 0x7F;
        assert!(check(&damaged).is_err());
        // A first row behind the last one.
        book[at + 4 + 3] = 0x50;
        assert!(check(&book).is_err());
    }

    #[test]
    fn two_cells_at_opposite_ends_of_a_sheet_are_refused() {
        let mut book = Chains::of(SHEET).unwrap().stream(&["Workbook", "Book"]).unwrap();
        let single = |kind: u16| kind != NUMBERS && CELLS.contains(&kind);
        let (at, _, _) = records(&book, 0).filter(|(_, kind, _)| single(*kind)).last().unwrap();
        book[at + 4..at + 8].copy_from_slice(&[0xFF, 0xFF, 0xFF, 0]);
        let fault = check(&book).unwrap_err();
        assert!(fault.why.contains("further apart"), "{fault:?}");
    }
}
