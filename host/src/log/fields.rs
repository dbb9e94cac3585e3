//! Splitting one line into fields, by whatever separates them.
//!
//! A sample is a line, so lines are split one at a time: the number of a line in a message is then exact, whatever
//! blank lines and remarks stand between the samples.

use std::cell::RefCell;
use std::ops::Range;

use csv_core::{ReadRecordResult, Reader, ReaderBuilder};

use super::clock;
use super::hexadecimal::is_hex;
use super::pairs::pairs;
use super::stamped::stamped;

/// What separates the fields of a row.
#[derive(Debug, Clone, PartialEq)]
pub enum Separator {
    /// This character.
    Byte(u8),
    /// Commas, and a comma within each number too: every second one separates.
    DecimalCommas,
    /// Blanks and tabs, any number of them.
    Blanks,
    /// Each value follows its name and a colon: `t:12 pwm:80`. The names, in the order of the columns.
    Names(Vec<String>),
}

/// Splits lines, respecting quotes; keeps its buffers from line to line.
#[derive(Debug)]
pub struct Splitter {
    separator: Separator,
    stamped: bool,
    /// What stands before the fields of a line; may be empty.
    tag: String,
    /// Columns at the beginning that are left out.
    first: usize,
    /// What stands behind the numbers of a column, by column; may be empty.
    units: Vec<String>,
    /// Columns of hexadecimal numbers without a mark, which they get.
    hex: Vec<usize>,
    text: String,
    fields: Vec<Range<usize>>,
    stamp: Option<String>,
}

impl Splitter {
    /// Splits as `separator` says; `stamped` says that a serial monitor put the time and an arrow before each line.
    pub fn of(separator: Separator, stamped: bool) -> Self {
        Splitter {
            separator,
            stamped,
            tag: String::new(),
            first: 0,
            units: Vec::new(),
            hex: Vec::new(),
            text: String::new(),
            fields: Vec::new(),
            stamp: None,
        }
    }

    /// Leaves out the unit that stands behind the numbers of a column.
    pub fn without_units(self, units: Vec<String>) -> Self {
        Splitter { units, ..self }
    }

    /// Leaves out what stands before the fields of a line.
    pub fn without_tag(self, tag: String) -> Self {
        Splitter { tag, ..self }
    }

    /// Leaves out the columns before this one.
    pub fn begun_at(self, first: usize) -> Self {
        Splitter { first, ..self }
    }

    /// Reads these columns as hexadecimal numbers.
    pub fn with_hex(self, hex: Vec<usize>) -> Self {
        Splitter { hex, ..self }
    }

    /// Splits one line, with or without its end. Says whether all quotes are closed.
    pub fn split(&mut self, line: &str) -> bool {
        let closed = self.split_as_it_is(line);
        self.fields.drain(..self.first.min(self.fields.len()));
        if !self.hex.is_empty() {
            self.mark_hex();
        }
        closed
    }

    /// Puts `0x` before the fields of hexadecimal columns.
    fn mark_hex(&mut self) {
        for k in 0..self.hex.len() {
            let column = self.hex[k];
            let Some(marked) = self.get(column).filter(|text| is_hex(text)).map(|text| format!("0x{text}"))
            else {
                continue;
            };
            let begin = self.text.len();
            self.text.push_str(&marked);
            self.fields[column] = begin..self.text.len();
        }
    }

