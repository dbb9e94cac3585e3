//! Opening a file as text, and refusing at once what is not a text.
//!
//! [`TextReader`] passes bytes through while it counts lines and checks the encoding, so that a file of any size is
//! refused at the first wrong byte, with its line, and without being held in memory.

use std::fs::File;
use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use crate::error::{BadInput, Result};

/// A log line has a few dozen characters; a line this long is not a log.
const LONGEST_LINE: usize = 1 << 20;

/// What stopped a [`TextReader`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotText {
    /// Bytes that are no UTF-8.
    #[error("byte {byte} of the file is not UTF-8 text")]
    Encoding {
        /// Line, from 1.
        line: u64,
        /// Offset in the file, from 0.
        byte: u64,
    },
    /// A zero byte: the file is binary.
    #[error("byte {byte} of the file is zero, so this is a binary file")]
    Binary {
        /// Line, from 1.
        line: u64,
        /// Offset in the file, from 0.
        byte: u64,
    },
    /// A line too long for any log.
    #[error("the line is longer than {LONGEST_LINE} bytes, so this is not a table of samples")]
    LongLine {
        /// Line, from 1.
        line: u64,
    },
}

impl NotText {
    fn line(&self) -> u64 {
        match self {
            NotText::Encoding { line, .. } | NotText::Binary { line, .. } | NotText::LongLine { line } => {
                *line
            }
        }
    }

    fn remedy(&self) -> &'static str {
        match self {
            NotText::Encoding { .. } => {
                "save the file as UTF-8 (iconv -f latin1 -t utf-8 OLD > NEW, or the encoding box of the editor)"
            }
            NotText::Binary { .. } => "export the log as CSV from the program that made it",
            NotText::LongLine { .. } => "check that this is the log, with one sample per line",
        }
    }
}

/// A byte source that is known to be UTF-8 as far as it was read.
#[derive(Debug)]
pub struct TextReader<R> {
    inner: R,
    line: u64,
    line_bytes: usize,
    byte: u64,
    /// The beginning of a character whose end has not been read yet.
    open: Vec<u8>,
}

impl<R: Read> TextReader<R> {
    /// Starts at the first line of `inner`.
    pub fn new(inner: R) -> Self {
        TextReader { inner, line: 1, line_bytes: 0, byte: 0, open: Vec::new() }
    }

    fn check(&mut self, fresh: &[u8]) -> Result<(), NotText> {
        let mut seen = std::mem::take(&mut self.open);
        let carried = seen.len();
        seen.extend_from_slice(fresh);
        let good = match std::str::from_utf8(&seen) {
            Ok(_) => seen.len(),
            Err(error) if error.error_len().is_none() && !fresh.is_empty() => error.valid_up_to(),
            Err(error) => {
                let before = &seen[..error.valid_up_to()];
                self.advance(before)?;
                return Err(NotText::Encoding { line: self.line, byte: self.byte });
            }
        };
        debug_assert!(carried <= 3);
        self.advance(&seen[..good])?;
        self.open = seen.split_off(good);
        Ok(())
    }

    fn advance(&mut self, text: &[u8]) -> Result<(), NotText> {
        if let Some(zero) = memchr::memchr(0, text) {
            let newlines = memchr::memchr_iter(b'\n', &text[..zero]).count();
            return Err(NotText::Binary { line: self.line + newlines as u64, byte: self.byte + zero as u64 });
        }
        let mut start = 0;
        for end in memchr::memchr_iter(b'\n', text).chain([text.len()]) {
            self.line_bytes += end - start;
            if self.line_bytes > LONGEST_LINE {
                return Err(NotText::LongLine { line: self.line });
            }
            if end < text.len() {
                self.line += 1;
                self.line_bytes = 0;
            }
            start = end + 1;
        }
        self.byte += text.len() as u64;
        Ok(())
    }
}

impl<R: Read> Read for TextReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        if buffer.is_empty() {
            return Ok(0);
        }
        let count = self.inner.read(buffer)?;
        self.check(&buffer[..count]).map_err(io::Error::other)?;
        Ok(count)
    }
}

