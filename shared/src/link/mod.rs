//! What host and board say to each other: messages, frames, versions.
//!
//! A message is a [postcard](https://postcard.jamesmunns.com) encoding with a CRC-32 behind it, stuffed by COBS, ended
//! by a zero byte ([`frame`]). Every message travels in a [`Packet`] that carries the number of the request it answers.
//!
//! # Bad lines
//! A frame may instead be protected by forward error correction, which takes some three and a half times the bytes (`protected`). A
//! receiver of version 3 reads both kinds at any time. A host asks an end of that age in protected frames once too many frames
//! arrive damaged, and asks in both kinds what it has asked in vain; a board sends as it was last spoken to.
//!
//! # Versions
//! The enums are append-only: a variant or a field, once released, keeps its place and meaning, and newer ones follow.
//! [`ToBoard::Hello`] and [`FromBoard::Hello`] are frozen for good, so two ends of any age can find out what both
//! speak ([`agree`]). A field that a newer end has appended is skipped by an older one, and where an older end does not
//! send it, it reads as zero (`false`, `None`, the first variant): see [`decode`]. A variant is sent only to an end that has
//! agreed on the version that brought it. The bytes of each version stand in `tests/link_v*.rs`: when one of those tests
//! fails, the change broke a deployed board or host.

mod cause;
pub mod frame;
mod messages;
mod protected;
mod reed_solomon;
mod sample;
mod setup;
mod status;

pub use cause::Cause;
pub use frame::{
    Damage, Decoder, MAX_ENCODED, MAX_FRAME, MAX_MESSAGE, decode, encode, encode_as, encode_protected,
};
pub use messages::{Capabilities, FromBoard, Hello, Packet, Refusal, ToBoard};
pub use protected::MAX_PROTECTED;
pub use sample::{LOG_SAMPLES, LogBlock, Sample, Scaling};
pub use setup::{DriveMode, PWM_HZ, PWM_LIMITS_HZ, SUPPLY_SHARES, Setup, SetupFault};
pub use status::{Reset, RunState, Status};

/// The oldest version of the protocol that this source still speaks.
pub const OLDEST: u16 = 1;
/// The version that this source speaks best.
pub const NEWEST: u16 = 5;

/// The version that two ends use: the newest that both speak, `None` when their ranges do not meet.
///
/// ```
/// use motorlens_shared::link::agree;
/// assert_eq!(agree((1, 3), (2, 5)), Some(3));
/// assert_eq!(agree((1, 1), (2, 5)), None);
/// ```
pub const fn agree(one: (u16, u16), other: (u16, u16)) -> Option<u16> {
    let newest = if one.1 < other.1 { one.1 } else { other.1 };
    let oldest = if one.0 > other.0 { one.0 } else { other.0 };
    if newest >= oldest { Some(newest) } else { None }
}
