//! WPILib data logs: of SysId, of several mechanisms, and of any other program.

use std::f64::consts::TAU;
use std::io::Write;
use std::path::Path;

use motorlens::log::{Format, ReadOptions, Record, read};

use super::formats_support::{Wpilog, canonical_columns};
use super::{as_csv, records, refusal, same, written};

/// The four tests of a real robot, in the layout of SysId's JSON; `None` where its logs are not beside the workspace.
fn robot() -> Option<serde_json::Value> {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data/frc-romi-left");
    if !data.is_dir() {
        // Written past the test harness, which would swallow it.
        let _ = std::io::stderr().write_all(b"SKIPPED: no logs at ../shared/data\n");
        return None;
    }
    let mut tests = serde_json::Map::new();
    for (number, (name, part)) in [
        ("slow-forward", "train"),
        ("slow-backward", "train"),
        ("fast-forward", "validation"),
        ("fast-backward", "train"),
    ]
    .into_iter()
    .enumerate()
    {
        let run =
            read(&data.join(part).join(format!("{name}.csv")), &ReadOptions::default()).unwrap().remove(0);
        let mut turns = 0.0;
        let rows: Vec<[f64; 4]> = (0..run.len())
            .map(|k| {
                let speed = run.speed_rad_s.as_ref().unwrap()[k] / TAU;
                turns += speed * (run.time_s[k] - run.time_s[k.saturating_sub(1)]);
                // Whole microseconds, as a data log has them.
                let time = ((100.0 * number as f64 + run.time_s[k]) * 1e6).round() * 1e-6;
                [time, run.voltage_v[k], turns, speed]
            })
            .collect();
        tests.insert(name.into(), serde_json::json!(rows));
    }
    Some(tests.into())
}

/// The tests as a robot's routine logs them: a value only when it changes, but for the velocity.
fn routine(tests: &serde_json::Value, state: &str, names: [&str; 3]) -> Vec<u8> {
    let mut file = Wpilog::new();
    let state = file.start(state, "string", "");
    let entries = names.map(|name| file.start(name, "double", "Rotation"));
    let mut before = [f64::NAN; 3];
    for (test, named) in [
        ("slow-forward", "Quasistatic-Forward"),
        ("slow-backward", "quasistatic-reverse"),
        ("fast-forward", "dynamic-forward"),
        ("fast-backward", "dynamic-reverse"),
    ] {
        let mut last = 0.0;
        for row in tests[test].as_array().unwrap() {
            let number = |k: usize| row[k].as_f64().unwrap();
            last = number(0);
            file.text(state, last, named);
            for k in 0..3 {
                if k == 2 || number(k + 1) != before[k] {
                    file.number(entries[k], last, number(k + 1));
                    before[k] = number(k + 1);
                }
            }
        }
        file.text(state, last + 1e-3, "none");
    }
    file.bytes
}

#[test]
fn a_wpilog_of_sysid_gives_the_records_of_its_json() {
    let Some(tests) = robot() else { return };
    let (_directory, path) = written("log.json", tests.to_string().as_bytes());
    let options = ReadOptions { format: Format::WpilibSysid, ..ReadOptions::default() };
    let expected = read(&path, &options).unwrap();
    assert_eq!(expected.len(), 4);
    for (state, names) in [
        ("sysid-test-state-drive", ["voltage-left-drive", "position-left-drive", "velocity-left-drive"]),
        (
            "/RealOutputs/Drive/SysIdState",
            [
                "/AdvantageKit/Drive/LeftAppliedVolts",
                "/AdvantageKit/Drive/LeftPositionRotations",
                "/AdvantageKit/Drive/LeftVelocityRotationsPerSec",
            ],
        ),
    ] {
        // No --format is needed: the content tells.
        let found = records("log.wpilog", &routine(&tests, state, names), "").unwrap();
        assert_eq!(found.len(), 4);
        for (found, expected) in found.iter().zip(&expected) {
            same(found, expected, 1e-9);
        }
    }
}

