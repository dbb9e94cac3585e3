//! A run begins when the shaft stands still, and not before.

use crate::{assert_off, pass_attended, ready, samples, sine, start, status};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, RunState, Setup, ToBoard};

#[test]
fn a_run_begins_when_the_motor_has_rolled_out_and_counts_go_on_from_run_to_run() {
    let mut bench = ready(Setup::default(), &[]);
    let push = Programme::single("push", Shape::Step { level_v: 8.0 }, 1.0);
    start(&mut bench, &push, 1);
    pass_attended(&mut bench, 1.2);
    let rolling = status(&mut bench);
    assert_eq!((rolling.state, rolling.next), (RunState::Stopped(Cause::Finished), 1000));
    bench.heard.clear();
    start(&mut bench, &push, 2);
    pass_attended(&mut bench, 0.5);
    let waiting = status(&mut bench);
    assert_eq!((waiting.state, waiting.run, waiting.next), (RunState::Running, 2, 0));
    assert_off(&bench);
    pass_attended(&mut bench, 8.0);
    let log = samples(&bench);
    assert_eq!(log.len(), 1000);
    assert!(log[0].count > 500, "where the first run ended, and not zero: {}", log[0].count);
    // From rest the motor is slow at first.
    assert!((log[1].count - log[0].count).abs() <= 1, "{:?}", &log[..2]);
}

#[test]
fn a_run_waits_for_a_shaft_that_turns_for_three_seconds() {
    let mut bench = ready(Setup::default(), &[]);
    bench.control(|control| control.hardware_mut().cranked_until_us = 3_000_000);
    start(&mut bench, &sine(1.0), 7);
    for _ in 0..30 {
        pass_attended(&mut bench, 0.1);
        assert_off(&bench);
    }
    let waiting = status(&mut bench);
    assert_eq!((waiting.state, waiting.run, waiting.next), (RunState::Running, 7, 0));
    pass_attended(&mut bench, 1.5);
    let ended = status(&mut bench);
    assert_eq!((ended.state, ended.next), (RunState::Stopped(Cause::Finished), 1000));
}

#[test]
fn a_shaft_that_turns_for_ever_is_not_driven_and_each_host_is_told_so_in_words_that_it_has() {
    for rate_hz in [100, 1000, 2000] {
        let setup = Setup { rate_hz, link_timeout_ms: 250, ..Setup::default() };
        let mut bench = ready(setup, &[]);
        bench.control(|control| control.hardware_mut().cranked_until_us = u32::MAX);
        start(&mut bench, &sine(1.0), 7);
        for _ in 0..59 {
            pass_attended(&mut bench, 0.1);
            assert_off(&bench);
        }
        assert_eq!(status(&mut bench).state, RunState::Running, "{rate_hz} Hz: it waits");
        for _ in 0..5 {
            pass_attended(&mut bench, 0.1);
            assert_off(&bench);
        }
        for (newest, cause) in [(1, Cause::RunLimit), (4, Cause::RunLimit), (5, Cause::Turning)] {
            bench.ask(ToBoard::Hello { oldest: 1, newest });
            let told = status(&mut bench);
            assert_eq!((told.state, told.run, told.next), (RunState::Stopped(cause), 7, 0));
        }
        // Somebody holds it.
        bench.control(|control| {
            let rig = control.hardware_mut();
            rig.cranked_until_us = rig.now_us;
        });
        start(&mut bench, &sine(1.0), 8);
        pass_attended(&mut bench, 1.3);
        assert_eq!(status(&mut bench).state, RunState::Stopped(Cause::Finished));
    }
}

#[test]
fn the_emergency_input_ends_the_wait_for_the_motor_too() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(1.0), 1);
    bench.pass(0.05);
    bench.control(|control| control.hardware_mut().emergency = true);
    bench.pass(0.01);
    assert_eq!(status(&mut bench).state, RunState::Stopped(Cause::Emergency));
}
