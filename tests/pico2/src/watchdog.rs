//! The watchdog (RP2350 data sheet 12.9). The emulator's counts its own turns in the place of microseconds, and does not say why the chip
//! started.

use crate::registers::written;

/// Where its registers are.
pub const WATCHDOG: std::ops::Range<u32> = 0x400d_8000..0x400d_802c;
const CTRL: u32 = 0x00;
const LOAD: u32 = 0x04;
const REASON: u32 = 0x08;
const SCRATCH: u32 = 0x0c;
const ENABLE: u32 = 1 << 30;
const TRIGGER: u32 = 1 << 31;
const TIME: u32 = 0x00ff_ffff;
/// Why the chip started: its time was over, or a program forced it.
const TIMER: u32 = 1;
const FORCE: u32 = 2;

/// Counter, reason and the registers that live through a restart.
#[derive(Default)]
pub struct Watchdog {
    control: u32,
    time: u32,
    reason: u32,
    scratch: [u32; 8],
    expired: u32,
}

impl Watchdog {
    /// A register, by its offset.
    pub fn read(&self, offset: u32) -> u32 {
        match offset {
            CTRL => self.control | self.time,
            REASON => self.reason,
            SCRATCH.. => self.scratch[(offset - SCRATCH) as usize / 4],
            _ => 0,
        }
    }

    /// Writes a register at `address`.
    pub fn write(&mut self, address: u32, value: u32) {
        match address & 0xfff {
            CTRL => {
                let control = written(self.control, value, address);
                self.control = control & !(TIME | TRIGGER);
                if control & TRIGGER != 0 {
                    self.expired = FORCE;
                }
            }
            LOAD => self.time = value & TIME,
            offset @ SCRATCH.. => {
                let scratch = &mut self.scratch[(offset - SCRATCH) as usize / 4];
                *scratch = written(*scratch, value, address);
            }
            _ => {}
        }
    }

    /// Whether it is on.
    pub fn counts(&self) -> bool {
        self.control & ENABLE != 0
    }

    /// Counts a tick.
    pub fn tick(&mut self) {
        self.time = self.time.saturating_sub(1);
        if self.time == 0 {
            self.expired = TIMER;
        }
    }

    /// Whether the chip has to start anew.
    pub fn expired(&self) -> bool {
        self.expired != 0
    }

    /// As it is after that start: what was noted is kept, and why is said.
    pub fn restarted(&self) -> Self {
        Self { reason: self.expired, scratch: self.scratch, ..Self::default() }
    }
}
