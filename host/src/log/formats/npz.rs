//! NumPy's `.npz`: a zip archive of arrays, each of which is a column by its name.

use std::io::{Cursor, Read};

use zip::ZipArchive;

use super::table::Table;
use super::{Content, Fault, LARGEST, npy};

/// Reads all arrays of an archive.
///
/// # Errors
/// A fault where the archive is damaged, or unpacked larger than any log.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let damaged = |why: &dyn std::fmt::Display| {
        Fault::new(
            format!("the archive is damaged: {why}"),
            "copy the file again, or save it anew with numpy.savez",
        )
    };
    let mut archive = ZipArchive::new(Cursor::new(all)).map_err(|why| damaged(&why))?;
    let (mut columns, mut left_out) = (Vec::new(), Vec::new());
    let mut room = LARGEST;
    for index in 0..archive.len() {
        let file = archive.by_index(index).map_err(|why| damaged(&why))?;
        let name =
            file.name().map_err(|why| damaged(&why))?.trim_end_matches(".npy").replace([',', '"', '='], "_");
        let mut array = Vec::new();
        file.take(room + 1).read_to_end(&mut array).map_err(|why| damaged(&why))?;
        room = room.checked_sub(array.len() as u64).ok_or_else(|| {
            Fault::new("unpacked it is larger than 1 GiB", "save the columns that show the motor alone")
        })?;
        match npy::columns(&array, &name) {
            Ok(found) => columns.extend(found),
            // Objects and texts beside the numbers are no fault; a broken array is.
            Err(fault) if fault.why.contains("damaged") => {
                return Err(damaged(&format!("{name}: {}", fault.why)));
            }
            Err(fault) => left_out.push(format!("{name} ({})", fault.why)),
        }
    }
    Ok(Content::Table(Table::of(columns, left_out)?))
}
