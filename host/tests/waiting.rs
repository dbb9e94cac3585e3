//! A shaft that still turns when a run is to begin: what `capture` says and does, and that it holds back boards of before version 5 of the
//! link, which would begin the run in spite of it.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::Stdio;
use std::time::Duration;

use motorlens::device::{Capture, Captured, Fault, WAITING};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, NEWEST, Setup};

mod program;
mod scripted_board;

use program::{command, files, run};
use scripted_board::{BEGINS_TURNING, Board, SAMPLES};

const FIRST: u32 = 100;
/// A turn of both ends.
const TURN: Duration = Duration::from_millis(10);
/// The longest that a talk may take.
const END: Duration = Duration::from_secs(100);

fn push() -> Programme {
    Programme::single("push", Shape::Step { level_v: 6.0 }, 1.0)
}

fn capture() -> Capture {
    Capture::new(Setup::default(), &push(), FIRST)
}

/// Follows a run to its end, in virtual time; what came of it, and how long it took.
fn follow(board: &mut Board, capture: &mut Capture) -> (Result<Captured, Fault>, Duration) {
    let (mut now, mut send) = (Duration::ZERO, Vec::new());
    while now < END {
        now += TURN;
        let said = board.turn(now, &send);
        send.clear();
        capture.receive(&said, now);
        capture.poll(now, &mut send);
        if let Some(outcome) = capture.take_outcome() {
            return (outcome, now);
        }
    }
    panic!("a run that has no end")
}

#[test]
fn a_board_that_would_begin_a_run_in_motion_is_stopped_before_and_asked_again() {
    for newest in BEGINS_TURNING {
        let mut board = Board::new(newest, Duration::from_secs(12));
        let mut capture = capture().patient();
        let captured = follow(&mut board, &mut capture).0.expect("the run goes through");
        assert_eq!((captured.cause, captured.samples.len()), (Cause::Finished, SAMPLES as usize));
        // It was begun after 0, 5 and 10 seconds.
        assert_eq!((board.starts, board.stops, capture.run()), (3, 2, FIRST + 2), "version {newest}");
        assert!(!board.begun_turning && !capture.waits(), "version {newest}");
    }
}

#[test]
fn a_shaft_that_never_rests_is_not_driven_by_a_board_that_would_begin_all_the_same() {
    for (capture, seconds) in [(capture().patient(), 60..67), (capture(), 5..6)] {
        let (mut board, mut capture) = (Board::new(*BEGINS_TURNING.end(), Duration::MAX), capture);
        let (refused, took) = follow(&mut board, &mut capture);
        let refused = refused.expect("the host says what is wrong");
        assert_eq!((refused.cause, refused.samples.len()), (Cause::Turning, 0));
        assert!(seconds.contains(&took.as_secs()) && !board.begun_turning, "{took:?}");
    }
}

#[test]
fn who_stops_the_run_while_the_board_is_stopped_for_the_shaft_waits_no_longer() {
    let (mut board, mut capture) = (Board::new(*BEGINS_TURNING.end(), Duration::MAX), capture().patient());
    let (mut now, mut send, mut asked) = (Duration::ZERO, Vec::new(), false);
    let captured = loop {
        now += TURN;
        assert!(now < END, "a run that has no end");
        let said = board.turn(now, &send);
        send.clear();
        if board.stops == 1 && !std::mem::replace(&mut asked, true) {
            capture.stop(now);
        }
        capture.receive(&said, now);
        capture.poll(now, &mut send);
        if let Some(outcome) = capture.take_outcome() {
            break outcome.expect("it ends as it was asked to");
        }
    };
    assert_eq!((captured.cause, captured.samples.len(), board.starts), (Cause::Asked, 0, 1));
    assert!(!board.begun_turning);
}

#[test]
fn no_board_is_stopped_in_a_run_that_has_begun_nor_one_that_ends_its_wait_by_itself() {
    let (swings, takes) = (Duration::from_secs(3), Duration::from_secs(20));
    let mut old = Board::new(*BEGINS_TURNING.end(), swings).running_for(takes);
    let captured = follow(&mut old, &mut capture()).0.expect("the run goes through");
    assert_eq!((captured.cause, old.starts, old.stops), (Cause::Finished, 1, 0));
    let mut new = Board::new(NEWEST, Duration::from_secs(8));
    let captured = follow(&mut new, &mut capture().patient()).0.expect("the run goes through");
    assert_eq!((captured.cause, new.starts, new.stops), (Cause::Finished, 2, 0));
}

/// The words of a `capture` of one programme from this port, which it writes into `directory`.
fn words(directory: &Path, port: &str) -> String {
    let programme = serde_json::to_string(&push()).expect("a programme is JSON");
    std::fs::write(directory.join("push.json"), programme).expect("the directory is there");
    format!("capture --port {port} --programme push.json --counts-per-rev 1000 --out logs")
}

#[test]
fn capture_says_once_that_the_shaft_still_turns_and_saves_the_run_that_follows() {
    for (turns_ms, said) in [(1500, 1), (0, 0)] {
        let directory = tempfile::tempdir().expect("a directory");
        let here = directory.path();
        let board = Board::new(NEWEST, Duration::from_millis(turns_ms));
        let (port, board) = board.waiting_for(Duration::from_millis(200)).serve();
        let told = run(here, &words(here, &port)).ends(0);
        let board = board.join().expect("the board answers to the end");
        assert_eq!(told.err.matches(WAITING).count(), said, "{}", told.err);
        // More than one wait, where there is one to be told of.
        assert!(if said == 0 { board.starts == 1 } else { board.starts > 2 }, "{} starts", board.starts);
        let logs = files(&here.join("logs"));
        let [log] = logs.as_slice() else { panic!("one log: {logs:?}") };
        let log = std::fs::read_to_string(log).expect("a log");
        let samples = log.lines().filter(|line| line.starts_with(|c: char| c.is_ascii_digit())).count();
        assert_eq!(samples, SAMPLES as usize, "{log}");
    }
}

#[test]
fn ctrl_c_ends_the_waiting_and_leaves_no_log() {
    let directory = tempfile::tempdir().expect("a directory");
    let here = directory.path();
    // By when the program has long begun to listen for Ctrl-C.
    let (port, board) = Board::new(NEWEST, Duration::MAX).waiting_for(Duration::from_secs(1)).serve();
    let mut capture = command(here, &words(here, &port));
    let mut capture =
        capture.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("the program starts");
    let mut lines = BufReader::new(capture.stderr.take().expect("piped above")).lines();
    let waits = lines.by_ref().map_while(Result::ok).any(|line| line.contains(WAITING));
    assert!(waits, "the program ended without a word of the shaft");
    let id = capture.id().to_string();
    assert!(std::process::Command::new("kill").args(["-INT", &id]).status().expect("kill runs").success());
    let said: Vec<String> = lines.map_while(Result::ok).collect();
    let status = capture.wait().expect("it ends by itself");
    let board = board.join().expect("the board answers to the end");
    assert_eq!(status.code(), Some(4), "{said:?}");
    let said = said.join("\n");
    assert!(said.contains("stopped") && said.contains("nothing was logged"), "{said}");
    assert!(files(&here.join("logs")).is_empty() && board.stops > 0 && !board.begun_turning);
}
