//! NumPy's `.npy`: one array, behind a header that is a Python literal; and `.npz`, a zip archive of them.
//!
//! The header is a dictionary of three keys; a reader of that literal and of numbers of known width is all there is to the format.
//! A vector is a column, a matrix one column per shorter side, a structured array one column per field.

use super::bytes::Bytes;
use super::table::{Column, Table, Values};
use super::{Content, Fault};

/// Reads one array.
///
/// # Errors
/// A fault where the header is another or the file is cut off.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    Ok(Content::Table(Table::of(columns(all, "")?, Vec::new())?))
}

/// The columns of an array called `name` (empty for the only one of a file).
pub fn columns(all: &[u8], name: &str) -> Result<Vec<Column>, Fault> {
    let mut bytes = Bytes::new(all);
    bytes.take(6)?;
    let major = bytes.u8()?;
    bytes.u8()?;
    let length = if major == 1 { usize::from(bytes.u16()?) } else { bytes.u32()? as usize };
    let header = String::from_utf8_lossy(bytes.take(length)?).into_owned();
    let header = Header::parse(&header).map_err(|what| {
        Fault::new(what, "save the columns as an npz of plain vectors: numpy.savez(NAME, t=t, u=u, y=y)")
    })?;
    let size: usize = header.fields.iter().map(|field| field.bytes).sum();
    let (rows, width) = match header.shape[..] {
        [] => (1, 1),
        [rows] => (rows, 1),
        [rows, width] => (rows, width),
        _ => {
            let why = format!("an array of {} dimensions is no table", header.shape.len());
            return Err(Fault::new(why, "save vectors, or a matrix with a column per quantity"));
        }
    };
    let cells =
        rows.checked_mul(width).filter(|cells| cells.checked_mul(size).is_some_and(|b| b <= bytes.left()));
    let Some(cells) = cells.filter(|_| size > 0) else {
        let what = format!("where {rows} x {width} values of {size} bytes should follow");
        return Err(Fault::broken(bytes.at() as u64, &what));
    };
    let data = bytes.take(cells * size)?;
    // Time runs along the longer side.
    let (rows, width, fortran) =
        if width > rows { (width, rows, !header.fortran) } else { (rows, width, header.fortran) };
    let mut all = Vec::new();
    let mut offset = 0;
    for field in &header.fields {
        for column in 0..width {
            let value = |row: usize| {
                let cell = if fortran { column * rows + row } else { row * width + column };
                field.value(&data[cell * size + offset..][..field.bytes])
            };
            let own = match (name, field.name.as_str(), width) {
                ("", "", 1) => "value".to_owned(),
                ("", "", _) => format!("column{column}"),
                (name, "", 1) => name.to_owned(),
                (name, "", _) => format!("{name}[{column}]"),
                ("", field, 1) => field.to_owned(),
                ("", field, _) => format!("{field}[{column}]"),
                (name, field, 1) => format!("{name}.{field}"),
                (name, field, _) => format!("{name}.{field}[{column}]"),
            };
            all.push(Column { name: own, values: Values::Numbers((0..rows).map(value).collect()) });
        }
        offset += field.bytes;
    }
    Ok(all)
}

/// A number within a cell.
#[derive(Debug, Clone, PartialEq)]
struct Field {
    name: String,
    /// `f`, `i`, `u`, `b` (truth), `m` or `M` (time), or `V` for what is no number.
    kind: u8,
    bytes: usize,
    big_endian: bool,
    /// Seconds per count, of times.
    scale: f64,
}

impl Field {
    /// Understands `<f8`, `|b1`, `<M8[ns]`.
    fn parse(name: &str, text: &str) -> Result<Field, String> {
        let known = || -> Option<Field> {
            let mut characters = text.chars();
            let order = characters.next().filter(|c| "<>|=".contains(*c))?;
            let kind = characters.next()? as u8;
            let rest = characters.as_str();
            let (digits, unit) = rest.split_once('[').unwrap_or((rest, ""));
            let bytes: usize = digits.parse().ok()?;
            let scale = match unit.trim_end_matches(']') {
                "ns" => 1e-9,
                "us" => 1e-6,
                "ms" => 1e-3,
                "s" | "" => 1.0,
                _ => return None,
            };
            let is_number = match kind {
                b'f' => [2, 4, 8].contains(&bytes),
                b'i' | b'u' => [1, 2, 4, 8].contains(&bytes),
                b'b' => bytes == 1,
                b'm' | b'M' => bytes == 8,
                _ => false,
            };
            let field = Field { name: name.to_owned(), kind, bytes, big_endian: order == '>', scale };
            is_number.then_some(field)
        };
        known().ok_or_else(|| format!("values of the type {text} are no numbers"))
    }

