//! The device's side of the USB controller (RP2350 data sheet 12.7): what the emulator, whose registers never tell of a host, has not.
//! Its memory of two ports is the emulator's.

use crate::registers::{address, written};

/// Where the registers are that tell of a host.
pub const USB: std::ops::Range<u32> = 0x5011_0040..0x5011_009c;
const SIE_CTRL: u32 = 0x5011_004c;
const SIE_STATUS: u32 = 0x5011_0050;
const BUFF_STATUS: u32 = 0x5011_0058;
const INTR: u32 = 0x5011_008c;
const INTE: u32 = 0x5011_0090;
const INTS: u32 = 0x5011_0098;
/// SIE_CTRL: the device pulls its line up, which is how the host knows of it.
const PULLUP_EN: u32 = 1 << 16;
/// SIE_STATUS: the host has reset the bus, has sent a request.
const BUS_RESET: u32 = 1 << 19;
const SETUP_REC: u32 = 1 << 17;
/// INTR: a buffer is done, and these.
const INTR_BUFF_STATUS: u32 = 1 << 4;
const INTR_BUS_RESET: u32 = 1 << 12;
const INTR_SETUP_REQ: u32 = 1 << 16;

/// The controller's registers.
#[derive(Default)]
pub struct Usb {
    control: u32,
    status: u32,
    buffers: u32,
    enabled: u32,
}

impl Usb {
    /// A register, where it is one of these.
    pub fn read(&self, register: u32) -> Option<u32> {
        let raw = |flag: bool, bit: u32| if flag { bit } else { 0 };
        let interrupts = raw(self.buffers != 0, INTR_BUFF_STATUS)
            | raw(self.status & BUS_RESET != 0, INTR_BUS_RESET)
            | raw(self.status & SETUP_REC != 0, INTR_SETUP_REQ);
        match register {
            SIE_CTRL => Some(self.control),
            SIE_STATUS => Some(self.status),
            BUFF_STATUS => Some(self.buffers),
            INTR => Some(interrupts),
            INTE => Some(self.enabled),
            INTS => Some(interrupts & self.enabled),
            _ => None,
        }
    }

    /// Writes a register at `at`; whether it is one of these. What has happened is forgotten where a 1 is written.
    pub fn write(&mut self, at: u32, value: u32) -> bool {
        match address(at) {
            SIE_CTRL => self.control = written(self.control, value, at),
            SIE_STATUS => self.status &= !value,
            BUFF_STATUS => self.buffers &= !value,
            INTE => self.enabled = written(self.enabled, value, at),
            _ => return false,
        }
        true
    }

    /// Whether a device shows itself on the bus.
    pub fn present(&self) -> bool {
        self.control & PULLUP_EN != 0
    }

    /// The host resets the bus, or has put a request into the memory's first eight bytes.
    pub fn reset_bus(&mut self) {
        self.status |= BUS_RESET;
    }

    /// See [`Usb::reset_bus`].
    pub fn set_up(&mut self) {
        self.status |= SETUP_REC;
    }

    /// Whether the device has yet to see either.
    pub fn unseen(&self) -> bool {
        self.status & (BUS_RESET | SETUP_REC) != 0
    }

    /// The buffer of this number has been taken or filled: 2 for each endpoint, its IN before its OUT.
    pub fn done(&mut self, buffer: u32) {
        self.buffers |= 1 << buffer;
    }
}
