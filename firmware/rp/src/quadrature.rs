//! The encoder's counter: the library's program on the first state machine of PIO 0.

use motorlens_firmware::hardware::Encoder;
use motorlens_firmware::quadrature::{ENTRY, PROGRAM, WRAP};

use crate::hal::gpio::bank0::{Gpio2, Gpio3};
use crate::hal::gpio::{FunctionSioInput, Pin, PullUp};
use crate::hal::pac;

type Input<I> = Pin<I, FunctionSioInput, PullUp>;

/// Where the first line is; the second is the next pin.
const FIRST_PIN: u8 = 2;
/// A fresh word comes within one turn of the program, some eleven cycles; a machine that stands never brings one.
const PATIENCE: u32 = 1000;

/// Words that the receive FIFO holds.
const FIFO: u32 = 4;

/// The state machine. Both pins are its own.
pub struct Counter {
    pio: pac::PIO0,
    last: u16,
    _lines: (Input<Gpio2>, Input<Gpio3>),
}

impl Counter {
    /// Loads the program and starts it at 0.
    pub fn new(pio: pac::PIO0, resets: &mut pac::RESETS, a: Input<Gpio2>, b: Input<Gpio3>) -> Self {
        resets.reset().modify(|_, w| w.pio0().clear_bit());
        while resets.reset_done().read().pio0().bit_is_clear() {}
        // SAFETY: the block is this function's alone, and every value below is one of its registers' values.
        unsafe {
            for (place, instruction) in PROGRAM.iter().enumerate() {
                pio.instr_mem(place).write(|w| w.instr_mem0().bits(*instruction));
            }
            let machine = pio.sm(0);
            machine.sm_clkdiv().write(|w| w.int().bits(1).frac().bits(0));
            machine.sm_execctrl().write(|w| w.wrap_bottom().bits(WRAP.0).wrap_top().bits(WRAP.1));
            // OUT takes the lowest bits first, IN makes room for new ones there.
            machine.sm_shiftctrl().write(|w| w.out_shiftdir().set_bit().in_shiftdir().clear_bit());
            machine.sm_pinctrl().write(|w| w.in_base().bits(FIRST_PIN));
            // An unconditional jump, carried out at once.
            machine.sm_instr().write(|w| w.sm0_instr().bits(ENTRY.into()));
            pio.ctrl().write(|w| w.sm_enable().bits(1));
        }
        Counter { pio, last: 0, _lines: (a, b) }
    }
}

impl Encoder for Counter {
    fn count(&mut self) -> u16 {
        let empty = || self.pio.fstat().read().rxempty().bits() & 1 != 0;
        // What has waited is old; as many words as the FIFO holds, for the program goes on filling it.
        for _ in 0..FIFO {
            if !empty() {
                let _ = self.pio.rxf(0).read().bits();
            }
        }
        for _ in 0..PATIENCE {
            if !empty() {
                self.last = self.pio.rxf(0).read().bits() as u16;
                break;
            }
        }
        self.last
    }
}
