//! Frames that a bad line has spoiled, and what the link's decoder makes of them.

use motorlens_shared::link::{Damage, Decoder, MAX_ENCODED, Packet, ToBoard, encode};

/// Frames that are spoiled.
const FRAMES: u32 = 20_000;

/// A small fast generator (xorshift32, Marsaglia 2003).
struct Random(u32);

impl Random {
    fn below(&mut self, n: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 17;
        self.0 ^= self.0 << 5;
        self.0 as usize % n
    }
}

/// Sends frames with bytes changed and dropped through the decoder and condenses its verdicts, in order, to one number.
pub fn verdicts() -> u32 {
    let mut random = Random(2_463_534_242);
    let mut decoder = Decoder::new();
    let mut condensed = 0_u32;
    for number in 0..FRAMES {
        let message = ToBoard::ReadLog { first: number, count: number as u16 };
        let mut frame = [0; MAX_ENCODED];
        let Ok(frame) = encode(&Packet { id: number as u16, message }, &mut frame) else { continue };
        for byte in frame.iter() {
            let byte = match random.below(20) {
                0 => continue,
                1 => random.below(256) as u8,
                _ => *byte,
            };
            let verdict = match decoder.push::<Packet<ToBoard>>(byte) {
                None => continue,
                Some(Ok(packet)) => u32::from(packet.id),
                Some(Err(Damage::TooLong)) => 1 << 16,
                Some(Err(Damage::Stuffing)) => 2 << 16,
                Some(Err(Damage::Checksum)) => 3 << 16,
                Some(Err(Damage::Meaning)) => 4 << 16,
            };
            condensed = (condensed ^ verdict).wrapping_mul(16_777_619);
        }
    }
    condensed
}
