//! What the host asks for: done once, refused with the reason, told in words that it has.

use crate::bench::{Bench, TOP};
use crate::{HELLO, assert_off, pass_attended, ready, sine, start, status};
use motorlens_firmware::log::Log;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{
    Cause, FromBoard, Refusal, Reset, RunState, Sample, Scaling, Setup, SetupFault, ToBoard,
};
use motorlens_shared::quickfit::Request;

#[test]
fn a_start_asked_for_twice_is_made_once() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(1.0), 3);
    pass_attended(&mut bench, 0.3);
    assert_eq!(bench.ask(ToBoard::Start { run: 3, segments: 1 }), FromBoard::Done);
    assert_eq!(bench.ask(ToBoard::Start { run: 4, segments: 1 }), FromBoard::Refused(Refusal::Running));
    pass_attended(&mut bench, 1.0);
    assert_eq!(bench.ask(ToBoard::Start { run: 3, segments: 1 }), FromBoard::Done);
    assert_eq!(status(&mut bench).next, 1000);
}

#[test]
fn what_cannot_be_done_is_refused_with_the_reason() {
    let mut bench = Bench::new(&[]);
    assert_eq!(bench.ask(ToBoard::Stop), FromBoard::Refused(Refusal::Version));
    bench.ask(HELLO);
    let fault = |setup| FromBoard::Refused(Refusal::Setup(setup));
    let fast = Setup { rate_hz: 3000, ..Setup::default() };
    assert_eq!(bench.ask(ToBoard::Configure(fast)), fault(SetupFault::Rate));
    assert_eq!(bench.ask(ToBoard::Start { run: 1, segments: 1 }), FromBoard::Refused(Refusal::SegmentOrder));
    assert_eq!(bench.ask(ToBoard::QuickFit(Request::default())), FromBoard::Refused(Refusal::NothingToFit));
    assert_eq!(bench.ask(ToBoard::EffectName { index: 200 }), FromBoard::Refused(Refusal::NoSuchEffect));
    bench.control(|control| control.hardware_mut().emergency = true);
    let segment = sine(1.0).segments[0].clone();
    bench.ask(ToBoard::SetSegment { index: 0, name: "sine".try_into().unwrap(), segment });
    assert_eq!(bench.ask(ToBoard::Start { run: 1, segments: 1 }), FromBoard::Refused(Refusal::Emergency));
}

#[test]
fn capabilities_name_every_effect_of_the_registry() {
    let mut bench = ready(Setup::default(), &[]);
    let FromBoard::Capabilities(capabilities) = bench.ask(ToBoard::Capabilities) else { panic!() };
    let names: Vec<_> = (0..capabilities.effects)
        .map(|index| match bench.ask(ToBoard::EffectName { index }) {
            FromBoard::EffectName(name) => name.to_string(),
            other => panic!("{other:?}"),
        })
        .collect();
    assert!(
        names.contains(&"coulomb".to_string()) && names.len() == motorlens_shared::effects::Kind::ALL.len()
    );
}

#[test]
fn a_watchdog_reset_is_reported_and_the_log_is_still_there() {
    let log: &'static mut Log = Box::leak(Box::new(Log::new()));
    log.begin(9, Scaling { pwm_top: TOP, rate_hz: 1000 });
    (0..40)
        .for_each(|count| log.push(Sample { duty: 1, count, supply_mv: 12_000, current_ma: 0, late_us: 0 }));
    let mut bench = Bench::started(&[], log, Reset::Watchdog);
    bench.ask(HELLO);
    let status = status(&mut bench);
    assert_eq!((status.state, status.reset), (RunState::Stopped(Cause::Watchdog), Reset::Watchdog));
    assert_eq!((status.run, status.next), (9, 40));
    let FromBoard::Log(block) = bench.ask(ToBoard::ReadLog { first: 36, count: 4 }) else { panic!() };
    assert_eq!(block.samples.len(), 4);
}

#[test]
fn what_cost_the_board_its_control_is_told_in_words_that_the_host_has() {
    for reset in [Reset::Panic, Reset::CoreFault, Reset::Clock, Reset::Supply] {
        let mut bench = Bench::started(&[], Box::leak(Box::new(Log::new())), reset);
        for (newest, told) in [(1, Reset::Watchdog), (2, Reset::Watchdog), (3, reset)] {
            bench.ask(ToBoard::Hello { oldest: 1, newest });
            assert_eq!(status(&mut bench).reset, told);
        }
    }
}

#[test]
fn the_pwm_is_put_to_the_frequency_asked_for_and_the_scaling_follows() {
    for (pwm_hz, has) in [(0, 20_000), (5_000, 5_000), (16_000, 16_000), (50_000, 50_000)] {
        let mut bench = ready(Setup { pwm_hz, ..Setup::default() }, &[]);
        let FromBoard::Capabilities(can) = bench.ask(ToBoard::Capabilities) else { panic!() };
        assert_eq!((can.pwm_hz, u32::from(can.scaling.pwm_top)), (has, 84_000_000 / has));
    }
    let mut bench = ready(Setup::default(), &[]);
    for pwm_hz in [1, 4_999, 50_001] {
        let refusal = FromBoard::Refused(Refusal::Setup(SetupFault::Pwm));
        assert_eq!(bench.ask(ToBoard::Configure(Setup { pwm_hz, ..Setup::default() })), refusal);
    }
}

#[test]
fn the_boot_loader_is_entered_only_after_the_answer_and_with_the_bridge_off() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(5.0), 1);
    pass_attended(&mut bench, 0.2);
    assert_eq!(bench.ask(ToBoard::Bootloader), FromBoard::Done);
    assert!(bench.rest.left_for_bootloader);
    assert_off(&bench);
}

#[test]
fn a_fit_asked_for_twice_under_one_number_is_made_once_and_another_request_anew() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(3.0), 7);
    pass_attended(&mut bench, 3.5);
    let request = Request { rad_per_count: 0.001, generations: 5, ..Request::default() };
    let first = bench.ask(ToBoard::QuickFit(request));
    let turns = bench.rest.alive;
    bench.id -= 1;
    assert_eq!(bench.ask(ToBoard::QuickFit(request)), first);
    assert!(bench.rest.alive - turns <= 2, "fitted again");
    let other = Request { seed: 99, ..request };
    bench.id -= 1;
    bench.ask(ToBoard::QuickFit(other));
    assert!(bench.rest.alive - turns > 5, "another request under the same number is another fit");
}

#[test]
fn the_watchdog_is_fed_while_a_long_programme_is_prepared() {
    let mut bench = ready(Setup::default(), &[]);
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 100.0, tones: 14, seed: 2 };
    let segments = (0..8).map(|_| motorlens_shared::excitation::Segment { shape, seconds: 8.0 });
    let programme = Programme::sequence("long", segments).unwrap();
    let before = bench.rest.alive;
    start(&mut bench, &programme, 7);
    // 8 crests of 16,384 points, fed every 1,024; a turn of the main loop for each of the nine requests.
    let fed = bench.rest.alive - before;
    assert!(fed >= 8 * 16, "{fed} times");
}