#[test]
fn several_mechanisms_in_one_wpilog_are_a_named_choice() {
    let mut file = Wpilog::new();
    for (mechanism, motor, begin) in [("arm", "joint-arm", 0.0), ("drive", "left-drive", 10.0)] {
        let state = file.start(&format!("sysid-test-state-{mechanism}"), "string", "");
        let entries =
            ["voltage", "position", "velocity"].map(|k| file.start(&format!("{k}-{motor}"), "double", ""));
        for k in 0..60 {
            let t = begin + 0.02 * f64::from(k);
            file.text(state, t, "dynamic-forward");
            for (entry, value) in entries.iter().zip([6.0, 0.1 * t, 0.1]) {
                file.number(*entry, t, value);
            }
        }
        file.text(state, begin + 2.0, "none");
    }
    let refused = refusal("log.wpilog", &file.bytes, "");
    assert!(refused.contains("arm (joint-arm), drive (left-drive)"), "{refused}");
    assert!(refused.contains("--map voltage=voltage-joint-arm:V"), "{refused}");
    let chosen = records("log.wpilog", &file.bytes, "voltage=voltage-left-drive:V").unwrap();
    assert_eq!(chosen.len(), 1);
    assert!(chosen[0].name.contains("left-drive") && chosen[0].time_s[0] >= 10.0, "{}", chosen[0].name);
}

/// Signals of two motors, logged when they change, beside one of no number.
fn free_log() -> Vec<u8> {
    let (_, columns) = canonical_columns();
    let mut file = Wpilog::new();
    file.start("/Pose", "struct:Pose2d", "");
    let other = file.start("NT:/Arm/encoderPosition", "double", "");
    let entries =
        ["NT:/Roller/appliedVoltage", "NT:/Roller/shaftAngle"].map(|name| file.start(name, "double", ""));
    let mut before = f64::NAN;
    for row in 0..columns[0].len() {
        let t = columns[0][row];
        file.number(other, t, 3.0);
        if columns[1][row] != before {
            file.number(entries[0], t, columns[1][row]);
            before = columns[1][row];
        }
        file.number(entries[1], t, columns[2][row]);
    }
    file.bytes
}

#[test]
fn a_wpilog_of_any_other_program_is_proposed_by_its_motors_and_read_by_its_entries() {
    let content = free_log();
    let refused = refusal("log.wpilog", &content, "");
    assert!(refused.contains("--map time=time_s"), "{refused}");
    assert!(
        refused.contains("voltage=NT:/Roller/appliedVoltage:V,angle=NT:/Roller/shaftAngle:rad"),
        "{refused}"
    );
    let found =
        records("log.wpilog", &content, "voltage=NT:/Roller/appliedVoltage,angle=NT:/Roller/shaftAngle")
            .unwrap();
    let expected = as_csv("");
    same(&found[0], &Record { speed_rad_s: None, ..expected }, 1e-6);
    let wrong = refusal("log.wpilog", &content, "voltage=NT:/Roller/volts:V,angle=NT:/Roller/shaftAngle");
    assert!(wrong.contains("there is no column \"NT:/Roller/volts\""), "{wrong}");
    assert!(wrong.contains("NT:/Roller/appliedVoltage"), "{wrong}");
}

#[test]
fn a_wpilog_that_was_cut_off_is_read_up_to_there_and_a_damaged_one_names_the_byte() {
    let content = free_log();
    let map = "voltage=NT:/Roller/appliedVoltage,angle=NT:/Roller/shaftAngle";
    let whole = records("log.wpilog", &content, map).unwrap().remove(0);
    let cut = records("log.wpilog", &content[..content.len() - 3], map).unwrap().remove(0);
    assert_eq!(cut.len(), whole.len() - 1);
    let damaged = refusal("log.wpilog", &content[..14], map);
    assert!(damaged.contains("damaged at byte 12"), "{damaged}");
    let mut version = content;
    version[7] = 9;
    assert!(refusal("log.wpilog", &version, map).contains("version is 9.0"));
}
