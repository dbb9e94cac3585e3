//! The shapes that a segment can have.

use serde::{Deserialize, Serialize};

/// The most tones of a multisine.
pub const MAX_TONES: usize = 14;

/// A voltage as a function of the time since the segment began.
///
/// The wire format numbers the variants and their fields in this order: append only, never reorder.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case", deny_unknown_fields)]
pub enum Shape {
    /// 0 V.
    Rest,
    /// `offset + amplitude * sin(2 pi frequency t)`.
    Sine {
        /// Peak of the alternating part, in volts.
        amplitude_v: f32,
        /// Frequency, in hertz.
        frequency_hz: f32,
        /// Constant part, in volts; larger than the amplitude, the motor never reverses.
        #[serde(default)]
        offset_v: f32,
    },
    /// Tones at geometrically spaced harmonics of the segment, with random phases and amplitudes
    /// falling as `frequency^-0.3`, scaled so that the crest of the sum is the amplitude.
    Multisine {
        /// Peak of the sum, in volts (reached within 2 %, never exceeded).
        amplitude_v: f32,
        /// Lowest tone, in hertz (rounded to a harmonic of `1 / seconds`).
        low_hz: f32,
        /// Highest tone, in hertz.
        high_hz: f32,
        /// Tones asked for, 1 to [`MAX_TONES`]; tones that round to the same harmonic are played once.
        tones: u8,
        /// Picks the phases.
        seed: u32,
    },
    /// A sine whose frequency rises exponentially over the segment.
    Chirp {
        /// Peak, in volts.
        amplitude_v: f32,
        /// Frequency at the start, in hertz.
        low_hz: f32,
        /// Frequency at the end, in hertz.
        high_hz: f32,
    },
    /// Levels evenly spaced from minus to plus the amplitude, each held once, in random order.
    Staircase {
        /// Largest level, in volts.
        amplitude_v: f32,
        /// How long each level is held, in seconds.
        hold_s: f32,
        /// Picks the order.
        seed: u32,
    },
    /// A triangle that starts at 0 V and rises.
    Triangle {
        /// Peak, in volts.
        amplitude_v: f32,
        /// One full period, in seconds.
        period_s: f32,
    },
    /// Plus or minus the amplitude by a maximum-length sequence of 2^15 - 1 chips.
    Prbs {
        /// Level, in volts.
        amplitude_v: f32,
        /// Shortest time between two reversals, in seconds.
        chip_s: f32,
        /// Picks where in the sequence to start.
        seed: u32,
    },
    /// Pulses of both signs at full, half and three tenths of the amplitude with rolling out at 0 V
    /// between them, repeated every 6.6 s.
    PulseAndCoast {
        /// Level of the strongest pulse, in volts.
        amplitude_v: f32,
    },
    /// One constant level.
    Step {
        /// The level, in volts.
        level_v: f32,
    },
    /// Plus the amplitude, then minus the amplitude, each for half a period: heats the winding and
    /// loads the supply more than any other shape.
    Square {
        /// Level, in volts.
        amplitude_v: f32,
        /// Frequency, in hertz.
        frequency_hz: f32,
    },
}

impl Shape {
    /// The largest voltage magnitude that the shape can reach, in volts.
    pub fn peak_v(&self) -> f32 {
        match *self {
            Self::Rest => 0.0,
            Self::Sine { amplitude_v, offset_v, .. } => amplitude_v.abs() + offset_v.abs(),
            Self::Multisine { amplitude_v, .. }
            | Self::Chirp { amplitude_v, .. }
            | Self::Staircase { amplitude_v, .. }
            | Self::Triangle { amplitude_v, .. }
            | Self::Prbs { amplitude_v, .. }
            | Self::PulseAndCoast { amplitude_v }
            | Self::Square { amplitude_v, .. } => amplitude_v.abs(),
            Self::Step { level_v } => level_v.abs(),
        }
    }

    /// The name that people and files use.
    pub fn name(&self) -> &'static str {
        match self {
            Self::Rest => "rest",
            Self::Sine { .. } => "sine",
            Self::Multisine { .. } => "multisine",
            Self::Chirp { .. } => "chirp",
            Self::Staircase { .. } => "staircase",
            Self::Triangle { .. } => "triangle",
            Self::Prbs { .. } => "prbs",
            Self::PulseAndCoast { .. } => "pulse_and_coast",
            Self::Step { .. } => "step",
            Self::Square { .. } => "square",
        }
    }
}
