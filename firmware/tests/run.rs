//! Runs and the log, on the firmware's logic with the virtual motor.

mod bench;
mod day;
mod inputs;
mod requests;
mod standing;
mod stops;

use bench::{Bench, TOP};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, FromBoard, RunState, Sample, Scaling, Setup, Status, ToBoard};
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
    let host = fit::<Float>(keeper.samples(), keeper.step_s(), &request, |_| (), || ()).unwrap();
    let FromBoard::Fit(Some(board)) = bench.ask(ToBoard::QuickFit(request)) else { panic!("no fit") };
    assert_eq!(board.samples, 2000);
    assert_eq!(motorlens_shared::quickfit::QuickFit { micros: 0, micros_search: 0, ..board }, host);
    assert!(board.coulomb.unwrap().value > 0.2);
    assert_eq!(bench.ask(ToBoard::ReadResult), FromBoard::Fit(Some(board)));
}
