//! `--format wpilib-sysid` on a table: a WPILOG of SysId (2024 and later) exported as a list.
//!
//! DataLogTool and AdvantageScope write one value per line: `Timestamp,Name,Value` (or `Key` for `Name`), times in
//! seconds. A routine logs its state under a name with `sysid-test-state` (`quasistatic-forward`, `dynamic-reverse`,
//! ..., `none`) and each motor under `voltage-MOTOR`, `position-MOTOR`, `velocity-MOTOR`, in rotations of the output
//! unless `--map angle=position:rad,speed=velocity:rad/s` says otherwise. Each test of each motor becomes one record.

use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use std::io::BufRead;
use std::path::Path;

use super::fields::Splitter;
use super::samples::{Place, Samples};
use super::sysid::{TEST_KEY, UNIT_KEY, restore_signs};
use super::text::cannot_read;
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record, preamble};
use crate::error::{BadInput, Result};

/// One value with its time and line.
#[derive(Debug, Clone, Copy)]
struct Value {
    time_s: f64,
    value: f64,
    line: u64,
}

/// A test between two changes of the state: its name, begin and end.
struct Test {
    name: String,
    begin_s: f64,
    end_s: f64,
}

#[derive(Default)]
struct List {
    tests: Vec<Test>,
    /// Values by the name of the entry.
    entries: BTreeMap<String, Vec<Value>>,
}

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
    let list = collect(path, input, head.splitter(), head.rows, head.read)?;
    if list.tests.is_empty() {
        return Err(BadInput::new(
            path,
            "no entry sysid-test-state tells when a test ran",
            "include the state of the routine in the export",
        )
        .in_column("Name")
        .into());
    }
    let mut records = Vec::new();
    let motors: Vec<String> = list.entries.keys().filter_map(|name| motor_of(name, "voltage")).collect();
    for motor in motors {
        for test in &list.tests {
            records.extend(one(path, &list, &motor, test, options)?);
        }
    }
    if records.is_empty() {
        return Err(BadInput::new(
            path,
            format!(
                "no test has a voltage-MOTOR together with a position-MOTOR or velocity-MOTOR (or, of AdvantageKit, \
                 MotorAppliedVolts with MotorPositionRad or MotorVelocityRadPerSec); the entries of motors are: {}",
                list.entries.keys().take(20).cloned().collect::<Vec<_>>().join(", ")
            ),
            "include the motor's entries in the export",
        )
        .in_column("Name")
        .into());
    }
    restore_signs(&mut records);
    Ok(records)
}

/// The values in the `rows` that were looked at already and in `input`, of which `read` lines are read.
fn collect(
    path: &Path,
    mut input: impl BufRead,
    mut splitter: Splitter,
    rows: Vec<(u64, String)>,
    read: u64,
) -> Result<List> {
    let mut list = List::default();
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
    let mut running: Option<(String, f64)> = None;
    let mut latest = f64::NEG_INFINITY;
    // Whatever an entry is called, its values tell that it is the state.
    let mut states = BTreeSet::new();
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
            latest = latest.max(time_s);
            let named = state_of(value);
            if named.is_some() && !states.contains(name) {
                states.insert(name.to_owned());
            }
            if is_state(name) || states.contains(name) {
                let value = named.unwrap_or("none");
                if running.as_ref().is_none_or(|(test, _)| test != value) {
                    list.end(running.take(), time_s);
                    running = (value != "none").then(|| (value.to_owned(), time_s));
                }
            } else if ["voltage", "position", "velocity"].iter().any(|kind| motor_of(name, kind).is_some()) {
                let value = value.parse().unwrap_or(f64::NAN);
                list.entries.entry(name.to_owned()).or_default().push(Value { time_s, value, line: number });
            }
        }
    }
    list.end(running, latest);
    Ok(list)
}

impl List {
    fn end(&mut self, test: Option<(String, f64)>, end_s: f64) {
        if let Some((name, begin_s)) = test {
            self.tests.push(Test { name, begin_s, end_s });
        }
    }
}

fn is_state(name: &str) -> bool {
    let name = name.to_ascii_lowercase();
    name.contains("sysid-test-state") || name.ends_with("sysidteststate") || name.ends_with("sysidstate")
}

/// The test that a state names, in whatever case and with whatever between its words; none while idle.
fn state_of(value: &str) -> Option<&'static str> {
    const TESTS: [&str; 4] =
        ["quasistatic-forward", "quasistatic-reverse", "dynamic-forward", "dynamic-reverse"];
    let plain = |text: &str| -> String {
        text.chars().filter(char::is_ascii_alphabetic).collect::<String>().to_ascii_lowercase()
    };
    let value = plain(value);
    TESTS.into_iter().find(|test| plain(test) == value)
}

/// What AdvantageKit programs call the end of an entry, for each kind, with its unit.
const ENDINGS: [(&str, &str, &str); 7] = [
    ("voltage", "appliedvolts", "V"),
    ("voltage", "appliedvoltage", "V"),
    ("position", "positionrad", "rad"),
    ("position", "positionrads", "rad"),
    ("position", "positionrotations", "rev"),
    ("velocity", "velocityradpersec", "rad"),
    ("velocity", "velocityrotationspersec", "rev"),
];

