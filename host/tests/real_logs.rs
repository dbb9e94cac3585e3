//! Logs of real motors, as their owners published them: they are read in place, and their data quality problems are known.
//!
//! Most files are no part of this project. `MOTORLENS_DATA` names their directory; `../shared/data` beside the
//! workspace is tried otherwise. Where they are absent, each test says so and ends. Two rigs' logs are in `python/examples/data`.

use std::io::Write;
use std::path::{Path, PathBuf};

use motorlens::diagnose::discover::{Options, discover};
use motorlens::estimate::{self, Method, fit};
use motorlens::log::quantum::quantum;
use motorlens::log::{Format, ReadOptions, Record, check_usable, content_faults, read, suspicions};
use motorlens::motor_file::MotorFile;
use motorlens_shared::effects::Kind;

fn data(directory: &str) -> Option<PathBuf> {
    let root = std::env::var_os("MOTORLENS_DATA")
        .map_or_else(|| Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/data"), PathBuf::from);
    let found = root.join(directory);
    if found.is_dir() {
        return Some(found);
    }
    // Written past the test harness, which would swallow it.
    let message = format!("SKIPPED: no real logs at {} (set MOTORLENS_DATA)\n", found.display());
    let _ = std::io::stderr().write_all(message.as_bytes());
    None
}

fn one(path: &Path, map: &str) -> Record {
    let options = ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
    read(path, &options).unwrap_or_else(|error| panic!("{error}")).remove(0)
}

#[test]
fn the_teaching_rig_is_read_in_its_units_and_shows_its_encoder_step() {
    let Some(directory) = data("undcmotor-jl") else {
        return;
    };
    for (file, map, rows) in [
        ("DCmotor_prbs_open_exp.csv", "time=t,voltage=u,speed=y:deg/s", 4093),
        ("DCmotor_step_open_exp.csv", "time=t,voltage=u,speed=y:deg/s", 302),
        ("DCmotor_stairs_closed_exp.csv", "time=t,voltage=u,speed=y:deg/s", 450),
        ("DCmotor_step_closed_exp.csv", "time=t,voltage=u,angle=y:deg", 126),
        ("DCmotor_profile_closed_exp.csv", "time=t,voltage=u,angle=y:deg", 151),
    ] {
        let record = one(&directory.join(file), map);
        assert_eq!(record.len(), rows, "{file}");
        assert_eq!(record.warnings, [], "{file}");
        check_usable(&record).unwrap();
    }
    let prbs = one(&directory.join("DCmotor_prbs_open_exp.csv"), "time=t,voltage=u,speed=y:deg/s");
    let step = quantum(&prbs.speed_rad_s.unwrap()).unwrap().to_degrees();
    // 2800 counts a turn at 50 Hz.
    assert!((step - 360.0 / 2800.0 * 50.0).abs() < 0.01, "{step}");
}

#[test]
fn the_micromouse_is_read_despite_its_bad_fields_and_its_two_clocks() {
    let Some(directory) = data("micromouse") else {
        return;
    };
    for (prefix, unit) in [
        ("controllerDelayImpact1ms", "ms"),
        ("controllerDelayImpact2ms", "ms"),
        ("controllerDelayImpact5ms", "ms"),
        ("controllerDelayImpact10ms", "ms"),
        ("maxAccel1", "ms"),
        ("testPid1", "ms"),
        ("testPid2", "s"),
        ("testPid3", "s"),
        ("testPid4", "s"),
        ("testPid5", "s"),
        ("testPid6", "ms"),
        ("testPid7", "ms"),
        ("testPid8", "ms"),
    ] {
        for side in ["left", "right"] {
            let map = format!("time=time:{unit},voltage={side}Command:V/255*7.9,speed={side}Speed:rpm");
            let record = one(&directory.join(format!("{prefix}.csv")), &map);
            assert_eq!(content_faults(&record), [], "{prefix} {side}");
            let odd = match (prefix, side) {
                ("testPid4", _) => Some("line 442"),
                ("maxAccel1", _) => Some("line 56"),
                // A speed of 0.00 between 184.98 and 192.01 rpm.
                ("controllerDelayImpact10ms", "right") => Some("speed_rad_s"),
                _ => None,
            };
            let warnings = &record.warnings;
            assert_eq!(warnings.len(), usize::from(odd.is_some()), "{prefix}: {warnings:?}");
            for (warning, line) in warnings.iter().zip(odd) {
                assert!(warning.place.contains(line), "{prefix}: {}", warning.place);
            }
        }
    }
    let map = "time=time:ms,duty=motorCommand:255,supply=batteryVoltage:mV,speed=leftSpeedRpm:rpm";
    let sweep = one(&directory.join("wheelSpeedCalibration3.csv"), map);
    assert_eq!(content_faults(&sweep), []);
    assert!((sweep.voltage_v[0] + 254.0 / 255.0 * 7.931).abs() < 1e-9);
}

#[test]
fn the_servo_with_a_pendulum_gives_an_inferred_voltage() {
    let Some(directory) = data("bam-sts3250") else {
        return;
    };
    let options = ReadOptions { format: Format::BamJson, ..ReadOptions::default() };
    for (file, rows) in [
        ("2024-10-26_12h23m27.json", 286),
        ("2024-10-26_12h23m42.json", 96),
        ("2024-10-26_12h24m55.json", 273),
        ("2024-10-26_12h27m27.json", 273),
    ] {
        let record = read(&directory.join(file), &options).unwrap().remove(0);
        assert_eq!(record.len(), rows, "{file}");
        assert_eq!(content_faults(&record), [], "{file}");
        assert!(record.voltage_v.iter().all(|volts| volts.abs() <= 12.9), "{file}");
        let step = quantum(record.angle_rad.as_ref().unwrap());
        if let Some(step) = step {
            assert!((step - std::f64::consts::TAU / 4096.0).abs() < 1e-6, "{file}: {step}");
        }
    }
}

/// The logs that a clone has: they are read, and without faults.
#[test]
fn the_logs_of_the_examples_are_read() {
    let here = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/examples/data");
    let read = |file: &str| read(&here.join(file), &ReadOptions::default()).unwrap().remove(0);
    for (file, rows) in [
        ("bam-sts3250/up_and_down.json", 273),
        ("undcmotor-angle/train/profile.csv", 201),
        ("undcmotor-angle/train/stairs.csv", 225),
        ("undcmotor-angle/validation/step.csv", 50),
    ] {
        let record = read(file);
        assert_eq!(record.len(), rows, "{file}");
        assert_eq!(content_faults(&record), [], "{file}");
        check_usable(&record).unwrap();
    }
}

fn told(records: &[Record]) -> Vec<String> {
    suspicions(records).into_iter().map(|w| format!("{}: {}", w.place, w.what)).collect()
}

#[test]
fn faults_of_real_data_are_told_and_none_is_made_up() {
    if let Some(directory) = data("undcmotor-jl") {
        let map = "time=t,voltage=u,speed=y:deg/s";
        let records =
            ["prbs", "step"].map(|n| one(&directory.join(format!("DCmotor_{n}_open_exp.csv")), map));
        println!("undcmotor-jl: {:#?}", told(&records));
        assert!(!told(&records).iter().any(|t| t.contains("stale") || t.contains("lost_counts")));
    }
    if let Some(directory) = data("micromouse") {
        let options = ReadOptions {
            map: Some("time=time:ms,duty=leftCommand:255,speed=leftSpeed:rpm".parse().unwrap()),
            supply_volts: Some(7.9),
            ..ReadOptions::default()
        };
        let read = |n: u32| {
            let path = directory.join(format!("controllerDelayImpact{n}ms.csv"));
            read(&path, &options).unwrap_or_else(|error| panic!("{error}")).remove(0)
        };
        let told = told(&[1, 2, 5, 10].map(read));
        println!("micromouse: {told:#?}");
        let commanded = told.iter().filter(|t| t.contains("commanded_voltage")).count();
        assert_eq!(commanded, 4, "a duty times one voltage, in every file: {told:#?}");
    }
    if let Some(directory) = data("bam-sts3250") {
        let options = ReadOptions { format: Format::BamJson, ..ReadOptions::default() };
        let record = read(&directory.join("2024-10-26_12h23m27.json"), &options).unwrap().remove(0);
        let told = told(&[record]);
        println!("bam-sts3250: {told:#?}");
        assert!(told.iter().any(|t| t.contains("commanded_voltage") && t.contains("inferred")), "{told:#?}");
    }
}

/// A motor's logs, the effects that its owners name, and the share of the error of the usual model (kS-kV-kA) on an unseen
/// record that may be left with them.
struct Owned {
    directory: &'static str,
    fitted: &'static [&'static str],
    unseen: &'static str,
    options: ReadOptions,
    named: &'static [Kind],
    share: f64,
}

