//! The DMA's first two channels (RP2350 data sheet 12.6), as far as they carry readings of the converter. The emulator's fetches those of its
//! own converter, and has two registers of the first alias at each other's places.

use crate::converter::FIFO;
use crate::registers::{address, written};

/// Where its registers are.
pub const DMA: std::ops::Range<u32> = 0x5000_0000..0x5000_046c;
/// A channel's registers, of the next one so much further on: of the aliases the first's control alone, whose writing begins nothing.
const CHANNEL: u32 = 0x40;
const READ_ADDR: u32 = 0x00;
const WRITE_ADDR: u32 = 0x04;
const TRANS_COUNT: u32 = 0x08;
const CTRL_TRIG: u32 = 0x0c;
const AL1_CTRL: u32 = 0x10;
/// What begins channels, and what ends them, a bit for each.
const MULTI_CHAN_TRIGGER: u32 = DMA.start + 0x450;
const CHAN_ABORT: u32 = DMA.start + 0x464;
/// A channel's control: on; how many bits of its addresses turn round, and which channel it begins at its end; it is under way.
const EN: u32 = 1;
const RING_SIZE: u32 = 8;
const CHAIN_TO: u32 = 13;
const IRQ_QUIET: u32 = 1 << 23;
const BUSY: u32 = 1 << 26;
/// The rest of it, as readings of the converter have to be carried: halfwords, to addresses that rise and turn round, at the converter's pace
/// (request 48).
const CARRIES: u32 = EN | 1 << 2 | 1 << 6 | 1 << 12 | 48 << 17;
const ANY: u32 = 0xf << RING_SIZE | 0xf << CHAIN_TO | IRQ_QUIET;

#[derive(Default)]
struct Channel {
    from: u32,
    to: u32,
    count: u32,
    left: u32,
    control: u32,
    busy: bool,
}

/// Both channels.
#[derive(Default)]
pub struct Dma {
    channels: [Channel; 2],
}

impl Dma {
    /// A register.
    pub fn read(&self, register: u32) -> u32 {
        if register == CHAN_ABORT {
            return 0;
        }
        let channel = &self.channels[number(register)];
        match register % CHANNEL {
            READ_ADDR => channel.from,
            WRITE_ADDR => channel.to,
            TRANS_COUNT => channel.left,
            CTRL_TRIG | AL1_CTRL => channel.control | if channel.busy { BUSY } else { 0 },
            _ => panic!("the DMA's register {register:#x} is not emulated"),
        }
    }

    /// Writes a register at `at`.
    pub fn write(&mut self, at: u32, value: u32) {
        let register = address(at);
        match register {
            MULTI_CHAN_TRIGGER => {
                (0..2).filter(|number| value >> number & 1 != 0).for_each(|number| self.begin(number))
            }
            CHAN_ABORT => {
                for (number, channel) in self.channels.iter_mut().enumerate() {
                    channel.busy &= value >> number & 1 == 0;
                }
            }
            _ => {
                let channel = &mut self.channels[number(register)];
                let held = match register % CHANNEL {
                    READ_ADDR => &mut channel.from,
                    WRITE_ADDR => &mut channel.to,
                    TRANS_COUNT => &mut channel.count,
                    AL1_CTRL => &mut channel.control,
                    _ => panic!("the DMA's register {register:#x} is not emulated"),
                };
                *held = written(*held, value, at);
            }
        }
    }

    fn begin(&mut self, number: usize) {
        let channel = &mut self.channels[number];
        if channel.control & EN == 0 || channel.busy {
            return;
        }
        assert_eq!(channel.count >> 28, 0, "it begins itself again, or has no end");
        (channel.left, channel.busy) = (channel.count, channel.count > 0);
    }

    /// Where the reading that the converter has goes, a halfword; nothing where no channel waits for one.
    pub fn carry(&mut self) -> Option<u32> {
        let number = self.channels.iter().position(|channel| channel.busy && channel.control & EN != 0)?;
        let channel = &mut self.channels[number];
        assert_eq!((channel.from, channel.control & !ANY), (FIFO, CARRIES), "not as readings are carried");
        let to = channel.to;
        let round: u32 = (1 << (channel.control >> RING_SIZE & 0xf)) - 1;
        channel.to = to & !round | (to + 2) & round;
        channel.left -= 1;
        if channel.left == 0 {
            channel.busy = false;
            let next = (channel.control >> CHAIN_TO & 0xf) as usize;
            if next != number {
                self.begin(next);
            }
        }
        Some(to)
    }
}

/// The channel to which a register belongs.
fn number(register: u32) -> usize {
    let number = ((register - DMA.start) / CHANNEL) as usize;
    assert!(number < 2, "the DMA's register {register:#x} is not emulated");
    number
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_channel_fills_its_ring_and_begins_the_other_which_begins_it_again() {
        let mut dma = Dma::default();
        for (number, next) in [(0, 1), (1, 0)] {
            let channel = DMA.start + CHANNEL * number;
            dma.write(channel + READ_ADDR, FIFO);
            dma.write(channel + WRITE_ADDR, 0x2000_0800);
            dma.write(channel + TRANS_COUNT, 4);
            dma.write(channel + AL1_CTRL, CARRIES | 3 << RING_SIZE | next << CHAIN_TO | IRQ_QUIET);
        }
        assert_eq!(dma.carry(), None, "not begun");
        dma.write(MULTI_CHAN_TRIGGER, 0b01);
        for round in 0..3 {
            for at in [0x2000_0800, 0x2000_0802, 0x2000_0804, 0x2000_0806] {
                assert_eq!(dma.carry(), Some(at), "round {round}");
            }
            let busy = [0, 1].map(|number| dma.read(DMA.start + CHANNEL * number + CTRL_TRIG) & BUSY != 0);
            assert_eq!(busy, [round % 2 == 1, round % 2 == 0]);
        }
        // Off first, so that neither begins the other (RP2350-E5), then ended.
        for number in 0..2 {
            dma.write(DMA.start + CHANNEL * number + AL1_CTRL, 0);
        }
        dma.write(CHAN_ABORT, 0b11);
        assert_eq!((dma.read(CHAN_ABORT), dma.carry()), (0, None));
    }
}
