//! Supply and current: the converter goes round its inputs by itself, and the DMA keeps what it finds.
//!
//! A round is the supply and the current, one after the other and again, all the time that anything is wired to them. The sampling interrupt
//! adds up the rounds of an interval, which holds whole PWM periods, and how far apart conversions are is chosen so that rounds fall evenly
//! on those periods ([`most_even`]): neither the ripple nor the pulses of the bridge bias the mean. These chips have no reference that their
//! maker has calibrated: what the pin ADC_VREF has is taken as 3.3 V.

use core::sync::atomic::{AtomicU32, Ordering};

use motorlens_firmware::analog::{CALIBRATED_MV, Means, Sums, Wiring, most_even};
use motorlens_firmware::hardware::Analog;

use crate::chip::CORE_HZ;
use crate::hal::gpio::bank0::{Gpio26, Gpio27};
use crate::hal::gpio::{FunctionNull, Pin, PullNone};
use crate::hal::pac;

/// The pins of the converter's inputs 0, the supply, and 1, the current.
const PINS: [usize; 2] = [26, 27];
/// The converter's clock, MHz, and its cycles from one conversion to the next: one takes 96 (RP2040 data sheet 4.9.2, RP2350 12.4.3).
const CONVERTER_MHZ: u32 = 48;
const APART: [u32; 9] = [97, 101, 105, 109, 113, 117, 121, 125, 129];

/// Rounds that are kept, a power of two: the fastest takes 4.04 us, so they last for two of the sampling timer's interrupts, which are a
/// millisecond apart at most.
const ROUNDS: usize = 512;
const RING_BITS: u8 = 11;
/// Two channels of the DMA, 0 and 1, begin each other, each after so many readings: whole rings, and no more than either chip counts.
const READINGS_EACH: u32 = 1 << 27;
/// Looks at what ends within some cycles.
const LOOKS: u32 = 1000;

/// Where the DMA writes, a round to a word: the supply in its lower half. Its address ends with as many zeros as the DMA turns round.
#[repr(align(2048))]
struct Ring([AtomicU32; ROUNDS]);
static RING: Ring = Ring([const { AtomicU32::new(0) }; ROUNDS]);
/// Cycles between two conversions, from the next time on that it is said what is wired.
static SPACING: AtomicU32 = AtomicU32::new(APART[0]);

/// The core's ticks of a round.
fn round_ticks(apart: u32) -> u32 {
    2 * apart * (CORE_HZ / 1_000_000) / CONVERTER_MHZ
}

/// Chooses the round for `interval` ticks of the core, which hold whole PWM periods of `period` ticks.
pub fn fit_round(period: u32, interval: u32) {
    let ticks = most_even(period, interval, APART.into_iter().map(round_ticks));
    let apart = APART.into_iter().find(|apart| round_ticks(*apart) == ticks);
    SPACING.store(apart.unwrap_or(APART[0]), Ordering::Relaxed);
}

/// The converter and its two inputs.
pub struct Sense {
    _inputs: (Pin<Gpio26, FunctionNull, PullNone>, Pin<Gpio27, FunctionNull, PullNone>),
    wiring: Wiring,
    sums: Sums,
    read: usize,
}

impl Sense {
    /// Takes the converter, the DMA and the pins.
    pub fn new(
        _: pac::ADC,
        _: pac::DMA,
        resets: &mut pac::RESETS,
        supply: Pin<Gpio26, FunctionNull, PullNone>,
        current: Pin<Gpio27, FunctionNull, PullNone>,
    ) -> Self {
        resets.reset().modify(|_, w| w.adc().clear_bit().dma().clear_bit());
        while resets.reset_done().read().adc().bit_is_clear()
            || resets.reset_done().read().dma().bit_is_clear()
        {}
        // SAFETY: registers of these pins, and of the converter, which is this module's alone. An input that is read as a level too would
        // load what it measures.
        unsafe {
            for pin in PINS {
                (*pac::PADS_BANK0::ptr()).gpio(pin).modify(|_, w| w.ie().clear_bit().od().set_bit());
            }
            (*pac::ADC::ptr()).cs().write(|w| w.en().set_bit());
        }
        Sense { _inputs: (supply, current), wiring: Wiring::default(), sums: Sums::new(), read: 0 }
    }
}

