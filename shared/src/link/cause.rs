//! Why a run ended, or did not begin.

use core::fmt;
use serde::{Deserialize, Serialize};

/// Why a run ended. Every cause but the first two is a fault that took the bridge off.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Cause {
    /// The programme was played to its end.
    Finished,
    /// The host asked for it.
    Asked,
    /// Longer than [`Setup::run_limit_ms`](super::Setup::run_limit_ms).
    RunLimit,
    /// Voltage, but no motion.
    Stall,
    /// More current than [`Setup::current_limit_ma`](super::Setup::current_limit_ma).
    OverCurrent,
    /// Nothing from the host for [`Setup::link_timeout_ms`](super::Setup::link_timeout_ms).
    LinkLoss,
    /// The emergency input opened.
    Emergency,
    /// The program hung and the watchdog started the board anew.
    Watchdog,
    /// The measured supply is outside [`SUPPLY_SHARES`](super::SUPPLY_SHARES) of the stated one. Since version 2.
    Supply,
    /// The shaft still turned, with the bridge off, when the board had waited for it long enough: the run has not begun. Since version 5.
    Turning,
}

impl Cause {
    /// The same in words that a version of the link has.
    pub const fn told_to(self, version: u16) -> Self {
        match self {
            // An electrical fault that took the bridge off.
            Self::Supply if version < 2 => Self::OverCurrent,
            // A time that is over; that nothing was logged tells the rest.
            Self::Turning if version < 5 => Self::RunLimit,
            _ => self,
        }
    }
}

impl fmt::Display for Cause {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Finished => "the programme ended",
            Self::Asked => "stopped on request",
            Self::RunLimit => "run-time limit reached",
            Self::Stall => "stall: voltage but no motion",
            Self::OverCurrent => "over-current",
            Self::LinkLoss => "link lost while running",
            Self::Emergency => "emergency input open",
            Self::Watchdog => "the firmware lost control, let the motor go and was restarted",
            Self::Supply => {
                "the measured supply is not within half and one and a half of the stated one: check --supply, the \
                 battery, and that a divider is wired to the board's supply input"
            }
            Self::Turning => "the shaft went on turning with the bridge off, so the run did not begin",
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cause_that_a_version_does_not_have_is_told_by_the_nearest_that_it_has() {
        for (cause, since, before) in
            [(Cause::Supply, 2, Cause::OverCurrent), (Cause::Turning, 5, Cause::RunLimit)]
        {
            assert_eq!((cause.told_to(since - 1), cause.told_to(since)), (before, cause));
        }
        assert_eq!(Cause::Stall.told_to(1), Cause::Stall);
    }
}
