//! The converter (RP2350 data sheet 12.4). The emulator's makes up what it reads, and puts the input's number beside it into its FIFO.

use std::collections::VecDeque;

use crate::chip::CORE_HZ;
use crate::registers::{address, written};

/// Where its registers are.
pub const CONVERTER: std::ops::Range<u32> = 0x400a_0000..0x400a_0024;
/// Where a reading is fetched.
pub const FIFO: u32 = CONVERTER.start + 0x0c;
const CS: u32 = CONVERTER.start;
const RESULT: u32 = CONVERTER.start + 0x04;
const FCS: u32 = CONVERTER.start + 0x08;
const DIV: u32 = CONVERTER.start + 0x10;
/// CS: a single conversion, one after the other, none under way; where the input stands, and which of nine take turns.
const START_ONCE: u32 = 1 << 2;
const START_MANY: u32 = 1 << 3;
const READY: u32 = 1 << 8;
const AINSEL: u32 = 12;
const RROBIN: u32 = 16;
const INPUTS: u32 = 9;
/// FCS: readings go to the FIFO, the DMA is asked; what the FIFO has, and what has gone wrong with it.
const EN: u32 = 1;
const DREQ_EN: u32 = 1 << 3;
const EMPTY: u32 = 1 << 8;
const FULL: u32 = 1 << 9;
const UNDER: u32 = 1 << 10;
const OVER: u32 = 1 << 11;
const LEVEL: u32 = 16;
const THRESH: u32 = 24;
/// Of it what a program sets: the first four bits, and from how many readings on the DMA is asked.
const SET: u32 = 0xf | 0xf << THRESH;
const DEPTH: usize = 8;
/// Time is counted in parts: so many to a cycle of the core, and of the converter's own clock of 48 MHz, of which a conversion takes 96.
const CORE_CYCLE: u64 = 48;
const OWN_CYCLE: u64 = CORE_HZ / 1_000_000;
const CONVERSION: u64 = 96 * OWN_CYCLE;
/// Its supply, V, and what it reads there.
const FULL_SCALE_V: f64 = 3.3;
const FULL_SCALE: f64 = 4095.0;
/// The PWM's period, cycles of the core: 20 kHz.
const PWM_CYCLES: u64 = CORE_HZ / 20_000;

/// The converter, and what is at its first two inputs.
#[derive(Default)]
pub struct Converter {
    /// Volts at inputs 0 and 1; at the others there is nothing.
    pub pins: [f64; 2],
    /// A saw-tooth on input 0, V from end to end, as often as the PWM's pulses.
    pub ripple_v: f64,
    control: u32,
    fifo_control: u32,
    divider: u32,
    result: u16,
    fifo: VecDeque<u16>,
    converts: bool,
    /// Parts since the conversion that began last.
    since: u64,
    cycles: u64,
}

impl Converter {
    /// Goes on for so many cycles of the core, fewer than a conversion takes.
    pub fn advance(&mut self, cycles: u32) {
        self.cycles += u64::from(cycles);
        self.since += u64::from(cycles) * CORE_CYCLE;
        if self.converts && self.since >= CONVERSION {
            self.end_conversion();
        }
        let period = self.period();
        if self.control & START_MANY != 0 && self.since >= period {
            self.since -= period;
            self.converts = true;
        }
    }

    /// Parts from one conversion to the next: back to back, or as often as the divider says.
    fn period(&self) -> u64 {
        if self.divider == 0 { CONVERSION } else { u64::from((self.divider >> 8) + 1) * OWN_CYCLE }
    }

    fn end_conversion(&mut self) {
        self.converts = false;
        let input = self.control >> AINSEL & 0xf;
        let ended = self.cycles - (self.since - CONVERSION) / CORE_CYCLE;
        self.result = (self.volts(input, ended) / FULL_SCALE_V * FULL_SCALE).clamp(0.0, FULL_SCALE) as u16;
        let in_turn = self.control >> RROBIN;
        let next =
            (input + 1..=input + INPUTS).map(|next| next % INPUTS).find(|next| in_turn >> next & 1 != 0);
        if let Some(next) = next {
            self.control = self.control & !(0xf << AINSEL) | next << AINSEL;
        }
        if self.fifo_control & EN == 0 {
            return;
        }
        if self.fifo.len() < DEPTH {
            self.fifo.push_back(self.result);
        } else {
            self.fifo_control |= OVER;
        }
    }

