//! What comes of a run.

use motorlens_shared::link::{Capabilities, Cause, Sample, Scaling, Setup, Status};
use std::ops::Range;

/// A run's log and what is known about it.
#[derive(Debug, Clone)]
pub struct Captured {
    /// What ended the run.
    pub cause: Cause,
    /// The samples with their numbers.
    pub samples: Vec<(u32, Sample)>,
    /// Numbers of the samples that are missing: not taken, or lost with a line that was out for too long.
    pub holes: Vec<Range<u32>>,
    /// What the raw numbers mean.
    pub scaling: Scaling,
    /// What the board can do.
    pub capabilities: Capabilities,
    /// How the run was set up.
    pub setup: Setup,
    /// The board's last word on the run.
    pub status: Status,
}
