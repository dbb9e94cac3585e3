//! The line protocol: runs of a motor as lines of text, from any board (docs/LINE_PROTOCOL.md).
//!
//! ```text
//! # programme: steps
//! # duty_full: 255
//! t_us,duty,count,supply_mv
//! 0,0,0,11980
//! 4000,64,0,11975
//! # end: finished
//! ```

use std::collections::BTreeMap;

/// The header line: after it come samples.
pub const HEADER: &str = "t_us,duty,count,supply_mv";
/// The longest line. A longer one is damaged, or no line of this protocol.
const LONGEST: usize = 120;
/// The duty of full voltage where a board does not say it: that of Arduino's `analogWrite`.
const DUTY_FULL: f64 = 255.0;

/// One line of a board.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// The samples of a run begin.
    Header,
    /// Something that the board says of the run.
    Pair(String, String),
    /// One sample.
    Row(Row),
}

/// A sampling instant as the board prints it, with times and counts that wrap at 32 bits.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Row {
    /// Microseconds.
    pub t_us: u32,
    /// Duty that is applied from here to the next sample, sign included.
    pub duty: i32,
    /// Encoder counts, every edge.
    pub count: i32,
    /// Supply of the driver, mV; 0 where it is not measured.
    pub supply_mv: u32,
}

/// Takes bytes, gives lines.
#[derive(Debug, Default)]
pub struct Reader {
    line: Vec<u8>,
    too_long: bool,
}

impl Reader {
    /// Takes a byte. A complete line is returned, with the reason where it is not one of the protocol; empty lines
    /// mean nothing.
    pub fn push(&mut self, byte: u8) -> Option<Result<Line, String>> {
        if byte != b'\n' {
            self.too_long |= self.line.len() >= LONGEST;
            if !self.too_long {
                self.line.push(byte);
            }
            return None;
        }
        let line = std::mem::take(&mut self.line);
        if std::mem::take(&mut self.too_long) {
            return Some(Err(format!("a line has more than {LONGEST} characters")));
        }
        let Ok(text) = std::str::from_utf8(&line) else {
            return Some(Err("a line is not text".to_owned()));
        };
        let text = text.trim();
        (!text.is_empty()).then(|| parse(text))
    }
}

fn parse(line: &str) -> Result<Line, String> {
    let text = checked(line)?;
    if let Some(pair) = text.strip_prefix('#') {
        let (key, value) = pair.split_once(':').ok_or_else(|| format!("\"{line}\" has no colon"))?;
        return Ok(Line::Pair(key.trim().to_owned(), value.trim().to_owned()));
    }
    if text.replace(' ', "") == HEADER {
        return Ok(Line::Header);
    }
    row(text).map(Line::Row).ok_or_else(|| format!("\"{line}\" is not {HEADER}"))
}

/// The line without its check, `*` and two hexadecimal digits, where it has one.
fn checked(line: &str) -> Result<&str, String> {
    let Some((text, check)) = line.rsplit_once('*') else { return Ok(line) };
    let sum = text.bytes().fold(0, |sum, byte| sum ^ byte);
    if u8::from_str_radix(check, 16) == Ok(sum) {
        Ok(text)
    } else {
        Err(format!("\"{line}\" does not match its check, which would be {sum:02X}"))
    }
}

fn row(text: &str) -> Option<Row> {
    let mut fields = text.split(',').map(str::trim);
    let row = Row {
        t_us: fields.next()?.parse().ok()?,
        duty: fields.next()?.parse().ok()?,
        count: fields.next()?.parse().ok()?,
        supply_mv: fields.next()?.parse().ok()?,
    };
    fields.next().is_none().then_some(row)
}

/// A run: what the board said of it, and its samples with times and counts that no longer wrap.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Run {
    /// What the board said, by key.
    pub pairs: BTreeMap<String, String>,
    /// Microseconds since the first sample.
    pub time_us: Vec<u64>,
    /// Duties.
    pub duty: Vec<i32>,
    /// Counts since the board began to count.
    pub count: Vec<i64>,
    /// Supplies, mV; 0 where not measured.
    pub supply_mv: Vec<u32>,
    last: Option<Row>,
}

impl Run {
    /// A run of which the board has said this, before its first sample.
    pub fn new(pairs: BTreeMap<String, String>) -> Self {
        Self { pairs, ..Self::default() }
    }

