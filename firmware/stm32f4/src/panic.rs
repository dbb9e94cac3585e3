//! A panic or a fault of the core, from whatever place, must not leave the motor driven.

use core::mem::MaybeUninit;
use core::panic::PanicInfo;

use cortex_m_rt::exception;
use motorlens_shared::link::Reset;
use stm32f4xx_hal::pac;

use crate::platform::note;

/// Takes the bridge down by registers alone (nothing that may itself be broken is called), notes the place, and waits for the
/// watchdog to start the board anew, which then says why ([`motorlens_firmware::diagnostics`]).
#[panic_handler]
fn panic(info: &PanicInfo) -> ! {
    cortex_m::interrupt::disable();
    bridge_off();
    note(Reset::Panic);
    // The place alone: the message would bring the whole of core's formatting into the image.
    if let Some(place) = info.location() {
        note_place(place.file(), place.line());
    }
    wait_for_the_watchdog()
}

/// Bytes of a file's name that are kept, its last ones.
const NAME: usize = 48;

/// Where the last panic was. Not cleared at the start; "pani", the line, the name's length, the name.
#[unsafe(link_section = ".uninit.PLACE")]
static mut PLACE: MaybeUninit<(u32, u32, usize, [u8; NAME])> = MaybeUninit::uninit();
const PLACED: u32 = 0x7061_6e69;

fn note_place(file: &str, line: u32) {
    let mut name = [0; NAME];
    let mut length = 0;
    for (place, byte) in name.iter_mut().zip(file.bytes().skip(file.len().saturating_sub(NAME))) {
        *place = byte;
        length += 1;
    }
    // SAFETY: memory that nothing else uses; interrupts are off.
    unsafe { (&raw mut PLACE).cast::<(u32, u32, usize, [u8; NAME])>().write((PLACED, line, length, name)) };
}

/// The last bytes of the file's name and the line of the panic that was noted, if one was.
pub fn last_place() -> Option<(&'static [u8], u32)> {
    // SAFETY: written by a panic alone, which does not return; integers, so any bytes are a value.
    let (mark, line, length, name) = unsafe { (*(&raw const PLACE)).assume_init_ref() };
    let name = name.get(..*length)?;
    (*mark == PLACED).then_some((name, *line))
}

motorlens_firmware::hard_fault!(core_fault);

/// A fault of the core, on a new stack.
extern "C" fn core_fault() -> ! {
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
