//! Writing a record as a canonical log.

use std::io::{self, Write};
use std::path::Path;

use super::units::Quantity;
use super::{Hold, Record};
use crate::atomic_file;
use crate::error::Result;

/// Writes `record` as a canonical log, whole or not at all. Numbers are written with as many digits as bring back
/// the same number.
///
/// # Errors
/// The machine's refusal, naming the path.
pub fn write_canonical(record: &Record, path: &Path) -> Result<()> {
    atomic_file::write_with(path, |file| write(record, file))
}

fn write(record: &Record, out: &mut impl Write) -> io::Result<()> {
    for (key, value) in record.meta.iter().filter(|(key, _)| *key != "hold") {
        writeln!(out, "# {key}: {}", one_line(value))?;
    }
    if record.hold == Hold::First {
        writeln!(out, "# hold: first")?;
    }
    let columns: Vec<(&str, &[f64])> = [
        (Quantity::Time, Some(&record.time_s)),
        (Quantity::Voltage, Some(&record.voltage_v)),
        (Quantity::Angle, record.angle_rad.as_ref()),
        (Quantity::Speed, record.speed_rad_s.as_ref()),
        (Quantity::Current, record.current_a.as_ref()),
        (Quantity::Supply, record.supply_v.as_ref()),
    ]
    .into_iter()
    .filter_map(|(quantity, values)| Some((quantity.canonical()?, values?.as_slice())))
    .collect();
    let headers: Vec<&str> = columns.iter().map(|(header, _)| *header).collect();
    writeln!(out, "{}", headers.join(","))?;
    for row in 0..record.len() {
        for (index, (_, values)) in columns.iter().enumerate() {
            let separator = if index == 0 { "" } else { "," };
            write!(out, "{separator}{}", values[row])?;
        }
        writeln!(out)?;
    }
    Ok(())
}

/// Metadata lives on one line each.
fn one_line(value: &str) -> String {
    value.replace(['\n', '\r'], " ")
}
