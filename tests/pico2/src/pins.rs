//! What the chip's pins do.

use crate::chip::Chip;

/// Control of the first pin (RP2350 data sheet 9.11.1, GPIO0_CTRL), of each other 8 bytes on.
pub const IO_BANK0: u32 = 0x4002_8004;
/// Its pad (9.11.3, GPIO0), of each other 4 bytes on.
const PADS_BANK0: u32 = 0x4003_8004;
/// What the port's pins have (3.1.11, GPIO_OUT).
const GPIO_OUT: u32 = 0xd000_0010;
/// Which of them are outputs (GPIO_OE), a bit for each.
pub const GPIO_OE: u32 = 0xd000_0030;
/// The PWM's slice of GP6 and GP7 (12.5.3, CH3_CSR): control, and from it compare values and top.
const PWM_SLICE: u32 = 0x400a_803c;
const CC: u32 = 0x0c;
const TOP: u32 = 0x10;
/// What a pin is given to.
const PWM: u32 = 4;
const SIO: u32 = 5;
/// A pad that is shut off, or that is no output.
const ISOLATED: u32 = 1 << 8;
const DISABLED: u32 = 1 << 7;

/// The bridge's: both PWMs, enable, direction forward and backward.
pub const BRIDGE: [u32; 5] = [6, 7, 9, 8, 11];

impl Chip {
    /// The share of time that a pin of the bridge is high; 0 where nothing drives it, for there its driver pulls it down.
    pub fn share(&mut self, pin: u32) -> f64 {
        let [control, pad] = [IO_BANK0 + 8 * pin, PADS_BANK0 + 4 * pin].map(|register| self.read(register));
        if pad & (ISOLATED | DISABLED) != 0 {
            return 0.0;
        }
        let given = match control & 0x1f {
            SIO => f64::from(self.read(GPIO_OUT) & self.read(GPIO_OE) & 1 << pin != 0),
            PWM => self.pwm(pin),
            _ => 0.0,
        };
        // OUTOVER: as it is, turned over, low, high.
        match control >> 12 & 3 {
            0 => given,
            1 => 1.0 - given,
            2 => 0.0,
            _ => 1.0,
        }
    }

    /// The share that the slice makes of the first or the second of its pins.
    fn pwm(&mut self, pin: u32) -> f64 {
        let [control, compare, top] = [0, CC, TOP].map(|register| self.read(PWM_SLICE + register));
        let compare = if pin.is_multiple_of(2) { compare & 0xffff } else { compare >> 16 };
        if control & 1 == 0 { 0.0 } else { (f64::from(compare) / f64::from(top + 1)).min(1.0) }
    }

    /// Whether every pin of the bridge is low.
    pub fn bridge_off(&mut self) -> bool {
        BRIDGE.iter().all(|pin| self.share(*pin) == 0.0)
    }
}
