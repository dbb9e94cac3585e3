//! Parquet, as pandas, polars, DuckDB and LeRobot write tables: numbers and times by name; fields of structures as `struct.field`, lists of
//! one length (a value per joint) as `name[0]`.

use ::bytes::Bytes;
use ::parquet::basic::{LogicalType, TimeUnit};
use ::parquet::column::reader::ColumnReader;
use ::parquet::data_type::Int96;
use ::parquet::file::reader::{FileReader, SerializedFileReader};
use ::parquet::schema::types::ColumnDescriptor;

use super::table::{Column, Table, Values};
use super::{Content, Fault, LARGEST};

/// Rows that are read at once.
const BATCH: usize = 1 << 16;

/// Reads all columns of numbers, texts and lists of numbers.
///
/// # Errors
/// A fault where the file is damaged, packed in a way that is not read, or unpacked larger than any log.
pub fn read(all: &[u8]) -> Result<Content, Fault> {
    let file = SerializedFileReader::new(Bytes::copy_from_slice(all)).map_err(|why| damaged(&why))?;
    let about = file.metadata();
    let schema = about.file_metadata().schema_descr();
    let rows = u64::try_from(about.file_metadata().num_rows()).unwrap_or(u64::MAX);
    let (mut columns, mut left_out) = (Vec::new(), Vec::new());
    if rows.saturating_mul(8).saturating_mul(schema.num_columns() as u64) > LARGEST {
        return Err(Fault::new(
            format!("its {rows} rows of {} columns are more than 1 GiB", schema.num_columns()),
            "save the columns and rows that show the motor alone",
        ));
    }
    for index in 0..schema.num_columns() {
        let description = schema.column(index);
        let name = description.path().parts().join(".");
        if description.max_rep_level() > 0 {
            let name = [".list.element", ".list.item", ".array"]
                .iter()
                .find_map(|end| name.strip_suffix(end))
                .unwrap_or(&name);
            let mut lists = Lists::default();
            for group in 0..file.num_row_groups() {
                let group = file.get_row_group(group).map_err(|why| damaged(&why))?;
                let reader = group.get_column_reader(index).map_err(|why| damaged(&why))?;
                lists
                    .take(reader, &description)
                    .map_err(|why| damaged(&format!("in the column {name}: {why}")))?;
            }
            match lists.columns(rows as usize) {
                Some(parts) => columns.extend(parts.into_iter().enumerate().map(|(joint, numbers)| Column {
                    name: format!("{name}[{joint}]"),
                    values: Values::Numbers(numbers),
                })),
                None => left_out.push(format!("{name} (lists of different lengths, or of no numbers)")),
            }
            continue;
        }
        let mut numbers = Vec::new();
        let mut texts = Vec::new();
        for group in 0..file.num_row_groups() {
            let group = file.get_row_group(group).map_err(|why| damaged(&why))?;
            let reader = group.get_column_reader(index).map_err(|why| damaged(&why))?;
            values(reader, &description, rows as usize, &mut numbers, &mut texts)
                .map_err(|why| damaged(&format!("in the column {name}: {why}")))?;
        }
        if numbers.len() as u64 == rows {
            columns.push(Column { name, values: Values::Numbers(numbers) });
        } else if texts.len() as u64 == rows {
            columns.push(Column { name, values: Values::Texts(texts) });
        } else {
            left_out.push(format!("{name} (no numbers)"));
        }
    }
    Ok(Content::Table(Table::of(columns, left_out)?))
}

fn damaged(why: &dyn std::fmt::Display) -> Fault {
    Fault::new(
        format!("it is damaged, cut off or packed in a way that is not read: {why}"),
        "copy the file again, or save it anew: DataFrame.to_parquet(NAME, compression=\"snappy\")",
    )
}

