//! Opening a file as text in whatever encoding it is, and refusing at once what is not a text.
//!
//! [`TextReader`] hands on UTF-8 piece by piece while it counts lines, so that a file of any size is read or refused without being
//! held in memory.

use std::fs::File;
use std::io::{self, BufRead, ErrorKind, Read, Seek};
use std::path::Path;

use super::encoding::Decoder;
use crate::error::{BadInput, Result};

/// A log line has a few dozen characters; a line this long is not a log.
const LONGEST_LINE: usize = 1 << 20;

/// What stopped a [`TextReader`].
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum NotText {
    /// Too many bytes that are no text in any encoding.
    #[error("from byte {byte} on there are too many bytes that are no text, so this is a binary file")]
    Binary {
        /// Line, from 1.
        line: u64,
        /// Offset of the first such byte in the file, from 0.
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
            NotText::Binary { line, .. } | NotText::LongLine { line } => *line,
        }
    }

    fn remedy(&self) -> &'static str {
        match self {
            NotText::Binary { .. } => "export the log as CSV from the program that made it",
            NotText::LongLine { .. } => "check that this is the log, with one sample per line",
        }
    }
}

/// Bytes of a file that are decoded at once.
const CHUNK: usize = 1 << 16;
/// More bytes than this share of a file's beginning are no text: the file is binary.
const BINARY_SHARE: f64 = 0.1;

/// A text of any usual encoding as UTF-8 with `\n` at the ends of its lines, decoded as it is read.
///
/// Lines are handed out whole: one that ends in a further piece of the file waits for it, so that whoever looks at what
/// [`fill_buf`](BufRead::fill_buf) gives sees all of the next line.
#[derive(Debug)]
pub struct TextReader<R> {
    inner: R,
    decoder: Decoder,
    raw: Vec<u8>,
    text: String,
    /// How much of `text` was taken.
    taken: usize,
    /// Where the last whole line of `text` ends.
    whole: usize,
    ended: bool,
    /// The line and its length where `text` ends.
    line: u64,
    line_bytes: usize,
}

impl<R: Read> TextReader<R> {
    /// Starts at the first line of `inner`, in the encoding that its first bytes speak for.
    ///
    /// # Errors
    /// What `inner` says; [`NotText::Binary`] where too many of the first bytes are no text in any encoding.
    pub fn new(mut inner: R) -> io::Result<Self> {
        let mut raw = Vec::new();
        inner.by_ref().take(CHUNK as u64).read_to_end(&mut raw)?;
        let ended = raw.len() < CHUNK;
        let decoder = Decoder::for_start(&raw);
        let bad = decoder.bad_bytes(&raw);
        if let Some(first) = bad.first
            && bad.count as f64 > BINARY_SHARE * raw.len() as f64
        {
            let line = 1 + memchr::memchr_iter(b'\n', &raw[..first]).count() as u64;
            return Err(io::Error::other(NotText::Binary { line, byte: first as u64 }));
        }
        let mut reader = TextReader {
            inner,
            decoder,
            raw,
            text: String::new(),
            taken: 0,
            whole: 0,
            ended,
            line: 1,
            line_bytes: 0,
        };
        reader.decode()?;
        Ok(reader)
    }

    /// What was decoded and not taken, with the line that is not whole: the beginning of the file, before anything was read.
    pub fn decoded(&self) -> &[u8] {
        &self.text.as_bytes()[self.taken..]
    }

    /// Decodes `raw` behind the line that was not whole, and checks the lengths of the lines.
    fn decode(&mut self) -> io::Result<()> {
        self.text.drain(..self.taken);
        self.taken = 0;
        // Colours may begin in the piece before.
        let open = self.text.rfind(ESCAPE).filter(|at| escape_in(&self.text[*at..]).is_none());
        let before = open.unwrap_or(self.text.len());
        self.decoder.decode(&self.raw, self.ended, &mut self.text);
        leave_out_escapes(&mut self.text, before);
        let text = &self.text.as_bytes()[before..];
        self.whole = match memchr::memrchr(b'\n', text) {
            _ if self.ended => self.text.len(),
            Some(at) => before + at + 1,
            None => 0,
        };
        let mut start = 0;
        for end in memchr::memchr_iter(b'\n', text).chain([text.len()]) {
            self.line_bytes += end - start;
            if self.line_bytes > LONGEST_LINE {
                return Err(io::Error::other(NotText::LongLine { line: self.line }));
            }
            if end < text.len() {
                self.line += 1;
                self.line_bytes = 0;
            }
            start = end + 1;
        }
        Ok(())
    }
}

/// The text of a file that was read as a whole, in whatever encoding.
///
/// # Errors
/// Says why it is no text.
pub fn whole(all: &[u8]) -> io::Result<String> {
    let mut text = String::new();
    TextReader::new(all)?.read_to_string(&mut text)?;
    Ok(text)
}

