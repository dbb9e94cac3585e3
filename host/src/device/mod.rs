//! The board at the other end of a line: capturing runs, fitting on the board, what it can do.
//!
//! The conversation is a state machine without input or output of its own ([`Exchange`], [`Capture`], [`Inquiry`]): it is
//! given bytes and the time, and gives bytes. So the same code talks over a serial port, over TCP, and to an emulated
//! board in virtual time.

mod capture;
mod captured;
pub mod check;
mod collector;
mod exchange;
mod foreign;
mod inquiry;
pub mod lines;
mod listen;
mod port;
mod record;
mod trouble;
pub mod wiring;

pub use capture::Capture;
pub use captured::Captured;
pub use collector::Collector;
pub use exchange::Exchange;
pub use inquiry::Inquiry;
pub use listen::{End, Listen, to_record};
pub use port::Port;
pub use record::{Shaft, record};

use motorlens_shared::link::{Cause, Refusal, Reset};
use std::fmt;

/// Why a conversation with a board ended without what was asked for.
#[derive(Debug, Clone, PartialEq)]
pub enum Fault {
    /// No answer, however often asked.
    Silent,
    /// Bytes came, and none of them of this program's link: the beginning of what was heard.
    Foreign(Vec<u8>),
    /// The board speaks other versions of the protocol: its oldest and newest.
    Version(u16, u16),
    /// The board refused.
    Refused(Refusal),
    /// The board answered with something else than was asked for.
    Confused,
    /// Stopped from here before the run began.
    Stopped,
    /// The board has started anew in the run, for this reason, and no longer has it.
    Forgotten(Reset),
    /// The board's firmware reads inputs for supply and current whether anything is wired to them or not.
    BuiltInSensors,
}

impl From<Fault> for crate::error::Error {
    fn from(fault: Fault) -> Self {
        let remedy = match &fault {
            Fault::Foreign(heard) => foreign::remedy(heard),
            Fault::Silent => "check power, cable and port; the firmware runs at 921,600 baud",
            Fault::Version(..) => "flash the firmware that belongs to this program: motorlens device flash",
            Fault::Refused(_) => "change what the board names and try again",
            Fault::Confused => "reset the board and try again",
            Fault::BuiltInSensors => {
                "flash the present firmware (motorlens device flash), which reads what --divider and --amplifier name"
            }
            Fault::Stopped => "capture again when the motor may run",
            Fault::Forgotten(_) => {
                "check the board's own supply and its cable: a motor that draws on either must not pull them down; then capture again"
            }
        };
        Self::device(fault.to_string(), remedy)
    }
}

/// What is said while a run is begun again and again, until the shaft rests ([`Capture::patient`]).
pub const WAITING: &str = "the shaft still turns: waiting (hold it, or wait)";

/// What to do about a run that ended before its programme.
pub fn remedy(cause: Cause) -> &'static str {
    match cause {
        Cause::Asked => "try again when the motor may run",
        Cause::Stall => {
            "free the shaft; a motor that breaks away at a higher voltage needs a higher --stall-voltage"
        }
        Cause::Turning => {
            "hold the shaft until it rests and try again; where it turns by itself the bridge is not off: check the wire of the driver's \
             enable, what the driver does while its inputs are low, and that a brake is wired; where nothing turns the encoder's lines pick up \
             noise"
        }
        _ => "clear the cause and try again",
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::BuiltInSensors => write!(
                f,
                "the board's firmware is older than this program and reads its inputs for supply and current whether anything is wired to \
                 them or not: one that floats could have the motor driven at full duty"
            ),
            Self::Silent => write!(f, "the board does not answer"),
            Self::Foreign(heard) => {
                write!(
                    f,
                    "the board runs other firmware: it does not speak the link, but says {}",
                    foreign::shown(heard)
                )
            }
            Self::Version(oldest, newest) => {
                write!(f, "the board speaks versions {oldest} to {newest} of the link, this program does not")
            }
            Self::Refused(refusal) => write!(f, "the board refuses: {refusal}"),
            Self::Stopped => write!(f, "stopped before the run began"),
            Self::Forgotten(reset) => {
                write!(f, "the board started anew in the run (reason: {reset}) and no longer has it")
            }
            Self::Confused => write!(f, "the board's answer does not belong to the request"),
        }
    }
}
