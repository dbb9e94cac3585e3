//! Forward error correction for a bad line, on which bytes are damaged and bytes are missing.
//!
//! Every byte on the line carries half a byte, its own place modulo 7 and a parity bit, so a byte that is damaged or missing is
//! seen as such and the others stay in their places. Two of them are a symbol of a [`reed_solomon`] word, whose parity is
//! half of the message and a little more. With one byte in ten damaged or missing a frame arrives in all but a few of a
//! thousand cases; without, one of 24 bytes arrives in 8 of a hundred. No byte is 0, which ends a frame as it ends one without protection.

use super::reed_solomon::{self, LONGEST};

/// The longest message with its CRC that can be protected, bytes.
pub const MAX_PLAIN: usize = 164;
/// The longest protected frame on the line, with the zeros that end it.
pub const MAX_PROTECTED: usize = 2 * word_length(MAX_PLAIN) + ZEROS;

/// A lost terminator costs two frames, so there are two.
const ZEROS: usize = 2;
/// Message lengths are filled up to a multiple of this, so that bytes missing at a frame's end leave its length known.
const STEP: usize = 4;
/// Places are told modulo this.
const PLACES: usize = 7;
/// Bytes of a frame that are looked at between two calls of `progress`.
const PART: usize = 64;

/// Symbols of the word for a message of `plain` bytes.
const fn word_length(plain: usize) -> usize {
    plain + parity(plain)
}

const fn parity(plain: usize) -> usize {
    6 + plain / 2
}

/// The length that a message of so many bytes is filled up to.
pub const fn filled(length: usize) -> usize {
    length.div_ceil(STEP) * STEP
}

/// What stands on the line for the half byte at this place: place in the upper three bits, the parity bit, the half byte.
fn line_byte(place: usize, half: u8) -> u8 {
    let byte = (((place % PLACES) as u8 + 1) << 5) | half;
    byte | (byte.count_ones() as u8 & 1) << 4
}

/// The place modulo [`PLACES`] and the half byte, where the byte is whole.
fn read_byte(byte: u8) -> Option<(usize, u8)> {
    let place = usize::from(byte >> 5).checked_sub(1)?;
    byte.count_ones().is_multiple_of(2).then_some((place, byte & 0x0f))
}

/// Writes `plain`, whose length is [`filled`], as a frame with its terminators; `None` when it is longer than [`MAX_PLAIN`].
pub fn write<'a>(
    plain: &[u8],
    out: &'a mut [u8; MAX_PROTECTED],
    progress: &mut dyn FnMut(),
) -> Option<&'a [u8]> {
    if plain.len() > MAX_PLAIN || plain.len() != filled(plain.len()) {
        return None;
    }
    let mut word = [0; LONGEST];
    let word = word.get_mut(..word_length(plain.len()))?;
    word.get_mut(..plain.len())?.copy_from_slice(plain);
    reed_solomon::encode(word, parity(plain.len()), progress);
    let halves = word.iter().flat_map(|symbol| [symbol >> 4, symbol & 0x0f]);
    for (place, (byte, half)) in out.iter_mut().zip(halves).enumerate() {
        *byte = line_byte(place, half);
    }
    let end = 2 * word.len();
    out.get_mut(end..end + ZEROS)?.fill(0);
    out.get(..end + ZEROS)
}

/// Reads a frame, given without its terminators, into `plain`; its length, or `None` when too much of it is damaged or it never was one.
/// That what is read is right, the message's CRC must tell.
pub fn read(frame: &[u8], plain: &mut [u8; MAX_PLAIN], progress: &mut dyn FnMut()) -> Option<usize> {
    let mut word = [0; LONGEST];
    // Which halves of each symbol have come: 0b11 both.
    let mut come = [0_u8; LONGEST];
    let (mut next, mut damaged) = (0, 0);
    for part in frame.chunks(PART) {
        progress();
        for byte in part {
            let Some((place, half)) = read_byte(*byte) else {
                damaged += 1;
                continue;
            };
            // A damaged byte has most likely stood where one was to come.
            let expected = next + damaged;
            let ahead = (place + PLACES - expected % PLACES) % PLACES;
            // One place back: a damaged byte too many, as a terminator becomes.
            let at = if ahead == PLACES - 1 && damaged > 0 { expected - 1 } else { expected + ahead };
            let (symbol, low) = (at / 2, at % 2);
            *word.get_mut(symbol)? |= half << (4 * (1 - low));
            *come.get_mut(symbol)? |= 1 << low;
            (next, damaged) = (at + 1, 0);
        }
    }
    let fits = |length: &usize| 2 * word_length(*length) >= next;
    let length = (2 * STEP..=MAX_PLAIN).step_by(STEP).find(fits)?;
    let symbols = word_length(length);
    let mut lost = [0; LONGEST];
    let mut losses = 0;
    for place in (0..symbols).filter(|place| come[*place] != 0b11) {
        lost[losses] = place as u8;
        losses += 1;
    }
    reed_solomon::decode(&mut word[..symbols], &lost[..losses], parity(length), progress).then(|| {
        plain[..length].copy_from_slice(&word[..length]);
        length
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::vec::Vec;

    fn message(length: usize) -> Vec<u8> {
        (0..length).map(|k| (k * 7 + 3) as u8).collect()
    }

    #[test]
    fn no_byte_of_a_frame_is_zero_nor_becomes_so_by_one_bit() {
        for place in 0..PLACES {
            for half in 0..16 {
                assert!(line_byte(place, half).count_ones() >= 2);
                assert_eq!(read_byte(line_byte(place, half)), Some((place, half)));
                (0..8).for_each(|bit| assert_eq!(read_byte(line_byte(place, half) ^ 1 << bit), None));
            }
        }
    }

    #[test]
    fn every_length_comes_back_whole_with_bytes_missing_at_both_ends() {
        for length in (2 * STEP..=MAX_PLAIN).step_by(STEP) {
            let (plain, mut out, mut back) = (message(length), [0; MAX_PROTECTED], [0; MAX_PLAIN]);
            let frame = write(&plain, &mut out, &mut || ()).unwrap();
            let frame = &frame[..frame.len() - ZEROS];
            let fewer = &frame[2..frame.len() - 5];
            assert_eq!(read(frame, &mut back, &mut || ()), Some(length));
            assert_eq!(back[..length], plain);
            // What a terminator becomes when a bit of it is flipped.
            let garbage = [&[0x04], fewer, &[0x20]].concat();
            assert_eq!(read(&garbage, &mut back, &mut || ()), Some(length));
            assert_eq!(back[..length], plain);
        }
        assert!(write(&message(MAX_PLAIN + STEP), &mut [0; MAX_PROTECTED], &mut || ()).is_none());
    }

    proptest! {
        #[test]
        fn any_bytes_do_not_panic(frame in prop::collection::vec(any::<u8>(), 0..600)) {
            read(&frame, &mut [0; MAX_PLAIN], &mut || ());
        }
    }
}
