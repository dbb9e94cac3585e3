//! MATLAB's `.mat` of version 5 (what `save` writes with `-v6` and `-v7`): numbers by name, those of a structure as `struct.field`.
//!
//! A file is a row of elements, each with its type and size; packed ones are elements within a zlib stream (MathWorks, "MAT-File Level
//! 5 File Format"). Objects of classes (timeseries, timetable, table) are opaque to everybody but MATLAB.

use std::io::Read;

use flate2::read::ZlibDecoder;

use super::bytes::Bytes;
use super::table::{Column, Table, Values, matrix};
use super::{Content, Fault, LARGEST};

/// Types of elements that are no numbers.
const MATRIX: u32 = 14;
const COMPRESSED: u32 = 15;
/// Classes of matrices.
const CELL: u32 = 1;
const STRUCT: u32 = 2;
const OBJECT: u32 = 3;
const CHARACTERS: u32 = 4;
const OPAQUE: u32 = 17;
/// Structures within structures are followed so far.
const DEEPEST: usize = 8;
/// Elements of a structure array beyond these are no columns.
const MOST_ELEMENTS: usize = 64;

/// What was found in a file.
#[derive(Default)]
struct Found {
    columns: Vec<Column>,
    left_out: Vec<String>,
    /// Objects of classes, which hold the data of a timetable.
    objects: Vec<String>,
    /// Texts by their names.
    texts: Vec<(String, String)>,
}

impl Found {
    /// Calls the numbers of a signal as the text beside them does: Simulink's `signals(1).values` have a `label`, those of a timeseries' `Data`
    /// a `Name`.
    fn label(&mut self) {
        const LABELS: [(&str, &str); 2] = [(".label", ".values"), (".Name", ".Data")];
        for (name, text) in &self.texts {
            let labelled = LABELS.iter().find_map(|(label, values)| {
                let signal = name.strip_suffix(label)?;
                self.columns.iter().position(|column| column.name == format!("{signal}{values}"))
            });
            let is_free = |text: &str| self.columns.iter().all(|column| column.name != text);
            if let Some(place) = labelled.filter(|_| !text.is_empty() && is_free(text)) {
                self.columns[place].name.clone_from(text);
            }
        }
    }
}

/// Reads all numbers of a file.
///
/// # Errors
/// A fault where the file is cut off or holds nothing but objects of classes.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let big = all.get(126..128) == Some(b"MI");
    let mut bytes = Bytes::new(all).big_endian(big);
    bytes.take(128)?;
    let mut found = Found::default();
    let mut room = LARGEST;
    while bytes.left() >= 8 {
        let at = bytes.at() as u64;
        let (kind, data) = element(&mut bytes)?;
        let within =
            |fault: Fault| Fault::new(format!("in the variable at byte {at}: {}", fault.why), fault.remedy);
        match kind {
            COMPRESSED => {
                let mut unpacked = Vec::new();
                let whole = ZlibDecoder::new(data).take(room + 1).read_to_end(&mut unpacked);
                whole.map_err(|_| Fault::broken(at, "where a packed variable does not unpack"))?;
                room = room.checked_sub(unpacked.len() as u64).ok_or_else(|| {
                    Fault::new(
                        "unpacked it is larger than 1 GiB",
                        "save the vectors that show the motor alone",
                    )
                })?;
                let mut inner = Bytes::new(&unpacked).big_endian(big);
                let (kind, data) = element(&mut inner).map_err(within)?;
                if kind == MATRIX {
                    variable(Bytes::new(data).big_endian(big), "", 0, &mut found).map_err(within)?;
                }
            }
            MATRIX => variable(Bytes::new(data).big_endian(big), "", 0, &mut found).map_err(within)?,
            _ => {}
        }
    }
    if found.columns.is_empty() && !found.objects.is_empty() {
        return Err(objects(&found.objects));
    }
    found.label();
    found.left_out.extend(found.objects);
    Ok(Content::Table(Table::of(found.columns, found.left_out)?))
}

/// The refusal of a file that holds nothing but objects.
pub fn objects(names: &[String]) -> Fault {
    let named: Vec<&str> = names.iter().map(String::as_str).filter(|name| !name.is_empty()).collect();
    let (what, name) = match named.first() {
        Some(first) => (named.join(", "), (*first).to_owned()),
        None => ("its variables".into(), "T".into()),
    };
    Fault::new(
        format!("{what}: objects such as table, timetable or timeseries, which only MATLAB can read"),
        format!(
            "write it as CSV in MATLAB: writetable({name}, 'log.csv') for a table, writetimetable({name}, 'log.csv') for a timetable; \
             of a timeseries: writematrix([{name}.Time {name}.Data], 'log.csv'); of an iddata: \
             writematrix([{name}.SamplingInstants {name}.InputData {name}.OutputData], 'log.csv')"
        ),
    )
}

/// Type and data of the next element; a small one has both in 8 bytes.
fn element<'a>(bytes: &mut Bytes<'a>) -> Result<(u32, &'a [u8]), Fault> {
    let first = bytes.u32()?;
    if first >> 16 != 0 {
        let size = (first >> 16) as usize;
        let data = bytes.take(4)?;
        return Ok((first & 0xFFFF, data.get(..size).unwrap_or(data)));
    }
    let size = bytes.u32()? as usize;
    let data = bytes.take(size)?;
    if first != COMPRESSED {
        bytes.align(8);
    }
    Ok((first, data))
}