    fn split_as_it_is(&mut self, line: &str) -> bool {
        self.fields.clear();
        self.stamp = None;
        let mut line = trimmed(line);
        if self.stamped
            && let Some((stamp, rest)) = stamped(line)
        {
            self.stamp = Some(stamp.to_owned());
            line = rest;
        }
        if !self.tag.is_empty()
            && let Some(rest) = line.strip_prefix(self.tag.as_str())
        {
            line = rest.trim_start();
        }
        line = unwrapped(line);
        self.text.clear();
        match &self.separator {
            Separator::Byte(_) if line.contains('"') => return self.split_quoted(line),
            Separator::Byte(byte) => {
                let mut start = 0;
                for end in memchr::memchr_iter(*byte, line.as_bytes()).chain([line.len()]) {
                    self.fields.push(start..end);
                    start = end + 1;
                }
            }
            Separator::DecimalCommas => {
                let commas: Vec<usize> =
                    memchr::memchr_iter(b',', line.as_bytes()).chain([line.len()]).collect();
                let mut start = 0;
                for pair in commas.chunks(2) {
                    let end = pair[pair.len() - 1];
                    self.fields.push(start..end);
                    start = end + 1;
                }
            }
            Separator::Blanks => split_blanks(line, &mut self.fields),
            Separator::Names(names) => {
                let pairs = pairs(line);
                self.fields.extend(names.iter().map(|name| {
                    pairs
                        .iter()
                        .find(|(key, _)| line[key.clone()] == **name)
                        .map_or(0..0, |(_, value)| value.clone())
                }));
                if pairs.is_empty() {
                    self.fields.truncate(1);
                }
            }
        }
        self.text.push_str(line);
        true
    }

    fn split_quoted(&mut self, line: &str) -> bool {
        let (mut text, mut ends) = (vec![0; line.len() + 1], vec![0; line.len() + 1]);
        let delimiter = if let Separator::Byte(byte) = self.separator { byte } else { b',' };
        let (closed, count) = with_reader(delimiter, |reader| {
            let (result, read, written, count) = reader.read_record(line.as_bytes(), &mut text, &mut ends);
            if result != ReadRecordResult::InputEmpty {
                return (result == ReadRecordResult::Record && read == line.len(), count);
            }
            // The end of the input closes the last field; within a quote, it comes too early.
            let (end, _, _, last) = reader.read_record(b"\n", &mut text[written..], &mut ends[count..]);
            (end == ReadRecordResult::Record, count + last)
        });
        let mut start = 0;
        for &end in &ends[..count] {
            let field = String::from_utf8_lossy(&text[start..end]);
            let begin = self.text.len();
            self.text.push_str(&field);
            self.fields.push(begin..self.text.len());
            start = end;
        }
        closed
    }

    /// Number of fields of the line.
    pub fn len(&self) -> usize {
        self.fields.len()
    }

    /// A field of the line without the spaces around it, or the unit of its column; `None` beyond the last.
    pub fn get(&self, index: usize) -> Option<&str> {
        let text = self.text[self.fields.get(index)?.clone()].trim();
        let unit = self.units.get(index).filter(|unit| !unit.is_empty());
        Some(unit.and_then(|unit| text.strip_suffix(unit.as_str())).map_or(text, str::trim_end))
    }

    /// When a serial monitor received the line, if it says.
    pub fn stamp(&self) -> Option<&str> {
        self.stamp.as_deref()
    }

    /// All fields of the line.
    pub fn iter(&self) -> impl Iterator<Item = &str> {
        (0..self.fields.len()).filter_map(|index| self.get(index))
    }
}

thread_local! {
    /// Readers of quoted lines by what separates the fields, made once: their making costs more than the splitting of many lines.
    static READERS: RefCell<Vec<(u8, Reader)>> = const { RefCell::new(Vec::new()) };
}

/// Does something with the reader of quoted lines whose fields `delimiter` separates.
fn with_reader<T>(delimiter: u8, act: impl FnOnce(&mut Reader) -> T) -> T {
    READERS.with_borrow_mut(|all| {
        let place = all.iter().position(|(known, _)| *known == delimiter).unwrap_or_else(|| {
            all.push((delimiter, ReaderBuilder::new().delimiter(delimiter).build()));
            all.len() - 1
        });
        let reader = &mut all[place].1;
        reader.reset();
        act(reader)
    })
}

