//! Runs, faults and the log, on the firmware's logic with the virtual motor.

mod bench;
mod day;

use bench::{Bench, TOP};
use motorlens_firmware::beat::split;
use motorlens_firmware::log::Log;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{
    Cause, FromBoard, Refusal, Reset, RunState, Sample, Scaling, Setup, SetupFault, Status, ToBoard,
};
use motorlens_shared::quickfit::{Float, Keeper, Request, fit};
use motorlens_virtual_motor::{Bridge, Effect, Motor};

const HELLO: ToBoard = ToBoard::Hello { oldest: 1, newest: 1 };

fn sine(seconds: f32) -> Programme {
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.25, high_hz: 8.0, tones: 8, seed: 1 };
    Programme::single("sine", shape, seconds)
}

/// A bench that has been greeted and set up.
fn ready(setup: Setup, effects: &[Effect]) -> Bench {
    let mut bench = Bench::new(effects);
    assert!(matches!(bench.ask(HELLO), FromBoard::Hello(_)));
    assert_eq!(bench.ask(ToBoard::Configure(setup)), FromBoard::Done);
    bench
}

fn start(bench: &mut Bench, programme: &Programme, run: u32) {
    for (index, segment) in programme.segments.iter().enumerate() {
        let (name, segment) = (programme.name.clone(), segment.clone());
        assert_eq!(bench.ask(ToBoard::SetSegment { index: index as u8, name, segment }), FromBoard::Done);
    }
    assert_eq!(bench.ask(ToBoard::Start { run, segments: programme.segments.len() as u8 }), FromBoard::Done);
}

/// Lets time pass while the host keeps saying that it is there.
fn pass_attended(bench: &mut Bench, seconds: f64) {
    for _ in 0..(seconds / 0.1).round() as u32 {
        bench.send(ToBoard::KeepAlive);
        bench.pass(0.1);
    }
}

fn status(bench: &mut Bench) -> Status {
    match bench.ask(ToBoard::Status) {
        FromBoard::Status(status) => status,
        other => panic!("{other:?}"),
    }
}

/// All samples heard, by number; a hole is an error.
fn samples(bench: &Bench) -> Vec<Sample> {
    let mut all = Vec::new();
    for packet in &bench.heard {
        if let FromBoard::Log(block) = &packet.message {
            assert_eq!(block.first as usize, all.len(), "streamed in order");
            all.extend(block.samples.iter().copied());
        }
    }
    all
}

fn assert_off(bench: &Bench) {
    assert_eq!(bench.control(|control| control.hardware_mut().bridge), Bridge::Floating);
}

#[test]
fn a_whole_run_is_logged_as_played_and_as_the_motor_moved() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(3.0), 5);
    pass_attended(&mut bench, 3.5);
    let status = status(&mut bench);
    assert_eq!(
        (status.state, status.run, status.next, status.missed),
        (RunState::Stopped(Cause::Finished), 5, 3000, 0)
    );
    assert_off(&bench);
    let log = samples(&bench);
    assert_eq!(log.len(), 3000);
    let scaling = Scaling { pwm_top: TOP, rate_hz: 1000 };
    let mut motor = motorlens_virtual_motor::VirtualMotor::new(&Motor::paper(), &[], 1);
    motor.advance(1e-3, Bridge::Floating);
    for (index, sample) in log.iter().enumerate() {
        assert_eq!(i64::from(sample.count), motor.counts(), "sample {index}");
        motor.advance(1e-3, Bridge::Volts(f64::from(sample.duty) / f64::from(TOP) * motor.motor().nominal_v));
        assert!(scaling.volts(sample).abs() < 9.01);
    }
}

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
fn the_duty_limit_clips_what_the_programme_asks_for() {
    let mut bench = ready(Setup { duty_limit: 300, ..Setup::default() }, &[]);
    start(&mut bench, &sine(2.0), 1);
    pass_attended(&mut bench, 2.5);
    let log = samples(&bench);
    assert_eq!(log.len(), 2000);
    let most = log.iter().map(|sample| sample.duty.unsigned_abs()).max();
    assert_eq!(most, Some(TOP * 3 / 10));
}

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
fn a_late_interrupt_leaves_a_marked_gap_and_the_programme_keeps_time() {
    let mut bench = ready(Setup::default(), &[]);
    start(&mut bench, &sine(1.0), 1);
    pass_attended(&mut bench, 0.2);
    bench.control(|control| control.hardware_mut().now_us += 3_400);
    pass_attended(&mut bench, 1.0);
    let status = status(&mut bench);
    assert_eq!((status.next, status.missed), (1000, 3));
    let log = samples(&bench);
    assert_eq!(log.iter().filter(|sample| sample.missed()).count(), 3);
    assert_eq!(log[300].late_us, 400);
}

#[test]
fn the_boards_fit_is_the_hosts_fit_of_the_same_log() {
    let mut bench =
        ready(Setup { keep_every: 2, ..Setup::default() }, &[Effect::parse("coulomb=0.5").unwrap()]);
    start(&mut bench, &sine(4.0), 1);
    pass_attended(&mut bench, 4.2);
    let request = Request { coulomb: true, rad_per_count: 0.01, ..Request::default() };
    let mut keeper = Keeper::new(Scaling { pwm_top: TOP, rate_hz: 1000 }, 2);
    samples(&bench).iter().for_each(|sample| keeper.push(sample));
    let host = fit::<Float>(keeper.samples(), keeper.step_s(), &request, |_| ()).unwrap();
    let FromBoard::Fit(Some(board)) = bench.ask(ToBoard::QuickFit(request)) else { panic!("no fit") };
    assert_eq!(board.samples, 2000);
    assert_eq!(motorlens_shared::quickfit::QuickFit { micros: 0, micros_search: 0, ..board }, host);
    assert!(board.coulomb.unwrap().value > 0.2);
    assert_eq!(bench.ask(ToBoard::ReadResult), FromBoard::Fit(Some(board)));
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
