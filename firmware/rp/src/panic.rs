//! A panic or a fault of the core, from whatever place, must not leave the motor driven.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use motorlens_shared::link::Reset;

use crate::hal::pac;
use crate::platform::note;

/// Both PWMs, direction forward, enable, direction backward.
const BRIDGE: [usize; 5] = [6, 7, 8, 9, 11];

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    stop_for_good(Reset::Panic)
}

/// An access without an address, an instruction without a meaning, a broken stack: nothing is trusted but the registers.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    bridge_off();
    note(Reset::CoreFault);
    wait_for_the_watchdog()
}

/// An interrupt that nobody asked for.
#[exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    stop_for_good(Reset::CoreFault)
}

/// Takes the bridge down and waits for the watchdog to start the board anew.
pub fn stop_for_good(reason: Reset) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    note(reason);
    wait_for_the_watchdog()
}

fn wait_for_the_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// Forces the bridge's pins low behind every peripheral (OUTOVER, RP2040 datasheet section 2.19.6.1): whatever the PWM
/// and the port do from now on, the pins stay low until [`let_bridge`], or the reset, which lets go of them all.
pub fn bridge_off() {
    for pin in BRIDGE {
        // SAFETY: writes that only take outputs low, of registers that exist from the start on.
        unsafe { (*pac::IO_BANK0::ptr()).gpio(pin).gpio_ctrl().modify(|_, w| w.outover().low()) };
    }
}

/// Lets the peripherals have the bridge's pins again.
pub fn let_bridge() {
    for pin in BRIDGE {
        // SAFETY: registers of the bridge's pins, whose peripherals are set up by the time a run begins.
        unsafe { (*pac::IO_BANK0::ptr()).gpio(pin).gpio_ctrl().modify(|_, w| w.outover().normal()) };
    }
}
