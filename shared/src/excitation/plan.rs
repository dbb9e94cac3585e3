//! A segment made ready for one sample rate: everything slow is done here, once, outside the interrupt.

use super::multisine::{self, Tones};
use super::phase::{self, TURN};
use super::sequence::permute;
use super::{Fault, Segment, Shape};

/// Times of one cycle of pulse and coast: (seconds, share of the amplitude).
const PULSES: [(f32, f32); 12] = [
    (0.8, 1.0),
    (0.7, 0.0),
    (0.8, -1.0),
    (0.7, 0.0),
    (0.5, 0.5),
    (0.5, 0.0),
    (0.5, -0.5),
    (0.5, 0.0),
    (0.4, 1.0),
    (0.4, -1.0),
    (0.4, 0.3),
    (0.4, -0.3),
];

/// The voltage at sample `k` of a segment, as a pure function of `k` (except [`Plan::Prbs`]).
/// Every `turn` is phase per sample in units of 2^-32 turns.
#[derive(Debug, Clone)]
pub enum Plan {
    Constant {
        level_v: f32,
    },
    Sine {
        amplitude_v: f32,
        offset_v: f32,
        turn: u32,
    },
    Multisine {
        peak_v: f32,
        tones: Tones,
    },
    /// Phase `turns * (2^(octaves k) - 1)`; `octaves` per sample in units of 2^-32.
    Chirp {
        amplitude_v: f32,
        turns: f32,
        octaves: u64,
    },
    Staircase {
        amplitude_v: f32,
        hold: u32,
        levels: u32,
        seed: u32,
    },
    Triangle {
        amplitude_v: f32,
        turn: u32,
    },
    Prbs {
        amplitude_v: f32,
        chip: u32,
        seed: u32,
    },
    Pulses {
        amplitude_v: f32,
        ends: [u32; PULSES.len()],
    },
    Square {
        amplitude_v: f32,
        turn: u32,
    },
}

impl Plan {
    /// Prepares a validated segment that lasts `samples` at `rate_hz`.
    pub fn new(
        segment: &Segment,
        samples: u32,
        rate_hz: u32,
        alive: &mut dyn FnMut(),
    ) -> Result<Self, Fault> {
        let too_fast = Err(Fault::TooFastForRate { rate_hz });
        let nyquist_hz = rate_hz as f32 / 2.0;
        let hold = |seconds: f32| libm::roundf(seconds * rate_hz as f32) as u32;
        Ok(match segment.shape {
            Shape::Rest => Self::Constant { level_v: 0.0 },
            Shape::Step { level_v } => Self::Constant { level_v },
            Shape::Sine { frequency_hz, .. } | Shape::Square { frequency_hz, .. }
                if frequency_hz > nyquist_hz =>
            {
                return too_fast;
            }
            Shape::Multisine { high_hz, .. } | Shape::Chirp { high_hz, .. } if high_hz > nyquist_hz => {
                return too_fast;
            }
            Shape::Staircase { hold_s, .. } if hold(hold_s) == 0 => return too_fast,
            Shape::Prbs { chip_s, .. } if hold(chip_s) == 0 => return too_fast,
            Shape::Triangle { period_s, .. } if hold(period_s) < 2 => return too_fast,
            Shape::Sine { amplitude_v, frequency_hz, offset_v } => Self::Sine {
                amplitude_v,
                offset_v,
                turn: phase::turn_per_sample(f64::from(frequency_hz), rate_hz),
            },
            Shape::Multisine { amplitude_v, low_hz, high_hz, tones, seed } => {
                let band = (low_hz * segment.seconds, high_hz * segment.seconds);
                Self::Multisine {
                    peak_v: amplitude_v,
                    tones: multisine::prepare(amplitude_v, band, tones, seed, samples, alive),
                }
            }
            Shape::Chirp { amplitude_v, low_hz, high_hz } => {
                let (low, high) = (f64::from(low_hz), f64::from(high_hz));
                // A chirp of no width is a sine; half a cent keeps the formula and its digits.
                let octaves_per_second = libm::log2((high / low).max(1.0003)) / f64::from(segment.seconds);
                Self::Chirp {
                    amplitude_v,
                    turns: (low / (octaves_per_second * core::f64::consts::LN_2)) as f32,
                    octaves: libm::round(octaves_per_second / f64::from(rate_hz) * TURN) as u64,
                }
            }
            Shape::Staircase { amplitude_v, hold_s, seed } => Self::Staircase {
                amplitude_v,
                hold: hold(hold_s),
                levels: samples.div_ceil(hold(hold_s)),
                seed,
            },
            Shape::Triangle { amplitude_v, period_s } => Self::Triangle {
                amplitude_v,
                turn: phase::turn_per_sample(1.0 / f64::from(period_s), rate_hz),
            },
            Shape::Prbs { amplitude_v, chip_s, seed } => Self::Prbs { amplitude_v, chip: hold(chip_s), seed },
            Shape::PulseAndCoast { amplitude_v } => {
                let mut end_s = 0.0;
                Self::Pulses {
                    amplitude_v,
                    ends: PULSES.map(|(seconds, _)| {
                        end_s += seconds;
                        hold(end_s).max(1)
                    }),
                }
            }
            Shape::Square { amplitude_v, frequency_hz } => {
                Self::Square { amplitude_v, turn: phase::turn_per_sample(f64::from(frequency_hz), rate_hz) }
            }
        })
    }

