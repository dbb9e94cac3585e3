//! What ends a run before its programme, and how soon the bridge is off then.

use crate::bench::Bench;
use crate::{assert_off, pass_attended, ready, samples, sine, start, status};
use motorlens_firmware::beat::split;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, FromBoard, Reset, RunState, Setup, ToBoard};
use motorlens_virtual_motor::Bridge;

#[test]
fn every_fault_stops_the_motor_names_its_cause_and_keeps_the_log() {
    type Fault = fn(&mut Bench);
    // Slow, so that the motor draws little until something holds it.
    let rise = Programme::single("rise", Shape::Triangle { amplitude_v: 8.0, period_s: 4.0 }, 20.0);
    let faults: [(Setup, Fault, Cause); 5] = [
        (Setup::default(), |bench| bench.control(|c| c.hardware_mut().jammed = true), Cause::Stall),
        (Setup::default(), |bench| bench.control(|c| c.hardware_mut().emergency = true), Cause::Emergency),
        (Setup { run_limit_ms: 700, ..Setup::default() }, |_| (), Cause::RunLimit),
        (
            Setup { current_limit_ma: 800, amplifier: 1650, stall_ms: 0, ..Setup::default() },
            |bench| bench.control(|c| c.hardware_mut().motor.disturb(0.05)),
            Cause::OverCurrent,
        ),
        (Setup::default(), |bench| assert_eq!(bench.ask(ToBoard::Stop), FromBoard::Done), Cause::Asked),
    ];
    for (setup, fault, cause) in faults {
        let mut bench = ready(setup, &[]);
        start(&mut bench, &rise, 1);
        // A tenth of a second to see that the motor stands, then the run.
        pass_attended(&mut bench, 0.6);
        fault(&mut bench);
        pass_attended(&mut bench, 1.5);
        let status = status(&mut bench);
        assert_eq!(status.state, RunState::Stopped(cause));
        assert_off(&bench);
        assert!(status.next >= 500, "{cause:?}: {}", status.next);
        assert_eq!(samples(&bench).len() as u32, status.next, "{cause:?}");
    }
}

#[test]
fn silence_stops_the_motor_and_the_rest_of_the_log_comes_when_the_host_is_back() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(10.0), 1);
    pass_attended(&mut bench, 1.1);
    bench.heard.clear();
    bench.pass(2.0);
    assert_off(&bench);
    let status = status(&mut bench);
    assert_eq!(status.state, RunState::Stopped(Cause::LinkLoss));
    assert!((1390..1420).contains(&status.next), "{}", status.next);
    bench.heard.clear();
    bench.send(ToBoard::ReadLog { first: status.oldest, count: 256 });
    bench.send(ToBoard::ReadLog { first: status.next - 3, count: 5 });
    bench.pass(0.5);
    let blocks = bench.heard.iter().filter_map(|packet| match &packet.message {
        FromBoard::Log(block) => Some((block.first, block.samples.len() as u32)),
        FromBoard::NotHeld { first, count } => Some((u32::MAX - first, *count)),
        _ => None,
    });
    let blocks: Vec<_> = blocks.collect();
    assert_eq!(blocks.iter().take(64).map(|block| block.1).sum::<u32>(), 256);
    assert_eq!(blocks[64..], [(status.next - 3, 3), (u32::MAX - status.next, 2)]);
}

/// Runs until the bridge is off, `each` done every 25 us with the time since the first sample, us. Returns that time, of a run that this
/// cause has ended and whose log is whole.
fn off_at(setup: Setup, cause: Cause, each: impl Fn(&mut Bench, u32)) -> u32 {
    const STEP_US: u32 = 25;
    // The log of the fastest sampling lasts half a second.
    let setup = Setup { link_timeout_ms: 250, ..setup };
    let (beats, apart_us) = split(1_000_000 / u32::from(setup.rate_hz));
    let mut bench = ready(setup, &[]);
    let rise = Programme::single("rise", Shape::Triangle { amplitude_v: 8.0, period_s: 4.0 }, 20.0);
    start(&mut bench, &rise, 1);
    while bench.control(|control| control.hardware_mut().bridge) == Bridge::Floating {
        bench.pass(1.0 / f64::from(setup.rate_hz));
    }
    let ended = (STEP_US..1_000_000).step_by(STEP_US as usize).find(|now| {
        bench.run_on(STEP_US);
        each(&mut bench, *now);
        if now.is_multiple_of(apart_us) {
            let sampling = now.is_multiple_of(beats * apart_us);
            assert_eq!(bench.control(|control| control.interrupt(sampling)), None);
        }
        bench.poll();
        bench.control(|control| control.hardware_mut().bridge) == Bridge::Floating
    });
    pass_attended(&mut bench, 0.5);
    let status = status(&mut bench);
    let ended = ended.expect("something ends the run");
    assert_eq!((status.state, status.next), (RunState::Stopped(cause), ended.div_ceil(beats * apart_us)));
    assert_eq!(samples(&bench).len() as u32, status.next, "the log is whole");
    ended
}

