//! What a person without hardware does: starts the bench with something hidden, captures, fits on the board, discovers.
//!
//! The commands for a board are those that README, docs and book print, with the bench's port.

use std::collections::BTreeSet;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::Duration;
use std::{fs, thread};

use motorlens_shared::excitation::{Programme, Shape};
use motorlens_virtual_motor::Motor;
use serde_json::Value;

#[path = "../../../documented.rs"]
mod documented;
mod hands;

use hands::{Bench, Extension, bench, fresh_directory, json, program, root};

/// The printed commands by what is the same in all of them; the last is run on an emulated Uno (`xtask/src/avr.rs`).
const CHECK: &str = "device check --port PORT";
const CHECK_DRIVER: &str = "device check --port PORT --drive brake --supply 12";
const CAPTURE: &str = "capture --port PORT --programme default --counts-per-rev COUNTS --out DIR";
const CAPTURE_WIRED: &str =
    "capture --port PORT --programme default --divider 11 --amplifier 165 --counts-per-rev COUNTS --out DIR";
const CAPTURE_PLANNED: &str =
    "capture --port PORT --programme programme.json --counts-per-rev COUNTS --out DIR";
const FIT: &str = "device fit --port PORT --counts-per-rev COUNTS --coulomb";
const LISTEN: &str = "capture --listen --port PORT --supply 12 --counts-per-rev COUNTS --out DIR";

/// Names of the effects that a number hides. The board measures its supply, so the log's voltage holds the sag already.
fn revealed(number: &str) -> BTreeSet<String> {
    let output = bench(&["--hidden", number, "--reveal"]).output().expect("the bench starts");
    let told = String::from_utf8(output.stdout).expect("text");
    let names = told.split_whitespace().filter_map(|word| word.split_once('=')).map(|(name, _)| name);
    let first = names.filter_map(|name| name.rsplit(',').next()).map(str::to_owned);
    first.filter(|name| name != "supply_sag").collect()
}

/// Captures the default protocol and discovers: `truth` by name, and an error of at most twice the floor.
fn discovers(hidden: &[&str], truth: &BTreeSet<String>) {
    let out = fresh_directory(&format!("hidden{}", hidden.join("-").replace(['=', ','], "-")));
    let bench = Bench::start(hidden);
    let captured = json(bench.printed(CAPTURE_WIRED, &out));
    let logs = captured["logs"].as_array().expect("a list");
    assert_eq!(logs.len(), 7);
    for log in logs {
        assert_eq!((&log["samples"], &log["missing"]), (&Value::from(8000), &Value::from(0)), "{log}");
    }
    let mut discover = program(&["discover"]);
    for log in logs {
        let path = log["log"].as_str().expect("a path");
        let held_out = path.contains("holdout");
        discover.args(held_out.then_some("--validate")).arg(path);
    }
    let found = json(discover);
    let named = found["effects"].as_array().expect("a list").iter().filter_map(Value::as_str);
    let named: BTreeSet<String> = named.map(str::to_owned).collect();
    let floor = found["noise_floor_rad"].as_f64().expect("a number");
    let ladder = found["ladder"].as_array().expect("a list");
    let unseen = |rung: &Value| rung["validation"]["rmse"].as_f64().expect("a number");
    let (before, after) = (unseen(&ladder[0]), unseen(&ladder[ladder.len() - 1]));
    println!("{hidden:?}: found {named:?}, unseen error {before:.2e} -> {after:.2e}, floor {floor:.2e} rad");
    assert_eq!(named, *truth);
    assert!(after <= 2.0 * floor, "{after} rad is more than twice the floor of {floor}");
}

#[test]
fn capture_and_discover_find_what_a_number_hides() {
    let number = "7";
    discovers(&["--hidden", number], &revealed(number));
}

#[test]
fn capture_and_discover_find_frictions_under_which_the_usual_model_is_far_off() {
    let effects = ["load_friction=0.12", "coulomb_asymmetric=0.43,asymmetry=-0.38"];
    let names = effects.map(|effect| effect.split('=').next().expect("a name first").to_owned());
    discovers(&["--effect", effects[0], "--effect", effects[1]], &BTreeSet::from(names));
}

#[test]
fn the_readmes_commands_check_the_wires_capture_and_fit_on_the_board_as_they_are_printed() {
    let out = fresh_directory("readme");
    let bench = Bench::start(&["--effect", "coulomb=0.4"]);
    assert_eq!(bench.counts_per_rev, "5000", "as the README has it");
    let checked = json(bench.printed(CHECK, &out));
    assert_eq!(checked["ok"], true, "{checked}");
    let captured = json(bench.printed(CAPTURE, &out));
    let logs = captured["logs"].as_array().expect("a list");
    assert!(logs.len() == 7 && logs.iter().all(|log| log["missing"] == 0), "{captured}");
    let fit = json(bench.printed(FIT, &out));
    let gain = fit["fit"]["gain"]["value"].as_f64().expect("a number");
    let truth = Motor::paper().gain();
    assert!((gain / truth - 1.0).abs() < 0.05, "{gain} on the board for {truth} rad/s per V");
    // The README says 0.7 s.
    let micros = fit["fit"]["micros"].as_u64().expect("a number");
    assert!(micros < 800_000, "{micros} us");
}

#[test]
fn the_books_command_plays_a_programme_that_was_planned() {
    let out = fresh_directory("planned");
    fs::create_dir_all(&out).expect("a directory");
    let step = Programme::single("planned", Shape::Step { level_v: 6.0 }, 1.0);
    let step = serde_json::to_string(&step).expect("a programme is JSON");
    fs::write(out.join("programme.json"), step).expect("the directory is there");
    let bench = Bench::start(&["--hidden", "1"]);
    let mut capture = bench.printed(CAPTURE_PLANNED, &out);
    capture.current_dir(&out);
    let captured = json(capture);
    assert_eq!((&captured["logs"][0]["samples"], &captured["logs"][1]), (&Value::from(1000), &Value::Null));
}

