//! Whole runs on the emulated board: nothing lost, counts exact, at both instruction rates.

use std::time::Duration;

use motorlens::device::Capture;
use motorlens_bench::bench;
use motorlens_bench::cable::Cable;
use motorlens_bench::machine::{self, CORE_HZ};
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, DriveMode, Setup};
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// The pessimistic rate: what is left of 84 MHz with the flash's wait states.
const SLOW: u64 = 47_000_000;

fn plant(driver: DriveMode) -> Plant {
    Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), driver)
}

/// A minute of the default protocol's shapes, as one programme.
fn minute() -> Programme {
    let protocol = Programme::default_protocol(12.0);
    let segments =
        protocol.training.iter().chain([&protocol.held_out]).flat_map(|programme| programme.segments.clone());
    let mut programme = Programme::sequence("minute", segments).unwrap();
    let scale = 60.0 / programme.seconds();
    programme.segments.iter_mut().for_each(|segment| segment.seconds *= scale);
    programme
}

#[test]
fn a_minute_at_a_kilohertz_is_captured_whole_with_the_plants_own_counts() {
    for rate in [CORE_HZ, SLOW] {
        let capture = Capture::new(Setup::default(), &minute(), 1);
        let session = Session::new(capture, Duration::from_secs(70), Box::new(|_, _, _| ()));
        let done = bench::run(
            &machine::image(),
            rate,
            plant(DriveMode::SignMagnitudeBrake),
            Cable::new(0.0, 1),
            session,
        );
        machine::assert_clean(&done.session);
        let run = done.remote.run();
        assert_eq!(run.cause, Cause::Finished);
        assert_eq!((run.samples.len(), run.holes.len()), (60_000, 0));
        let counts: Vec<i64> = run.samples.iter().map(|(_, sample)| i64::from(sample.count)).collect();
        assert_eq!(counts, done.scene.plant.run_counts(60_000), "at {rate} instructions a second");
        let late = run.samples.iter().map(|(_, sample)| sample.late_us.unsigned_abs()).max();
        assert!(late <= Some(5), "{late:?} us late at {rate} instructions a second");
        println!(
            "{rate} instructions/s: longest interrupt {} instructions, {} cycles by the board's own count",
            done.scene.longest_interrupt, run.status.worst_cycles
        );
    }
}

#[test]
fn the_slowest_and_the_fastest_sampling_lose_nothing_either() {
    for (rate_hz, core) in [(100, CORE_HZ), (2000, CORE_HZ), (2000, SLOW)] {
        // Half of the log at the fastest rate is a quarter of a second.
        let setup = Setup { rate_hz, link_timeout_ms: 250, ..Setup::default() };
        let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.2, high_hz: 8.0, tones: 8, seed: 2 };
        let capture = Capture::new(setup, &Programme::single("multisine", shape, 5.0), 1);
        let session = Session::new(capture, Duration::from_secs(10), Box::new(|_, _, _| ()));
        let plant = plant(DriveMode::SignMagnitudeBrake).sampled_at(rate_hz);
        let done = bench::run(&machine::image(), core, plant, Cable::new(0.0, 1), session);
        machine::assert_clean(&done.session);
        let run = done.remote.run();
        let samples = 5 * usize::from(rate_hz);
        assert_eq!((run.cause, run.samples.len(), run.holes.len()), (Cause::Finished, samples, 0));
        let counts: Vec<i64> = run.samples.iter().map(|(_, sample)| i64::from(sample.count)).collect();
        assert_eq!(
            counts,
            done.scene.plant.run_counts(samples),
            "{rate_hz} Hz, {core} instructions a second"
        );
    }
}
