//! Watchdog, identity, boot loader and the reasons for a start.

use motorlens_firmware::Shared;
use motorlens_firmware::station::Platform;
use motorlens_shared::link::Reset;

use crate::hal::{Watchdog, fugit::ExtU32, pac};
use crate::{Hardware, chip};

/// The board starts anew when the main loop or the sampling interrupt stood still for so long. Preparing a programme of
/// many multisines takes the larger part of it.
const WATCHDOG_MS: u32 = 500;

/// The board, for the main loop.
pub struct Board {
    watchdog: Watchdog,
    control: &'static Shared<Hardware>,
    ticks: u32,
}

impl Board {
    /// Starts the watchdog.
    pub fn new(mut watchdog: Watchdog, control: &'static Shared<Hardware>) -> Self {
        watchdog.start(WATCHDOG_MS.millis());
        Board { watchdog, control, ticks: 0 }
    }
}

impl Platform for Board {
    const CORE_HZ: u32 = chip::CORE_HZ;
    type Arithmetic = chip::Arithmetic;
    const VERSION: [u8; 3] = [0, 1, 0];

    /// The kind of chip alone: the RP2040 has no number of its own, only its flash has.
    fn unique(&self) -> [u8; 12] {
        let mut bytes = *b"RP\0\0\0\0\0\0\0\0\0\0";
        // SAFETY: a read of a constant register.
        let chip = unsafe { (*pac::SYSINFO::ptr()).chip_id().read().bits() };
        bytes[2..6].copy_from_slice(&chip.to_le_bytes());
        bytes
    }

    /// Feeds the watchdog, but only while the sampling interrupt comes too.
    fn alive(&mut self) {
        let ticks = critical_section::with(|section| self.control.borrow_ref(section).ticks());
        if core::mem::replace(&mut self.ticks, ticks) != ticks {
            self.watchdog.feed();
        }
    }

    fn has_bootloader(&self) -> bool {
        true
    }

    /// The chip's own loader, which shows itself as a drive.
    fn enter_bootloader(&mut self) {
        chip::bootloader();
    }
}

/// Notes why the board is about to be started anew, in the watchdog's first scratch register; a start by power or by the RUN pin clears it
/// (RP2040 datasheet 4.7.4). What is noted first stays: the guard, which comes half a millisecond after a panic or a fault in a run, would
/// have it that the program hung.
pub fn note(reason: Reset) {
    // SAFETY: a register that nothing else uses; the boot program reads others.
    let noted = unsafe { (*pac::WATCHDOG::ptr()).scratch0() };
    if noted.read().bits() == 0 {
        // SAFETY: as above.
        noted.write(|w| unsafe { w.bits(reason as u32) });
    }
}

/// Why the chip started.
pub fn reset_cause(watchdog: &pac::WATCHDOG) -> Reset {
    let reason = watchdog.reason().read();
    let noted = watchdog.scratch0().read().bits();
    // SAFETY: as in `note`.
    watchdog.scratch0().write(|w| unsafe { w.bits(0) });
    if reason.timer().bit_is_set() {
        Reset::noted(noted).unwrap_or(Reset::Watchdog)
    } else if reason.force().bit_is_set() {
        Reset::Software
    } else {
        Reset::PowerOn
    }
}
