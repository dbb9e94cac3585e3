//! After whatever happens to chip, program, line or host, the bridge's pins are off within 2 ms and stay off, and the log so far is
//! there.
//!
//! The pins, not the program's intention: the enable as the port or the timer drives it, and the pins of both PWMs, which are all that a
//! driver with two inputs may have.

use std::time::Duration;

use motorlens::device::Capture;
use motorlens_bench::bench::{self, Done, Scene, Upset};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::{Hand, Session};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, DriveMode, Reset, Setup};
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// The bar.
const OFF: Duration = Duration::from_millis(2);

/// Drivers with two inputs, which rest with both of them high and low.
const TWO_INPUTS: [DriveMode; 2] = [DriveMode::InInBrake, DriveMode::InInCoast];
/// Whatever is forced low stays so until the watchdog starts the program anew, half a second after it was last fed.
const BEFORE_THE_RESTART: Duration = Duration::from_millis(400);

/// What is wired, at this rate.
fn setup(rate_hz: u16, drive: DriveMode) -> Setup {
    // The log of the fastest sampling lasts half a second.
    let link_timeout_ms = if rate_hz > 1000 { 250 } else { 500 };
    Setup { rate_hz, drive, link_timeout_ms, divider: 1100, amplifier: 1650, ..Setup::default() }
}

/// [`off`] with what is wired.
fn off_after(
    within: Duration,
    rate_hz: u16,
    drive: DriveMode,
    act: impl FnMut(Duration, &mut Scene) + Send + 'static,
) -> Done<Session> {
    off(within, setup(rate_hz, drive), act)
}

/// Runs, does `act` to the scene after 0.4 s of log, and sees the pins off `within` so long from then to the end. `act` is called at
/// each half millisecond from then on with the time since.
fn off(
    within: Duration,
    setup: Setup,
    mut act: impl FnMut(Duration, &mut Scene) + Send + 'static,
) -> Done<Session> {
    let Setup { rate_hz, drive, .. } = setup;
    let mut began = None;
    let hand: Hand = Box::new(move |now, capture, scene| {
        if began.is_none() && capture.samples() >= usize::from(rate_hz) * 2 / 5 && scene.plant.driven() {
            began = Some(now);
        }
        let Some(began) = began else { return };
        act(now - began, scene);
        // The main loop runs in a circle from its next sleep on.
        let began = scene.circling.unwrap_or(began);
        if now.saturating_sub(began) > within {
            let plant = &scene.plant;
            assert!(!plant.driven() && !plant.pulses(), "on {:?} after: {plant:?}", now - began);
        }
    });
    let rise = Programme::single("rise", Shape::Triangle { amplitude_v: 8.0, period_s: 4.0 }, 20.0);
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), drive).sampled_at(rate_hz);
    let session = Session::new(Capture::new(setup, &rise, 1), Duration::from_secs(40), hand);
    bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), session)
}

/// The log so far, the plant's own counts in it.
fn assert_log(done: &Done<Session>, cause: Cause, at_least: usize) {
    let run = done.remote.run();
    assert_eq!(run.cause, cause);
    assert!(run.holes.is_empty() && run.samples.len() >= at_least, "{} samples", run.samples.len());
    let counts = done.scene.plant.run_counts(run.status.next as usize);
    for (index, sample) in &run.samples {
        assert_eq!(i64::from(sample.count), counts[*index as usize], "sample {index}");
    }
}

/// An upset that only the watchdog ends, by a restart, of which the board then tells the reason.
fn upset(upset: Upset, rate_hz: u16, drive: DriveMode, told: Reset) {
    let done = off_after(OFF, rate_hz, drive, move |since, scene| {
        if since.is_zero() {
            scene.upset = Some(upset);
        }
    });
    assert_log(&done, Cause::Watchdog, usize::from(rate_hz) * 2 / 5);
    assert_eq!((done.remote.run().status.reset, done.session.resets().len()), (told, 1));
}

#[test]
fn a_panic() {
    for drive in [DriveMode::SignMagnitudeBrake, DriveMode::InInBrake, DriveMode::InInCoast] {
        upset(Upset::Panic, 1000, drive, Reset::Panic);
    }
}

/// The panic handler itself: the sampling interrupt, which would find the same, comes no more. The dead man's handle ends the timer's outputs
/// soon after, but leaves it its pins; the handler takes them.
#[test]
fn a_panic_of_the_main_loop() {
    for drive in [DriveMode::SignMagnitudeBrake, DriveMode::LockedAntiPhase, DriveMode::InInBrake] {
        let done = off_after(OFF, 1000, drive, |since, scene| {
            if since.is_zero() {
                scene.upset = Some(Upset::PanicOfMainLoop);
            }
            let handled = since > OFF && since < BEFORE_THE_RESTART;
            assert!(!(handled && scene.plant.by_timer()), "{since:?}: no handler was there");
        });
        assert_log(&done, Cause::Watchdog, 400);
        assert_eq!((done.remote.run().status.reset, done.session.resets().len()), (Reset::Panic, 1));
    }
}

