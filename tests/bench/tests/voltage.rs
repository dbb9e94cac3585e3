//! The log says the mean of the voltage in each interval, at every rate: the PWM's pin is high for the share that it says.

use std::time::Duration;

use motorlens::device::Capture;
use motorlens_bench::bench;
use motorlens_bench::cable::Cable;
use motorlens_bench::machine;
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{DriveMode, Setup};
use motorlens_virtual_motor::{Motor, VirtualMotor};

/// Of the full voltage.
const BAR: f64 = 1e-3;

#[test]
fn the_pin_is_high_for_the_share_that_the_log_says_within_a_thousandth_at_every_rate() {
    // Rates that divide the PWM's 20 kHz, and some that do not.
    for rate_hz in [100, 625, 1000, 1600, 2000] {
        for drive in [DriveMode::SignMagnitudeBrake, DriveMode::LockedAntiPhase] {
            let setup = Setup { rate_hz, drive, link_timeout_ms: 250, ..Setup::default() };
            let shape = Shape::Triangle { amplitude_v: 9.0, period_s: 0.3 };
            let capture = Capture::new(setup, &Programme::single("triangle", shape, 0.3), 1);
            let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), drive).sampled_at(rate_hz);
            let session = Session::new(capture, Duration::from_secs(5), Box::new(|_, _, _| ()));
            let done = bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), session);
            let run = done.remote.run();
            let top = f64::from(run.scaling.pwm_top);
            let (mut worst, mut seen) = (0.0_f64, 0);
            // In the first interval the driver is being enabled, the last has no end.
            for (index, sample) in &run.samples[1..run.samples.len() - 1] {
                let share = done.scene.plant.high_share(*index as usize).expect("every interval was seen");
                let duty = f64::from(sample.duty) / top;
                let mean = if drive == DriveMode::LockedAntiPhase { 2.0 * share - 1.0 } else { share };
                let said = if drive == DriveMode::LockedAntiPhase { duty } else { duty.abs() };
                worst = worst.max((mean - said).abs());
                seen += 1;
            }
            assert!(seen + 2 >= usize::from(rate_hz) * 3 / 10, "{seen} intervals at {rate_hz} Hz");
            println!("{drive:?} at {rate_hz} Hz: {worst:.1e} of the full voltage off");
            assert!(worst <= BAR, "{drive:?} at {rate_hz} Hz: {worst} of the full voltage off");
        }
    }
}
