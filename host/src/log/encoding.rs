//! From bytes to UTF-8: UTF-8 and UTF-16 with and without a byte-order mark, and what older programs and disturbed lines write.
//!
//! A byte that is no UTF-8 is taken as a character of Windows-1252 (`°`, `µ`, `ü` in a header), or of the code page in which the names are
//! known words; among the numbers of a row it makes the row unreadable in either way, and the row is then named. Zero bytes, which a
//! preallocated file or a disturbed line leaves, become one U+FFFD a run, never nothing: a number with a hole must not pass as another
//! number.

use encoding_rs::{UTF_16BE, UTF_16LE, WINDOWS_1252};

use super::code_pages;

/// Zeros at this share of the high bytes, and at so few of the low ones, are UTF-16.
const HIGH_ZEROS: f64 = 0.6;
const LOW_ZEROS: f64 = 0.05;

/// Decodes a text piece by piece.
#[derive(Debug)]
pub(super) struct Decoder {
    coding: Coding,
    at_start: bool,
    /// The beginning of a character whose end is in the next piece.
    open: Vec<u8>,
    /// Lines end with a carriage return alone.
    returns: bool,
}

enum Coding {
    Utf8,
    Utf16(encoding_rs::Decoder),
    /// Another country's code page.
    Page(encoding_rs::Decoder),
}

impl std::fmt::Debug for Coding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Coding::Utf8 => "Utf8",
            Coding::Utf16(_) => "Utf16",
            Coding::Page(_) => "Page",
        })
    }
}

/// Bytes that no text has.
#[derive(Debug, Default)]
pub(super) struct BadBytes {
    pub count: usize,
    pub first: Option<usize>,
}

impl Decoder {
    /// The decoder for a file that begins with `start`.
    pub fn for_start(start: &[u8]) -> Self {
        let coding = match start {
            [0xFF, 0xFE, ..] => Coding::Utf16(UTF_16LE.new_decoder_with_bom_removal()),
            [0xFE, 0xFF, ..] => Coding::Utf16(UTF_16BE.new_decoder_with_bom_removal()),
            _ => {
                let zeros = |from: usize| {
                    let all = start.iter().skip(from).step_by(2);
                    all.clone().filter(|byte| **byte == 0).count() as f64 / all.count().max(1) as f64
                };
                let (even, odd) = (zeros(0), zeros(1));
                if start.len() >= 8 && odd > HIGH_ZEROS && even < LOW_ZEROS {
                    Coding::Utf16(UTF_16LE.new_decoder_without_bom_handling())
                } else if start.len() >= 8 && even > HIGH_ZEROS && odd < LOW_ZEROS {
                    Coding::Utf16(UTF_16BE.new_decoder_without_bom_handling())
                } else {
                    let page = code_pages::of(start);
                    page.map_or(Coding::Utf8, |page| Coding::Page(page.new_decoder_without_bom_handling()))
                }
            }
        };
        Decoder { coding, at_start: true, open: Vec::new(), returns: false }
    }

    /// The bytes of `start` that are no text: control characters other than blanks and line ends, zeros.
    pub fn bad_bytes(&self, start: &[u8]) -> BadBytes {
        if matches!(self.coding, Coding::Utf16(_)) {
            return BadBytes::default();
        }
        // Zeros at the end are a file that was laid out before it was filled; zeros alone are no text.
        let filled = start.iter().rposition(|byte| *byte != 0).map_or(start.len(), |last| last + 1);
        let bad = |byte: &u8| *byte < 0x20 && !b"\t\n\r\x0b\x0c\x1b\x1a".contains(byte);
        let places = start[..filled].iter().enumerate().filter(|(_, byte)| bad(byte)).map(|(at, _)| at);
        BadBytes { count: places.clone().count(), first: places.clone().next() }
    }

