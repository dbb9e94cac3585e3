//! A panic, from whatever place, must not leave the motor driven.

use core::panic::PanicInfo;

use stm32f4xx_hal::pac;

/// Takes the bridge down by registers alone (nothing that may itself be broken is called), says why over RTT, and
/// waits for the watchdog to start the board anew.
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    defmt::error!("panic: {}", defmt::Display2Format(info));
    loop {
        cortex_m::asm::nop();
    }
}

/// Clears TIM1's main output enable (MOE): its outputs fall to their idle level, which is low, whatever state the
/// rest of the program is in.
pub fn bridge_off() {
    // SAFETY: a single-bit clear of a register that exists from reset on; interrupts are off or the caller owns TIM1.
    unsafe {
        (*pac::TIM1::ptr())
            .bdtr()
            .modify(|_, w| w.moe().clear_bit())
    };
}