/// A line without its end and the blanks around it; a tab before it ends a field that is blank. A semicolon ends it too where there is no
/// other, as a row of a matrix or a message.
pub fn trimmed(line: &str) -> &str {
    let line = behind_terminal(line.trim_matches(|c: char| c.is_whitespace() && c != '\t'));
    let line = without_checksum(line);
    line.strip_suffix(';').filter(|rest| !rest.contains(';')).map_or(line, str::trim_end)
}

/// A sentence as receivers of satellites write them, `$MOT,10,80,7*5A`, without its checksum.
fn without_checksum(line: &str) -> &str {
    if !line.starts_with('$') {
        return line;
    }
    match line.rsplit_once('*') {
        Some((sentence, sum)) if sum.len() == 2 && sum.bytes().all(|b| b.is_ascii_hexdigit()) => sentence,
        _ => line,
    }
}

/// What follows the terminal's number that J-Link's viewer puts before every line, `00> 10,80,7`.
pub(super) fn behind_terminal(line: &str) -> &str {
    match line.as_bytes() {
        [b'0'..=b'9', b'0'..=b'9', b'>'] => "",
        [b'0'..=b'9', b'0'..=b'9', b'>', b' ', ..] => line[4..].trim_start_matches(' '),
        _ => line,
    }
}

/// What is between the brackets or bars that a whole line stands in: `[1, 2]`, `[1, 2],`, `(1, 2)`, `<1,2>`, `| 1 | 2 |`.
fn unwrapped(line: &str) -> &str {
    let wrapped = [('[', ']'), ('(', ')'), ('<', '>'), ('|', '|')];
    // Rows of a list end with a comma.
    let bare = line.strip_suffix(',').map_or(line, str::trim_end);
    let inside = wrapped
        .into_iter()
        .find_map(|(open, close)| bare.strip_prefix(open)?.strip_suffix(close).map(|inside| (open, inside)));
    match inside {
        Some(('|', inside)) => inside,
        // `(ms),(V)` is none.
        Some((_, inside)) if !inside.contains(['[', ']', '(', ')']) => inside.trim_end_matches([',', ' ']),
        _ => line,
    }
}

