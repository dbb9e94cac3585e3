//! Frames on a serial line: where a message begins and ends, and whether it arrived whole.

use super::protected::{self, MAX_PLAIN, MAX_PROTECTED};
use crc::{CRC_32_ISCSI, Crc, NoTable};
use serde::Serialize;
use serde::de::DeserializeOwned;

/// The longest message with its CRC, bytes.
pub const MAX_MESSAGE: usize = 192;
/// The longest frame on the line, bytes: COBS adds one byte in 254, and the zero that ends it.
pub const MAX_ENCODED: usize = MAX_MESSAGE + 2;

/// Bit by bit: a table would save time that the line does not have, and cost flash.
const CRC: Crc<u32, NoTable> = Crc::<u32, NoTable>::new(&CRC_32_ISCSI);

/// Why a frame was thrown away.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Damage {
    /// Longer than any message, so a terminator was lost.
    TooLong,
    /// The byte stuffing does not fit together.
    Stuffing,
    /// The CRC does not fit.
    Checksum,
    /// Arrived whole, yet is no message of this version.
    Meaning,
}

/// Writes `message` as a frame into `out` and returns it.
///
/// # Errors
/// [`Damage::TooLong`] when the message does not fit in [`MAX_MESSAGE`] bytes.
pub fn encode<'a, M: Serialize>(message: &M, out: &'a mut [u8; MAX_ENCODED]) -> Result<&'a [u8], Damage> {
    let mut plain = [0; MAX_MESSAGE];
    let used = postcard::to_slice(message, &mut plain[..MAX_MESSAGE - 4]).map_err(|_| Damage::TooLong)?.len();
    let length = close(&mut plain, used);
    let length = cobs::encode(&plain[..length], out);
    out[length] = 0;
    Ok(&out[..=length])
}

/// Writes `message` as a frame with forward error correction, for a bad line. Only to an end of version 3 or later.
///
/// # Errors
/// [`Damage::TooLong`] when the message does not fit.
pub fn encode_protected<'a, M: Serialize>(
    message: &M,
    out: &'a mut [u8; MAX_PROTECTED],
) -> Result<&'a [u8], Damage> {
    protect(message, out, &mut || ())
}

fn protect<'a, M: Serialize>(
    message: &M,
    out: &'a mut [u8; MAX_PROTECTED],
    progress: &mut dyn FnMut(),
) -> Result<&'a [u8], Damage> {
    let mut plain = [0; MAX_MESSAGE];
    let used = postcard::to_slice(message, &mut plain[..MAX_PLAIN - 4]).map_err(|_| Damage::TooLong)?.len();
    let length = close(&mut plain, protected::filled(used + 4) - 4);
    protected::write(&plain[..length], out, progress).ok_or(Damage::TooLong)
}

/// The longest frame of either kind.
pub const MAX_FRAME: usize = if MAX_PROTECTED > MAX_ENCODED { MAX_PROTECTED } else { MAX_ENCODED };

/// Writes `message` as a protected frame where that is asked for and it fits in one, else as a plain one. Calls `progress` again and
/// again, at least every ten thousand instructions or so: a protected frame takes a board long.
///
/// # Errors
/// [`Damage::TooLong`] when it fits in neither.
pub fn encode_as<'a, M: Serialize>(
    message: &M,
    protected: bool,
    out: &'a mut [u8; MAX_FRAME],
    progress: &mut dyn FnMut(),
) -> Result<&'a [u8], Damage> {
    if protected {
        let room = out.first_chunk_mut().ok_or(Damage::TooLong)?;
        if let Ok(length) = protect(message, room, progress).map(<[u8]>::len) {
            return Ok(&out[..length]);
        }
    }
    encode(message, out.first_chunk_mut().ok_or(Damage::TooLong)?)
}

/// Puts the CRC behind the first `used` bytes; the length of both.
fn close(plain: &mut [u8; MAX_MESSAGE], used: usize) -> usize {
    let sum = CRC.checksum(&plain[..used]).to_le_bytes();
    plain[used..used + 4].copy_from_slice(&sum);
    used + 4
}

/// Reads the message of one frame, given without its terminator, protected or not.
///
/// # Errors
/// What is wrong with the frame; a wrong message never passes the CRC except by one chance in 2^32.
pub fn decode<M: DeserializeOwned>(frame: &[u8]) -> Result<M, Damage> {
    read(frame, &mut || ()).map(|(message, _)| message)
}

/// The message, and whether its frame was protected.
fn read<M: DeserializeOwned>(frame: &[u8], progress: &mut dyn FnMut()) -> Result<(M, bool), Damage> {
    progress();
    let mut plain = [0; MAX_ENCODED];
    let stuffed = match frame.len() {
        // It cannot grow.
        ..=MAX_ENCODED => cobs::decode(frame, &mut plain).map_err(|_| Damage::Stuffing),
        _ => Err(Damage::TooLong),
    };
    let damage = match stuffed.and_then(|length| open(&plain[..length])) {
        Err(damage @ (Damage::TooLong | Damage::Stuffing | Damage::Checksum)) => damage,
        other => return other.map(|message| (message, false)),
    };
    let mut plain = [0; MAX_PLAIN];
    let length = protected::read(frame, &mut plain, progress).ok_or(damage)?;
    progress();
    open(&plain[..length]).map(|message| (message, true))
}