    /// The voltage at sample `k`; `chip` is the current chip of a maximum-length sequence.
    #[inline]
    pub fn volts(&self, k: u32, chip: bool) -> f32 {
        match *self {
            Self::Constant { level_v } => level_v,
            Self::Sine { amplitude_v, offset_v, turn } => {
                offset_v + amplitude_v * phase::sine(turn.wrapping_mul(k)).clamp(-1.0, 1.0)
            }
            Self::Multisine { peak_v, ref tones } => {
                let sum: f32 = tones.iter().map(|tone| tone.volts(k)).sum();
                // Not clamp(): with limits unknown to the compiler its panic message needs float formatting.
                sum.max(-peak_v).min(peak_v)
            }
            Self::Chirp { amplitude_v, turns, octaves } => {
                let cycles = turns * (phase::exp2(octaves * u64::from(k)) - 1.0);
                let part = cycles - cycles as u32 as f32;
                amplitude_v * phase::sine((part * TURN as f32) as u32).clamp(-1.0, 1.0)
            }
            Self::Staircase { amplitude_v, hold, levels, seed } => {
                // No division that could panic: this runs in the board's sampling interrupt.
                let level = permute(k.checked_div(hold).unwrap_or(0), levels, seed);
                let steps = (levels - 1).max(1);
                amplitude_v * ((2 * level) as f32 / steps as f32 - 1.0)
            }
            Self::Triangle { amplitude_v, turn } => {
                // A quarter turn ahead, the triangle is 1 - 4 |x - 1/2| of a turn's fraction x.
                let x = turn.wrapping_mul(k).wrapping_add(1 << 30);
                let from_middle = ((x ^ (1 << 31)) as i32) as f32 * (1.0 / TURN as f32);
                amplitude_v * (1.0 - 4.0 * from_middle.abs())
            }
            Self::Prbs { amplitude_v, .. } => {
                if chip {
                    amplitude_v
                } else {
                    -amplitude_v
                }
            }
            Self::Pulses { amplitude_v, ref ends } => {
                let within = k.checked_rem(ends[PULSES.len() - 1]).unwrap_or(0);
                let pulse = ends.iter().zip(&PULSES).find(|(end, _)| within < **end);
                pulse.map_or(0.0, |(_, (_, share))| amplitude_v * share)
            }
            Self::Square { amplitude_v, turn } => {
                if turn.wrapping_mul(k) >> 31 == 0 {
                    amplitude_v
                } else {
                    -amplitude_v
                }
            }
        }
    }
}