/// Ends the rounds, and forgets what is under way.
fn rest() {
    // SAFETY: the converter and both channels are this module's alone. A channel that is to be aborted must not begin the other
    // (RP2040 data sheet 2.5.5.3, RP2350-E5).
    unsafe {
        let (converter, dma) = (&*pac::ADC::ptr(), &*pac::DMA::ptr());
        converter.cs().modify(|_, w| w.start_many().clear_bit());
        let _ = (0..LOOKS).any(|_| converter.cs().read().ready().bit_is_set());
        for channel in [dma.ch(0), dma.ch(1)] {
            channel.ch_al1_ctrl().write(|w| w.bits(0));
        }
        dma.chan_abort().write(|w| w.bits(0b11));
        let _ = (0..LOOKS).any(|_| dma.chan_abort().read().bits() == 0);
        let _ = (0..LOOKS).any(|_| {
            let _ = converter.fifo().read();
            converter.fcs().read().empty().bit_is_set()
        });
    }
}

/// Starts the rounds.
fn begin() {
    rest();
    // SAFETY: as in `rest`; the DMA writes inside RING only, as halfwords.
    unsafe {
        let (converter, dma) = (&*pac::ADC::ptr(), &*pac::DMA::ptr());
        converter.fcs().write(|w| {
            w.en().set_bit().dreq_en().set_bit().thresh().bits(1);
            w.over().clear_bit_by_one().under().clear_bit_by_one()
        });
        converter.div().write(|w| w.int().bits((SPACING.load(Ordering::Relaxed) - 1) as u16));
        for (channel, next) in [(dma.ch(0), 1), (dma.ch(1), 0)] {
            channel.ch_read_addr().write(|w| w.bits(converter.fifo().as_ptr() as u32));
            channel.ch_write_addr().write(|w| w.bits(RING.0.as_ptr() as u32));
            channel.ch_trans_count().write(|w| w.bits(READINGS_EACH));
            channel.ch_al1_ctrl().write(|w| w.bits(crate::chip::control_of_readings(next, RING_BITS)));
        }
        dma.multi_chan_trigger().write(|w| w.bits(0b01));
        converter
            .cs()
            .write(|w| w.en().set_bit().ainsel().bits(0).rrobin().bits(0b11).start_many().set_bit());
    }
}

/// The round that the DMA writes.
fn under_way() -> usize {
    // SAFETY: reads of this module's channels. Where the first is at its end, the second is at the ring's begin, as it is.
    let written = unsafe {
        let dma = &*pac::DMA::ptr();
        let busy = dma.ch(0).ch_ctrl_trig().read().busy().bit_is_set();
        if busy { dma.ch(0) } else { dma.ch(1) }.ch_write_addr().read().bits()
    };
    written.wrapping_sub(RING.0.as_ptr() as u32) as usize / 4 % ROUNDS
}

impl Analog for Sense {
    const CONVERTER: bool = true;

    fn wire(&mut self, wiring: Wiring) {
        (self.wiring, self.sums, self.read) = (wiring, Sums::new(), 0);
        if wiring == Wiring::default() { rest() } else { begin() }
    }

    fn gather(&mut self) -> Means {
        let before = self.sums;
        // SAFETY: a read of a status register.
        if unsafe { (*pac::ADC::ptr()).fcs().read().over().bit_is_set() } {
            // A reading was lost, and supply and current would change places. What is missing ends a run.
            self.wire(self.wiring);
            return Means::default();
        }
        let end = under_way();
        self.sums.follow(&RING.0, self.read, end);
        self.read = end;
        self.sums.since(&before, self.wiring)
    }

    fn means(&mut self) -> Means {
        self.sums.take(self.wiring, CALIBRATED_MV)
    }
}
