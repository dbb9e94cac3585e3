//! A panic or a fault of the core, from whatever place, must not leave the motor driven.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use stm32f4xx_hal::pac;

/// Takes the bridge down by registers alone (nothing that may itself be broken is called), says why over RTT, and
/// waits for the watchdog to start the board anew.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    // The place alone: the message would bring the whole of core's formatting into the image.
    if let Some(place) = info.location() {
        defmt::error!("panic at {}:{}", place.file(), place.line());
    }
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

/// Pulls the enable pin and the direction pins low and takes the PWM's output away.
fn bridge_off() {
    // SAFETY: writes that only clear outputs, of registers that exist from reset on, with interrupts off.
    unsafe {
        (*pac::GPIOB::ptr()).bsrr().write(|w| w.br10().set_bit().br0().set_bit().br1().set_bit());
        (*pac::TIM1::ptr()).bdtr().modify(|_, w| w.moe().clear_bit());
    }
}