    /// Takes the next sample.
    ///
    /// # Errors
    /// A sample that no sound board sends: out of order, or moved by more than the counter can tell.
    pub fn push(&mut self, row: Row) -> Result<(), String> {
        let (step_us, moved) = match self.last {
            None => (0, i64::from(row.count)),
            Some(last) => (row.t_us.wrapping_sub(last.t_us), i64::from(row.count.wrapping_sub(last.count))),
        };
        if self.last.is_some() && (step_us == 0 || step_us > u32::MAX / 2) {
            return Err(format!("time {} us does not come after the sample before it", row.t_us));
        }
        self.time_us.push(self.time_us.last().map_or(0, |time| time + u64::from(step_us)));
        self.count.push(self.count.last().unwrap_or(&0) + moved);
        self.duty.push(row.duty);
        self.supply_mv.push(row.supply_mv);
        self.last = Some(row);
        Ok(())
    }

    /// Samples so far.
    pub fn len(&self) -> usize {
        self.time_us.len()
    }

    /// Whether no sample has come.
    pub fn is_empty(&self) -> bool {
        self.time_us.is_empty()
    }

    /// What the board said under `key`, as a number.
    pub fn number(&self, key: &str) -> Option<f64> {
        self.pairs.get(key)?.parse().ok().filter(|number: &f64| number.is_finite())
    }

    /// The duty of full voltage.
    pub fn duty_full(&self) -> f64 {
        self.number("duty_full").filter(|full| *full > 0.0).unwrap_or(DUTY_FULL)
    }

    /// Whether the board measures its driver's supply.
    pub fn measures_supply(&self) -> bool {
        self.supply_mv.iter().all(|supply| *supply > 0)
    }

    /// The driver's supply at each sample, V; `stated_v` where the board measures none.
    pub fn supply_v(&self, stated_v: f64) -> Vec<f64> {
        let measured = self.measures_supply();
        let volts = |supply: &u32| if measured { f64::from(*supply) * 1e-3 } else { stated_v };
        self.supply_mv.iter().map(volts).collect()
    }

    /// What is applied from each sample on, V.
    pub fn voltage_v(&self, stated_v: f64) -> Vec<f64> {
        let full = self.duty_full();
        let volts = |(duty, supply): (&i32, f64)| f64::from(*duty) / full * supply;
        self.duty.iter().zip(self.supply_v(stated_v)).map(volts).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn lines(text: &str) -> Vec<Result<Line, String>> {
        let mut reader = Reader::default();
        text.bytes().filter_map(|byte| reader.push(byte)).collect()
    }

    #[test]
    fn a_row_is_four_whole_numbers_and_its_check_is_verified_where_it_has_one() {
        let row = Row { t_us: 4000, duty: -64, count: -3, supply_mv: 0 };
        let sum = "4000,-64,-3,0".bytes().fold(0, |sum, byte| sum ^ byte);
        assert_eq!(lines("4000,-64,-3,0\r\n"), [Ok(Line::Row(row))]);
        assert_eq!(lines(&format!("4000,-64,-3,0*{sum:02X}\n")), [Ok(Line::Row(row))]);
        for wrong in ["4000,-64,-3\n", "4000,-64,-3,0,1\n", "4000,-6.4,-3,0\n", "x\n", "# no colon\n"] {
            assert!(lines(wrong)[0].is_err(), "{wrong}");
        }
        let damaged = lines(&format!("4000,-65,-3,0*{sum:02X}\n")).remove(0).unwrap_err();
        assert!(damaged.contains("check"), "{damaged}");
    }

    #[test]
    fn header_pairs_and_empty_lines_are_told_apart() {
        let text = "\n# end: link loss\nt_us, duty, count, supply_mv\n";
        assert_eq!(lines(text), [Ok(Line::Pair("end".into(), "link loss".into())), Ok(Line::Header)]);
        assert!(lines(&format!("{}\n", "7".repeat(500)))[0].is_err());
    }

    #[test]
    fn clock_and_counter_may_wrap_but_time_may_not_go_back() {
        let mut run = Run::default();
        let row = |t_us, count| Row { t_us, duty: 1, count, supply_mv: 0 };
        run.push(row(u32::MAX - 999, i32::MAX)).unwrap();
        run.push(row(1000, i32::MIN)).unwrap();
        assert_eq!((run.time_us[1], run.count[1]), (2000, i64::from(i32::MAX) + 1));
        assert!(run.push(row(1000, 0)).is_err() && run.push(row(900, 0)).is_err());
        assert_eq!(run.len(), 2);
    }

    proptest! {
        #[test]
        fn any_bytes_are_survived(bytes: Vec<u8>) {
            let (mut reader, mut run) = (Reader::default(), Run::default());
            for byte in bytes {
                if let Some(Ok(Line::Row(row))) = reader.push(byte) {
                    let _ = run.push(row);
                }
            }
        }
    }
}
