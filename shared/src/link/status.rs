//! What state the board is in.

use super::Cause;
use core::fmt;
use serde::{Deserialize, Serialize};

/// What the board is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum RunState {
    /// Nothing has run since it started.
    Idle,
    /// The motor is driven.
    Running,
    /// The last run ended; the bridge is off and the log is kept.
    Stopped(Cause),
}

/// Why the board last started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Reset {
    /// Power or the reset pin.
    PowerOn,
    /// The watchdog.
    Watchdog,
    /// Its own software.
    Software,
    /// The watchdog, after the program had found itself at fault and had taken the bridge off. Since version 3, as all that follow.
    Panic,
    /// The watchdog, after a fault of the core: an access without an address, an instruction without a meaning.
    CoreFault,
    /// The watchdog, after the crystal had stopped.
    Clock,
    /// The watchdog, after the chip's own supply had sunk.
    Supply,
}

impl Reset {
    /// Whether the program lost control: a run that was under way ended there, and its log is still in memory.
    pub const fn lost_control(self) -> bool {
        !matches!(self, Self::PowerOn | Self::Software)
    }

    /// What a program notes by number, `self as u32`, before it waits for the watchdog; `None` for any other number.
    pub const fn noted(number: u32) -> Option<Self> {
        match number {
            3 => Some(Self::Panic),
            4 => Some(Self::CoreFault),
            5 => Some(Self::Clock),
            6 => Some(Self::Supply),
            _ => None,
        }
    }

    /// The same in words that a version of the link has.
    pub const fn told_to(self, version: u16) -> Self {
        if version < 3 && self.lost_control() { Self::Watchdog } else { self }
    }
}

impl fmt::Display for Reset {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::PowerOn => "power or the reset pin",
            Self::Watchdog => "the firmware hung",
            Self::Software => "on request",
            Self::Panic => "the firmware found itself at fault",
            Self::CoreFault => "a fault of the chip's core",
            Self::Clock => "the chip's crystal stopped",
            Self::Supply => "the chip's own supply sank",
        })
    }
}

/// The board's state and what its log holds. Sent ten times a second and on request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Status {
    /// What it is doing.
    pub state: RunState,
    /// The run that `state` and the log belong to.
    pub run: u32,
    /// Number of the oldest sample still held.
    pub oldest: u32,
    /// Number that the next sample will get: the run has so many so far.
    pub next: u32,
    /// Samples of this run that the board had no time to take.
    pub missed: u32,
    /// Samples kept for the quick fit.
    pub kept: u16,
    /// Damaged frames received since the board started.
    pub damaged: u32,
    /// Why the board last started.
    pub reset: Reset,
    /// Core cycles that the longest sampling interrupt took so far; 0 where nobody counts.
    pub worst_cycles: u32,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_cost_the_program_its_control_comes_back_from_its_number_and_nothing_else_does() {
        for reset in [Reset::Panic, Reset::CoreFault, Reset::Clock, Reset::Supply] {
            assert_eq!(Reset::noted(reset as u32), Some(reset));
        }
        for other in [Reset::PowerOn as u32, Reset::Watchdog as u32, Reset::Software as u32, 7, u32::MAX] {
            assert_eq!(Reset::noted(other), None);
        }
    }
}
