//! A panic or a fault of the core, from whatever place, must not leave the motor driven.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};

use crate::hal::pac;

/// PWM, direction forward and backward, enable.
const BRIDGE: [usize; 4] = [6, 7, 8, 9];

#[panic_handler]
fn panic(_: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    wait_for_the_watchdog()
}

/// An access without an address, an instruction without a meaning, a broken stack: nothing is trusted but the registers.
#[exception]
unsafe fn HardFault(_: &ExceptionFrame) -> ! {
    bridge_off();
    wait_for_the_watchdog()
}

/// An interrupt that nobody asked for.
#[exception]
unsafe fn DefaultHandler(_: i16) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    wait_for_the_watchdog()
}

fn wait_for_the_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// Forces the bridge's pins low behind every peripheral (OUTOVER, RP2040 datasheet section 2.19.6.1): whatever the PWM
/// and the port do from now on, the pins stay low until the reset, which lets go of them all.
fn bridge_off() {
    for pin in BRIDGE {
        // SAFETY: writes that only take outputs low, of registers that exist from the start on, with interrupts off.
        unsafe { (*pac::IO_BANK0::ptr()).gpio(pin).gpio_ctrl().modify(|_, w| w.outover().low()) };
    }
}
