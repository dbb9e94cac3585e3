//! Splitting one line into fields.
//!
//! A sample is a line, so lines are split one at a time: the number of a line in a message is then exact, whatever
//! blank lines and remarks stand between the samples.

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

/// Splits lines at a delimiter, respecting quotes; keeps its buffers from line to line.
#[derive(Debug)]
pub struct Splitter {
    reader: Reader,
    text: Vec<u8>,
    ends: Vec<usize>,
    count: usize,
}

impl Splitter {
    /// Splits at `delimiter`.
    pub fn new(delimiter: u8) -> Self {
        Splitter {
            reader: ReaderBuilder::new().delimiter(delimiter).build(),
            text: Vec::new(),
            ends: Vec::new(),
            count: 0,
        }
    }

    /// Splits one line, with or without its end. Says whether all quotes are closed.
    pub fn split(&mut self, line: &[u8]) -> bool {
        let line = line.trim_ascii();
        self.text.resize(line.len() + 1, 0);
        self.ends.resize(line.len() + 1, 0);
        self.reader.reset();
        let (result, read, written, count) = self.reader.read_record(line, &mut self.text, &mut self.ends);
        self.count = count;
        if result == ReadRecordResult::InputEmpty {
            // The end of the input closes the last field; within a quote, it comes too early.
            let (end, _, _, last) =
                self.reader.read_record(b"\n", &mut self.text[written..], &mut self.ends[count..]);
            self.count += last;
            return end == ReadRecordResult::Record;
        }
        result == ReadRecordResult::Record && read == line.len()
    }

    /// Number of fields of the line.
    pub fn len(&self) -> usize {
        self.count
    }

    /// A field of the line without the spaces around it; `None` beyond the last.
    pub fn get(&self, index: usize) -> Option<&str> {
        let end = *self.ends[..self.count].get(index)?;
        let start = if index == 0 { 0 } else { self.ends[index - 1] };
        std::str::from_utf8(&self.text[start..end]).ok().map(str::trim)
    }

    /// All fields of the line.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        (0..self.count).filter_map(|index| self.get(index))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(line: &str, delimiter: u8) -> Vec<String> {
        let mut splitter = Splitter::new(delimiter);
        // An earlier, longer line must leave no trace.
        splitter.split(b"an,earlier;line,\"with\",many,fields");
        assert!(splitter.split(line.as_bytes()));
        splitter.iter().map(str::to_owned).collect()
    }

    #[test]
    fn delimiters_quotes_spaces_and_line_ends_are_understood() {
        assert_eq!(fields("1, 2 ,3\r\n", b','), ["1", "2", "3"]);
        assert_eq!(fields("1;;\"a;b\"", b';'), ["1", "", "a;b"]);
        assert_eq!(fields("1,2,\n", b','), ["1", "2", ""]);
        assert_eq!(fields("\"say \"\"hi\"\"\"\tx", b'\t'), ["say \"hi\"", "x"]);
        assert_eq!(fields("1", b','), ["1"]);
    }

    #[test]
    fn an_open_quote_is_noticed() {
        assert!(!Splitter::new(b',').split(b"1,\"2,3\n"));
    }
}
