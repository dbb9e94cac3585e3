//! Records from plain slices.

use std::path::PathBuf;

use crate::error::{BadInput, Result};
use crate::log::{self, Record};

/// What was measured of the output shaft.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Measured<'a> {
    /// Its angle, rad.
    Angle(&'a [f64]),
    /// Its speed, rad/s.
    Speed(&'a [f64]),
}

/// One record from slices: times (s) that rise, the voltage at the driver's output (V) held from each sample to the next, and
/// what was measured of the output shaft.
///
/// # Errors
/// Slices of different length, numbers that are not finite, times that do not rise, too few samples.
///
/// ```
/// use motorlens::{Measured, record};
/// let time: Vec<f64> = (0..50).map(|k| f64::from(k) * 0.01).collect();
/// let run = record("run", &time, &[6.0; 50], Measured::Speed(&[1.0; 50]))?;
/// assert_eq!(run.len(), 50);
/// assert!(record("run", &time, &[6.0; 49], Measured::Speed(&[1.0; 50])).is_err());
/// # Ok::<(), motorlens::Error>(())
/// ```
pub fn record(name: &str, time_s: &[f64], voltage_v: &[f64], measured: Measured) -> Result<Record> {
    let (column, values) = match measured {
        Measured::Angle(values) => ("angle_rad", values),
        Measured::Speed(values) => ("speed_rad_s", values),
    };
    let columns = [("time_s", time_s), ("voltage_v", voltage_v), (column, values)];
    check(name, &columns)?;
    if time_s.len() < log::FEWEST_SAMPLES {
        let why = format!("{} samples are too few to fit a motor", time_s.len());
        return Err(BadInput::new(name.as_ref(), why, "record some seconds with changing voltage").into());
    }
    Ok(laid_out(name, time_s, voltage_v, measured))
}

/// Columns that were checked, as a record.
pub(crate) fn laid_out(name: &str, time_s: &[f64], voltage_v: &[f64], measured: Measured) -> Record {
    let (angle, values) = match measured {
        Measured::Angle(values) => (true, values),
        Measured::Speed(values) => (false, values),
    };
    let own = || Some(values.to_vec());
    Record {
        name: name.to_owned(),
        path: PathBuf::from(name),
        time_s: time_s.to_vec(),
        voltage_v: voltage_v.to_vec(),
        angle_rad: if angle { own() } else { None },
        speed_rad_s: if angle { None } else { own() },
        ..Record::default()
    }
}

/// Whether `columns`, time first, are numbers in step.
pub(crate) fn check(name: &str, columns: &[(&str, &[f64])]) -> Result<()> {
    let bad = |column: &str, why: String, remedy: &str| -> Result<()> {
        Err(BadInput::new(name.as_ref(), why, remedy).in_column(column).into())
    };
    let rows = columns[0].1.len();
    for (column, values) in columns {
        if values.len() != rows {
            let why = format!("{} values, and {rows} times", values.len());
            return bad(column, why, "give every column a value for each time");
        }
        if let Some(k) = values.iter().position(|x| !x.is_finite()) {
            let why = format!("value {k} (from 0) is {}", values[k]);
            return bad(column, why, "leave out the rows that have no number");
        }
    }
    if let Some(k) = columns[0].1.windows(2).position(|t| t[1] <= t[0]) {
        let t = columns[0].1;
        let why =
            format!("time does not rise from value {k} (from 0), {} s, to the next, {} s", t[k], t[k + 1]);
        return bad(columns[0].0, why, "sort the rows by time, and give each time once");
    }
    Ok(())
}
