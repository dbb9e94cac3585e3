//! What takes the bridge's pins off without the program: a dead man's handle and the emergency contact, both as interrupts
//! that nothing holds off (the core's NMI; RP2040 data sheet 2.20.2, SYSCFG: PROC0_NMI_MASK; RP2350 3.7.5.2, EPPB: NMI_MASK0).
//!
//! While the bridge is driven, the timer's second alarm stands half a millisecond after the next interrupt of the first, and
//! is moved on by it. Where that interrupt does not come, be the program's interrupts held off or the first alarm lost, the
//! second goes off. It also guards the contact, which acts at its edge and not at the next sample.

use core::convert::Infallible;
use core::sync::atomic::{AtomicBool, Ordering};

use cortex_m_rt::exception;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use motorlens_firmware::beat::GRACE_US;
use motorlens_shared::link::Reset;

use crate::chip::{self, ClockRegisters};
use crate::hal::gpio::bank0::{Gpio9, Gpio10};
use crate::hal::gpio::{FunctionSioInput, FunctionSioOutput, Pin, PullDown, PullUp};
use crate::hal::pac;
use crate::panic::{bridge_off, let_bridge, stop_for_good};

/// The contact's pin, and its rising edge among the eight pins of its register (four bits a pin, the last is the edge).
const CONTACT: u32 = 10;
const CONTACT_BANK: usize = 1;
const CONTACT_EDGE: u32 = 1 << ((CONTACT - 8) * 4 + 3);
/// A pulse that is gone after so many cycles, half a microsecond, is what the bridge's switching induces.
const PULSE: u32 = 60;

/// The bridge is driven.
static ARMED: AtomicBool = AtomicBool::new(false);
/// The contact has opened since.
static TRIPPED: AtomicBool = AtomicBool::new(false);

/// Lets alarm and contact ask for the NMI.
pub fn prepare(resets: &mut pac::RESETS) {
    resets.reset().modify(|_, w| w.syscfg().clear_bit());
    while resets.reset_done().read().syscfg().bit_is_clear() {}
    // SAFETY: registers of one pin's interrupt and of one alarm, which are this module's alone.
    unsafe {
        let bank = &*pac::IO_BANK0::ptr();
        bank.intr(CONTACT_BANK).write(|w| w.bits(CONTACT_EDGE));
        bank.proc0_inte(CONTACT_BANK).modify(|r, w| w.bits(r.bits() | CONTACT_EDGE));
        (*ClockRegisters::ptr()).inte().modify(|_, w| w.alarm_1().set_bit());
    }
    chip::route_to_nmi();
}

/// The sampling timer has interrupted, and will again at `next_us`.
pub fn renew(next_us: u32) {
    if ARMED.load(Ordering::Relaxed) {
        // SAFETY: the second alarm is this module's alone.
        unsafe { (*ClockRegisters::ptr()).alarm1().write(|w| w.bits(next_us.wrapping_add(GRACE_US))) };
    }
}

fn open() -> bool {
    // SAFETY: a read of the pins' levels.
    unsafe { (*pac::SIO::ptr()).gpio_in().read().bits() & (1 << CONTACT) != 0 }
}

/// The second alarm has gone off, or the contact's edge has come.
#[exception]
unsafe fn NonMaskableInt() {
    // SAFETY: this module's alarm and pin.
    let (late, edge) = unsafe {
        let bank = &*pac::IO_BANK0::ptr();
        let edge = bank.proc0_ints(CONTACT_BANK).read().bits() & CONTACT_EDGE != 0;
        bank.intr(CONTACT_BANK).write(|w| w.bits(CONTACT_EDGE));
        let timer = &*ClockRegisters::ptr();
        let late = timer.ints().read().alarm_1().bit_is_set();
        timer.intr().write(|w| w.alarm_1().clear_bit_by_one());
        (late, edge)
    };
    if !ARMED.load(Ordering::Relaxed) {
        return;
    }
    if late {
        // Whatever the program does, it no longer samples: the watchdog starts it anew.
        stop_for_good(Reset::Watchdog);
    }
    if edge {
        cortex_m::asm::delay(PULSE);
        if open() {
            bridge_off();
            TRIPPED.store(true, Ordering::Relaxed);
        }
    }
}

/// The driver's enable, which is also what arms the guard.
pub struct Enable(Pin<Gpio9, FunctionSioOutput, PullDown>);

impl Enable {
    /// Takes the pin.
    pub fn new(pin: Pin<Gpio9, FunctionSioOutput, PullDown>) -> Self {
        Enable(pin)
    }
}

impl ErrorType for Enable {
    type Error = Infallible;
}

impl OutputPin for Enable {
    fn set_high(&mut self) -> Result<(), Infallible> {
        if !ARMED.load(Ordering::Relaxed) {
            TRIPPED.store(false, Ordering::Relaxed);
            ARMED.store(true, Ordering::Relaxed);
            renew(crate::timers::next_us());
            let_bridge();
            // An edge before this moment was not for this run; a contact that stands open is.
            if open() {
                bridge_off();
                TRIPPED.store(true, Ordering::Relaxed);
            }
        }
        self.0.set_high()
    }

    fn set_low(&mut self) -> Result<(), Infallible> {
        let done = self.0.set_low();
        ARMED.store(false, Ordering::Relaxed);
        // SAFETY: takes the second alarm back (a 1 in ARMED disarms), and what it may have asked for.
        unsafe {
            let timer = &*ClockRegisters::ptr();
            timer.armed().write(|w| w.bits(1 << 1));
            timer.intr().write(|w| w.alarm_1().clear_bit_by_one());
        }
        done
    }
}

/// The emergency contact: its level, and whether it has opened since the bridge was driven.
pub struct Emergency(Pin<Gpio10, FunctionSioInput, PullUp>);

impl Emergency {
    /// Takes the pin.
    pub fn new(pin: Pin<Gpio10, FunctionSioInput, PullUp>) -> Self {
        Emergency(pin)
    }
}

impl ErrorType for Emergency {
    type Error = Infallible;
}

impl InputPin for Emergency {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        let tripped = ARMED.load(Ordering::Relaxed) && TRIPPED.load(Ordering::Relaxed);
        Ok(tripped || self.0.is_high()?)
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
