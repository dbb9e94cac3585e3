//! Messages beside their recorded bytes.

use motorlens_shared::link::{MAX_ENCODED, Packet, decode, encode};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fmt::Debug;

/// Encodes the message under request number 300 and compares with the bytes; decodes the bytes and compares with the
/// message.
pub fn golden<M: Serialize + DeserializeOwned + PartialEq + Debug>(message: M, hex: &str) {
    let packet = Packet { id: 300, message };
    assert_eq!(sent(&packet), hex, "{packet:?}");
    assert_eq!(decode::<Packet<M>>(&unended(hex)), Ok(packet));
}

/// The bytes of a packet's frame.
pub fn sent(packet: &impl Serialize) -> String {
    let mut out = [0; MAX_ENCODED];
    encode(packet, &mut out).unwrap().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// The bytes of a frame without its terminator.
pub fn unended(hex: &str) -> Vec<u8> {
    (0..hex.len() / 2 - 1).map(|k| u8::from_str_radix(&hex[2 * k..2 * k + 2], 16).unwrap()).collect()
}
