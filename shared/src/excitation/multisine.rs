//! A sum of sines with a known crest.

use super::MAX_TONES;
use super::phase;
use super::sequence::hash;
use heapless::Vec;

/// The tones of one segment, ready to be summed.
pub type Tones = Vec<Tone, MAX_TONES>;

/// One sine: amplitude in volts, phase per sample and at the start in units of 2^-32 turns.
#[derive(Debug, Clone, Copy)]
pub struct Tone {
    amplitude_v: f32,
    turn: u32,
    start: u32,
}

impl Tone {
    /// Its voltage at sample `k`.
    #[inline]
    pub fn volts(&self, k: u32) -> f32 {
        let phase = self.turn.wrapping_mul(k).wrapping_add(self.start);
        self.amplitude_v * phase::sine(phase)
    }
}

/// Tones on harmonics of the segment, so that the record is periodic and the crest can be scanned exactly.
pub fn prepare(
    amplitude_v: f32,
    (low, high): (f32, f32),
    tones: u8,
    seed: u32,
    samples: u32,
    alive: &mut dyn FnMut(),
) -> Tones {
    let mut list = Tones::new();
    let mut last = 0;
    for index in 0..u32::from(tones) {
        let share = index as f32 / (tones - 1).max(1) as f32;
        let harmonic = libm::roundf(low * libm::powf(high / low, share)).max(1.0) as u32;
        if harmonic > last {
            last = harmonic;
            list.extend([Tone {
                amplitude_v: libm::powf(harmonic as f32, -0.3),
                turn: harmonic, // per segment; per sample below
                start: hash(seed, index),
            }]);
        }
    }
    // On a grid of 16 or more points per cycle of the highest tone the crest of a trigonometric
    // polynomial exceeds the largest grid value by at most 1 / cos(pi / 16) (Ehlich and Zeller 1964).
    const BETWEEN_POINTS: f32 = 1.019_592;
    let points = (16 * last).next_power_of_two();
    let stride = ((1u64 << 32) / u64::from(points)) as u32;
    let crest = (0..points)
        .map(|point| {
            if point % 1024 == 0 {
                alive();
            }
            let sum: f32 = list
                .iter()
                .map(|tone| {
                    let phase = tone.turn.wrapping_mul(point).wrapping_mul(stride);
                    tone.amplitude_v * phase::sine(phase.wrapping_add(tone.start))
                })
                .sum();
            sum.abs()
        })
        .fold(f32::MIN_POSITIVE, f32::max);
    let scale = amplitude_v / (crest * BETWEEN_POINTS);
    for tone in &mut list {
        tone.amplitude_v *= scale;
        tone.turn = ((u64::from(tone.turn) << 32) / u64::from(samples)) as u32;
    }
    list
}