/// An instruction without a meaning, as a stray jump or a damaged flash comes upon: the core enters the hard fault's handler.
#[test]
fn a_fault_of_the_core() {
    for (rate_hz, drive) in [
        (1000, DriveMode::SignMagnitudeBrake),
        (100, DriveMode::LockedAntiPhase),
        (1000, DriveMode::InInBrake),
        (1000, DriveMode::InInCoast),
    ] {
        let done = off_after(OFF, rate_hz, drive, |since, scene| {
            if since.is_zero() {
                scene.upset = Some(Upset::Fault);
            } else if since >= BEFORE_THE_RESTART {
                scene.upset = Some(Upset::Straight);
            }
            // It comes at the main loop's next sleep.
            let handled = since > OFF + OFF && since < BEFORE_THE_RESTART;
            assert!(!(handled && scene.plant.by_timer()), "{since:?}: no handler was there");
        });
        assert_log(&done, Cause::Watchdog, usize::from(rate_hz) * 2 / 5);
        assert_eq!((done.remote.run().status.reset, done.session.resets().len()), (Reset::CoreFault, 1));
        machine::assert_clean(&done.session);
    }
}

#[test]
fn a_dead_sampling_timer() {
    for rate_hz in [100, 1000, 2000] {
        upset(Upset::DeadSampling, rate_hz, DriveMode::SignMagnitudeBrake, Reset::Watchdog);
    }
}

#[test]
fn a_hang_with_interrupts_held_off() {
    for (rate_hz, drive) in [
        (1000, DriveMode::LockedAntiPhase),
        (100, DriveMode::SignMagnitudeBrake),
        (1000, DriveMode::InInBrake),
    ] {
        let done = off_after(OFF, rate_hz, drive, |since, scene| {
            if since.is_zero() {
                scene.upset = Some(Upset::Hang);
            } else if since >= Duration::from_millis(900) {
                // The watchdog has reset the chip by now, which the emulated core sees when it goes on.
                scene.upset = Some(Upset::GoOn);
            }
        });
        assert_log(&done, Cause::Watchdog, usize::from(rate_hz) * 2 / 5);
    }
}

#[test]
fn a_main_loop_that_runs_in_a_circle() {
    for rate_hz in [100, 1000, 1250, 2000] {
        let done = off_after(OFF, rate_hz, DriveMode::SignMagnitudeBrake, |since, scene| {
            if since.is_zero() {
                scene.upset = Some(Upset::Circle);
            } else if since >= BEFORE_THE_RESTART {
                scene.upset = Some(Upset::Straight);
            }
        });
        assert_log(&done, Cause::Watchdog, usize::from(rate_hz) * 2 / 5);
        assert_eq!((done.remote.run().status.reset, done.session.resets().len()), (Reset::Watchdog, 1));
    }
}

#[test]
fn a_crystal_that_stops() {
    // The emulated core gets no NMI of it, so what is shown is the timer's break, which comes before any program; the NMI's handler is below.
    let done = off_after(OFF, 1000, DriveMode::LockedAntiPhase, |since, scene| {
        if since.is_zero() {
            scene.upset = Some(Upset::ClockLoss);
        }
        scene.enough = since > Duration::from_millis(300);
    });
    assert!(!done.scene.plant.driven());
}

/// What the clock security asks for then: the handler takes the pins from the timer, and the board tells of it after the restart.
#[test]
fn a_crystal_that_stops_is_told_after_the_restart_and_the_log_is_there() {
    let done = off_after(OFF, 1000, DriveMode::SignMagnitudeBrake, |since, scene| {
        if since.is_zero() {
            scene.upset = Some(Upset::Nmi);
        } else if since >= BEFORE_THE_RESTART {
            scene.upset = Some(Upset::Straight);
        }
        // It comes at the main loop's next sleep.
        let handled = since > OFF + OFF && since < BEFORE_THE_RESTART;
        assert!(!(handled && scene.plant.by_timer()), "{since:?}: no handler was there");
    });
    assert_log(&done, Cause::Watchdog, 400);
    assert_eq!((done.remote.run().status.reset, done.session.resets().len()), (Reset::Clock, 1));
    machine::assert_clean(&done.session);
}

#[test]
fn a_supply_that_sinks_and_stays_low() {
    let done = off_after(OFF, 1000, DriveMode::SignMagnitudeBrake, |since, scene| {
        if since.is_zero() {
            scene.upset = Some(Upset::Supply(2800));
        }
        // Over the watchdog's restarts too, after which the supply is still low.
        scene.enough = since > Duration::from_millis(1200);
    });
    assert!(!done.scene.plant.driven());
    assert!(done.session.resets().len() >= 2, "{:?}", done.session.resets());
}

