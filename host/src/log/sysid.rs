//! `--format wpilib-sysid`: the JSON files of WPILib's SysId.
//!
//! Four tests (`slow-forward`, `slow-backward`, `fast-forward`, `fast-backward`), each an array of rows. A mechanism
//! has `[time, voltage, position, velocity]`, a drive train
//! `[time, left V, right V, left position, right position, left velocity, right velocity, angle, rate]`; times are in
//! seconds, positions in rotations of the output and velocities in rotations per second, whatever `units` says
//! (WPILib, "Data Collection" of the SysId documentation). A robot program that logged otherwise is read with
//! `--map angle=position:rad,speed=velocity:rad/s`. Each test and side becomes one record.

use std::io::BufRead;
use std::path::Path;

use serde::Deserialize;

use super::samples::{Place, Samples};
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record, Warning, json, sysid_units};
use crate::error::{BadInput, Result};

/// A row as SysId wrote it; a lost number is `null`.
type Row = Vec<Option<f64>>;

#[derive(Deserialize)]
#[serde(rename_all = "kebab-case")]
struct File {
    #[serde(default)]
    test: String,
    #[serde(default)]
    slow_forward: Vec<Row>,
    #[serde(default)]
    slow_backward: Vec<Row>,
    #[serde(default)]
    fast_forward: Vec<Row>,
    #[serde(default)]
    fast_backward: Vec<Row>,
}

/// One side of the machine: where its numbers stand in a row.
struct Side {
    name: &'static str,
    voltage: usize,
    position: usize,
    velocity: usize,
}

const MECHANISM: &[Side] = &[Side { name: "", voltage: 1, position: 2, velocity: 3 }];

const DRIVE_TRAIN: &[Side] = &[
    Side { name: " left", voltage: 1, position: 3, velocity: 5 },
    Side { name: " right", voltage: 2, position: 4, velocity: 6 },
];

/// Metadata key that marks a record as one of the tests of a SysId file.
pub const TEST_KEY: &str = "sysid_test";
/// Metadata key of the unit in which a data log has the position, as `--map` writes it.
pub const UNIT_KEY: &str = "sysid_unit";

/// Reads the records of a SysId file: one per test, two per test of a drive train.
///
/// # Errors
/// Bad input where the JSON is broken, holds no test, or a test fails the rules for samples.
pub fn read(path: &Path, input: impl BufRead, options: &ReadOptions) -> Result<Vec<Record>> {
    let file: File = json::parse(path, input)?;
    let mut records = Vec::new();
    for (test, rows) in [
        ("slow-forward", &file.slow_forward),
        ("slow-backward", &file.slow_backward),
        ("fast-forward", &file.fast_forward),
        ("fast-backward", &file.fast_backward),
    ] {
        let Some(width) = rows.first().map(Vec::len) else {
            continue;
        };
        let sides = match width {
            4 => MECHANISM,
            9 => DRIVE_TRAIN,
            _ => {
                let why = format!(
                    "{test}, entry 0: a row of {width} numbers is neither a mechanism (4) nor a drive train (9)"
                );
                let remedy = "convert the log to CSV and say with --map which column is what";
                return Err(BadInput::new(path, why, remedy).in_column(test).into());
            }
        };
        for side in sides {
            records.push(one(path, test, rows, side, options)?);
        }
    }
    if records.is_empty() {
        let found = if file.test.is_empty() { "this JSON" } else { &file.test };
        return Err(BadInput::new(
            path,
            format!("{found} holds none of slow-forward, slow-backward, fast-forward, fast-backward"),
            "save the raw data of SysId, not its analysis; a WPILOG file must be exported as CSV and read with --map",
        )
        .in_column("slow-forward")
        .into());
    }
    restore_signs(&mut records);
    Ok(records)
}

fn one(path: &Path, test: &str, rows: &[Row], side: &Side, options: &ReadOptions) -> Result<Record> {
    // A mapping gives the unit where the robot program did not log rotations.
    let factor = |quantity, own| sysid_units::factor(path, quantity, own, options);
    let columns = [
        ("timestamp", 0, factor(Quantity::Time, "s")?),
        ("voltage", side.voltage, factor(Quantity::Voltage, "V")?),
        ("position", side.position, factor(Quantity::Angle, "rev")?),
        ("velocity", side.velocity, factor(Quantity::Speed, "rev/s")?),
    ];
    let label = |name: &str| format!("{test}{} {name}", side.name);
    let mut samples = Samples::new(path, columns.iter().map(|(name, ..)| label(name)).collect());
    for (entry, row) in rows.iter().enumerate() {
        let mut numbers = [0.0; 4];
        let lost = columns.iter().zip(&mut numbers).find_map(|((name, index, factor), number)| {
            match row.get(*index).copied().flatten() {
                Some(value) => {
                    *number = value * factor;
                    None
                }
                None => Some(*name),
            }
        });
        match lost {
            None => samples.accept(Place::Entry(entry), &numbers)?,
            Some(name) => samples.reject(Place::Entry(entry), &label(name), "the number is missing".into()),
        }
    }
    let (columns, warnings) = samples.finish(None)?;
    let mut meta = Metadata::default();
    for (key, value) in [(TEST_KEY, test), ("programme", test)] {
        meta.insert(key, value).expect("these keys take any text");
    }
    options.complete(path, &mut meta)?;
    let mut columns = columns.into_iter();
    let mut next = || columns.next().unwrap_or_default();
    let record = Record {
        name: format!("{} {test}{}", super::stem(path), side.name),
        path: path.to_owned(),
        time_s: next(),
        voltage_v: next(),
        angle_rad: Some(next()),
        speed_rad_s: Some(next()),
        hold: options.hold.unwrap_or_default(),
        map: options.map.clone(),
        meta,
        warnings,
        ..Record::default()
    };
    Ok(record)
}

