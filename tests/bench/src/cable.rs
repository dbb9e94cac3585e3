//! The serial line between board and host.

use std::collections::VecDeque;

use rand::rngs::ChaCha8Rng;
use rand::{RngExt, SeedableRng};
use rigless::chip::Timeline;
use rigless::chip::uart::Peer;
use rigless::snapshot::Store;
use rigless::time::VirtualNanos;

/// The far end of the chip's UART: bytes as the wire carries them.
#[derive(Debug, Default)]
pub struct Socket {
    /// From the board, not yet taken.
    pub from_board: Vec<u8>,
    /// To the board, not yet sent.
    pub to_board: VecDeque<u8>,
}

impl Store for Socket {}

impl Peer for Socket {
    fn receive(&mut self, word: u16, _: &mut Timeline<'_, '_>) {
        self.from_board.push(word as u8);
    }

    fn transmit(&mut self, _: VirtualNanos) -> Option<u16> {
        self.to_board.pop_front().map(u16::from)
    }
}

/// What the cable does to the bytes on it.
#[derive(Debug)]
pub struct Cable {
    /// Share of bytes that are damaged or dropped, half each.
    pub bad: f64,
    /// Whether it is plugged out.
    pub out: bool,
    /// Bytes that it damaged or dropped.
    pub spoiled: u64,
    rng: ChaCha8Rng,
}

impl Cable {
    /// A cable that spoils this share of bytes, the same ones for the same seed.
    pub fn new(bad: f64, seed: u64) -> Self {
        Cable { bad, out: false, spoiled: 0, rng: ChaCha8Rng::seed_from_u64(seed) }
    }

    /// What arrives of these bytes.
    pub fn carry(&mut self, bytes: &[u8]) -> Vec<u8> {
        if self.out {
            return Vec::new();
        }
        let mut arrived = Vec::with_capacity(bytes.len());
        for byte in bytes {
            if self.bad > 0.0 && self.rng.random::<f64>() < self.bad {
                self.spoiled += 1;
                if self.rng.random::<bool>() {
                    arrived.push(byte ^ (1 << self.rng.random_range(0..8)));
                }
            } else {
                arrived.push(*byte);
            }
        }
        arrived
    }
}
