//! What the motor is asked to do: a programme of voltage segments.
//!
//! One definition serves the host and the device. A [`Programme`] is immutable data (JSON for people,
//! postcard on the wire); a [`Player`] is the small state that turns it into one voltage per sample.
//! All arithmetic that reaches a sample is integer or `f32` addition and multiplication, so a Cortex-M4F
//! and a host play the same programme bit for bit.
//!
//! ```
//! use motorlens_shared::excitation::{Player, Programme};
//! let sine = Programme::paper(3.0);
//! let mut player = Player::new(&sine, 1000).unwrap();
//! assert_eq!(player.next(), Some(0.0));
//! assert!((player.nth(999).unwrap() - 3.0).abs() < 1e-5); // 0.25 Hz: the peak is at 1 s
//! ```

mod check;
mod multisine;
pub mod phase;
mod plan;
mod player;
mod protocol;
mod sequence;
mod shape;

pub use check::{Fault, ProgrammeError};
pub use player::Player;
pub use protocol::{NOMINAL_V, Protocol};
pub use shape::{MAX_TONES, Shape};

use heapless::{String, Vec};
use serde::{Deserialize, Serialize};

/// The most segments a programme may have.
pub const MAX_SEGMENTS: usize = 16;
/// The longest name of a programme, in bytes of UTF-8.
pub const MAX_NAME: usize = 24;

/// One shape, played for some time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Segment {
    /// What is played.
    pub shape: Shape,
    /// For how long, in seconds (more than 0, at most 3600).
    pub seconds: f32,
}

/// A named sequence of segments, each starting at its own time zero.
///
/// The wire format is that of the field order; fields may only be appended.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Programme {
    /// A short name, used for file names and reports.
    pub name: String<MAX_NAME>,
    /// The segments, in the order they are played.
    pub segments: Vec<Segment, MAX_SEGMENTS>,
}

impl Programme {
    /// A programme of one segment. A name longer than [`MAX_NAME`] bytes is cut at a character.
    pub fn single(name: &str, shape: Shape, seconds: f32) -> Self {
        let mut programme = Self::empty(name);
        programme.segments.extend([Segment { shape, seconds }]);
        programme
    }

    /// A programme of several segments; those beyond [`MAX_SEGMENTS`] are refused.
    ///
    /// # Errors
    /// [`Fault::TooManySegments`] when they do not fit.
    pub fn sequence(name: &str, segments: impl IntoIterator<Item = Segment>) -> Result<Self, ProgrammeError> {
        let mut programme = Self::empty(name);
        for segment in segments {
            programme.segments.push(segment).map_err(|_| ProgrammeError::whole(Fault::TooManySegments))?;
        }
        Ok(programme)
    }

    fn empty(name: &str) -> Self {
        let mut short = String::new();
        for character in name.chars() {
            if short.push(character).is_err() {
                break;
            }
        }
        Self { name: short, segments: Vec::new() }
    }

    /// How long the whole programme takes, in seconds.
    pub fn seconds(&self) -> f32 {
        self.segments.iter().map(|segment| segment.seconds).sum()
    }

    /// The largest voltage magnitude that the programme can ask for, in volts.
    pub fn peak_v(&self) -> f32 {
        self.segments.iter().map(|segment| segment.shape.peak_v()).fold(0.0, f32::max)
    }

    /// Checks every segment against its limits and against the driver's `limit_v` (volts).
    ///
    /// # Errors
    /// The first segment at fault, and what is wrong with it.
    pub fn validate(&self, limit_v: f32) -> Result<(), ProgrammeError> {
        check::programme(self, limit_v)
    }
}

#[cfg(test)]
mod tests;