/// Restores the sign of every test where none of the file has one: where some voltage is negative, all are signed.
pub(super) fn restore_signs(records: &mut [Record]) {
    if records.iter().all(|record| record.voltage_v.iter().all(|&voltage| voltage >= 0.0)) {
        records.iter_mut().for_each(restore_sign);
    }
}

/// Some robot programs logged the voltage without its sign; SysId itself copies the sign of the velocity onto every
/// row. Here the whole test is turned round, so that rows at rest or braking keep what they had.
fn restore_sign(record: &mut Record) {
    let Some(speed) = &record.speed_rad_s else {
        return;
    };
    let unsigned = record.voltage_v.iter().all(|&voltage| voltage >= 0.0);
    let power: f64 = record.voltage_v.iter().zip(speed).map(|(voltage, speed)| voltage * speed).sum();
    if unsigned && power < 0.0 {
        record.voltage_v.iter_mut().for_each(|voltage| *voltage = -*voltage);
        record.warnings.push(Warning {
            place: format!("{}, {}, voltage", record.path.display(), record.name),
            what: "the voltage was logged without its sign, and was given that of the motion".into(),
            fix: "log the signed voltage".into(),
        });
    }
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{assert_bad, file};
    use super::super::{Format, ReadOptions, Record, read};
    use crate::error::Result;

    fn sysid(content: &str) -> Result<Vec<Record>> {
        let (_directory, path) = file(content.as_bytes());
        let options = ReadOptions { format: Format::WpilibSysid, ..ReadOptions::default() };
        read(&path, &options)
    }

    fn rows(sign: f64, row: impl Fn(f64, f64) -> String) -> String {
        let rows: Vec<String> = (0..30).map(|i| row(f64::from(i) * 0.02, sign * f64::from(i))).collect();
        format!("[{}]", rows.join(","))
    }

    #[test]
    fn a_mechanism_gives_one_record_per_test_in_radians() {
        let forward = rows(1.0, |t, x| format!("[{t},{x},{x},{x}]"));
        let unsigned = rows(-1.0, |t, x| format!("[{t},{},{x},{x}]", x.abs()));
        let records = sysid(&format!(
            "{{\"sysid\":true,\"test\":\"Simple\",\"units\":\"Rotations\",\"unitsPerRotation\":1.0,\
             \"slow-forward\":{forward},\"fast-backward\":{unsigned}}}"
        ))
        .unwrap();
        assert_eq!(records.len(), 2);
        assert!(records[0].name.ends_with("slow-forward") && records[0].warnings.is_empty());
        let turn = std::f64::consts::TAU;
        assert!((records[0].angle_rad.as_ref().unwrap()[3] - 3.0 * turn).abs() < 1e-12);
        assert!((records[0].speed_rad_s.as_ref().unwrap()[3] - 3.0 * turn).abs() < 1e-12);
        assert_eq!(records[1].voltage_v[3], -3.0);
        assert_eq!(records[1].warnings.len(), 1);
    }

    #[test]
    fn a_drive_train_gives_two_records_per_test() {
        let rows = rows(1.0, |t, x| format!("[{t},{x},{},{x},{},{x},{},0,0]", 2.0 * x, 3.0 * x, 4.0 * x));
        let records = sysid(&format!("{{\"test\":\"Drivetrain\",\"slow-forward\":{rows}}}")).unwrap();
        assert_eq!(records.len(), 2);
        assert!(records[1].name.ends_with("slow-forward right"));
        assert_eq!(records[1].voltage_v[5], 10.0);
        assert!((records[1].angle_rad.as_ref().unwrap()[5] - 15.0 * std::f64::consts::TAU).abs() < 1e-12);
    }

    #[test]
    fn a_pause_or_a_clock_that_starts_anew_cuts_a_test_as_it_cuts_a_table() {
        for later in [15.0, -0.6] {
            let time = |t: f64| if t < 0.59 { t } else { t + later };
            let rows: Vec<String> =
                (0..60).map(|i| f64::from(i) * 0.02).map(|t| format!("[{},{t},{t},1]", time(t))).collect();
            let records = sysid(&format!("{{\"slow-forward\":[{}]}}", rows.join(","))).unwrap();
            assert_eq!(records.iter().map(Record::len).collect::<Vec<_>>(), [30, 30], "{later}");
            assert!(records[1].name.ends_with("slow-forward part 2"), "{}", records[1].name);
            let said: Vec<&str> = records.iter().flat_map(|r| &r.warnings).map(|w| w.what.as_str()).collect();
            assert!(said.len() == 1 && said[0].contains("read as 2 records"), "{said:?}");
        }
    }

    #[test]
    fn broken_files_are_refused_with_place_cause_and_remedy() {
        let backwards = rows(1.0, |t, x| format!("[{},{x},{x},{x}]", -t));
        for (content, place, cause, remedy) in [
            ("{\n\"slow-forward\": [[1,2,\n", "line 3", "JSON", "complete"),
            ("{\"sysid\":true,\"test\":\"Arm\"}", "column slow-forward", "Arm holds none", "raw data"),
            ("{\"slow-forward\":[[1,2]]}", "column slow-forward", "2 numbers", "--map"),
            (
                "{\"slow-forward\":[[0,1,1,null],[1,1,1,1]]}",
                "slow-forward velocity",
                "entry 0: the number is missing",
                "remove",
            ),
            (
                &format!("{{\"slow-forward\":{backwards}}}"),
                "slow-forward timestamp",
                "entry 1: time goes backwards",
                "sort",
            ),
        ] {
            assert_bad(&sysid(content).unwrap_err(), place, cause, remedy);
        }
    }
}
