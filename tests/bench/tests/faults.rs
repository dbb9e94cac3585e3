//! What can go wrong, injected: each fault stops the motor with the bridge off, is told by its name, and leaves the log.

use std::time::Duration;

use motorlens::device::{Capture, Captured};
use motorlens_bench::bench::{self, Done, Scene};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::{Hand, Session};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, DriveMode, Setup};
use motorlens_virtual_motor::{Motor, VirtualMotor};

fn multisine(seconds: f32) -> Programme {
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 8.0, tones: 8, seed: 2 };
    Programme::single("multisine", shape, seconds)
}

/// Rises to 8 V in a second and back in the next.
fn rise() -> Programme {
    Programme::single("rise", Shape::Triangle { amplitude_v: 8.0, period_s: 4.0 }, 20.0)
}

fn run(setup: Setup, programme: &Programme, cable: Cable, hand: Hand) -> Done<Session> {
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), setup.drive);
    let session = Session::new(Capture::new(setup, programme, 1), Duration::from_secs(40), hand);
    let done = bench::run_at_full_rate(&machine::image(), plant, cable, session);
    machine::assert_clean(&done.session);
    done
}

/// Every sample of the log holds the plant's own count at its instant.
fn assert_true_to_the_plant(done: &Done<Session>) {
    let run = done.remote.run();
    let counts = done.scene.plant.run_counts(run.status.next as usize);
    for (index, sample) in &run.samples {
        assert_eq!(i64::from(sample.count), counts[*index as usize], "sample {index}");
    }
}

/// Does something to the scene, once, `after` the log has begun.
fn once(after: usize, mut act: impl FnMut(&mut Scene) + Send + 'static) -> Hand {
    let mut done = false;
    Box::new(move |_, capture, scene| {
        if !done && capture.samples() >= after {
            done = true;
            act(scene);
        }
    })
}

fn stopped_by(cause: Cause, setup: Setup, act: impl FnMut(&mut Scene) + Send + 'static) -> Captured {
    let done = run(setup, &rise(), Cable::new(0.0, 1), once(500, act));
    let run = done.remote.run().clone();
    assert_eq!(run.cause, cause);
    assert!(!done.scene.plant.driven(), "{cause:?}: the bridge is off");
    assert!(run.holes.is_empty() && run.samples.len() >= 500, "{cause:?}: {} samples", run.samples.len());
    run
}

#[test]
fn one_byte_in_a_hundred_or_in_ten_spoiled_and_the_log_is_still_whole() {
    for (share, seconds) in [(0.01, 20.0), (0.1, 10.0)] {
        let done = run(Setup::default(), &multisine(seconds), Cable::new(share, 5), Box::new(|_, _, _| ()));
        let run = done.remote.run();
        assert!(done.scene.cable.spoiled > 2000, "{} bytes spoiled", done.scene.cable.spoiled);
        let samples = (1000.0 * seconds) as usize;
        assert_eq!((run.cause, run.samples.len(), run.holes.len()), (Cause::Finished, samples, 0));
        assert_true_to_the_plant(&done);
    }
}

#[test]
fn the_pwm_has_the_frequency_asked_for_and_the_voltage_is_what_the_log_says_at_each() {
    for pwm_hz in [5_000, 16_000, 50_000] {
        let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 1.0);
        let setup = Setup { pwm_hz, ..Setup::default() };
        let done = run(setup, &step, Cable::new(0.0, 1), Box::new(|_, _, _| ()));
        let run = done.remote.run();
        assert_true_to_the_plant(&done);
        assert_eq!((run.capabilities.pwm_hz, u32::from(run.scaling.pwm_top)), (pwm_hz, 84_000_000 / pwm_hz));
        let mut twin = VirtualMotor::new(&Motor::paper(), &[], 3);
        twin.advance(1.0, motorlens_virtual_motor::Bridge::Volts(6.0));
        let (count, ideal) = (f64::from(run.samples[999].1.count), twin.counts() as f64);
        assert!((0.99..1.01).contains(&(count / ideal)), "{pwm_hz} Hz: {count} against {ideal}");
    }
}