/// Takes the numbers of a matrix element, of which `bytes` are the data.
fn variable(mut bytes: Bytes<'_>, within: &str, depth: usize, found: &mut Found) -> Result<(), Fault> {
    if bytes.left() == 0 {
        return Ok(());
    }
    let big = bytes.is_big_endian();
    let (_, flags) = element(&mut bytes)?;
    let flags = Bytes::new(flags).big_endian(big).u32()?;
    let class = flags & 0xFF;
    if class == OPAQUE {
        // Its name stands where others have their size.
        let (_, name) = element(&mut bytes)?;
        found.objects.push(join(within, String::from_utf8_lossy(name).trim_matches('\0')));
        return Ok(());
    }
    let (_, sides) = element(&mut bytes)?;
    let mut sides_bytes = Bytes::new(sides).big_endian(big);
    let mut sides = Vec::new();
    while sides_bytes.left() >= 4 {
        sides.push(sides_bytes.u32()? as usize);
    }
    let (_, name) = element(&mut bytes)?;
    let name = String::from_utf8_lossy(name).trim_matches('\0').to_owned();
    let name = if name.is_empty() { within.to_owned() } else { join(within, &name) };
    let count = sides.iter().try_fold(1_usize, |count, side| count.checked_mul(*side)).unwrap_or(usize::MAX);
    match class {
        STRUCT | OBJECT if depth < DEEPEST => {
            let (_, length) = element(&mut bytes)?;
            let length = Bytes::new(length).big_endian(big).u32()? as usize;
            let (_, names) = element(&mut bytes)?;
            if length == 0 {
                return Ok(());
            }
            let fields = names.chunks(length).map(|name| {
                String::from_utf8_lossy(name.split(|byte| *byte == 0).next().unwrap_or_default()).into_owned()
            });
            let fields: Vec<String> = fields.collect();
            for number in 0..count.min(MOST_ELEMENTS) {
                let own = if count > 1 { format!("{name}({})", number + 1) } else { name.clone() };
                for field in &fields {
                    if bytes.left() < 8 {
                        return Ok(());
                    }
                    let (_, data) = element(&mut bytes)?;
                    variable(Bytes::new(data).big_endian(big), &join(&own, field), depth + 1, found)?;
                }
            }
        }
        CELL => found.left_out.push(format!("{name} (a cell array)")),
        CHARACTERS => {
            let text = element(&mut bytes).ok().and_then(|(kind, data)| text(kind, data, big));
            found.left_out.push(format!("{name} (text)"));
            // A mapping cannot name these characters.
            let text = text.unwrap_or_default().trim().replace([',', '"', '='], "_");
            found.texts.push((name, text));
        }
        // Numbers: classes 6 (double) to 15 (uint64).
        6..=15 => {
            let (kind, data) = element(&mut bytes)?;
            let numbers = numbers(kind, data, big)?;
            if numbers.len() != count {
                let why = format!("{name} should hold {count} numbers and holds {}", numbers.len());
                return Err(Fault::new(why, "save the file again"));
            }
            match sides[..] {
                [rows, width] => found.columns.extend(matrix(&name, rows, width, &numbers)),
                _ => {
                    found.columns.push(Column { name, values: Values::Numbers(numbers) });
                }
            }
        }
        _ => found.left_out.push(format!("{name} (no numbers)")),
    }
    Ok(())
}

/// Characters, each of which is a number; bytes of UTF-8 are what they are.
fn text(kind: u32, data: &[u8], big: bool) -> Option<String> {
    const UTF8: u32 = 16;
    const UTF16: u32 = 17;
    match kind {
        UTF8 => Some(String::from_utf8_lossy(data).into_owned()),
        _ => {
            let codes = numbers(if kind == UTF16 { 4 } else { kind }, data, big).ok()?;
            Some(codes.iter().filter_map(|code| char::from_u32(*code as u32)).collect())
        }
    }
}

fn join(within: &str, name: &str) -> String {
    if within.is_empty() { name.to_owned() } else { format!("{within}.{name}") }
}

/// Numbers are stored in the smallest type that holds them, whatever their class.
fn numbers(kind: u32, data: &[u8], big: bool) -> Result<Vec<f64>, Fault> {
    let mut bytes = Bytes::new(data).big_endian(big);
    let mut all = Vec::new();
    while bytes.left() > 0 {
        all.push(match kind {
            1 => f64::from(bytes.i8()?),
            2 => f64::from(bytes.u8()?),
            3 => f64::from(bytes.i16()?),
            4 => f64::from(bytes.u16()?),
            5 => f64::from(bytes.i32()?),
            6 => f64::from(bytes.u32()?),
            7 => f64::from(bytes.f32()?),
            9 => bytes.f64()?,
            12 => bytes.i64()? as f64,
            13 => bytes.u64()? as f64,
            _ => {
                return Err(Fault::new(format!("numbers of the unknown type {kind}"), "save the file again"));
            }
        });
    }
    Ok(all)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_label_beside_the_numbers_of_a_signal_is_their_name() {
        let column = |name: &str| Column { name: name.into(), values: Values::Numbers(vec![0.0; 3]) };
        let text = |name: &str, text: &str| (name.to_owned(), text.to_owned());
        let mut found = Found {
            columns: ["scope.time", "scope.signals(1).values", "scope.signals(2).values", "w.Data"]
                .map(column)
                .to_vec(),
            texts: vec![
                text("scope.signals(1).label", "voltage"),
                text("scope.signals(2).label", ""),
                text("w.Name", "speed [rpm]"),
                text("title", "run 1"),
            ],
            ..Found::default()
        };
        found.label();
        let names: Vec<&str> = found.columns.iter().map(|column| column.name.as_str()).collect();
        assert_eq!(names, ["scope.time", "voltage", "scope.signals(2).values", "speed [rpm]"]);
        assert_eq!(super::text(4, &[118, 0, 176, 0], false), Some("v\u{b0}".into()));
    }
}