#[test]
fn every_command_for_a_board_that_a_document_prints_is_run_as_it_is_printed() {
    let run = [CHECK, CHECK_DRIVER, CAPTURE, CAPTURE_WIRED, CAPTURE_PLANNED, FIT, LISTEN];
    let printed: BTreeSet<String> = documented::lines(&root()).iter().map(documented::Line::shape).collect();
    assert_eq!(printed, run.map(str::to_owned).into_iter().collect());
}

#[test]
fn a_cable_pulled_for_two_seconds_ends_the_run_with_its_log_and_the_next_one_goes_through() {
    let out = fresh_directory("pulled");
    let bench = Bench::start(&["--hidden", "1"]);
    let cable = Extension::to(&bench.address);
    let capture = |seconds: &str| {
        let mut capture = program(&["capture", "--port", &cable.address, "--programme", "multisine"]);
        capture.args(["--seconds", seconds, "--counts-per-rev", &bench.counts_per_rev, "--out"]).arg(&out);
        capture
    };
    let running =
        capture("20").stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts");
    cable.wait_for(20_000);
    cable.plug(false);
    // More of the board's time than that.
    thread::sleep(Duration::from_secs(2));
    cable.plug(true);
    let ended = running.wait_with_output().expect("it ends by itself");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(4), "{said}");
    assert!(said.contains("link"), "{said}");
    let files: Vec<_> =
        fs::read_dir(&out).expect("made").map(|entry| entry.expect("a file").path()).collect();
    let [log] = files.as_slice() else { panic!("one log, and nothing half: {files:?}") };
    let log = fs::read_to_string(log).expect("the log so far is saved");
    let samples = log.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit())).count();
    assert!((500..19_000).contains(&samples), "{samples} samples: {said}");
    assert!(said.contains(&format!("{samples} samples")) && !log.contains("missing_samples"), "{said}");

    let again = json(capture("1"));
    assert_eq!(again["logs"][0]["samples"], 1000, "{again}");
}

#[test]
fn ctrl_c_stops_the_motor_at_once_and_saves_the_log() {
    let out = fresh_directory("interrupted");
    let bench = Bench::start(&["--hidden", "1"]);
    let cable = Extension::to(&bench.address);
    let mut capture = program(&["capture", "--port", &cable.address, "--programme", "multisine"]);
    capture.args(["--counts-per-rev", &bench.counts_per_rev, "--out"]).arg(&out);
    let running = capture.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts");
    cable.wait_for(20_000);
    let id = running.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    let ended = running.wait_with_output().expect("it ends by itself");
    let said = String::from_utf8_lossy(&ended.stderr);
    assert_eq!(ended.status.code(), Some(4), "{said}");
    assert!(said.contains("stopped on request"), "{said}");
    let files: Vec<_> =
        fs::read_dir(&out).expect("made").map(|entry| entry.expect("a file").path()).collect();
    let [log] = files.as_slice() else { panic!("one log, and nothing half: {files:?}") };
    let log = fs::read_to_string(log).expect("the log so far is saved");
    let samples = log.lines().filter(|line| line.starts_with(|first: char| first.is_ascii_digit())).count();
    assert!((500..7000).contains(&samples) && said.contains(&format!("{samples} samples")), "{said}");
    let status = json(bench.program(&["device", "hello"]))["status"].clone();
    assert_eq!(status["state"]["Stopped"], "asked");
}

#[test]
fn device_check_finds_the_bench_wired_right_and_where_its_motor_breaks_away() {
    let bench = Bench::start(&["--hidden", "1"]);
    let checked = json(bench.program(&["device", "check", "--divider", "11"]));
    assert!(checked["findings"].as_array().is_some_and(|all| all.iter().any(|one| one["check"] == "supply")));
    assert_eq!(checked["ok"], true, "{checked}");
    let stall = checked["stall_voltage_v"].as_f64().expect("it turned");
    assert!((0.1..4.0).contains(&stall), "{checked}");
    let checked = json(bench.printed(CHECK_DRIVER, Path::new("")));
    assert_eq!(checked["ok"], true, "{checked}");
    // A driver that is not of the kind that is stated does not follow.
    let mut other = bench.program(&["device", "check"]);
    other.args(["--drive", "in-in"]);
    let checked = json(other);
    assert_eq!(checked["ok"], false, "{checked}");
}

#[test]
fn a_capture_that_is_killed_leaves_no_half_file_and_a_board_that_stopped_and_answers() {
    let out = fresh_directory("killed");
    let bench = Bench::start(&["--hidden", "1"]);
    let cable = Extension::to(&bench.address);
    let mut capture = program(&["capture", "--port", &cable.address, "--programme", "multisine"]);
    capture.args(["--counts-per-rev", &bench.counts_per_rev, "--out"]).arg(&out);
    let mut capture = capture.stdout(Stdio::null()).spawn().expect("the program starts");
    cable.wait_for(10_000);
    capture.kill().expect("it still runs");
    capture.wait().expect("it ended");
    thread::sleep(Duration::from_secs(5));
    let left: Vec<_> = fs::read_dir(&out).expect("the directory was made").collect();
    assert!(left.is_empty(), "{left:?}");
    let status = json(bench.program(&["device", "hello"]))["status"].clone();
    assert_eq!(status["state"]["Stopped"], "link_loss");
    assert!(status["next"].as_u64() > Some(0), "the log is kept: {status}");
    assert_eq!(json(bench.program(&["device", "stop"]))["stopped"], true);
}