#[test]
fn with_the_cable_out_for_two_seconds_the_motor_stops_and_the_session_resumes() {
    let mut out_at = None;
    let hand: Hand = Box::new(move |now, capture, scene| {
        if capture.samples() >= 3000 {
            let since = *out_at.get_or_insert(now);
            scene.cable.out = now - since < Duration::from_secs(2);
        }
    });
    let done = run(Setup::default(), &multisine(20.0), Cable::new(0.0, 1), hand);
    let run = done.remote.run();
    assert_eq!(run.cause, Cause::LinkLoss);
    assert!(!done.scene.plant.driven());
    assert!(run.holes.is_empty());
    // Half a second of timeout, counted from the last keep-alive before the cable went.
    assert!((3400..3600).contains(&run.samples.len()), "{} samples", run.samples.len());
    assert_true_to_the_plant(&done);
}

#[test]
fn a_stall_an_over_current_and_the_emergency_input_each_stop_the_motor() {
    let stall = stopped_by(Cause::Stall, Setup::default(), |scene| scene.plant.jammed = true);
    assert!(stall.samples.len() < 1600, "{}", stall.samples.len());
    let limited = Setup { current_limit_ma: 3000, amplifier: 1650, ..Setup::default() };
    let current = stopped_by(Cause::OverCurrent, limited, |scene| scene.plant.short_a = 5.0);
    assert!(current.samples.len() < 560, "{}", current.samples.len());
    let emergency = stopped_by(Cause::Emergency, Setup::default(), |scene| scene.plant.emergency = true);
    assert!(emergency.samples.len() < 560, "{}", emergency.samples.len());
    stopped_by(Cause::RunLimit, Setup { run_limit_ms: 900, ..Setup::default() }, |_| ());
}

#[test]
fn the_duty_limit_holds_whatever_the_programme_asks_for() {
    let setup = Setup { duty_limit: 400, ..Setup::default() };
    let step = Programme::single("step", Shape::Step { level_v: 9.0 }, 1.0);
    let mut most = 0.0_f64;
    let (told, tell) = std::sync::mpsc::channel();
    let hand: Hand = Box::new(move |_, _, scene| {
        most = most.max(scene.plant.duty());
        // Nobody listens after the end.
        let _ = told.send(most);
    });
    let done = run(setup, &step, Cable::new(0.0, 1), hand);
    let run = done.remote.run();
    assert_eq!((run.cause, run.samples.len()), (Cause::Finished, 1000));
    let volts = run.samples.iter().map(|(_, sample)| run.scaling.volts(sample)).fold(0.0, f32::max);
    assert!((4.75..4.81).contains(&volts), "40 % of 12 V, and no more: {volts} V in the log");
    let most = tell.try_iter().last().expect("the hand was there");
    assert!((0.395..=0.4001).contains(&most), "{most} of the PWM's period at the driver");
}

#[test]
fn every_kind_of_driver_gives_the_voltage_that_the_log_says() {
    for drive in [
        DriveMode::SignMagnitudeBrake,
        DriveMode::SignMagnitudeCoast,
        DriveMode::LockedAntiPhase,
        DriveMode::InInBrake,
        DriveMode::InInCoast,
    ] {
        let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 1.0);
        let done =
            run(Setup { drive, ..Setup::default() }, &step, Cable::new(0.0, 1), Box::new(|_, _, _| ()));
        let run = done.remote.run();
        assert_true_to_the_plant(&done);
        let volts = run.scaling.volts(&run.samples[900].1);
        assert!((volts - 6.0).abs() < 0.01, "{drive:?}: {volts} V");
        let mut twin = VirtualMotor::new(&Motor::paper(), &[], 3);
        twin.advance(1.0, motorlens_virtual_motor::Bridge::Volts(6.0));
        let (count, ideal) = (f64::from(run.samples[999].1.count), twin.counts() as f64);
        // A motor that floats in the off part is driven only while the current lasts; the others follow the mean voltage.
        let floats = matches!(drive, DriveMode::SignMagnitudeCoast | DriveMode::InInCoast);
        let range = if floats { 0.05..0.95 } else { 0.99..1.01 };
        assert!(range.contains(&(count / ideal)), "{drive:?}: {count} against {ideal}");
    }
}