/// What a terminal's colours and movements begin with.
const ESCAPE: char = '\u{1b}';

/// The length of the sequence that a text begins with which colours what follows or moves the cursor, as `ESC [ 0 ; 32 m`; none where it is
/// none, or does not end.
fn escape_in(text: &str) -> Option<usize> {
    let rest = text.strip_prefix(ESCAPE)?.strip_prefix('[')?;
    let end = rest.find(|c: char| !c.is_ascii_digit() && !";?".contains(c))?;
    rest[end..].starts_with(|c: char| c.is_ascii_alphabetic()).then_some(end + 3)
}

/// Leaves out the sequences for a terminal behind `from`: boards and their tools colour their lines.
fn leave_out_escapes(text: &mut String, from: usize) {
    if memchr::memchr(0x1b, &text.as_bytes()[from..]).is_none() {
        return;
    }
    let coloured = text.split_off(from);
    let mut rest = coloured.as_str();
    while let Some(at) = rest.find(ESCAPE) {
        // What is no such sequence stays.
        let length = escape_in(&rest[at..]);
        text.push_str(&rest[..at + usize::from(length.is_none())]);
        rest = &rest[at + length.unwrap_or(1)..];
    }
    text.push_str(rest);
}

impl<R: Read> BufRead for TextReader<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        while self.taken == self.whole && !self.ended {
            self.raw.clear();
            self.inner.by_ref().take(CHUNK as u64).read_to_end(&mut self.raw)?;
            self.ended = self.raw.len() < CHUNK;
            self.decode()?;
        }
        Ok(&self.text.as_bytes()[self.taken..self.whole])
    }

    fn consume(&mut self, count: usize) {
        self.taken = (self.taken + count).min(self.whole);
    }
}

impl<R: Read> Read for TextReader<R> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.fill_buf()?.read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

/// Opens `path` for reading as text.
///
/// # Errors
/// Bad input if it is absent, unreadable, a directory, empty, or no text.
pub fn open(path: &Path) -> Result<TextReader<File>> {
    let mut file = File::open(path).map_err(|error| cannot_read(path, &error))?;
    if file.metadata().is_ok_and(|about| about.is_dir()) {
        return Err(BadInput::new(
            path,
            "this is a directory, not a log",
            format!("name the files in it, for example {}/*.csv", path.display()),
        )
        .into());
    }
    let mut start = Vec::new();
    file.by_ref()
        .take(16)
        .read_to_end(&mut start)
        .and_then(|_| file.rewind())
        .map_err(|error| cannot_read(path, &error))?;
    if start.is_empty() {
        return Err(BadInput::new(
            path,
            "the file is empty",
            "check that the logger was running and closed its file",
        )
        .into());
    }
    TextReader::new(file).map_err(|error| cannot_read(path, &error))
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
        let error = match TextReader::new(Drip(bytes)) {
            Ok(mut reader) => reader.read_to_end(&mut Vec::new()).unwrap_err(),
            Err(error) => error,
        };
        error.get_ref().unwrap().downcast_ref::<NotText>().unwrap().clone()
    }

    #[test]
    fn characters_split_over_reads_pass_unchanged() {
        // Longer than a chunk, with characters of two and three bytes across its end.
        for begin in ["", "x", "xy"] {
            let text = begin.to_owned() + &"température_°C €\n".repeat(8000);
            let mut sink = String::new();
            TextReader::new(Drip(text.as_bytes())).unwrap().read_to_string(&mut sink).unwrap();
            assert_eq!(sink, text);
        }
    }

    #[test]
    fn the_colours_of_a_terminal_are_left_out_wherever_a_piece_of_the_file_ends() {
        for begin in ["", "x", "xy", "xyz", "xyzu", "xyzuv"] {
            let line = "\u{1b}[0;32m10,\u{1b}[1m80\u{1b}[0m,55\n";
            let text = begin.to_owned() + &line.repeat(8000);
            let mut read = String::new();
            TextReader::new(Drip(text.as_bytes())).unwrap().read_to_string(&mut read).unwrap();
            assert_eq!(read, begin.to_owned() + &"10,80,55\n".repeat(8000));
        }
        let mut read = String::new();
        TextReader::new(Drip(b"a\x1b[12\nb\x1bc\x1b")).unwrap().read_to_string(&mut read).unwrap();
        assert_eq!(read, "a\u{1b}[12\nb\u{1b}c\u{1b}");
    }

    #[test]
    fn many_bytes_that_are_no_text_mean_a_binary_file() {
        assert_eq!(fault_of(b"ab\n\0\0\x01\x02"), NotText::Binary { line: 2, byte: 3 });
    }

    #[test]
    fn an_endless_line_is_refused_before_it_fills_memory() {
        let endless = io::repeat(b'7').take(1 << 24);
        let error = io::copy(&mut TextReader::new(endless).unwrap(), &mut io::sink()).unwrap_err();
        assert!(error.to_string().contains("longer than"));
    }
}
