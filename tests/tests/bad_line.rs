//! A line that damages or drops a share of its bytes, in both directions: the host's capture and the board's own program lose no sample.
//!
//! The line carries no more than a real one does in the time, so a log that comes whole has come while the board's memory lasted.

// What the firmware's own tests run on; they use more of it.
#[allow(dead_code)]
#[path = "../../firmware/tests/bench/mod.rs"]
mod bench;

use std::time::Duration;

use bench::{Bench, Cable};
use motorlens::device::{Capture, Captured};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Cause, Setup};

/// A turn of both ends.
const TURN_US: u32 = 500;
/// What a line of 921,600 baud carries in it, bytes.
const CARRIED: usize = 46;
/// What the board gives to the line at once.
const SEND: usize = 256;

/// Spoils a share of the bytes, half of them damaged in one bit and half of them lost (xorshift64*, Vigna 2016).
struct Noise {
    state: u64,
    share: f64,
    spoiled: u32,
    carried: u32,
}

impl Noise {
    fn next(&mut self) -> u64 {
        self.state ^= self.state >> 12;
        self.state ^= self.state << 25;
        self.state ^= self.state >> 27;
        self.state.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 16
    }

    fn carry(&mut self, byte: u8) -> Option<u8> {
        let chance = self.next() as f64 / (1_u64 << 48) as f64;
        self.carried += 1;
        self.spoiled += u32::from(chance < self.share);
        match chance {
            chance if chance < self.share / 2.0 => None,
            chance if chance < self.share => Some(byte ^ 1 << (self.next() % 8)),
            _ => Some(byte),
        }
    }
}

/// A run over such a line: what the host has of it, the counts that the board sampled, and the frames that could not be read.
fn run(share: f64, rate_hz: u16, seconds: f32, seed: u64) -> (Captured, Vec<i32>, u64) {
    let link_timeout_ms = (500_000 / u32::from(rate_hz)).min(500) as u16;
    let setup = Setup { rate_hz, link_timeout_ms, ..Setup::default() };
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 0.25, high_hz: 8.0, tones: 8, seed: 1 };
    let mut capture = Capture::new(setup, &Programme::single("multisine", shape, seconds), 1_790_000_000);
    let mut bench = Bench::new(&[]);
    let (mut line, mut noise) = (
        Cable { room: 1, at_once: SEND, ..Cable::default() },
        Noise { state: seed, share, spoiled: 0, carried: 0 },
    );
    let mut counts = Vec::new();
    let mut until_sample_us = 0;
    for turn in 0.. {
        let now = Duration::from_micros(turn * u64::from(TURN_US));
        bench.control(|control| {
            let rate = control.setup().rate_hz;
            let rig = control.hardware_mut();
            let bridge = rig.bridge;
            rig.motor.advance(f64::from(TURN_US) * 1e-6, bridge);
            rig.now_us = rig.now_us.wrapping_add(TURN_US);
            until_sample_us += TURN_US;
            if until_sample_us >= 1_000_000 / u32::from(rate) {
                until_sample_us = 0;
                control.tick();
                let next = control.log().next();
                if next as usize > counts.len()
                    && let Some(sample) = control.log().get(next - 1)
                {
                    counts.push(sample.count);
                }
            }
        });
        bench.station.poll(&mut line, bench.control, &mut bench.rest);
        let carried = line.to_host.len().min(CARRIED);
        let received: Vec<u8> = line.to_host.drain(..carried).filter_map(|byte| noise.carry(byte)).collect();
        capture.receive(&received, now);
        let mut send = Vec::new();
        capture.poll(now, &mut send);
        line.to_board.extend(send.into_iter().filter_map(|byte| noise.carry(byte)));
        if let Some(outcome) = capture.take_outcome() {
            let expected = share * f64::from(noise.carried);
            assert!(share < 0.01 || f64::from(noise.spoiled) > 0.8 * expected, "the line is not that bad");
            return (outcome.expect("the run goes through"), counts, capture.damaged());
        }
    }
    unreachable!("every run has an outcome")
}

#[test]
fn up_to_a_tenth_of_the_bytes_spoiled_loses_no_sample() {
    println!("bytes spoiled  samples/s  samples lost  frames lost");
    for share in [0.0, 0.001, 0.02, 0.05, 0.08, 0.1] {
        for (rate_hz, seed) in [(1000, 7), (2000, 8), (100, 9)] {
            let seconds = 4.0;
            let (captured, counts, damaged) = run(share, rate_hz, seconds, seed);
            let samples = (seconds * f32::from(rate_hz)) as usize;
            let lost: u32 = captured.holes.iter().map(|hole| hole.end - hole.start).sum();
            println!("{:>11} % {rate_hz:>10} {lost:>13} {damaged:>12}", 100.0 * share);
            assert_eq!(captured.cause, Cause::Finished, "{share} at {rate_hz} Hz");
            assert_eq!((captured.samples.len(), lost), (samples, 0), "{share} at {rate_hz} Hz");
            let heard: Vec<i32> = captured.samples.iter().map(|(_, sample)| sample.count).collect();
            assert_eq!(heard, counts, "{share} at {rate_hz} Hz");
        }
    }
}