    fn value(&self, cell: &[u8]) -> f64 {
        let mut bits = 0_u64;
        for k in 0..cell.len() {
            bits = bits << 8 | u64::from(cell[if self.big_endian { k } else { cell.len() - 1 - k }]);
        }
        let unused = 64 - 8 * cell.len() as u32;
        match (self.kind, self.bytes) {
            (b'f', 8) => f64::from_bits(bits),
            (b'f', 4) => f64::from(f32::from_bits(bits as u32)),
            (b'f', _) => half(bits as u16),
            (b'i', _) => ((bits << unused) as i64 >> unused) as f64,
            // Not a time.
            (b'm' | b'M', _) if bits as i64 == i64::MIN => f64::NAN,
            (b'm' | b'M', _) => bits as i64 as f64 * self.scale,
            _ => bits as f64,
        }
    }
}

/// A number of half precision.
fn half(bits: u16) -> f64 {
    let (exponent, fraction) = (i32::from(bits >> 10 & 31), f64::from(bits & 1023));
    let size = match exponent {
        0 => fraction * 2f64.powi(-24),
        31 if fraction == 0.0 => f64::INFINITY,
        31 => f64::NAN,
        _ => (1024.0 + fraction) * 2f64.powi(exponent - 25),
    };
    if bits >> 15 == 1 { -size } else { size }
}

#[derive(Debug, PartialEq)]
struct Header {
    fields: Vec<Field>,
    fortran: bool,
    shape: Vec<usize>,
}

impl Header {
    /// Understands `{'descr': '<f8', 'fortran_order': False, 'shape': (3, 2), }`.
    fn parse(text: &str) -> Result<Header, String> {
        let behind = |key: &str| {
            let (_, rest) =
                text.split_once(&format!("'{key}':")).ok_or(format!("its header has no {key}"))?;
            Ok::<&str, String>(rest.trim_start())
        };
        let description = behind("descr")?;
        let fields = if description.starts_with('[') {
            let end = description.find(']').map_or(description.len(), |end| {
                // Brackets of a unit of time stand within quotes.
                let quoted = |end: usize| description[..end].matches('\'').count() % 2 == 1;
                let mut end = end;
                while quoted(end) {
                    end = description[end + 1..].find(']').map_or(description.len(), |k| end + 1 + k);
                }
                end
            });
            let words: Vec<&str> = description[1..end].split('\'').skip(1).step_by(2).collect();
            if words.len() % 2 == 1 || description[1..end].matches('(').count() != words.len() / 2 {
                return Err("fields that are arrays themselves are no columns".into());
            }
            words.chunks(2).map(|pair| Field::parse(pair[0], pair[1])).collect::<Result<_, _>>()?
        } else {
            let kind = description.split('\'').nth(1).unwrap_or_default();
            vec![Field::parse("", kind)?]
        };
        let shape = behind("shape")?;
        let inside = shape.trim_start_matches('(').split(')').next().unwrap_or_default();
        let sides = inside.split(',').map(str::trim).filter(|side| !side.is_empty());
        let shape: Result<Vec<usize>, _> = sides.map(|side| side.trim_end_matches('L').parse()).collect();
        let shape = shape.map_err(|_| format!("its shape ({inside}) is none"))?;
        Ok(Header { fields, fortran: behind("fortran_order")?.starts_with("True"), shape })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn headers_of_plain_and_structured_arrays_are_understood() {
        let plain = Header::parse("{'descr': '>i2', 'fortran_order': True, 'shape': (3, 2), }").unwrap();
        assert_eq!((plain.fortran, &plain.shape[..], plain.fields[0].bytes), (true, &[3, 2][..], 2));
        let text = "{'descr': [('t', '<M8[ns]'), ('u', '<f4')], 'fortran_order': False, 'shape': (7,), }";
        let fields = Header::parse(text).unwrap().fields;
        assert_eq!(
            fields.iter().map(|f| (f.name.as_str(), f.bytes)).collect::<Vec<_>>(),
            [("t", 8), ("u", 4)]
        );
        for text in ["{'descr': '|O', 'shape': (3,)}", "{'descr': [('a', '<f8', (3,))], 'shape': (1,)}", "{}"]
        {
            assert!(Header::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn numbers_of_every_width_have_their_value() {
        let value = |text: &str, cell: &[u8]| Field::parse("", text).unwrap().value(cell);
        assert_eq!(value("<i2", &[0xFE, 0xFF]), -2.0);
        assert_eq!(value(">u2", &[1, 2]), 258.0);
        assert_eq!(value("<f2", &[0x00, 0xC1]), -2.5);
        assert_eq!(value("<f4", &1.5f32.to_le_bytes()), 1.5);
        assert_eq!(value(">f8", &(-1.5f64).to_be_bytes()), -1.5);
        assert_eq!(value("<m8[ms]", &250_i64.to_le_bytes()), 0.25);
        assert_eq!(value("|b1", &[1]), 1.0);
        assert!(value("<M8[ns]", &i64::MIN.to_le_bytes()).is_nan());
    }
}
