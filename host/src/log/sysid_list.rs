//! `--format wpilib-sysid` on a table: a WPILOG of SysId (2024 and later) exported as a list.
//!
//! DataLogTool and AdvantageScope write one value per line: `Timestamp,Name,Value` (or `Key` for `Name`), times in
//! seconds. What the entries mean is told in [`super::sysid_entries`].

use std::io::BufRead;
use std::path::Path;

use super::fields::Splitter;
use super::samples::Place;
use super::sysid_entries::{Entries, Value, records};
use super::text::cannot_read;
use super::{ReadOptions, Record, preamble};
use crate::error::{BadInput, Result};

/// Reads the records of an exported list.
///
/// # Errors
/// Bad input where the header is another, no state or no motor was logged, or a test fails the rules for samples.
pub fn read(path: &Path, mut input: impl BufRead, options: &ReadOptions) -> Result<Vec<Record>> {
    let mut head = preamble::read(path, &mut input, false)?;
    let names: Vec<String> =
        head.headers.take().unwrap_or_default().iter().map(|name| name.to_lowercase()).collect();
    if names.len() < 3
        || names[0] != "timestamp"
        || !["name", "key"].contains(&names[1].as_str())
        || names[2] != "value"
    {
        return Err(BadInput::new(
            path,
            format!("the columns are {}, not Timestamp, Name, Value", names.join(", ")),
            "export the data log as a CSV list; a table with one column per signal is read with --map alone",
        )
        .at_line(head.line)
        .into());
    }
    records(path, &collect(path, input, head.splitter(), head.rows, head.read)?, options)
}

/// The values in the `rows` that were looked at already and in `input`, of which `read` lines are read.
fn collect(
    path: &Path,
    mut input: impl BufRead,
    mut splitter: Splitter,
    rows: Vec<(u64, String)>,
    read: u64,
) -> Result<Entries> {
    let mut entries = Entries::default();
    let (mut rows, mut beyond) = (rows.into_iter(), read);
    let mut next = || -> Result<Option<(u64, String)>> {
        if let Some(row) = rows.next() {
            return Ok(Some(row));
        }
        beyond += 1;
        let mut line = String::new();
        let count = input.read_line(&mut line).map_err(|error| cannot_read(path, &error))?;
        Ok((count > 0).then_some((beyond, line)))
    };
    while let Some((number, line)) = next()? {
        let closed = splitter.split(&line);
        if let (true, Some(time), Some(name), Some(value)) =
            (closed, splitter.get(0), splitter.get(1), splitter.get(2))
        {
            let Some(time_s) = time.parse().ok().filter(|time: &f64| time.is_finite()) else {
                let why = format!("\"{time}\" is not a time");
                let fault = BadInput::new(path, why, "export the log again").at_line(number);
                return Err(fault.in_column("Timestamp").into());
            };
            if !entries.saw_text(time_s, name, value) {
                let value = value.parse().unwrap_or(f64::NAN);
                entries.saw_number(name, Value { time_s, value, place: Place::Line(number) });
            }
        }
    }
    Ok(entries)
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::super::{Format, ReadOptions, Record, read};
    use crate::error::Result;

    fn exported(content: &str) -> Result<Vec<Record>> {
        let (_directory, path) = file(content.as_bytes());
        let options = ReadOptions { format: Format::WpilibSysid, ..ReadOptions::default() };
        read(&path, &options)
    }

    /// Two tests of 30 turns of the loop each, with the state logged in every turn and idling in between.
    fn log() -> String {
        let mut text = "Timestamp,Name,Value\n0,\"systemTime\",5\n".to_owned();
        for turn in 0..100 {
            let t = f64::from(turn) * 0.02;
            let (state, sign) = match turn {
                10..40 => ("quasistatic-forward", 1.0),
                60..90 => ("dynamic-reverse", -1.0),
                _ => ("none", 0.0),
            };
            text += &format!("{t},\"sysid-test-state-arm\",\"{state}\"\n");
            for (late, kind, value) in
                [(1e-5, "voltage", 2.0), (2e-5, "position", t), (3e-5, "velocity", 1.0)]
            {
                text += &format!("{},\"/arm/{kind}-left\",{}\n", t + late, sign * value);
            }
        }
        text
    }

    #[test]
    fn each_test_of_the_log_becomes_a_record_in_radians() {
        for text in [log(), log().replace("Timestamp,Name", "Timestamp,Key")] {
            let records = exported(&text).unwrap();
            assert_eq!(records.len(), 2);
            assert_eq!(records[0].len(), 30);
            assert!(records[0].name.ends_with("quasistatic-forward left"));
            assert_eq!(records[1].voltage_v[0], -2.0);
            let turn = std::f64::consts::TAU;
            assert!((records[1].angle_rad.as_ref().unwrap()[0] + 1.2 * turn).abs() < 1e-9);
            assert!((records[1].speed_rad_s.as_ref().unwrap()[0] + turn).abs() < 1e-9);
        }
    }

    #[test]
    fn what_is_missing_in_an_export_is_named() {
        let stateless: String =
            log().lines().filter(|line| !line.contains("state")).map(|line| format!("{line}\n")).collect();
        for (text, place, cause, remedy) in [
            ("time_s,voltage_v,angle_rad\n1,2,3\n", "line 1", "not Timestamp, Name, Value", "--map"),
            (stateless.as_str(), "column Name", "sysid-test-state", "include"),
            (&log().replace("voltage-", "volts-"), "column Name", "no test has", "include"),
            (
                &log().replace("0.02,", "noon,"),
                "line 7, column Timestamp",
                "\"noon\" is not a time",
                "export",
            ),
        ] {
            assert_bad(&exported(text).unwrap_err(), place, cause, remedy);
        }
    }
}