/// Opens `path` for reading as text; a byte-order mark is skipped.
///
/// # Errors
/// Bad input if it is absent, unreadable, a directory, empty, or of a kind known by its first bytes not to be text.
pub fn open(path: &Path) -> Result<BufReader<TextReader<BufReader<File>>>> {
    let file = File::open(path).map_err(|error| cannot_read(path, &error))?;
    if file.metadata().is_ok_and(|about| about.is_dir()) {
        return Err(BadInput::new(
            path,
            "this is a directory, not a log",
            format!("name the files in it, for example {}/*.csv", path.display()),
        )
        .into());
    }
    let mut bytes = BufReader::with_capacity(1 << 16, file);
    let start = bytes.fill_buf().map_err(|error| cannot_read(path, &error))?;
    if start.is_empty() {
        return Err(BadInput::new(
            path,
            "the file is empty",
            "check that the logger was running and closed its file",
        )
        .into());
    }
    if let Some((kind, remedy)) = foreign_kind(start) {
        return Err(BadInput::new(path, format!("this is {kind}, not a text"), remedy).at_line(1).into());
    }
    if start.starts_with(b"\xEF\xBB\xBF") {
        bytes.consume(3);
    }
    Ok(BufReader::with_capacity(1 << 16, TextReader::new(bytes)))
}

/// Turns an error met while reading into bad input, with the line if the text itself was to blame.
pub fn cannot_read(path: &Path, error: &io::Error) -> crate::error::Error {
    if let Some(fault) = error.get_ref().and_then(|inner| inner.downcast_ref::<NotText>()) {
        return BadInput::new(path, fault.to_string(), fault.remedy()).at_line(fault.line()).into();
    }
    let (why, remedy) = match error.kind() {
        ErrorKind::NotFound => ("there is no such file".into(), "check the name and the directory"),
        ErrorKind::PermissionDenied => (
            "the system does not permit reading it".into(),
            "change its permissions (chmod u+r FILE) or copy it",
        ),
        ErrorKind::IsADirectory => ("this is a directory, not a log".into(), "name the files in it"),
        _ => (format!("cannot be read: {error}"), "copy the file to a local disk and try again"),
    };
    BadInput::new(path, why, remedy).into()
}

fn foreign_kind(start: &[u8]) -> Option<(&'static str, &'static str)> {
    const KINDS: [(&[u8], &str, &str); 6] = [
        (
            b"WPILOG",
            "a WPILOG data log",
            "export it as CSV with DataLogTool or AdvantageScope and add --format wpilib-sysid",
        ),
        (b"\x1F\x8B", "compressed with gzip", "unpack it with gunzip"),
        (b"PK\x03\x04", "a zip archive or spreadsheet", "save the sheet as CSV (UTF-8)"),
        (b"\xFF\xFE", "UTF-16 text", "save it as UTF-8 (iconv -f utf-16 -t utf-8 OLD > NEW)"),
        (b"\xFE\xFF", "UTF-16 text", "save it as UTF-8 (iconv -f utf-16 -t utf-8 OLD > NEW)"),
        (b"\x89HDF", "an HDF5 or MATLAB file", "write the columns as CSV (writetable in MATLAB)"),
    ];
    KINDS.iter().find(|(magic, ..)| start.starts_with(magic)).map(|&(_, kind, remedy)| (kind, remedy))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Hands out one byte per call, so that characters arrive in pieces.
    struct Drip<'a>(&'a [u8]);

    impl Read for Drip<'_> {
        fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
            let count = self.0.len().min(buffer.len()).min(1);
            buffer[..count].copy_from_slice(&self.0[..count]);
            self.0 = &self.0[count..];
            Ok(count)
        }
    }

    fn fault_of(bytes: &[u8]) -> NotText {
        let mut sink = Vec::new();
        let error = TextReader::new(Drip(bytes)).read_to_end(&mut sink).unwrap_err();
        error.get_ref().unwrap().downcast_ref::<NotText>().unwrap().clone()
    }

    #[test]
    fn characters_split_over_reads_pass_unchanged() {
        let text = "time_s,température_°C\n1,2\n";
        let mut sink = String::new();
        TextReader::new(Drip(text.as_bytes())).read_to_string(&mut sink).unwrap();
        assert_eq!(sink, text);
    }

    #[test]
    fn a_latin1_byte_is_named_by_line_and_offset() {
        assert_eq!(fault_of(b"a\nb\nc\xB0d\n"), NotText::Encoding { line: 3, byte: 5 });
    }

    #[test]
    fn a_character_cut_off_by_the_end_of_file_is_a_fault() {
        assert_eq!(fault_of(b"a\n\xC3"), NotText::Encoding { line: 2, byte: 2 });
    }

    #[test]
    fn a_zero_byte_means_binary() {
        assert_eq!(fault_of(b"ab\n\0"), NotText::Binary { line: 2, byte: 3 });
    }

    #[test]
    fn an_endless_line_is_refused_before_it_fills_memory() {
        let endless = io::repeat(b'7').take(1 << 24);
        let error = io::copy(&mut TextReader::new(endless), &mut io::sink()).unwrap_err();
        assert!(error.to_string().contains("longer than"));
    }
}