fn owned() -> [Owned; 4] {
    let map = |map: &str| ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() };
    [
        Owned {
            directory: "undcmotor-jl",
            fitted: &["DCmotor_prbs_open_exp.csv"],
            unseen: "DCmotor_step_open_exp.csv",
            options: map("time=t,voltage=u,speed=y:deg/s"),
            named: &[Kind::Coulomb, Kind::Delay],
            share: 0.5,
        },
        Owned {
            directory: "micromouse",
            fitted: &[
                "controllerDelayImpact1ms.csv",
                "controllerDelayImpact2ms.csv",
                "controllerDelayImpact10ms.csv",
            ],
            unseen: "controllerDelayImpact5ms.csv",
            options: ReadOptions {
                supply_volts: Some(7.9),
                ..map("time=time:ms,duty=leftCommand:255,speed=leftSpeed:rpm")
            },
            // A dead band, as its owner calls it: wheels that stick before they turn.
            named: &[Kind::Coulomb],
            share: 0.95,
        },
        Owned {
            directory: "bam-sts3250",
            fitted: &["2024-10-26_12h23m27.json", "2024-10-26_12h23m42.json", "2024-10-26_12h24m55.json"],
            unseen: "2024-10-26_12h27m27.json",
            options: ReadOptions { format: Format::BamJson, ..ReadOptions::default() },
            // Its gear friction is no sure gain on these nine seconds, but expected.
            named: &[Kind::Gravity, Kind::Coulomb],
            share: 0.2,
        },
        Owned {
            directory: "frc-romi-left",
            fitted: &["train/fast-backward.csv", "train/slow-backward.csv", "train/slow-forward.csv"],
            unseen: "validation/fast-forward.csv",
            options: ReadOptions::default(),
            // By radio, which one step of three tests shows.
            named: &[Kind::Delay],
            share: 0.55,
        },
    ]
}

