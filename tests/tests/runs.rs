//! Runs that do not begin or end as they should, between the host's capture and the board's own program, with no line but memory.
//!
//! A shaft that still turns when a run is to begin: the host has it begun again for up to a minute, and a stop ends that at once. A board
//! that loses its power in a run.

// What the firmware's own tests run on; they use more of it.
#[allow(dead_code)]
#[path = "../../firmware/tests/bench/mod.rs"]
mod bench;

use std::time::Duration;

use bench::{Bench, Cable};
use motorlens::device::{Capture, Captured, Fault};
use motorlens_firmware::control::Control;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, Reset, RunState, Setup};
use motorlens_virtual_motor::Bridge;

/// A turn of both ends, and a sampling period.
const TURN_US: u32 = 1000;
const SECOND_US: u32 = 1_000_000;
/// The board answers within some turns.
const AT_ONCE_US: u32 = 20 * TURN_US;
/// Samples of a run, which takes a second.
const SAMPLES: usize = 1000;
const FIRST: u32 = 100;

/// A board whose shaft is turned by something else until then.
struct Talk {
    bench: Bench,
    line: Cable,
    turns_until_us: u32,
    /// When the board loses its power for a moment, and with it all that it knows.
    restarts_us: Option<u32>,
    at_us: u32,
}

impl Talk {
    fn new(turns_until_us: u32) -> Self {
        let bench = Bench::new(&[]);
        bench.control(|control| control.hardware_mut().cranked_until_us = turns_until_us);
        Self { bench, line: Cable::default(), turns_until_us, restarts_us: None, at_us: 0 }
    }

    /// A turn of the board; the bridge is off as long as the shaft is turned.
    fn turn(&mut self) {
        self.at_us += TURN_US;
        self.bench.run_on(TURN_US);
        self.bench.control(Control::tick);
        self.bench.station.poll(&mut self.line, self.bench.control, &mut self.bench.rest);
        let bridge = self.bench.control(|control| control.hardware_mut().bridge);
        assert!(
            self.at_us >= self.turns_until_us || bridge == Bridge::Floating,
            "driven at {} us",
            self.at_us
        );
    }

    /// Follows a run to its end; the host is stopped so long after the talk's begin.
    fn follow(&mut self, capture: &mut Capture, stop_us: Option<u32>) -> Result<Captured, Fault> {
        let began_us = self.at_us;
        while self.at_us - began_us < 100 * SECOND_US {
            self.turn();
            if self.restarts_us == Some(self.at_us) {
                (self.bench, self.line) = (Bench::new(&[]), Cable::default());
            }
            let now = Duration::from_micros((self.at_us - began_us).into());
            let received: Vec<u8> = self.line.to_host.drain(..).collect();
            capture.receive(&received, now);
            if stop_us == Some(self.at_us) {
                capture.stop(now);
            }
            let mut send = Vec::new();
            capture.poll(now, &mut send);
            self.line.to_board.extend(send);
            if let Some(outcome) = capture.take_outcome() {
                return outcome;
            }
        }
        panic!("a run that has no end");
    }
}

fn capture(run: u32) -> Capture {
    Capture::new(Setup::default(), &Programme::single("push", Shape::Step { level_v: 6.0 }, 1.0), run)
}

#[test]
fn a_shaft_that_swings_for_fifteen_seconds_is_waited_for_and_the_next_run_has_a_number_of_its_own() {
    let mut talk = Talk::new(15 * SECOND_US);
    let mut patient = capture(FIRST).patient();
    assert!(!patient.waits());
    let captured = talk.follow(&mut patient, None).expect("the run goes through");
    // It was begun after 0, 6 and 12 seconds.
    assert_eq!((patient.run(), captured.status.run), (FIRST + 2, FIRST + 2));
    assert_eq!((captured.cause, captured.samples.len(), captured.holes.len()), (Cause::Finished, SAMPLES, 0));
    assert!((15 * SECOND_US..17 * SECOND_US).contains(&talk.at_us), "{} us", talk.at_us);
    assert!(!patient.waits());
    let mut next = capture(patient.run() + 1).patient();
    let captured = talk.follow(&mut next, None).expect("the run goes through");
    assert_eq!((captured.cause, captured.samples.len()), (Cause::Finished, SAMPLES));
    assert_ne!(captured.status.run, patient.run());
}

#[test]
fn a_shaft_that_never_stops_is_waited_for_a_minute_and_not_at_all_by_who_has_no_patience() {
    for (capture, seconds, again) in [(capture(FIRST).patient(), 60..67, 9), (capture(FIRST), 6..7, 0)] {
        let (mut talk, mut capture) = (Talk::new(u32::MAX), capture);
        let refused = talk.follow(&mut capture, None).expect("the board says what is wrong");
        assert_eq!((refused.cause, refused.samples.len(), refused.status.next), (Cause::Turning, 0, 0));
        assert!(seconds.contains(&(talk.at_us / SECOND_US)), "{} us", talk.at_us);
        assert_eq!((capture.run() - FIRST, capture.waits()), (again, again > 0));
    }
}

#[test]
fn a_stop_ends_the_waiting_at_once_whenever_it_comes() {
    // In the midst of an attempt, and at each moment from one to the next.
    let moments = (5_990..6_040).chain([20_000]).map(|ms| ms * TURN_US);
    for stop_us in moments {
        let mut talk = Talk::new(u32::MAX);
        let ended = talk.follow(&mut capture(FIRST).patient(), Some(stop_us));
        assert!(
            talk.at_us - stop_us <= AT_ONCE_US,
            "stopped at {stop_us} us, and ended at {} us",
            talk.at_us
        );
        match ended {
            Ok(captured) => assert_eq!((captured.cause, captured.samples.len()), (Cause::Asked, 0)),
            Err(fault) => assert_eq!(fault, Fault::Stopped),
        }
        // Nothing begins behind the host's back.
        for _ in 0..100 {
            talk.turn();
            let state = talk.bench.control(|control| control.status().state);
            assert!(matches!(state, RunState::Stopped(_)), "stopped at {stop_us} us, and {state:?}");
        }
    }
}

#[test]
fn a_board_that_loses_its_power_in_a_run_ends_it_and_leaves_the_log_so_far() {
    for stop_us in [None, Some(620 * TURN_US)] {
        let mut talk = Talk { restarts_us: Some(600 * TURN_US), ..Talk::new(0) };
        let mut capture = capture(FIRST).patient();
        let fault = talk.follow(&mut capture, stop_us).expect_err("the board has lost the run");
        assert_eq!(fault, Fault::Forgotten(Reset::PowerOn));
        assert!(talk.at_us < 2 * SECOND_US, "{} us", talk.at_us);
        let kept = capture.so_far().expect("what had come");
        assert!((300..SAMPLES).contains(&kept.samples.len()), "{} samples", kept.samples.len());
    }
}
