//! What makes a programme unplayable, in words that say what to do.

use super::{MAX_TONES, Programme, Shape};
use core::fmt;
use serde::{Deserialize, Serialize};

/// What is wrong with a programme. Append only: the order is the wire format.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Fault {
    /// There is nothing to play.
    Empty,
    /// More segments than fit.
    TooManySegments,
    /// Zero, negative, not a number, or more than an hour.
    Duration,
    /// A parameter is not finite, or not positive where it must be.
    Parameter,
    /// The voltage exceeds the driver's limit (volts).
    OverVoltage {
        /// What the segment asks for, in volts.
        asked_v: f32,
        /// What the driver allows, in volts.
        limit_v: f32,
    },
    /// A multisine with no tone or more than [`MAX_TONES`].
    Tones,
    /// Lowest frequency above the highest, or less than one cycle in the segment.
    Band,
    /// More than 4096 cycles in the segment.
    TooManyCycles,
    /// More than 65536 levels in a staircase.
    TooManyLevels,
    /// The segment, a chip or a level is shorter than a sample, or a frequency above half the sample rate.
    TooFastForRate {
        /// The sample rate, in hertz.
        rate_hz: u32,
    },
    /// The sample rate is not in 1..=50000 Hz.
    Rate,
}

/// A fault and the segment (from 0) that has it; `None` when it is the whole programme.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct ProgrammeError {
    /// The segment at fault, counted from 0.
    pub segment: Option<u8>,
    /// What is wrong with it.
    pub fault: Fault,
}

impl ProgrammeError {
    pub(super) fn whole(fault: Fault) -> Self {
        Self { segment: None, fault }
    }

    pub(super) fn at(segment: usize, fault: Fault) -> Self {
        Self { segment: Some(segment as u8), fault }
    }
}

impl fmt::Display for ProgrammeError {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(segment) = self.segment {
            write!(f, "segment {}: ", segment + 1)?;
        }
        match self.fault {
            Fault::Empty => write!(f, "the programme has no segment; add at least one"),
            Fault::TooManySegments => {
                write!(f, "more than {} segments; split the programme in two", super::MAX_SEGMENTS)
            }
            Fault::Duration => write!(f, "seconds must be more than 0 and at most 3600"),
            Fault::Parameter => {
                write!(f, "a parameter is not finite, or a time, frequency or amplitude is not positive")
            }
            Fault::OverVoltage { asked_v, limit_v } => {
                write!(f, "asks for {asked_v} V but the limit is {limit_v} V; lower the amplitude or offset")
            }
            Fault::Tones => write!(f, "tones must be 1 to {MAX_TONES}"),
            Fault::Band => write!(
                f,
                "the band is empty: low_hz must be at most high_hz, and high_hz at least one cycle per segment"
            ),
            Fault::TooManyCycles => {
                write!(f, "more than {MAX_CYCLES} cycles in the segment; shorten it or lower the frequency")
            }
            Fault::TooManyLevels => {
                write!(f, "more than {MAX_LEVELS} levels in the staircase; hold them longer")
            }
            Fault::TooFastForRate { rate_hz } => write!(
                f,
                "too fast for {rate_hz} samples per second; sample faster, or slow the segment down"
            ),
            Fault::Rate => write!(f, "the sample rate must be 1 to 50000 Hz"),
        }
    }
}

impl core::error::Error for ProgrammeError {}

const MAX_CYCLES: f32 = 4096.0;
const MAX_LEVELS: f32 = 65_536.0;

pub(super) fn programme(programme: &Programme, limit_v: f32) -> Result<(), ProgrammeError> {
    if programme.segments.is_empty() {
        return Err(ProgrammeError::whole(Fault::Empty));
    }
    for (index, segment) in programme.segments.iter().enumerate() {
        if !(segment.seconds > 0.0 && segment.seconds <= 3600.0) {
            return Err(ProgrammeError::at(index, Fault::Duration));
        }
        shape(&segment.shape, segment.seconds).map_err(|fault| ProgrammeError::at(index, fault))?;
        let asked_v = segment.shape.peak_v();
        if asked_v > limit_v {
            return Err(ProgrammeError::at(index, Fault::OverVoltage { asked_v, limit_v }));
        }
    }
    Ok(())
}

fn shape(shape: &Shape, seconds: f32) -> Result<(), Fault> {
    let positive = |values: &[f32]| {
        if values.iter().all(|value| value.is_finite() && *value > 0.0) {
            Ok(())
        } else {
            Err(Fault::Parameter)
        }
    };
    let band = |low_hz: f32, high_hz: f32| {
        if low_hz > high_hz || high_hz * seconds < 1.0 {
            Err(Fault::Band)
        } else if high_hz * seconds > MAX_CYCLES {
            Err(Fault::TooManyCycles)
        } else {
            Ok(())
        }
    };
    match *shape {
        Shape::Rest => Ok(()),
        Shape::Sine { amplitude_v, frequency_hz, offset_v } => {
            if !offset_v.is_finite() {
                return Err(Fault::Parameter);
            }
            positive(&[amplitude_v, frequency_hz])
        }
        Shape::Multisine { amplitude_v, low_hz, high_hz, tones, .. } => {
            positive(&[amplitude_v, low_hz, high_hz])?;
            if tones == 0 || usize::from(tones) > MAX_TONES {
                return Err(Fault::Tones);
            }
            band(low_hz, high_hz)
        }
        Shape::Chirp { amplitude_v, low_hz, high_hz } => {
            positive(&[amplitude_v, low_hz, high_hz])?;
            band(low_hz, high_hz)
        }
        Shape::Staircase { amplitude_v, hold_s, .. } => {
            positive(&[amplitude_v, hold_s])?;
            if seconds / hold_s > MAX_LEVELS {
                return Err(Fault::TooManyLevels);
            }
            Ok(())
        }
        Shape::Triangle { amplitude_v, period_s } => positive(&[amplitude_v, period_s]),
        Shape::Prbs { amplitude_v, chip_s, .. } => positive(&[amplitude_v, chip_s]),
        Shape::PulseAndCoast { amplitude_v } => positive(&[amplitude_v]),
        Shape::Step { level_v } => {
            if level_v.is_finite() {
                Ok(())
            } else {
                Err(Fault::Parameter)
            }
        }
        Shape::Square { amplitude_v, frequency_hz } => positive(&[amplitude_v, frequency_hz]),
    }
}
