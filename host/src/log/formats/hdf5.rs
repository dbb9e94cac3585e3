//! HDF5: MATLAB's `.mat` of version 7.3, and files of h5py, pandas or LabVIEW. Datasets are columns by their path, `group.name`.

use hdf5_pure::{DType, Dataset, File, Group};

use super::table::{Column, Table, Values, matrix};
use super::{Content, Fault, LARGEST};

/// Groups within groups are followed so far.
const DEEPEST: usize = 8;
/// More datasets than these are not looked at.
const MOST_SETS: usize = 2000;

/// What was found in a file.
#[derive(Default)]
struct Found {
    columns: Vec<Column>,
    left_out: Vec<String>,
    objects: Vec<String>,
    /// Bytes of numbers so far.
    taken: u64,
}

/// Reads all numbers of a file.
///
/// # Errors
/// A fault where the file is damaged or holds nothing but objects of MATLAB's classes.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let file = File::from_bytes(all.to_vec()).map_err(|why| damaged(&why))?;
    let mut found = Found::default();
    group(&file.root(), "", 0, &mut found)?;
    if found.columns.is_empty() && !found.objects.is_empty() {
        return Err(super::mat::objects(&found.objects));
    }
    found.left_out.extend(found.objects);
    Ok(Content::Table(Table::of(found.columns, found.left_out)?))
}

fn damaged(why: &dyn std::fmt::Display) -> Fault {
    Fault::new(
        format!("the file is damaged or cut off: {why}"),
        "copy the file again, or save it anew (in MATLAB with save('NEW.mat', '-v7'))",
    )
}

fn group(group: &Group, within: &str, depth: usize, found: &mut Found) -> Result<(), Fault> {
    let join = |name: &str| if within.is_empty() { name.to_owned() } else { format!("{within}.{name}") };
    for name in group.datasets().map_err(|why| damaged(&why))? {
        if found.columns.len() + found.left_out.len() > MOST_SETS {
            return Ok(());
        }
        let path = join(&name);
        let set = group.dataset(&name).map_err(|why| damaged(&format!("{path}: {why}")))?;
        dataset(&set, path, found)?;
    }
    if depth == DEEPEST {
        return Ok(());
    }
    for name in group.groups().map_err(|why| damaged(&why))? {
        // MATLAB keeps the contents of cells and objects there.
        if !name.starts_with('#') {
            let inner = group.group(&name).map_err(|why| damaged(&format!("{}: {why}", join(&name))))?;
            self::group(&inner, &join(&name), depth + 1, found)?;
        }
    }
    Ok(())
}

fn dataset(set: &Dataset, path: String, found: &mut Found) -> Result<(), Fault> {
    use hdf5_pure::AttrValue;
    let attributes = set.attrs().unwrap_or_default();
    let class =
        attributes.iter().find(|(name, _)| *name == "MATLAB_class").and_then(|(_, value)| match value {
            AttrValue::AsciiString(text) | AttrValue::String(text) => {
                Some(text.trim_matches('\0').to_owned())
            }
            _ => None,
        });
    let class = class.as_deref().unwrap_or_default();
    if attributes.contains_key("MATLAB_object_decode")
        || ["table", "timetable", "timeseries"].contains(&class)
    {
        found.objects.push(path);
        return Ok(());
    }
    let kind = set.dtype().map_err(|why| damaged(&format!("{path}: {why}")))?;
    if let DType::Compound(fields) = &kind {
        return compound(set, &path, fields, found);
    }
    if class == "char" || class == "cell" || !is_number(&kind) {
        found.left_out.push(format!("{path} (no numbers)"));
        return Ok(());
    }
    let shape = room(set, 8, &path, found)?;
    let numbers = set.read_f64().map_err(|why| damaged(&format!("{path}: {why}")))?;
    match shape[..] {
        // HDF5 counts rows first, so that the file's columns are the rows of what is read column by column.
        [width, rows] if width as usize * rows as usize == numbers.len() => {
            found.columns.extend(matrix(&path, rows as usize, width as usize, &numbers));
        }
        _ => found.columns.push(Column { name: path, values: Values::Numbers(numbers) }),
    }
    Ok(())
}

/// The shape of a dataset whose values of so many bytes there is room for.
fn room(set: &Dataset, bytes: u64, path: &str, found: &mut Found) -> Result<Vec<u64>, Fault> {
    let shape = set.shape().map_err(|why| damaged(&format!("{path}: {why}")))?;
    let count = shape.iter().try_fold(bytes, |count, side| count.checked_mul(*side));
    let taken = count.and_then(|count| count.checked_add(found.taken)).filter(|taken| *taken <= LARGEST);
    found.taken = taken.ok_or_else(|| {
        Fault::new(format!("{path} is larger than 1 GiB"), "save the vectors that show the motor alone")
    })?;
    Ok(shape)
}

fn is_number(kind: &DType) -> bool {
    use DType::{F32, F64, I8, I16, I32, I64, U8, U16, U32, U64};
    matches!(kind, F32 | F64 | I8 | I16 | I32 | I64 | U8 | U16 | U32 | U64)
}

/// Numbers in the rows of a compound dataset, as pandas and h5py write tables.
fn compound(set: &Dataset, path: &str, fields: &[(String, DType)], found: &mut Found) -> Result<(), Fault> {
    let size = set.element_size().map_err(|why| damaged(&format!("{path}: {why}")))?;
    let width = |kind: &DType| match kind {
        DType::F32 | DType::I32 | DType::U32 => Some(4),
        DType::F64 | DType::I64 | DType::U64 => Some(8),
        DType::I16 | DType::U16 => Some(2),
        DType::I8 | DType::U8 => Some(1),
        _ => None,
    };
    // Places of the fields are known where they lie one behind the other.
    let widths: Option<Vec<usize>> = fields.iter().map(|(_, kind)| width(kind)).collect();
    let Some(widths) = widths.filter(|widths| widths.iter().sum::<usize>() as u64 == size) else {
        found.left_out.push(format!("{path} (rows of other things than numbers)"));
        return Ok(());
    };
    room(set, size + 8 * fields.len() as u64, path, found)?;
    let raw = set.read_raw().map_err(|why| damaged(&format!("{path}: {why}")))?;
    let mut offset = 0;
    for ((name, kind), width) in fields.iter().zip(widths) {
        let value = |row: &[u8]| {
            let mut cell = super::bytes::Bytes::new(&row[offset..]);
            let value = match kind {
                DType::F32 => cell.f32().map(f64::from),
                DType::F64 => cell.f64(),
                DType::I8 => cell.i8().map(f64::from),
                DType::I16 => cell.i16().map(f64::from),
                DType::I32 => cell.i32().map(f64::from),
                DType::I64 => cell.i64().map(|value| value as f64),
                DType::U8 => cell.u8().map(f64::from),
                DType::U16 => cell.u16().map(f64::from),
                DType::U32 => cell.u32().map(f64::from),
                _ => cell.u64().map(|value| value as f64),
            };
            value.unwrap_or(f64::NAN)
        };
        let numbers = raw.chunks_exact(size as usize).map(value).collect();
        found.columns.push(Column { name: format!("{path}.{name}"), values: Values::Numbers(numbers) });
        offset += width;
    }
    Ok(())
}