/// The message before a CRC that fits.
fn open<M: DeserializeOwned>(plain: &[u8]) -> Result<M, Damage> {
    let (body, sum) =
        plain.split_last_chunk::<4>().map(|(body, sum)| (body, *sum)).ok_or(Damage::Checksum)?;
    if CRC.checksum(body) != u32::from_le_bytes(sum) {
        return Err(Damage::Checksum);
    }
    // An older end does not send the fields appended since: they read as zero. The CRC has shown by now that nothing else
    // is missing.
    let mut padded = [0; MAX_MESSAGE];
    padded.get_mut(..body.len()).ok_or(Damage::TooLong)?.copy_from_slice(body);
    match postcard::take_from_bytes(&padded) {
        // A newer end may have appended fields to a message: what follows the known ones is skipped.
        Ok((message, _newer)) => Ok(message),
        Err(_) => Err(Damage::Meaning),
    }
}

/// Collects bytes as they come and yields a message at each terminator. Needs no start: it falls into step at the
/// first zero byte.
#[derive(Debug, Clone)]
pub struct Decoder {
    bytes: [u8; MAX_PROTECTED],
    length: usize,
    overrun: bool,
    protected: bool,
}

impl Default for Decoder {
    fn default() -> Self {
        Self::new()
    }
}

impl Decoder {
    /// A decoder that has seen nothing.
    pub const fn new() -> Self {
        Self { bytes: [0; MAX_PROTECTED], length: 0, overrun: false, protected: false }
    }

    /// Takes the next byte. `Some` when it ended a frame: its message, or what was wrong with it.
    pub fn push<M: DeserializeOwned>(&mut self, byte: u8) -> Option<Result<M, Damage>> {
        self.push_with_progress(byte, &mut || ())
    }

    /// [`Self::push`], which calls `progress` again and again, at least every ten thousand instructions or so: a long frame that is damaged
    /// takes a board long.
    pub fn push_with_progress<M: DeserializeOwned>(
        &mut self,
        byte: u8,
        progress: &mut dyn FnMut(),
    ) -> Option<Result<M, Damage>> {
        if byte != 0 {
            match self.bytes.get_mut(self.length) {
                Some(place) => {
                    *place = byte;
                    self.length += 1;
                }
                None => self.overrun = true,
            }
            return None;
        }
        let (length, overrun) = (self.length, self.overrun);
        (self.length, self.overrun) = (0, false);
        match length {
            // An empty frame is a terminator sent to wake the line.
            0 => None,
            _ if overrun => Some(Err(Damage::TooLong)),
            _ => Some(read(&self.bytes[..length], progress).map(|(message, protected)| {
                self.protected = protected;
                message
            })),
        }
    }

    /// Whether the last whole message came protected: its sender understands protected frames, and takes the line for bad.
    pub fn protected(&self) -> bool {
        self.protected
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::{FromBoard, LogBlock, Packet, Sample};
    use std::vec::Vec;

    fn log_packet() -> Packet<FromBoard> {
        let sample = Sample { duty: -2100, count: -70_000, supply_mv: 12_000, current_ma: -900, late_us: -3 };
        let mut block = LogBlock { run: 9, first: 59_992, samples: heapless::Vec::new() };
        while block.samples.push(sample).is_ok() {}
        Packet { id: 0, message: FromBoard::Log(block) }
    }

    #[test]
    fn a_message_too_long_to_be_protected_goes_plain_and_a_shorter_one_does_not() {
        for (length, protected) in [(20, true), (100, true), (MAX_PLAIN, false), (MAX_MESSAGE - 8, false)] {
            // A length before the bytes, and a CRC behind.
            let message = std::vec![7_u8; length];
            let mut out = [0; MAX_FRAME];
            let mut decoder = Decoder::new();
            let frame = encode_as(&&*message, true, &mut out, &mut || ()).unwrap();
            let read = frame.iter().find_map(|byte| decoder.push::<std::vec::Vec<u8>>(*byte));
            assert_eq!((read, decoder.protected()), (Some(Ok(message)), protected), "{length} bytes");
        }
    }

    #[test]
    fn a_message_comes_back_as_it_went_in() {
        let mut out = [0; MAX_ENCODED];
        let packet = log_packet();
        let frame = encode(&packet, &mut out).unwrap();
        assert_eq!(frame.iter().filter(|byte| **byte == 0).count(), 1);
        let mut decoder = Decoder::new();
        let got: Vec<_> = frame.iter().filter_map(|byte| decoder.push(*byte)).collect();
        assert_eq!(got, [Ok(packet)]);
    }

    #[test]
    fn every_damaged_byte_and_every_lost_byte_is_noticed() {
        let mut out = [0; MAX_ENCODED];
        let frame = encode(&log_packet(), &mut out).unwrap().to_vec();
        for place in 0..frame.len() - 1 {
            for change in [0x01, 0x80, 0xff] {
                let mut bad = frame.clone();
                bad[place] ^= change;
                let mut decoder = Decoder::new();
                let got = bad.iter().filter_map(|byte| decoder.push::<Packet<FromBoard>>(*byte));
                assert!(got.into_iter().all(|result| result.is_err()), "byte {place} ^ {change}");
            }
            let mut short = frame.clone();
            short.remove(place);
            let mut decoder = Decoder::new();
            assert!(short.iter().filter_map(|b| decoder.push::<Packet<FromBoard>>(*b)).all(|r| r.is_err()));
        }
    }

    #[test]
    fn an_endless_frame_costs_only_itself() {
        let mut decoder = Decoder::new();
        for _ in 0..100_000 {
            assert_eq!(decoder.push::<Packet<FromBoard>>(7), None);
        }
        assert_eq!(decoder.push::<Packet<FromBoard>>(0), Some(Err(Damage::TooLong)));
        let mut out = [0; MAX_ENCODED];
        let frame = encode(&log_packet(), &mut out).unwrap();
        assert_eq!(frame.iter().find_map(|byte| decoder.push(*byte)), Some(Ok(log_packet())));
    }
}
