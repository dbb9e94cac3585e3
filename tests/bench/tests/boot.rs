//! The image starts on the emulated chip, at both instruction rates, and touches nothing the chip has not.

use motorlens_bench::machine::{self, CORE_HZ, Machine};
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