    fn volts(&self, input: u32, cycle: u64) -> f64 {
        let phase = (cycle % PWM_CYCLES) as f64 / PWM_CYCLES as f64;
        let ripple_v = if input == 0 { self.ripple_v * (phase - 0.5) } else { 0.0 };
        self.pins.get(input as usize).map_or(0.0, |volts| volts + ripple_v)
    }

    /// Whether the DMA is to fetch a reading.
    pub fn asks(&self) -> bool {
        let threshold = (self.fifo_control >> THRESH & 0xf) as usize;
        self.fifo_control & DREQ_EN != 0 && threshold > 0 && self.fifo.len() >= threshold
    }

    /// Takes a reading out of the FIFO.
    pub fn take(&mut self) -> u16 {
        if self.fifo.is_empty() {
            self.fifo_control |= UNDER;
        }
        self.fifo.pop_front().unwrap_or_default()
    }

    /// A register. None of the interrupts' is used.
    pub fn read(&mut self, register: u32) -> u32 {
        let flag = |holds: bool, bit: u32| if holds { bit } else { 0 };
        match register {
            CS => self.control | flag(!self.converts, READY),
            RESULT => self.result.into(),
            FCS => {
                let level = self.fifo.len();
                let state = flag(level == 0, EMPTY) | flag(level == DEPTH, FULL);
                self.fifo_control | state | (level as u32) << LEVEL
            }
            FIFO => self.take().into(),
            DIV => self.divider,
            _ => 0,
        }
    }

    /// Writes a register at `at`. What has gone wrong is forgotten where a 1 is written.
    pub fn write(&mut self, at: u32, value: u32) {
        match address(at) {
            CS => {
                let before = self.control;
                self.control = written(before, value, at) & !READY;
                assert_eq!(self.control & START_ONCE, 0, "a single conversion is not carried out here");
                if self.control & !before & START_MANY != 0 {
                    (self.since, self.converts) = (0, true);
                }
            }
            FCS => {
                let wrong = self.fifo_control & (UNDER | OVER) & !value;
                self.fifo_control = written(self.fifo_control, value, at) & SET | wrong;
            }
            DIV => {
                self.divider = written(self.divider, value, at);
                let is_whole = self.divider & 0xff == 0 && self.period() >= CONVERSION;
                assert!(is_whole, "conversions that are not whole cycles apart, or overlap");
            }
            _ => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two inputs in turn, a conversion each 97 cycles, as the image sets it.
    fn started() -> Converter {
        let mut converter = Converter { pins: [1.1, 1.65], ..Converter::default() };
        converter.write(FCS, EN | DREQ_EN | 1 << THRESH);
        converter.write(DIV, 96 << 8);
        converter.write(CS, 1 | START_MANY | 0b11 << RROBIN);
        converter
    }

    #[test]
    fn inputs_are_read_in_turn_as_often_as_the_divider_says() {
        let mut converter = started();
        let mut readings = Vec::new();
        // A millisecond of turns of 30 cycles: 494 conversions 97 cycles of 48 MHz apart.
        for _ in 0..5000 {
            converter.advance(30);
            if converter.asks() {
                readings.push(converter.take());
            }
        }
        assert_eq!(readings.len(), 494);
        assert!(readings.chunks_exact(2).all(|pair| pair == [1365, 2047]), "{readings:?}");
    }

    #[test]
    fn readings_that_nobody_fetches_are_lost_when_the_fifo_is_full_which_says_so() {
        let mut converter = started();
        for _ in 0..100 {
            converter.advance(30);
        }
        assert_eq!(converter.read(FCS) & (FULL | OVER | 0xf << LEVEL), FULL | OVER | 8 << LEVEL);
        converter.write(FCS, EN | OVER);
        (0..DEPTH).for_each(|_| assert_ne!(converter.read(FIFO), 0));
        assert_eq!(converter.read(FCS), EN | EMPTY);
        converter.take();
        assert_eq!(converter.read(FCS), EN | EMPTY | UNDER);
    }

    #[test]
    fn the_last_conversion_ends_after_the_converter_is_told_to_rest() {
        let mut converter = started();
        converter.write(CS, 1);
        assert_eq!(converter.read(CS) & READY, 0);
        (0..20).for_each(|_| converter.advance(30));
        assert_eq!(converter.read(CS) & READY, READY);
        assert_eq!(converter.read(FCS) >> LEVEL & 0xf, 1);
    }
}
