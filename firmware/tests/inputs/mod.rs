//! Supply and current as they are measured, and where they are not.

use crate::bench::TOP;
use crate::{assert_off, pass_attended, ready, samples, sine, start, status};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, FromBoard, Refusal, RunState, Setup, SetupFault, ToBoard};
use motorlens_virtual_motor::Bridge;

#[test]
fn a_supply_input_that_floats_ends_the_run_before_the_motor_is_driven() {
    for floating_mv in [0, 300, 5_900, 18_100, 36_000] {
        let mut bench = ready(Setup { divider: 1100, ..Setup::default() }, &[]);
        bench.control(|control| control.hardware_mut().floating_mv = Some(floating_mv));
        start(&mut bench, &sine(2.0), 7);
        for _ in 0..300 {
            bench.pass(0.001);
            let bridge = bench.control(|control| control.hardware_mut().bridge);
            assert!(matches!(bridge, Bridge::Floating), "{floating_mv} mV drives the motor");
        }
        // This host speaks version 1, which has no word for it.
        assert_eq!(status(&mut bench).state, RunState::Stopped(Cause::OverCurrent));
        assert!(matches!(bench.ask(ToBoard::Hello { oldest: 1, newest: 2 }), FromBoard::Hello(_)));
        assert_eq!(status(&mut bench).state, RunState::Stopped(Cause::Supply));
    }
}

#[test]
fn a_sample_has_the_supply_of_its_own_interval_and_the_duty_is_worked_out_from_the_last_one() {
    let mut bench = ready(Setup { divider: 1100, ..Setup::default() }, &[]);
    let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 0.5);
    start(&mut bench, &step, 1);
    // The supply of each millisecond, which ends with the interrupt.
    let supply = |ms: u16| 11_000 + 100 * (ms % 7);
    for ms in 0..700 {
        bench.control(|control| control.hardware_mut().floating_mv = Some(supply(ms)));
        bench.send(ToBoard::KeepAlive);
        bench.pass(0.001);
    }
    let log = samples(&bench);
    assert_eq!(log.len(), 500);
    let first =
        (0..700).find(|ms| supply(*ms) == log[0].supply_mv && supply(ms + 1) == log[1].supply_mv).unwrap();
    for (place, sample) in (first..).zip(&log) {
        assert_eq!(sample.supply_mv, supply(place), "sample {}", place - first);
    }
    for pair in log.windows(3) {
        // Planned at the begin of the interval before, when the supply of the one before that was known.
        let wanted = 6000.0 / f64::from(pair[0].supply_mv) * f64::from(TOP);
        assert_eq!(f64::from(pair[2].duty), wanted.round(), "{pair:?}");
    }
}

#[test]
fn a_supply_that_is_pumped_up_ends_the_run_at_once_and_one_that_sinks_when_it_stays() {
    for (supply_mv, samples) in [(18_100, 1), (5_900, 3)] {
        let mut bench = ready(Setup { divider: 1100, ..Setup::default() }, &[]);
        start(&mut bench, &sine(2.0), 7);
        pass_attended(&mut bench, 0.5);
        bench.control(|control| control.hardware_mut().floating_mv = Some(supply_mv));
        for _ in 1..samples {
            bench.pass(0.001);
            assert_eq!(status(&mut bench).state, RunState::Running, "{supply_mv} mV");
        }
        bench.pass(0.001);
        assert_off(&bench);
    }
    // Where samples are rare, between two of them.
    let mut bench = ready(Setup { divider: 1100, rate_hz: 100, ..Setup::default() }, &[]);
    start(&mut bench, &sine(2.0), 7);
    pass_attended(&mut bench, 0.5);
    bench.control(|control| control.between());
    assert_eq!(status(&mut bench).state, RunState::Running);
    bench.control(|control| {
        control.hardware_mut().floating_mv = Some(18_100);
        control.between();
    });
    assert_off(&bench);
}

#[test]
fn an_input_that_is_not_said_to_be_wired_is_not_read() {
    let mut bench = ready(Setup::default(), &[]);
    bench.control(|control| control.hardware_mut().floating_mv = Some(300));
    start(&mut bench, &sine(0.5), 7);
    pass_attended(&mut bench, 1.0);
    assert_eq!(status(&mut bench).state, RunState::Stopped(Cause::Finished));
    assert!(samples(&bench).iter().all(|sample| (sample.supply_mv, sample.current_ma) == (12_000, 0)));
    let limited = Setup { current_limit_ma: 800, ..Setup::default() };
    let refusal = FromBoard::Refused(Refusal::Setup(SetupFault::NoCurrentSense));
    assert_eq!(bench.ask(ToBoard::Configure(limited)), refusal);
}