/// `voltage-left-drive` and `NT:/x/voltage-left-drive` are of the motor `left-drive`; `/Drive/LeftAppliedVolts` of `left`.
fn motor_of(name: &str, kind: &str) -> Option<String> {
    Some(motor_and_unit(name, kind)?.0)
}

/// The motor whose `kind` the entry holds, and `rad` or `rev` (which SysId takes where the name does not say).
fn motor_and_unit(name: &str, kind: &str) -> Option<(String, &'static str)> {
    let last = name.rsplit(['/', ':']).next()?;
    if let Some(motor) = last.strip_prefix(kind).and_then(|rest| rest.strip_prefix('-')) {
        return Some((motor.to_owned(), "rev"));
    }
    let lower = last.to_ascii_lowercase();
    let (ending, unit) = ENDINGS
        .iter()
        .filter(|(of, ..)| *of == kind)
        .find_map(|(_, ending, unit)| lower.ends_with(ending).then_some((*ending, *unit)))?;
    let path = name[..name.len() - last.len()].trim_matches('/');
    let motor = lower[..lower.len() - ending.len()].trim_matches('-');
    Some((if motor.is_empty() { path.to_owned() } else { motor.to_owned() }, unit))
}

fn one(path: &Path, list: &List, motor: &str, test: &Test, options: &ReadOptions) -> Result<Option<Record>> {
    let entry = |kind: &str| {
        list.entries.iter().find_map(|(name, values)| {
            let (of, unit) = motor_and_unit(name, kind)?;
            (of == motor).then_some((values.as_slice(), unit))
        })
    };
    let factor = |quantity, usual| {
        let source = options.map.as_ref().and_then(|map| map.source(quantity));
        source.map_or(usual, |source| source.unit.factor)
    };
    let (Some((voltage, _)), position, velocity) = (entry("voltage"), entry("position"), entry("velocity"))
    else {
        return Ok(None);
    };
    let Some((_, unit)) = position.or(velocity) else { return Ok(None) };
    let usual = |unit: &str| if unit == "rad" { 1.0 } else { TAU };
    let mut kinds = vec![("voltage", voltage, factor(Quantity::Voltage, 1.0))];
    kinds.extend(position.map(|(values, unit)| ("position", values, factor(Quantity::Angle, usual(unit)))));
    kinds.extend(velocity.map(|(values, unit)| ("velocity", values, factor(Quantity::Speed, usual(unit)))));

    let headers = ["timestamp"].into_iter().chain(kinds.iter().map(|(kind, ..)| *kind));
    let mut samples = Samples::new(path, headers.map(|kind| format!("{kind}-{motor}")).collect());
    let within = |value: &&Value| value.time_s >= test.begin_s && value.time_s <= test.end_s;
    // Some programs log a value only when it changes: the entry that was logged most often has the most turns of the loop.
    let logged = |values: &[Value]| values.iter().filter(within).count();
    let Some(clock) = kinds.iter().map(|(_, values, _)| *values).max_by_key(|values| logged(values)) else {
        return Ok(None);
    };
    let times: Vec<f64> = clock.iter().filter(within).map(|value| value.time_s).collect();
    let turn_s = (TURN_SHARE * super::timing::median_interval(&times)).min(LONGEST_TURN_S);
    for beat in clock.iter().filter(within) {
        let row: Vec<f64> =
            kinds.iter().map(|(_, values, factor)| held(values, beat.time_s + turn_s) * factor).collect();
        match row.iter().position(|value| !value.is_finite()) {
            None => samples.accept(Place::Line(beat.line), &[&[beat.time_s], row.as_slice()].concat())?,
            Some(lost) => {
                let column = format!("{}-{motor}", kinds[lost].0);
                samples.reject(
                    Place::Line(beat.line),
                    &column,
                    "the value is not a number a fit can use".into(),
                );
            }
        }
    }
    let (columns, warnings) = samples.finish(None)?;
    let mut meta = Metadata::default();
    for (key, value) in
        [(TEST_KEY, test.name.as_str()), ("programme", &test.name), ("motor", motor), (UNIT_KEY, unit)]
    {
        meta.insert(key, value).expect("these keys take any text");
    }
    options.complete(path, &mut meta)?;
    let mut columns = columns.into_iter();
    let record = Record {
        name: format!("{} {} {motor}", super::stem(path), test.name),
        path: path.to_owned(),
        time_s: columns.next().unwrap_or_default(),
        voltage_v: columns.next().unwrap_or_default(),
        angle_rad: position.and_then(|_| columns.next()),
        speed_rad_s: velocity.and_then(|_| columns.next()),
        hold: options.hold.unwrap_or_default(),
        map: options.map.clone(),
        meta,
        warnings,
        ..Record::default()
    };
    Ok(Some(record))
}

/// One turn of the robot's loop logs its entries within this share of the turn, and within so many seconds.
const TURN_SHARE: f64 = 0.1;
const LONGEST_TURN_S: f64 = 2e-3;

/// The last value logged by `time_s`, which holds until the next; values are in the order of their times.
fn held(values: &[Value], time_s: f64) -> f64 {
    let after = values.partition_point(|value| value.time_s <= time_s);
    after.checked_sub(1).and_then(|index| values.get(index)).map_or(f64::NAN, |value| value.value)
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