/// Rates of sampling, and some of the moments, us, at which something may happen there: between two interrupts, and between two samples.
fn rates_and_moments() -> impl Iterator<Item = (u16, u32)> {
    [100, 1000, 1250, 1600, 2000].into_iter().flat_map(|rate_hz| {
        let period_us = 1_000_000 / u32::from(rate_hz);
        (0..9).map(move |k| (rate_hz, 100_000 + 25 * (k * period_us / 200 + k)))
    })
}

/// The bridge has to be off so long after its moment, us.
const OFF_US: u32 = 2000;

#[test]
fn a_silent_link_ends_a_run_within_two_milliseconds_at_every_rate() {
    for (rate_hz, silent_us) in rates_and_moments() {
        let setup = Setup { rate_hz, ..Setup::default() };
        let off = off_at(setup, Cause::LinkLoss, |bench, now| {
            if now <= silent_us {
                bench.send(ToBoard::KeepAlive);
            }
        });
        let late = off.checked_sub(silent_us + 250_000);
        assert!(
            late.is_some_and(|late| late < OFF_US),
            "{rate_hz} Hz, silent at {silent_us} us: off at {off}"
        );
    }
}

#[test]
fn over_current_ends_a_run_within_two_milliseconds_at_every_rate() {
    for (rate_hz, rises_us) in rates_and_moments() {
        let setup = Setup { rate_hz, current_limit_ma: 2000, amplifier: 1650, ..Setup::default() };
        let (_, apart_us) = split(1_000_000 / u32::from(rate_hz));
        let off = off_at(setup, Cause::OverCurrent, |bench, now| {
            // The mean since the last interrupt, of half an ampere before the moment and a little too much after it.
            let over_us = now.saturating_sub(rises_us).min(apart_us);
            let mean_ma = 500 + 1501 * over_us / apart_us;
            bench.control(|control| control.hardware_mut().short_ma = Some(mean_ma as i16));
            if now.is_multiple_of(10_000) {
                bench.send(ToBoard::KeepAlive);
            }
        });
        let late = off.checked_sub(rises_us);
        assert!(late.is_some_and(|late| late <= OFF_US), "{rate_hz} Hz, over at {rises_us} us: off at {off}");
    }
}

#[test]
fn the_longest_run_ends_within_two_milliseconds_of_its_time_at_every_rate() {
    for rate_hz in [100, 1000, 1250, 1600, 2000] {
        for run_limit_ms in [201, 205, 209, 210] {
            let setup = Setup { rate_hz, run_limit_ms, ..Setup::default() };
            let off = off_at(setup, Cause::RunLimit, |bench, now| {
                if now.is_multiple_of(10_000) {
                    bench.send(ToBoard::KeepAlive);
                }
            });
            let late = off.checked_sub(1000 * run_limit_ms);
            assert!(late.is_some_and(|late| late < OFF_US), "{rate_hz} Hz, {run_limit_ms} ms: off at {off}");
        }
    }
}

#[test]
fn the_emergency_contact_ends_a_run_between_two_samples_too() {
    let mut bench = ready(Setup { rate_hz: 100, ..Setup::default() }, &[]);
    start(&mut bench, &sine(2.0), 7);
    pass_attended(&mut bench, 0.5);
    assert_eq!(bench.control(|control| control.interrupt(false)), None);
    assert_eq!(status(&mut bench).state, RunState::Running);
    bench.control(|control| {
        control.hardware_mut().emergency = true;
        assert_eq!(control.interrupt(false), None);
    });
    assert_off(&bench);
    assert_eq!(status(&mut bench).state, RunState::Stopped(Cause::Emergency));
}

#[test]
fn a_main_loop_that_hangs_is_found_while_the_motor_is_driven_and_within_two_milliseconds() {
    let mut bench = ready(Setup::default(), &[]);
    // An interrupt each millisecond, and a turn half a millisecond before it.
    let pass = |bench: &Bench, micros: u32| {
        bench.control(|control| {
            let rig = control.hardware_mut();
            rig.now_us = rig.now_us.wrapping_add(micros);
        });
    };
    let interrupt = |bench: &Bench| bench.control(|control| control.interrupt(true));
    // A fit takes its time, while nothing runs.
    assert!((0..100).all(|_| {
        pass(&bench, 1000);
        interrupt(&bench).is_none()
    }));
    start(&mut bench, &sine(2.0), 7);
    assert!((0..100).all(|_| {
        pass(&bench, 500);
        bench.poll();
        pass(&bench, 500);
        interrupt(&bench).is_none()
    }));
    pass(&bench, 1000);
    assert_eq!(interrupt(&bench), Some(Reset::Watchdog), "a millisecond and a half after the last turn");
}

#[test]
fn a_main_loop_that_stays_in_one_turn_is_found_although_it_says_that_it_works() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(2.0), 7);
    let found = (1..1000).find(|_| {
        bench.control(|control| {
            let rig = control.hardware_mut();
            rig.now_us = rig.now_us.wrapping_add(100);
            control.worked();
            control.interrupt(false).is_some()
        })
    });
    assert_eq!(found, Some(500), "tenths of a millisecond");
}