/// Words between blanks; a word in quotes may hold some, and a date and the time behind it are one.
pub(super) fn split_blanks(line: &str, fields: &mut Vec<Range<usize>>) {
    let mut rest = 0;
    while let Some(begin) = line[rest..].find(|c: char| !c.is_whitespace()).map(|at| rest + at) {
        let quoted = line[begin..].starts_with('"');
        let first = if quoted { begin + 1 } else { begin };
        let ends = |c: char| if quoted { c == '"' } else { c.is_whitespace() };
        let end = line[first..].find(ends).map_or(line.len(), |at| first + at);
        rest = (end + usize::from(quoted)).min(line.len());
        let is_date = |field: &Range<usize>| clock::is_date(&line[field.clone()]);
        let is_time = line[first..end].contains(':');
        match fields.last_mut() {
            Some(before) if is_time && is_date(before) => before.end = end,
            _ => fields.push(first..end),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn fields(line: &str, delimiter: u8) -> Vec<String> {
        split(line, Separator::Byte(delimiter))
    }

    fn split(line: &str, separator: Separator) -> Vec<String> {
        let mut splitter = Splitter::of(separator, true);
        // An earlier, longer line must leave no trace.
        splitter.split("an,earlier;line,\"with\",many,fields");
        assert!(splitter.split(line));
        splitter.iter().map(str::to_owned).collect()
    }

    #[test]
    fn delimiters_quotes_spaces_and_line_ends_are_understood() {
        assert_eq!(fields("1, 2 ,3\r\n", b','), ["1", "2", "3"]);
        assert_eq!(fields("1;;\"a;b\"", b';'), ["1", "", "a;b"]);
        assert_eq!(fields("1,2,\n", b','), ["1", "2", ""]);
        assert_eq!(fields("\"say \"\"hi\"\"\"\tx", b'\t'), ["say \"hi\"", "x"]);
        assert_eq!(fields("\"0,01\",\"5,2\"", b','), ["0,01", "5,2"]);
        assert_eq!(fields("1", b','), ["1"]);
        assert_eq!(fields("<1,2,3>", b','), ["1", "2", "3"]);
        assert_eq!(fields("  [1, 2, 3],", b','), ["1", "2", "3"]);
        assert_eq!(fields("$MOT,10,80,7*5A", b','), ["$MOT", "10", "80", "7"]);
        assert_eq!(fields("1,2*5A", b','), ["1", "2*5A"]);
    }

    #[test]
    fn an_open_quote_is_noticed() {
        assert!(!Splitter::of(Separator::Byte(b','), false).split("1,\"2,3\n"));
    }

    #[test]
    fn blanks_decimal_commas_and_names_separate_too() {
        assert_eq!(split("  1.0 \t 2   \"a b\" ", Separator::Blanks), ["1.0", "2", "a b"]);
        assert_eq!(split("2024-05-01 12:30:00.5  2", Separator::Blanks), ["2024-05-01 12:30:00.5", "2"]);
        assert_eq!(split("0,01,5,2", Separator::DecimalCommas), ["0,01", "5,2"]);
        let names = || Separator::Names(vec!["t".into(), "pwm".into(), "motor enc".into()]);
        for (line, time) in [
            ("t:12 pwm:80 motor enc:-3", "12"),
            ("motor enc: -3, t = 12 ms, pwm: 80", "12 ms"),
            ("t:12\tpwm:80\tmotor enc:-3", "12"),
            ("t: 12 s pwm: 80 motor enc: -3", "12 s"),
            ("t: 12 pwm: 80 motor enc: -3 m: 7", "12"),
            ("t: 12 pwm: 80 motor enc: -3 (drive main.rs:42)", "12"),
            ("echo: t:12 pwm:80 motor enc:-3", "12"),
            ("00> t:12 pwm:80 motor enc:-3", "12"),
            ("[7] t: 12 pwm: 80 motor enc: -3", "12"),
            ("[INFO] [drive] left.motor: t=12 pwm=80, motor enc=-3", "12"),
            ("t:,12,pwm:,80,motor enc:,-3", "12"),
            ("t:,pwm:,80,motor enc:,-3", ""),
        ] {
            assert_eq!(split(line, names()), [time, "80", "-3"], "{line}");
        }
        assert_eq!(split("t:12", names()), ["12", "", ""]);
        assert_eq!(split("hello", names()), [""]);
        let names = || Separator::Names(vec!["t".into(), "pwm".into()]);
        assert_eq!(split("pwm 80, t 12", names()), ["12", "80"]);
        assert_eq!(split("pwm 80 t", names()), [""]);
        assert_eq!(split("motor: pwm 80 t 12", names()), ["12", "80"]);
        assert_eq!(split("pwm,80,t,12", names()), ["12", "80"]);
        assert_eq!(split("t; 12; pwm; -80", names()), ["12", "-80"]);
        assert_eq!(split("note,80", names()), [""]);
    }

    #[test]
    fn the_stamp_of_a_serial_monitor_is_no_field() {
        let mut splitter = Splitter::of(Separator::Byte(b','), true);
        assert!(splitter.split("12:34:56.789 -> 1,2"));
        assert_eq!((splitter.stamp(), splitter.len()), (Some("12:34:56.789"), 2));
        assert!(splitter.split("3,4"));
        assert_eq!((splitter.stamp(), splitter.get(0)), (None, Some("3")));
        for (line, stamp) in [
            ("[12:34:56.789] 1,2", "12:34:56.789"),
            ("I (1234) motor: 1,2", "1234"),
            ("\u{1b}[0;32mI (1234) motor: 1,2\u{1b}[0m", "1234"),
            ("[INFO] [1700000000.25] [motor]: 1,2", "1700000000.25"),
        ] {
            assert!(splitter.split(line));
            assert_eq!(
                (splitter.stamp(), splitter.get(0), splitter.get(1)),
                (Some(stamp), Some("1"), Some("2"))
            );
        }
    }
}
