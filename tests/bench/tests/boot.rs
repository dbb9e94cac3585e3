//! The image starts on the emulated chip, at both instruction rates, and touches nothing the chip has not.

use std::time::Duration as Time;

use motorlens::device::{Capture, Inquiry};
use motorlens_bench::bench::{self, Scene};
use motorlens_bench::cable::Cable;
use motorlens_bench::machine::{self, CORE_HZ, Machine};
use motorlens_bench::plant::Plant;
use motorlens_bench::remote::Session as Conversation;
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{FromBoard, Setup, ToBoard};
use motorlens_virtual_motor::{Motor, VirtualMotor};
use rigless::emulator::{Driver, Host, Stop};
use rigless::session::Session;
use rigless::time::VirtualNanos;

/// Lets the image run for a while, alone.
struct Wait(VirtualNanos);

impl Driver<Machine> for Wait {
    fn on_stop(&mut self, _: &mut Session<Machine>, stop: Stop, _: &mut dyn Host) -> Option<VirtualNanos> {
        (stop.at.0 < self.0.0).then_some(self.0)
    }
}

#[test]
fn the_image_starts_cleanly_and_the_watchdog_stays_fed() {
    for rate in [CORE_HZ, 47_000_000] {
        let finished = Machine::new(rate).run(
            &machine::image(),
            VirtualNanos(1_000_000),
            Wait(VirtualNanos(500_000_000)),
        );
        machine::assert_clean(&finished.session);
        assert!(finished.session.resets().is_empty(), "restarted: {:?}", finished.session.resets());
    }
}

#[test]
fn the_boot_loader_is_entered_by_a_reset_after_the_whole_answer() {
    let step = Programme::single("step", Shape::Step { level_v: 6.0 }, 0.2);
    let capture = Capture::new(Setup::default(), &step, 1);
    // The emulated chip's boot loader is blank.
    let hand = Box::new(|_, _: &Capture, scene: &mut Scene| scene.led_astray = true);
    let conversation =
        Conversation::new(capture, Time::from_secs(5), hand).then(Inquiry::new([ToBoard::Bootloader]));
    let plant = Plant::new(VirtualMotor::new(&Motor::paper(), &[], 3), Setup::default().drive);
    let done = bench::run_at_full_rate(&machine::image(), plant, Cable::new(0.0, 1), conversation);
    let answers = done.remote.answers.expect("the board answers").expect("the board agrees");
    assert_eq!(answers.last(), Some(&FromBoard::Done));
    assert_eq!(done.session.resets().len(), 1, "{:?}", done.session.resets());
    assert!(!done.scene.plant.driven());
    // It was jumped into: its stack, as the blank memory has it, lies at the end of all addresses.
    let unmapped = done.session.unmapped();
    assert!(
        !unmapped.is_empty() && unmapped.iter().all(|access| access.address > 0xffff_0000),
        "{unmapped:?}"
    );
}
