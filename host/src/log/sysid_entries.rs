//! What SysId's routines log, whatever the file: entries with values of their own times, one of which names the test.
//!
//! A routine logs its state under a name with `sysid-test-state` (`quasistatic-forward`, `dynamic-reverse`,
//! ..., `none`) and each motor under `voltage-MOTOR`, `position-MOTOR`, `velocity-MOTOR`, in rotations of the output
//! unless the log says its unit, or `--map angle=position:rad,speed=velocity:rad/s` does. Where MOTOR ends with the name of a
//! routine, the tests of that routine are its own. Each test of each motor becomes one record.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::path::Path;

use super::mapping::Mapping;
use super::samples::{Place, Samples};
use super::sysid::{TEST_KEY, UNIT_KEY, restore_signs};
use super::units::Quantity;
use super::{Metadata, ReadOptions, Record};
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
struct Test {
    name: &'static str,
    /// The routine's name; empty where its entry does not say.
    routine: String,
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

    /// The tests in the order of their begin. A state that two entries tell is one test.
    fn tests(&self) -> Vec<Test> {
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
    fn motors(&self) -> Vec<String> {
        let mut motors: Vec<String> =
            self.numbers.keys().filter_map(|name| motor_of(name, "voltage")).collect();
        motors.dedup();
        motors
    }
}

/// What stands behind `sysid-test-state-`, the name of the routine.
fn routine_of(entry: &str) -> String {
    let lower = entry.to_ascii_lowercase();
    lower.rsplit_once("sysid-test-state-").map_or_else(String::new, |(_, routine)| routine.to_owned())
}

/// Whether the routine's log names this motor: `left-drive` is of `drive`.
fn belongs(motor: &str, routine: &str) -> bool {
    let motor = motor.to_ascii_lowercase();
    motor == routine || motor.strip_suffix(routine).is_some_and(|rest| rest.ends_with('-'))
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
    let own = |routine: &str| motors.iter().any(|motor| !routine.is_empty() && belongs(motor, routine));
    let is_of = |test: &Test, motor: &str| !own(&test.routine) || belongs(motor, &test.routine);
    let chosen = chosen(path, &motors, &tests, own, options.map.as_ref())?;
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

/// The motor whose voltage the mapping names. Several mechanisms in one log are several motors: one has to be chosen.
fn chosen(
    path: &Path,
    motors: &[String],
    tests: &[Test],
    own: impl Fn(&str) -> bool,
    map: Option<&Mapping>,
) -> Result<Option<String>> {
    let column = map.and_then(|map| map.source(Quantity::Voltage)).map(|source| source.column.as_str());
    let motor = column.and_then(|column| motor_of(column, "voltage")).filter(|motor| motors.contains(motor));
    if motor.is_some() {
        return Ok(motor);
    }
    let mut routines: Vec<&str> = tests.iter().map(|test| test.routine.as_str()).filter(|r| own(r)).collect();
    routines.sort_unstable();
    routines.dedup();
    if routines.len() < 2 {
        return Ok(None);
    }
    let of = |routine: &&str| {
        let own: Vec<&str> =
            motors.iter().map(String::as_str).filter(|motor| belongs(motor, routine)).collect();
        format!("{routine} ({})", own.join(", "))
    };
    let why = format!(
        "the log holds tests of several mechanisms: {}",
        routines.iter().map(of).collect::<Vec<_>>().join(", ")
    );
    let first = motors.iter().find(|motor| belongs(motor, routines[0])).map_or("MOTOR", String::as_str);
    Err(BadInput::new(path, why, format!("choose a motor by its voltage: --map voltage=voltage-{first}:V"))
        .into())
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

/// What an entry belongs to: the motor, by SysId's and AdvantageKit's names, or else all that stands before the last part of its name.
pub fn group_of(name: &str) -> String {
    let motor = ["voltage", "position", "velocity"].iter().find_map(|kind| motor_of(name, kind));
    let path = name.rsplit_once(['/', '.']).map_or("", |(path, _)| path);
    motor.map_or_else(|| path.to_owned(), |motor| format!("{path}/{motor}"))
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
    let factor = |quantity, usual| {
        let source = options.map.as_ref().and_then(|map| map.source(quantity));
        source.map_or(usual, |source| source.unit.factor)
    };
    let (Some((voltage, _)), position, velocity) = (entry("voltage"), entry("position"), entry("velocity"))
    else {
        return Ok(None);
    };
    let Some((_, unit)) = position.or(velocity) else { return Ok(None) };
    if unit == "m" && !options.map.as_ref().is_some_and(Mapping::names_motion) {
        let why = format!("position and velocity of {motor} are in metres, and a motor turns");
        let remedy = "give the radius of the wheel or drum in metres: --map angle=position:rad/0.0762,speed=velocity:rad/s/0.0762";
        return Err(BadInput::new(path, why, remedy).into());
    }
    let usual = |unit: &str| match unit {
        "rad" | "m" => 1.0,
        "deg" => TAU / 360.0,
        _ => TAU,
    };
    let mut kinds = vec![("voltage", voltage, factor(Quantity::Voltage, 1.0))];
    kinds.extend(position.map(|(values, unit)| ("position", values, factor(Quantity::Angle, usual(unit)))));
    kinds.extend(velocity.map(|(values, unit)| ("velocity", values, factor(Quantity::Speed, usual(unit)))));

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

/// One turn of the robot's loop logs its entries within this share of the turn, and within so many seconds.
const TURN_SHARE: f64 = 0.1;
const LONGEST_TURN_S: f64 = 2e-3;

/// Of several series the one that was logged most often (the first of equals): it has the most turns of the loop, where others are
/// logged only when they change.
pub fn clock<'v, T>(all: impl Iterator<Item = &'v [T]>) -> Option<&'v [T]> {
    all.fold(None, |best: Option<&[T]>, next| match best {
        Some(best) if best.len() >= next.len() => Some(best),
        _ => Some(next),
    })
}

/// How far behind the first entry of a turn of the loop its others may be logged, s.
pub fn turn_s(times: &[f64]) -> f64 {
    (TURN_SHARE * super::timing::median_interval(times)).min(LONGEST_TURN_S)
}

/// Where the last of `times` up to `time_s` stands, whose value holds until the next.
pub fn held_at(times: &[f64], time_s: f64) -> Option<usize> {
    times.partition_point(|time| *time <= time_s).checked_sub(1)
}

/// The last value logged by `time_s`, which holds until the next; values are in the order of their times.
fn held(values: &[Value], time_s: f64) -> f64 {
    let after = values.partition_point(|value| value.time_s <= time_s);
    after.checked_sub(1).and_then(|index| values.get(index)).map_or(f64::NAN, |value| value.value)
}
