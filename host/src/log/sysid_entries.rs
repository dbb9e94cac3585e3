//! What SysId's routines log, whatever the file: entries with values of their own times, one of which names the test.
//!
//! A routine logs its state under a name with `sysid-test-state` (`quasistatic-forward`, `dynamic-reverse`,
//! ..., `none`) and each motor under `voltage-MOTOR`, `position-MOTOR`, `velocity-MOTOR`, in rotations of the output
//! unless the log says its unit, or `--map angle=position:rad,speed=velocity:rad/s` does. Where MOTOR ends with the name of a
//! routine, the tests of that routine are its own. Each test of each motor becomes one record.

use std::collections::BTreeMap;
use std::path::Path;

use super::robot_loop::{clock, turn_s};
use super::samples::{Place, Samples};
use super::sysid::{TEST_KEY, UNIT_KEY, restore_signs};
use super::sysid_mechanisms::{chosen, is_owned};
use super::sysid_names::{belongs, is_state, motor_and_unit, motor_of, routine_of, state_of};
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record, sysid_units};
use crate::error::{BadInput, Result};

/// One value with its time and place.
#[derive(Debug, Clone, Copy)]
pub struct Value {
    /// Time, s.
    pub time_s: f64,
    /// The number.
    pub value: f64,
    /// Where the file has it.
    pub place: Place,
}

/// A test between two changes of the state.
#[derive(Debug, Clone, PartialEq)]
pub struct Test {
    /// What SysId calls it.
    pub name: &'static str,
    /// The routine's name; empty where its entry does not say.
    pub routine: String,
    begin_s: f64,
    end_s: f64,
}