    /// Appends `bytes` to `text`; `last` says that no more will come.
    pub fn decode(&mut self, bytes: &[u8], last: bool, text: &mut String) {
        match &mut self.coding {
            Coding::Utf8 => {
                let joined;
                let mut rest = if self.open.is_empty() {
                    bytes
                } else {
                    joined = [std::mem::take(&mut self.open).as_slice(), bytes].concat();
                    &joined
                };
                loop {
                    let error = match std::str::from_utf8(rest) {
                        Ok(good) => {
                            text.push_str(good);
                            break;
                        }
                        Err(error) => error,
                    };
                    let (good, bad) = rest.split_at(error.valid_up_to());
                    text.push_str(std::str::from_utf8(good).unwrap_or_default());
                    if error.error_len().is_none() && !last {
                        self.open = bad.to_vec();
                        break;
                    }
                    let (byte, after) = bad.split_at(1);
                    text.push_str(&WINDOWS_1252.decode_without_bom_handling(byte).0);
                    rest = after;
                }
            }
            Coding::Utf16(decoder) | Coding::Page(decoder) => {
                text.reserve(decoder.max_utf8_buffer_length(bytes.len()).unwrap_or(4 * bytes.len()));
                let _ = decoder.decode_to_string(bytes, text, last);
            }
        }
        if std::mem::take(&mut self.at_start) {
            if text.starts_with('\u{feff}') {
                text.drain(..'\u{feff}'.len_utf8());
            }
            self.returns = text.contains('\r') && !text.contains('\n');
        }
        if self.returns {
            *text = text.replace('\r', "\n");
        }
        if memchr::memchr(0, text.as_bytes()).is_some() {
            *text = without_zeros(text);
        }
    }
}

/// Each run of zeros as one U+FFFD.
fn without_zeros(text: &str) -> String {
    let mut clean = String::with_capacity(text.len());
    for piece in text.split_inclusive('\0') {
        match piece.strip_suffix('\0') {
            Some("") if clean.ends_with('\u{fffd}') => {}
            Some(before) => {
                clean.push_str(before);
                clean.push('\u{fffd}');
            }
            None => clean.push_str(piece),
        }
    }
    clean
}

#[cfg(test)]
mod tests {
    use super::*;

    fn decoded(bytes: &[u8]) -> String {
        let mut text = String::new();
        Decoder::for_start(bytes).decode(bytes, true, &mut text);
        text
    }

    #[test]
    fn every_usual_encoding_is_read_with_and_without_its_mark() {
        let text = "time_s,Winkel [\u{b0}]\n0,1\n1,2\n";
        let wide = |order: fn(u16) -> [u8; 2]| -> Vec<u8> { text.encode_utf16().flat_map(order).collect() };
        let (little, big) = (wide(u16::to_le_bytes), wide(u16::to_be_bytes));
        let latin: Vec<u8> = text.chars().map(|c| c as u8).collect();
        for bytes in [
            text.as_bytes().to_vec(),
            [b"\xEF\xBB\xBF", text.as_bytes()].concat(),
            [b"\xFF\xFE", little.as_slice()].concat(),
            [b"\xFE\xFF", big.as_slice()].concat(),
            little.clone(),
            big.clone(),
            latin,
        ] {
            assert_eq!(decoded(&bytes), text, "{bytes:?}");
        }
    }

    #[test]
    fn the_code_page_of_another_country_is_told_by_its_names_also_in_pieces() {
        let text = "Время, с;Напряжение, В;Скорость, об/мин\n0;1;2\n";
        let bytes = encoding_rs::WINDOWS_1251.encode(text).0;
        assert_eq!(decoded(&bytes), text);
        let mut out = String::new();
        let mut decoder = Decoder::for_start(&bytes);
        bytes.chunks(7).for_each(|piece| decoder.decode(piece, false, &mut out));
        decoder.decode(&[], true, &mut out);
        assert_eq!(out, text);
    }

    #[test]
    fn a_character_in_two_pieces_is_one() {
        let text = "a\u{20ac}b";
        for cut in 0..=text.len() {
            let mut out = String::new();
            let mut decoder = Decoder::for_start(text.as_bytes());
            decoder.decode(&text.as_bytes()[..cut], false, &mut out);
            decoder.decode(&text.as_bytes()[cut..], true, &mut out);
            assert_eq!(out, text);
        }
    }

    #[test]
    fn returns_alone_end_lines_and_zeros_leave_a_mark() {
        assert_eq!(decoded(b"a\rb\rc"), "a\nb\nc");
        assert_eq!(decoded(b"a\r\nb"), "a\r\nb");
        assert_eq!(decoded(b"1,2\0\0\0.5\n\0"), "1,2\u{fffd}.5\n\u{fffd}");
    }
}
