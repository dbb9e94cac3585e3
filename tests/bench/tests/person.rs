//! What a person without hardware does: starts the bench with something hidden, captures, fits on the board, discovers.

use std::collections::BTreeSet;
use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use std::time::Duration;
use std::{env, fs, thread};

use motorlens_virtual_motor::Motor;
use serde_json::Value;

/// Virtual seconds in a second. Half of the link's timeout is then 125 ms on the wall: a busy machine keeps up.
const SPEED: &str = "2";

/// A running bench; it ends with the test.
struct Bench {
    child: Child,
    address: String,
    counts_per_rev: String,
}

impl Bench {
    fn start(hidden: &[&str]) -> Self {
        let mut child = bench(hidden)
            .args(["--port", "0", "--speed", SPEED])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the bench starts");
        let mut line = String::new();
        let said = child.stdout.take().expect("piped above");
        BufReader::new(said).read_line(&mut line).expect("the bench says where it is");
        let word = |after: &str| {
            let rest = line.split_once(after).expect("the bench's line").1;
            rest.split([';', '\n']).next().expect("one word at least").trim().to_owned()
        };
        let (address, counts_per_rev) = (word("answers at "), word("--counts-per-rev "));
        Bench { child, address, counts_per_rev }
    }

    /// `motorlens VERB... --port ... --json`.
    fn program(&self, verb: &[&str]) -> Command {
        let mut command = program(verb);
        command.args(["--port", &self.address]);
        command
    }
}

/// A line between program and bench that can be pulled out and plugged in again.
struct Extension {
    address: String,
    plugged: Arc<AtomicBool>,
    /// Bytes that came from the board.
    carried: Arc<AtomicUsize>,
}

impl Extension {
    fn to(bench: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp://{}", listener.local_addr().expect("bound above"));
        let (plugged, carried) = (Arc::new(AtomicBool::new(true)), Arc::new(AtomicUsize::new(0)));
        let bench = bench.trim_start_matches("tcp://").to_owned();
        let (state, count) = (Arc::clone(&plugged), Arc::clone(&carried));
        // Ends with the test's process.
        thread::spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                if state.load(Relaxed) {
                    let far = TcpStream::connect(&bench).expect("the bench is there");
                    let nobody = Arc::new(AtomicUsize::new(0));
                    for (from, to, count) in [(&near, &far, &nobody), (&far, &near, &count)] {
                        let ends = (from.try_clone().expect("a socket"), to.try_clone().expect("a socket"));
                        let (state, count) = (Arc::clone(&state), Arc::clone(count));
                        thread::spawn(move || carry(ends, &state, &count));
                    }
                }
            }
        });
        Extension { address, plugged, carried }
    }

    /// Waits until the board has said so much; a second of log at 1 kHz is about 12 KiB.
    fn wait_for(&self, bytes: usize) {
        while self.carried.load(Relaxed) < bytes {
            thread::sleep(Duration::from_millis(5));
        }
    }

    fn plug(&self, plugged: bool) {
        self.plugged.store(plugged, Relaxed);
    }
}

/// Copies bytes until either end closes or the plug is out; then closes both.
fn carry((mut from, mut to): (TcpStream, TcpStream), plugged: &AtomicBool, carried: &AtomicUsize) {
    from.set_read_timeout(Some(Duration::from_millis(5))).expect("a socket");
    let mut buffer = [0; 4096];
    while plugged.load(Relaxed) {
        match from.read(&mut buffer) {
            Ok(length) if length > 0 && to.write_all(&buffer[..length]).is_ok() => {
                carried.fetch_add(length, Relaxed);
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            _ => break,
        }
    }
    // Closed already, where the other direction was first.
    let _ = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
}

impl Drop for Bench {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to end.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// With `hidden`, the effects by number or by name.
fn bench(hidden: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motorlens-bench"));
    command.arg("--image").arg(motorlens_bench::machine::image()).args(hidden);
    command
}

fn program(verb: &[&str]) -> Command {
    let program = env::var_os("MOTORLENS_PROGRAM")
        .expect("MOTORLENS_PROGRAM names the host program; run the bench by `cargo xtask test --only bench`");
    let mut command = Command::new(program);
    command.args(verb).args(["--json", "--quiet"]);
    command
}

fn json(mut command: Command) -> Value {
    let output = command.stderr(Stdio::inherit()).output().expect("the program starts");
    assert!(output.status.success(), "{command:?}: {}", output.status);
    serde_json::from_slice(&output.stdout).expect("one document")
}

fn fresh_directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&directory);
    directory
}

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
    let mut capture = bench.program(&["capture", "--divider", "11", "--amplifier", "165"]);
    capture.args(["--programme", "default", "--counts-per-rev", &bench.counts_per_rev, "--out"]).arg(&out);
    let captured = json(capture);
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
fn the_board_fits_the_run_that_it_holds_and_finds_the_motor() {
    let out = fresh_directory("device-fit");
    let bench = Bench::start(&["--effect", "coulomb=0.4"]);
    let mut capture = bench.program(&["capture", "--programme", "multisine", "--seconds", "2"]);
    capture.args(["--counts-per-rev", &bench.counts_per_rev, "--out"]).arg(&out);
    json(capture);
    let mut fit = bench.program(&["device", "fit", "--coulomb"]);
    fit.args(["--counts-per-rev", &bench.counts_per_rev]);
    let fit = json(fit);
    let gain = fit["fit"]["gain"]["value"].as_f64().expect("a number");
    let truth = Motor::paper().gain();
    assert!((gain / truth - 1.0).abs() < 0.05, "{gain} on the board for {truth} rad/s per V");
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