/// A time with the test that began or went on there; none while idle.
type State = (f64, Option<&'static str>);

/// The entries of a log that matter to SysId.
#[derive(Debug, Default)]
pub struct Entries {
    /// States by the name of the entry.
    states: BTreeMap<String, Vec<State>>,
    /// Values by the name of the entry.
    numbers: BTreeMap<String, Vec<Value>>,
    /// The units that the log itself gives, by the name of the entry.
    units: BTreeMap<String, &'static str>,
    latest_s: f64,
}

impl Entries {
    /// Takes a text if it is a state; says whether it was. Whatever an entry is called, its values tell that it is the state.
    pub fn saw_text(&mut self, time_s: f64, name: &str, text: &str) -> bool {
        self.latest_s = self.latest_s.max(time_s);
        let test = state_of(text);
        let known = self.states.get_mut(name);
        if let Some(states) = known {
            states.push((time_s, test));
        } else if test.is_some() || is_state(name) {
            self.states.insert(name.to_owned(), vec![(time_s, test)]);
        } else {
            return false;
        }
        true
    }

    /// Takes a number if it is of a motor. Numbers of an entry come in the order of their times.
    pub fn saw_number(&mut self, name: &str, value: Value) {
        self.latest_s = self.latest_s.max(value.time_s);
        if let Some(values) = self.numbers.get_mut(name) {
            values.push(value);
        } else if ["voltage", "position", "velocity"].iter().any(|kind| motor_of(name, kind).is_some()) {
            self.numbers.insert(name.to_owned(), vec![value]);
        }
    }

    /// Takes the unit that the log gives for an entry.
    pub fn saw_unit(&mut self, name: &str, about: &str) {
        let about = about.to_lowercase();
        let known = [
            ("radian", "rad"),
            ("degree", "deg"),
            ("rotation", "rev"),
            ("revolution", "rev"),
            ("millimeter", "mm"),
            ("centimeter", "cm"),
            ("meter", "m"),
        ];
        if let Some((_, unit)) = known.iter().find(|(word, _)| about.contains(word)) {
            self.units.insert(name.to_owned(), unit);
        }
    }

    /// Whether any test ran.
    pub fn has_tests(&self) -> bool {
        self.states.values().flatten().any(|(_, test)| test.is_some())
    }

    /// Whether a test ran while a motor's voltage and motion were logged: what [`records`] are made of.
    pub fn are_complete(&self) -> bool {
        let moves = |motor: &String| {
            let is_of = |name: &str, kind: &str| motor_of(name, kind).as_ref() == Some(motor);
            self.numbers.keys().any(|name| is_of(name, "position") || is_of(name, "velocity"))
        };
        self.has_tests() && self.motors().iter().any(moves)
    }

    /// Whether some motor's numbers are ways of a linear axis.
    pub fn has_ways(&self) -> bool {
        let mut units = self.numbers.keys().filter_map(|name| self.units.get(name));
        units.any(|unit| ["m", "cm", "mm"].contains(unit))
    }

    /// The tests in the order of their begin. A state that two entries tell is one test.
    pub fn tests(&self) -> Vec<Test> {
        let mut tests: Vec<Test> = Vec::new();
        for (entry, states) in &self.states {
            let mut add = |test: Option<(&'static str, f64)>, end_s: f64| {
                let Some((name, begin_s)) = test else { return };
                let told =
                    |other: &Test| other.name == name && begin_s < other.end_s && other.begin_s < end_s;
                if !tests.iter().any(told) {
                    tests.push(Test { name, routine: routine_of(entry), begin_s, end_s });
                }
            };
            let mut running: Option<(&'static str, f64)> = None;
            for &(time_s, test) in states {
                if running.map(|(name, _)| name) != test {
                    add(running.take(), time_s);
                    running = test.map(|name| (name, time_s));
                }
            }
            add(running, self.latest_s);
        }
        tests.sort_by(|a, b| a.begin_s.total_cmp(&b.begin_s));
        tests
    }

    /// All motors with a voltage.
    pub fn motors(&self) -> Vec<String> {
        let mut motors: Vec<String> =
            self.numbers.keys().filter_map(|name| motor_of(name, "voltage")).collect();
        motors.dedup();
        motors
    }
}

/// The records of a log.
///
/// # Errors
/// Bad input where no state or no motor was logged, several mechanisms were and none is chosen, or a test fails the rules for samples.
pub fn records(path: &Path, entries: &Entries, options: &ReadOptions) -> Result<Vec<Record>> {
    let tests = entries.tests();
    if tests.is_empty() {
        return Err(BadInput::new(
            path,
            "no entry sysid-test-state tells when a test ran",
            "include the state of the routine in the export",
        )
        .in_column("Name")
        .into());
    }
    let motors = entries.motors();
    let is_of = |test: &Test, motor: &str| !is_owned(&test.routine, &motors) || belongs(motor, &test.routine);
    let chosen = chosen(path, &motors, &tests, options.map.as_ref())?;
    let mut records = Vec::new();
    for motor in motors.iter().filter(|motor| chosen.as_ref().is_none_or(|chosen| chosen == *motor)) {
        for test in tests.iter().filter(|test| is_of(test, motor)) {
            records.extend(one(path, entries, motor, test, options)?);
        }
    }
    if records.is_empty() {
        return Err(BadInput::new(
            path,
            format!(
                "no test has a voltage-MOTOR together with a position-MOTOR or velocity-MOTOR (or, of AdvantageKit, \
                 MotorAppliedVolts with MotorPositionRad or MotorVelocityRadPerSec); the entries of motors are: {}",
                entries.numbers.keys().take(20).cloned().collect::<Vec<_>>().join(", ")
            ),
            "include the motor's entries in the export",
        )
        .in_column("Name")
        .into());
    }
    restore_signs(&mut records);
    Ok(records)
}

fn one(
    path: &Path,
    entries: &Entries,
    motor: &str,
    test: &Test,
    options: &ReadOptions,
) -> Result<Option<Record>> {
    let entry = |kind: &str| {
        entries.numbers.iter().find_map(|(name, values)| {
            let (of, unit) = motor_and_unit(name, kind)?;
            let unit = entries.units.get(name).copied().unwrap_or(unit);
            (of == motor).then_some((values.as_slice(), unit))
        })
    };
    let (Some((voltage, _)), position, velocity) = (entry("voltage"), entry("position"), entry("velocity"))
    else {
        return Ok(None);
    };
    let Some((_, unit)) = position.or(velocity) else { return Ok(None) };
    let factor = |quantity, own: &str| sysid_units::factor(path, quantity, own, options);
    let mut kinds = vec![("voltage", voltage, factor(Quantity::Voltage, "V")?)];
    if let Some((values, unit)) = position {
        kinds.push(("position", values, factor(Quantity::Angle, unit)?));
    }
    if let Some((values, unit)) = velocity {
        kinds.push(("velocity", values, factor(Quantity::Speed, &format!("{unit}/s"))?));
    }

    let headers = ["timestamp"].into_iter().chain(kinds.iter().map(|(kind, ..)| *kind));
    let mut samples = Samples::new(path, headers.map(|kind| format!("{kind}-{motor}")).collect());
    let within = |value: &&Value| value.time_s >= test.begin_s && value.time_s <= test.end_s;
    let beats: Vec<Vec<Value>> =
        kinds.iter().map(|(_, values, _)| values.iter().filter(within).copied().collect()).collect();
    let Some(beats) = clock(beats.iter().map(Vec::as_slice)) else { return Ok(None) };
    let turn_s = turn_s(&beats.iter().map(|value| value.time_s).collect::<Vec<_>>());
    for beat in beats {
        let row: Vec<f64> =
            kinds.iter().map(|(_, values, factor)| held(values, beat.time_s + turn_s) * factor).collect();
        match row.iter().position(|value| !value.is_finite()) {
            None => samples.accept(beat.place, &[&[beat.time_s], row.as_slice()].concat())?,
            Some(lost) => {
                let column = format!("{}-{motor}", kinds[lost].0);
                samples.reject(beat.place, &column, "the value is not a number a fit can use".into());
            }
        }
    }
    let (columns, warnings) = samples.finish(None)?;
    let mut meta = Metadata::default();
    for (key, value) in [(TEST_KEY, test.name), ("programme", test.name), ("motor", motor), (UNIT_KEY, unit)]
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

/// The last value logged by `time_s`, which holds until the next; values are in the order of their times.
fn held(values: &[Value], time_s: f64) -> f64 {
    let after = values.partition_point(|value| value.time_s <= time_s);
    after.checked_sub(1).and_then(|index| values.get(index)).map_or(f64::NAN, |value| value.value)
}
