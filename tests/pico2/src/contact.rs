//! The interrupt of the emergency contact's pin (RP2350 data sheet 9.11.1, INTR1, PROC0_INTE1, PROC0_INTS1). The emulator keeps the registers
//! and sees no edges.

use crate::registers::written;

/// The pin.
pub const CONTACT: u32 = 10;
/// The interrupt of all pins (RP2350 data sheet 3.2, IO_IRQ_BANK0).
pub const CONTACT_IRQ: u32 = 21;
/// Raw interrupts of GP8 to GP15, and which of them core 0 is to see and sees.
pub const INTR: u32 = 0x4002_8234;
pub const INTE: u32 = 0x4002_824c;
pub const INTS: u32 = 0x4002_827c;
/// Of a pin's four bits the last is its rising edge.
const RISING: u32 = 1 << ((CONTACT - 8) * 4 + 3);

/// The edges that have been seen, and what core 0 is to see.
#[derive(Default)]
pub struct Contact {
    raw: u32,
    enabled: u32,
}

impl Contact {
    /// The contact has opened.
    pub fn rises(&mut self) {
        self.raw |= RISING;
    }

    /// Whether core 0 is interrupted.
    pub fn asks(&self) -> bool {
        self.raw & self.enabled != 0
    }

    /// One of the three registers.
    pub fn read(&self, register: u32) -> u32 {
        match register {
            INTR => self.raw,
            INTE => self.enabled,
            _ => self.raw & self.enabled,
        }
    }

    /// Writes one of them at `address`. An edge is forgotten where a 1 is written.
    pub fn write(&mut self, address: u32, value: u32) {
        match crate::registers::address(address) {
            INTR => self.raw &= !value,
            INTE => self.enabled = written(self.enabled, value, address),
            _ => {}
        }
    }
}
