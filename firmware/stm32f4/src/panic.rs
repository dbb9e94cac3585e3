//! A panic or a fault of the core, from whatever place, must not leave the motor driven.

use core::panic::PanicInfo;

use cortex_m_rt::{ExceptionFrame, exception};
use motorlens_shared::link::Reset;
use stm32f4xx_hal::pac;

use crate::platform::note;

/// Takes the bridge down by registers alone (nothing that may itself be broken is called), says why over RTT, and
/// waits for the watchdog to start the board anew.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    note(Reset::Panic);
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
    note(Reset::CoreFault);
    wait_for_the_watchdog()
}

/// The crystal has stopped (RM0090 7.2.7): the chip runs on by its own oscillator, at another speed, and the timers' clocks
/// mean nothing any more. The timer's break has taken the PWM away by then. The watchdog has an oscillator of its own.
#[exception]
unsafe fn NonMaskableInt() -> ! {
    bridge_off();
    note(Reset::Clock);
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
    defmt::error!("the program stops: {}", reason as u8);
    wait_for_the_watchdog()
}

fn wait_for_the_watchdog() -> ! {
    loop {
        cortex_m::asm::nop();
    }
}

/// Disables the timer's outputs, PWM and enable together; they do not come back at its next period (AOE). Their pins and the
/// direction pins are pulled low as well, taken from the timer: whatever it does then, they stay low.
fn bridge_off() {
    // SAFETY: writes that only clear outputs, of registers that exist from reset on.
    unsafe {
        (*pac::TIM1::ptr()).bdtr().modify(|_, w| w.aoe().clear_bit().moe().clear_bit());
        (*pac::GPIOB::ptr()).bsrr().write(|w| w.br15().set_bit().br0().set_bit().br1().set_bit());
        (*pac::GPIOB::ptr()).moder().modify(|_, w| w.moder15().output());
        (*pac::GPIOA::ptr()).bsrr().write(|w| w.br8().set_bit().br9().set_bit());
        (*pac::GPIOA::ptr()).moder().modify(|_, w| w.moder8().output().moder9().output());
    }
}