#[test]
fn a_supply_that_is_still_low_after_the_first_restarts_costs_neither_the_log_nor_the_reason() {
    let done = off_after(OFF, 1000, DriveMode::SignMagnitudeBrake, |since, scene| {
        if since.is_zero() {
            scene.upset = Some(Upset::Supply(2800));
        } else if since >= Duration::from_millis(1300) {
            scene.upset = Some(Upset::Supply(3300));
        }
    });
    assert_log(&done, Cause::Watchdog, 400);
    assert_eq!(done.remote.run().status.reset, Reset::Supply);
    assert!(done.session.resets().len() >= 2, "{:?}", done.session.resets());
}

#[test]
fn a_supply_that_sinks_and_comes_back_restarts_the_board_and_not_the_motor() {
    let done = off_after(OFF, 1000, DriveMode::SignMagnitudeBrake, |since, scene| {
        if since.is_zero() {
            scene.upset = Some(Upset::Supply(2800));
        } else if since >= Duration::from_millis(200) {
            scene.upset = Some(Upset::Supply(3300));
        }
    });
    assert_log(&done, Cause::Watchdog, 400);
    assert_eq!(done.remote.run().status.reset, Reset::Supply);
    assert_eq!(done.session.resets().len(), 1, "{:?}", done.session.resets());
}

#[test]
fn a_supply_that_cannot_sink_what_a_braking_motor_pumps_into_it() {
    // Half as much again as is stated is the bound.
    for rate_hz in [100, 1000, 2000] {
        let done = off_after(OFF, rate_hz, DriveMode::SignMagnitudeBrake, |since, scene| {
            scene.plant.pumped_v = if since < Duration::from_millis(500) { 7.0 } else { 0.0 };
        });
        assert_log(&done, Cause::Supply, usize::from(rate_hz) * 2 / 5);
        machine::assert_clean(&done.session);
    }
}

#[test]
fn the_emergency_contact_at_every_rate_and_even_where_it_only_bounces() {
    let anti_phase = [(100, 1000), (1000, 1000), (100, 1)]
        .map(|(rate_hz, open_for)| (rate_hz, open_for, DriveMode::LockedAntiPhase));
    let two_inputs = TWO_INPUTS.map(|drive| (1000, 1000, drive));
    for (rate_hz, open_for, drive) in anti_phase.into_iter().chain(two_inputs) {
        let done = off_after(OFF, rate_hz, drive, move |since, scene| {
            scene.plant.emergency = since < Duration::from_millis(open_for);
        });
        assert_log(&done, Cause::Emergency, usize::from(rate_hz) * 2 / 5);
        machine::assert_clean(&done.session);
    }
}

#[test]
fn over_current_with_every_kind_of_driver() {
    let two_inputs = TWO_INPUTS.map(|drive| (1000, drive));
    let others = [
        (100, DriveMode::SignMagnitudeBrake),
        (2000, DriveMode::SignMagnitudeBrake),
        (1000, DriveMode::LockedAntiPhase),
    ];
    for (rate_hz, drive) in two_inputs.into_iter().chain(others) {
        let limited = Setup { current_limit_ma: 3000, ..setup(rate_hz, drive) };
        let done = off(OFF, limited, |since, scene| {
            // The converter's input sees it at the next look.
            scene.stop_ns = 50_000;
            scene.plant.short_a = if since < Duration::from_millis(500) { 5.0 } else { 0.0 };
        });
        assert_log(&done, Cause::OverCurrent, usize::from(rate_hz) * 2 / 5);
        machine::assert_clean(&done.session);
    }
}

#[test]
fn a_cable_pulled_once_the_link_timeout_is_over() {
    let timeout = Duration::from_millis(Setup::default().link_timeout_ms.into());
    let two_inputs = TWO_INPUTS.map(|drive| (1000, drive));
    let others = [(100, DriveMode::SignMagnitudeBrake), (1000, DriveMode::SignMagnitudeBrake)];
    for (rate_hz, drive) in others.into_iter().chain(two_inputs) {
        let done = off_after(timeout + OFF, rate_hz, drive, move |since, scene| {
            scene.cable.out = since < 2 * timeout;
        });
        assert_log(&done, Cause::LinkLoss, usize::from(rate_hz) * 2 / 5);
    }
}

#[test]
fn a_blocked_shaft_once_the_stalls_time_is_over() {
    for rate_hz in [1000, 2000] {
        // The voltage is above this from before the shaft is blocked to the run's end.
        let watched = Setup { stall_mv: 2000, ..setup(rate_hz, DriveMode::SignMagnitudeBrake) };
        let stall = Duration::from_millis(watched.stall_ms.into());
        let done = off(stall + OFF, watched, |_, scene| scene.plant.jammed = true);
        assert_log(&done, Cause::Stall, usize::from(rate_hz) * 2 / 5);
        machine::assert_clean(&done.session);
    }
}

#[test]
fn ctrl_c_at_the_host() {
    let done = off_after(OFF, 1000, DriveMode::LockedAntiPhase, |since, scene| {
        scene.interrupt |= since.is_zero();
    });
    assert_log(&done, Cause::Asked, 400);
    machine::assert_clean(&done.session);
}