#[test]
fn the_effects_that_owners_name_are_found_and_unseen_runs_follow_better_than_the_usual_model() {
    for case in owned() {
        let Some(directory) = data(case.directory) else { continue };
        let read = |file: &&str| {
            read(&directory.join(file), &case.options).unwrap_or_else(|error| panic!("{error}")).remove(0)
        };
        let (fitted, unseen) = (case.fitted.iter().map(read).collect::<Vec<_>>(), [read(&case.unseen)]);
        let motor = MotorFile::default();
        let found = discover(&fitted, &unseen, &motor, &Options::default(), &mut |_| ()).unwrap();
        let usual = estimate::Options {
            method: Method::Feedforward,
            effects: Vec::new(),
            population: 80,
            generations: 800,
            seed: 1,
        };
        let usual = fit(&fitted, &unseen, &motor, &usual, &mut |_, _| ()).unwrap().validation.unwrap().rmse;
        let left = found.ladder.last().unwrap().validation.unwrap().rmse;
        let name = case.directory;
        let open = found.open_sets();
        let told = |kind: &Kind| found.effects.contains(kind) || open.iter().any(|set| set.contains(kind));
        assert!(case.named.iter().all(told), "{name}: {:?}, open {open:?}", found.effects);
        assert!(left < case.share * usual, "{name}: {left:.4} with {:?}, kS-kV-kA {usual:.4}", found.effects);
    }
}