/// Appends the values of one column of one row group; blanks are NaN.
fn values(
    reader: ColumnReader,
    description: &ColumnDescriptor,
    rows: usize,
    numbers: &mut Vec<f64>,
    texts: &mut Vec<String>,
) -> Result<(), String> {
    let seconds = seconds(description);
    let most = description.max_def_level();
    macro_rules! all {
        ($reader:expr, $into:expr, $blank:expr, $value:expr) => {{
            let mut reader = $reader;
            loop {
                let (mut levels, mut values) = (Vec::new(), Vec::new());
                let (records, ..) = reader
                    .read_records(BATCH, (most > 0).then_some(&mut levels), None, &mut values)
                    .map_err(|why| why.to_string())?;
                if records == 0 || $into.len() > rows {
                    return Ok(());
                }
                let mut values = values.into_iter();
                for row in 0..records {
                    let there = most == 0 || levels.get(row).is_some_and(|level| *level == most);
                    let value = if there { values.next() } else { None };
                    $into.push(value.map_or($blank, $value));
                }
            }
        }};
    }
    match reader {
        ColumnReader::BoolColumnReader(reader) => all!(reader, numbers, f64::NAN, |v| f64::from(u8::from(v))),
        ColumnReader::Int32ColumnReader(reader) => {
            all!(reader, numbers, f64::NAN, |v| f64::from(v) * seconds)
        }
        ColumnReader::Int64ColumnReader(reader) => all!(reader, numbers, f64::NAN, |v| v as f64 * seconds),
        ColumnReader::FloatColumnReader(reader) => all!(reader, numbers, f64::NAN, f64::from),
        ColumnReader::DoubleColumnReader(reader) => all!(reader, numbers, f64::NAN, |v| v),
        ColumnReader::Int96ColumnReader(reader) => {
            all!(reader, numbers, f64::NAN, |v: Int96| v.to_nanos() as f64 * 1e-9)
        }
        ColumnReader::ByteArrayColumnReader(reader) => {
            all!(reader, texts, String::new(), |v: ::parquet::data_type::ByteArray| {
                String::from_utf8_lossy(v.data()).into_owned()
            })
        }
        ColumnReader::FixedLenByteArrayColumnReader(_) => Ok(()),
    }
}

/// Joints that a list may have.
const LONGEST_LIST: usize = 64;

/// The lists of a column, one per row, end to end.
#[derive(Default)]
struct Lists {
    numbers: Vec<f64>,
    /// Where each list begins.
    begins: Vec<usize>,
}

impl Lists {
    /// Appends the lists of one row group.
    fn take(&mut self, reader: ColumnReader, description: &ColumnDescriptor) -> Result<(), String> {
        let most = description.max_def_level();
        macro_rules! all {
            ($reader:expr, $value:expr) => {{
                let mut reader = $reader;
                loop {
                    let (mut levels, mut repeats, mut values) = (Vec::new(), Vec::new(), Vec::new());
                    let (records, ..) = reader
                        .read_records(BATCH, Some(&mut levels), Some(&mut repeats), &mut values)
                        .map_err(|why| why.to_string())?;
                    if records == 0 {
                        return Ok(());
                    }
                    if 8 * (self.numbers.len() + levels.len()) as u64 > LARGEST {
                        return Err("its lists are larger than 1 GiB".into());
                    }
                    let mut values = values.into_iter();
                    for (level, repeat) in levels.iter().zip(&repeats) {
                        if *repeat == 0 {
                            self.begins.push(self.numbers.len());
                        }
                        // Levels below that of a blank number are lists without any.
                        if *level == most {
                            self.numbers.push(values.next().map_or(f64::NAN, $value));
                        } else if *level + 1 == most {
                            self.numbers.push(f64::NAN);
                        }
                    }
                }
            }};
        }
        match reader {
            ColumnReader::Int32ColumnReader(reader) => all!(reader, f64::from),
            ColumnReader::Int64ColumnReader(reader) => all!(reader, |v| v as f64),
            ColumnReader::FloatColumnReader(reader) => all!(reader, f64::from),
            ColumnReader::DoubleColumnReader(reader) => all!(reader, |v| v),
            _ => Ok(()),
        }
    }

    /// A column for every place of the list, where all `rows` lists are of one length.
    fn columns(&self, rows: usize) -> Option<Vec<Vec<f64>>> {
        let length =
            self.numbers.len().checked_div(rows).filter(|length| (1..=LONGEST_LIST).contains(length))?;
        let even = self.begins.len() == rows
            && self.begins.iter().enumerate().all(|(row, begin)| *begin == row * length);
        even.then(|| {
            (0..length)
                .map(|place| self.numbers.iter().skip(place).step_by(length).copied().collect())
                .collect()
        })
    }
}

/// Seconds per count of a column of times; 1 for numbers.
fn seconds(description: &ColumnDescriptor) -> f64 {
    use ::parquet::basic::ConvertedType;
    let unit = match description.logical_type_ref() {
        Some(LogicalType::Timestamp(about)) => Some(&about.unit),
        Some(LogicalType::Time(about)) => Some(&about.unit),
        _ => None,
    };
    match unit {
        Some(TimeUnit::MILLIS) => 1e-3,
        Some(TimeUnit::MICROS) => 1e-6,
        Some(TimeUnit::NANOS) => 1e-9,
        None => match description.converted_type() {
            ConvertedType::TIMESTAMP_MILLIS | ConvertedType::TIME_MILLIS => 1e-3,
            ConvertedType::TIMESTAMP_MICROS | ConvertedType::TIME_MICROS => 1e-6,
            _ => 1.0,
        },
    }
}
