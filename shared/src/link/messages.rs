//! The messages, in both directions. Append only.

use core::fmt;
use heapless::String;
use serde::{Deserialize, Serialize};

use super::{LogBlock, Scaling, Setup, SetupFault, Status};
use crate::excitation::{MAX_NAME, ProgrammeError, Segment};
use crate::quickfit::{Progress, QuickFit, Request};

/// A message and the number of the request that it is or answers; 0 for what the board says unasked.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Packet<M> {
    /// The request's number.
    pub id: u16,
    /// The message.
    pub message: M,
}

/// What the host says. Every one is answered under the request's number, and may be sent again when the answer does
/// not come: repeating has no further effect.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum ToBoard {
    /// Who is there, and which versions do we share? FROZEN.
    Hello {
        /// The oldest version the host speaks.
        oldest: u16,
        /// The newest version the host speaks.
        newest: u16,
    },
    /// What can this board do? Answered by [`FromBoard::Capabilities`].
    Capabilities,
    /// The name of an effect this board's model has. Answered by [`FromBoard::EffectName`].
    EffectName {
        /// From 0 to [`Capabilities::effects`] - 1.
        index: u8,
    },
    /// How the next run is made.
    Configure(Setup),
    /// One segment of the next run's programme, sent in order.
    SetSegment {
        /// Its place, from 0, which begins a new programme.
        index: u8,
        /// The programme's name.
        name: String<MAX_NAME>,
        /// What is played.
        segment: Segment,
    },
    /// Plays the programme. The same run asked for again is not begun again.
    Start {
        /// The run's number, of the host's choosing, other than the last one's.
        run: u32,
        /// Segments the programme must have by now.
        segments: u8,
    },
    /// Ends the run.
    Stop,
    /// Samples to send (again).
    ReadLog {
        /// Number of the first.
        first: u32,
        /// How many, at most 256.
        count: u16,
    },
    /// Fits the kept samples. Progress and result follow the answer unasked.
    QuickFit(Request),
    /// The last fit's result.
    ReadResult,
    /// Leaves the program for the chip's boot loader.
    Bootloader,
    /// The host is still there.
    KeepAlive,
    /// Answered by [`FromBoard::Status`].
    Status,
}

/// What the board says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub enum FromBoard {
    /// Answers the hello. FROZEN.
    Hello(Hello),
    /// What the board can do.
    Capabilities(Capabilities),
    /// An effect's name.
    EffectName(String<MAX_NAME>),
    /// The request was carried out.
    Done,
    /// The request was not carried out.
    Refused(Refusal),
    /// Samples: as they are taken, and on request.
    Log(LogBlock),
    /// Samples that were asked for and are no longer, or not yet, held.
    NotHeld {
        /// Number of the first.
        first: u32,
        /// How many.
        count: u32,
    },
    /// The board's state.
    Status(Status),
    /// A fit is under way.
    Progress(Progress),
    /// A fit's result; `None` when nothing has been fitted.
    Fit(Option<QuickFit>),
}

/// Who answers. FROZEN.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Hello {
    /// The oldest version the board speaks.
    pub oldest: u16,
    /// The newest version the board speaks.
    pub newest: u16,
    /// The firmware's own version: major, minor, patch.
    pub firmware: [u8; 3],
    /// The chip's unique number, so that a host can tell boards apart.
    pub unique: [u8; 12],
}

/// What a board can do.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub struct Capabilities {
    /// Effects in its model; [`ToBoard::EffectName`] names each.
    pub effects: u8,
    /// Segments that a programme may have.
    pub segments: u8,
    /// Samples that the log holds for being sent again.
    pub log_samples: u16,
    /// Samples kept for the quick fit.
    pub fit_samples: u16,
    /// The core's clock, Hz.
    pub core_hz: u32,
    /// The PWM's frequency, Hz.
    pub pwm_hz: u32,
    /// Whether the supply is measured at the current setup.
    pub measures_supply: bool,
    /// Whether the current is measured at the current setup.
    pub measures_current: bool,
    /// What the log's raw numbers mean at the current setup.
    pub scaling: Scaling,
    /// Whether it has a converter that could measure supply and current, where [`Setup`] says what is wired. Since version 4.
    pub converter: bool,
}

/// Why a request was not carried out.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Refusal {
    /// The motor is running: stop it first.
    Running,
    /// The setup is at fault.
    Setup(SetupFault),
    /// The programme is at fault.
    Programme(ProgrammeError),
    /// A segment came out of order, or fewer came than the start asks for.
    SegmentOrder,
    /// No hello has agreed on a version yet.
    Version,
    /// The emergency input is open.
    Emergency,
    /// Nothing, or too little, is kept to fit.
    NothingToFit,
    /// This board has no effect of that number.
    NoSuchEffect,
    /// The board knows no way into its boot loader.
    NoBootloader,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Running => "the motor is running; stop it first",
            Self::Setup(fault) => return fault.fmt(f),
            Self::Programme(error) => return error.fmt(f),
            Self::SegmentOrder => "the programme did not arrive whole; send it again",
            Self::Version => "say hello first",
            Self::Emergency => {
                "the emergency input is open; close it (a jumper to ground where no button is fitted)"
            }
            Self::NothingToFit => "too few samples are kept on the board; capture a run first",
            Self::NoSuchEffect => "the board has no effect of that number",
            Self::NoBootloader => "this board cannot enter its boot loader by itself",
        })
    }
}
