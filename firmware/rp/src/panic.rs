//! A panic or a fault of the core, from whatever place, must not leave the motor driven.

use core::panic::PanicInfo;

use cortex_m_rt::exception;
use motorlens_shared::link::Reset;

use crate::hal::pac;
use crate::platform::note;

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    stop_for_good(Reset::Panic)
}

motorlens_firmware::hard_fault!(core_fault);

/// A fault of the core, on a new stack.
extern "C" fn core_fault() -> ! {
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
    of_bridge(|pin| pin.gpio_ctrl().modify(|_, w| w.outover().low()));
}

/// Lets the peripherals have the bridge's pins again, which are set up by the time a run begins.
pub fn let_bridge() {
    of_bridge(|pin| pin.gpio_ctrl().modify(|_, w| w.outover().normal()));
}

/// Both PWMs, direction forward, enable, direction backward. By their numbers, so that none of them can be out of bounds: a look
/// that panics would panic in the panic's own handler.
#[inline(always)]
fn of_bridge<R>(act: impl Fn(&pac::io_bank0::GPIO) -> R) {
    // SAFETY: registers of the bridge's pins, which exist from the start on; what is written only takes outputs low or lets them go.
    let bank = unsafe { &*pac::IO_BANK0::ptr() };
    for pin in [bank.gpio(6), bank.gpio(7), bank.gpio(8), bank.gpio(9), bank.gpio(11)] {
        act(pin);
    }
}
