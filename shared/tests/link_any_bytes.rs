//! The decoder, host's and board's alike (it is one), on bytes of any kind: it never panics, and it finds its step again.

use motorlens_shared::excitation::{Segment, Shape};
use motorlens_shared::link::{
    Decoder, FromBoard, LogBlock, MAX_ENCODED, Packet, Sample, Setup, ToBoard, decode, encode,
};
use motorlens_shared::quickfit::Request;

/// Inputs per direction, host and board: ten million in an optimised build, a two-hundredth in a quick one.
const INPUTS: u64 = if cfg!(debug_assertions) { 50_000 } else { 10_000_000 };

/// A small fast generator (xorshift64*, Vigna 2016); the same inputs in every run.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        self.0.wrapping_mul(0x2545_f491_4f6c_dd1d)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() >> 33) as usize % n
    }
}

fn frame<M: serde::Serialize>(message: M) -> Vec<u8> {
    let mut out = [0; MAX_ENCODED];
    encode(&Packet { id: 77, message }, &mut out).unwrap().to_vec()
}

fn to_board() -> Vec<Vec<u8>> {
    let shape = Shape::Multisine { amplitude_v: 8.0, low_hz: 0.1, high_hz: 12.0, tones: 14, seed: 5 };
    let segment = Segment { shape, seconds: 10.0 };
    vec![
        frame(ToBoard::Hello { oldest: 1, newest: 1 }),
        frame(ToBoard::Configure(Setup::default())),
        frame(ToBoard::SetSegment { index: 2, name: "training".try_into().unwrap(), segment }),
        frame(ToBoard::ReadLog { first: 59_000, count: 64 }),
        frame(ToBoard::QuickFit(Request::default())),
    ]
}

fn from_board() -> Vec<Vec<u8>> {
    let sample = Sample { duty: -2100, count: -70_000, supply_mv: 12_000, current_ma: -900, late_us: -3 };
    let samples = std::iter::repeat_n(sample, 8).collect();
    vec![
        frame(FromBoard::Log(LogBlock { run: 9, first: 59_992, samples })),
        frame(FromBoard::EffectName("coulomb_asymmetric".try_into().unwrap())),
        frame(FromBoard::NotHeld { first: 3, count: 300 }),
    ]
}

/// A frame with a few bytes changed, dropped, doubled or cut, or bytes without any meaning.
fn spoiled(random: &mut Random, good: &[Vec<u8>], out: &mut Vec<u8>) {
    out.clear();
    if random.below(4) == 0 {
        let length = random.below(2 * MAX_ENCODED);
        out.extend((0..length).map(|_| random.next() as u8));
        return;
    }
    out.extend_from_slice(&good[random.below(good.len())]);
    for _ in 0..=random.below(3) {
        let at = random.below(out.len().max(1));
        match random.below(4) {
            0 if at < out.len() => out[at] = random.next() as u8,
            1 if at < out.len() => drop(out.remove(at)),
            2 => out.insert(at, random.next() as u8),
            _ => out.truncate(at),
        }
    }
}

fn attack<M>(good: &[Vec<u8>], seed: u64)
where
    M: serde::de::DeserializeOwned + serde::Serialize + PartialEq + std::fmt::Debug,
{
    let mut random = Random(seed);
    let mut input = Vec::new();
    let mut decoder = Decoder::new();
    for round in 0..INPUTS {
        spoiled(&mut random, good, &mut input);
        for byte in &input {
            if let Some(Ok(packet)) = decoder.push::<Packet<M>>(*byte) {
                // What is accepted can be sent again: no value escapes its type's bounds.
                let mut out = [0; MAX_ENCODED];
                assert!(encode(&packet, &mut out).is_ok());
            }
        }
        // Messages behind a right checksum, which only a faulty end would send.
        let mut plain = input.clone();
        plain.truncate(150);
        let sum = crc::Crc::<u32>::new(&crc::CRC_32_ISCSI).checksum(&plain).to_le_bytes();
        plain.extend(sum);
        let mut stuffed = [0; 256];
        let length = cobs::encode(&plain, &mut stuffed);
        let _ = decode::<Packet<M>>(&stuffed[..length]);
        if round % 64 == 0 {
            decoder.push::<Packet<M>>(0);
            let first = good[0].iter().filter_map(|byte| decoder.push::<Packet<M>>(*byte)).next();
            assert!(first.is_some_and(|packet| packet.is_ok()), "back in step after one terminator");
        }
    }
}

#[test]
fn requests_of_any_bytes_do_not_panic_the_board() {
    attack::<ToBoard>(&to_board(), 1);
}

#[test]
fn answers_of_any_bytes_do_not_panic_the_host() {
    attack::<FromBoard>(&from_board(), 2);
}
