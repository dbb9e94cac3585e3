//! Lists in which voltage and motion were logged each at its own times: the motor is found as it was.

use std::fmt::Write as _;

use motorlens::estimate::{Method, Options, fit};
use motorlens::log::{ReadOptions, Record, read};
use motorlens::motor_file::MotorFile;

const GAIN: f64 = 2.0;
const TAU_S: f64 = 0.06;
const SECONDS: f64 = 20.0;
/// Step of the simulation, s.
const STEP_S: f64 = 5e-4;

/// Levels of a quarter of a second, some of them none, with a sine on top where it is `lively`.
fn volts(t: f64, lively: bool) -> f64 {
    const LEVELS: [f64; 11] = [4.0, -3.0, 0.0, 6.0, 2.0, -6.0, 0.0, -2.0, 5.0, -4.0, 3.0];
    let level = LEVELS[(4.0 * t + 1e-9) as usize % LEVELS.len()];
    if lively { 0.5 * level + 5.0 * (4.4 * t).sin() } else { level }
}

/// Angle and speed at every step under a drive that updates its voltage every `hold_s`.
fn motion(hold_s: f64, lively: bool) -> Vec<(f64, f64)> {
    let (mut x, mut w) = (0.0, 0.0);
    let share = 1.0 - (-STEP_S / TAU_S).exp();
    let step = |k: usize| {
        let now = (x, w);
        let u = volts(hold_s * (k as f64 * STEP_S / hold_s + 1e-9).floor(), lively);
        x += GAIN * u * STEP_S + (w - GAIN * u) * TAU_S * share;
        w += share * (GAIN * u - w);
        now
    };
    (0..=(SECONDS / STEP_S) as usize).map(step).collect()
}

/// How a list was logged: the voltage every `voltage_s`, the motion every `motion_s` from `from_s` on.
struct Logged {
    voltage_s: f64,
    motion_s: f64,
    from_s: f64,
    speed: bool,
    /// Values that repeat the one before are not written; the motion is in so many steps a unit.
    changes: Option<f64>,
}

fn list(logged: &Logged) -> String {
    let lively = logged.changes.is_none();
    let motion = motion(logged.voltage_s, lively);
    let every = |interval: f64, from: f64| {
        (0..((SECONDS - from) / interval) as usize).map(move |k| from + interval * k as f64)
    };
    let mut rows: Vec<(f64, &str, f64)> =
        every(logged.voltage_s, 0.0).map(|t| (t, "voltage", volts(t, lively))).collect();
    let name = if logged.speed { "velocity" } else { "position" };
    rows.extend(every(logged.motion_s, logged.from_s).map(|t| {
        let (x, w) = motion[(t / STEP_S).round() as usize];
        let value = if logged.speed { w } else { x };
        (t, name, logged.changes.map_or(value, |steps| (value * steps).round() / steps))
    }));
    rows.sort_by(|a, b| a.0.total_cmp(&b.0));
    let mut text = "Timestamp,Name,Value\n".to_owned();
    let mut last = [None; 2];
    for (t, name, value) in rows {
        let last = &mut last[usize::from(name == "voltage")];
        if lively || *last != Some(value) {
            writeln!(text, "{t:.6},/motor/{name},{value:.6}").unwrap();
        }
        *last = Some(value);
    }
    text
}

fn records(logged: &Logged) -> Vec<Record> {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("log.csv");
    std::fs::write(&path, list(logged)).unwrap();
    let motion = if logged.speed { "speed=/motor/velocity:rad/s" } else { "angle=/motor/position:rad" };
    let map = format!("voltage=/motor/voltage:V,{motion}").parse().unwrap();
    read(&path, &ReadOptions { map: Some(map), ..ReadOptions::default() }).unwrap()
}

fn found(records: &[Record], name: &str) -> f64 {
    let options = Options { method: Method::Fast, effects: vec![], population: 80, generations: 1, seed: 1 };
    let fitted = fit(records, &[], &MotorFile::default(), &options, &mut |_, _| ()).unwrap();
    fitted.parameters.iter().find(|p| p.name == name).unwrap().value
}

#[test]
fn a_motor_whose_voltage_and_motion_have_stamps_of_their_own_is_found_as_it_was() {
    let of =
        |voltage_s, motion_s, from_s, speed| Logged { voltage_s, motion_s, from_s, speed, changes: None };
    for (what, logged) in [
        ("half an interval apart", of(0.02, 0.02, 0.01, true)),
        ("an angle twice a voltage", of(0.02, 0.01, 0.003, false)),
        ("a voltage twice an angle", of(0.01, 0.02, 0.005, false)),
    ] {
        let records = records(&logged);
        assert_eq!(records.len(), 1, "{what}");
        let interval = (records[0].time_s[100] - records[0].time_s[0]) / 100.0;
        assert!((interval / logged.motion_s - 1.0).abs() < 1e-3, "{what}: the rows are those of the motion");
        let (gain, tau) = (found(&records, "gain"), found(&records, "tau_m"));
        assert!(
            (gain / GAIN - 1.0).abs() < 0.01 && (tau / TAU_S - 1.0).abs() < 0.03,
            "{what}: {gain}, {tau}"
        );
        let said = &records[0].warnings;
        assert!(said.len() == 1 && said[0].what.contains("counts by its time"), "{what}: {said:?}");
    }
}

#[test]
fn a_motion_that_is_logged_when_it_changes_stands_still_where_it_does_not() {
    for (speed, steps) in [(false, 210.0), (true, 10.0)] {
        let records =
            records(&Logged { voltage_s: 0.02, motion_s: 0.02, from_s: 0.0, speed, changes: Some(steps) });
        assert_eq!(records.len(), 1, "speed {speed}: {:?}", records[0].warnings);
        let tau = found(&records, "tau_m");
        assert!((tau / TAU_S - 1.0).abs() < 0.03, "speed {speed}: {tau}");
    }
}
