//! What a debugger reads of the board: the bytes of its terminal (SEGGER RTT), and defmt's messages in them.

use std::collections::BTreeMap;
use std::path::Path;

use rigless::emulator::{Error, Host};
use rigless::soc::Width;

use crate::machine;

/// The first channel to the debugger, in bytes from the block's begin: its buffer, size, and the two places in it
/// (`SEGGER_RTT.h`, `SEGGER_RTT_BUFFER_UP`).
const BUFFER: u64 = 28;
const SIZE: u64 = 32;
const WRITTEN: u64 = 36;
const READ: u64 = 40;

/// The board's first channel.
#[derive(Debug)]
pub struct Terminal {
    block: u64,
}

impl Terminal {
    /// That of an image.
    ///
    /// # Panics
    /// When it has none.
    pub fn of(image: &Path) -> Self {
        Terminal { block: machine::address_of(image, "_SEGGER_RTT") }
    }

    /// Takes what waits.
    ///
    /// # Errors
    /// When the channel does not lie in memory.
    pub fn drain(&self, host: &mut dyn Host, told: &mut Vec<u8>) -> Result<(), Error> {
        let mut field = |at: u64| host.read(self.block + at, Width::W32);
        let (written, mut read) = (field(WRITTEN)?, field(READ)?);
        let (buffer, size) = (field(BUFFER)?, field(SIZE)?);
        // Before the program has set the block up there is nothing.
        if written == read || written >= size {
            return Ok(());
        }
        while read != written {
            told.push(host.read(buffer + read, Width::W8)? as u8);
            read = (read + 1) % size;
        }
        host.write(self.block + READ, Width::W32, read)
    }
}

/// The messages in what an image has told, as text: defmt's formats stand in the symbols of the ELF, and what is told is their
/// numbers and arguments, in frames of reversed COBS (rzCOBS) that end with a zero.
///
/// # Panics
/// When a frame is not what this image says.
pub fn messages(image: &Path, told: &[u8]) -> Vec<String> {
    let formats: BTreeMap<u64, String> = machine::symbols(image)
        .into_iter()
        .filter_map(|(name, number)| {
            let symbol: serde_json::Value = serde_json::from_str(&name).ok()?;
            let level = symbol["tag"].as_str()?.strip_prefix("defmt_")?;
            Some((number & 0xffff, format!("{level}: {}", symbol["data"].as_str()?)))
        })
        .collect();
    let frames = told.split(|byte| *byte == 0).filter(|frame| !frame.is_empty());
    frames.map(|frame| message(&formats, &unpacked(frame))).collect()
}

/// A frame without its packing: from its end, each control byte tells which of the seven bytes before it were zero (bits),
/// or how many follow that are none.
fn unpacked(frame: &[u8]) -> Vec<u8> {
    let mut bytes = frame.iter().rev().copied();
    let mut out = Vec::new();
    while let Some(control) = bytes.next() {
        let literal = match control {
            0x01..=0x7f => {
                for bit in (0..7).rev() {
                    out.push(if control >> bit & 1 == 0 { bytes.next().expect("a whole frame") } else { 0 });
                }
                0
            }
            0xff => 134,
            _ => {
                out.push(0);
                usize::from(control & 0x7f) + 7
            }
        };
        out.extend(bytes.by_ref().take(literal));
    }
    out.reverse();
    out
}

/// A frame's text: its format with the arguments put in.
fn message(formats: &BTreeMap<u64, String>, frame: &[u8]) -> String {
    let number = u64::from(u16::from_le_bytes([frame[0], frame[1]]));
    let format = formats.get(&number).unwrap_or_else(|| panic!("no format {number}: {frame:x?}"));
    let mut rest = &frame[2..];
    let mut take = |length: usize| {
        let (taken, left) = rest.split_at(length);
        rest = left;
        taken
    };
    let word = |bytes: &[u8]| u32::from_le_bytes(bytes.try_into().expect("four"));
    let mut text = String::new();
    let mut parts = format.split('{');
    text.push_str(parts.next().unwrap_or_default());
    for part in parts {
        let (kind, plain) = part.split_once('}').expect("a format closes what it opens");
        match kind {
            "=u32" => text.push_str(&word(take(4)).to_string()),
            "=str" | "=[u8]:a" => {
                let length = word(take(4)) as usize;
                text.push_str(&String::from_utf8_lossy(take(length)));
            }
            _ => panic!("an argument of another kind: {format}"),
        }
        text.push_str(plain);
    }
    text
}
