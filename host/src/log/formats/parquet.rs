//! Parquet, as pandas, polars and DuckDB write tables: numbers and times by name; fields of structures as `struct.field`.

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

/// Reads all flat columns.
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
            left_out.push(format!("{name} (a list)"));
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
