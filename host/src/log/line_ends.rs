//! Rows of which a quoted field holds line ends: Python's csv quotes a line of a serial port that was not stripped, `1,"0\n"`, and Excel a header
//! of two lines.

use std::io::{self, BufRead};

/// Appends the next row to `row` and tells the number of its lines, 0 at the end of the input. A line end within a quoted field becomes a
/// blank. A quotation mark that the next line does not close at the end of a field is left as it is: that line is a row of its own. The
/// `input` hands out whole lines, as a [`TextReader`](super::text::TextReader) does.
///
/// # Errors
/// What the input says.
pub(super) fn read_row(input: &mut impl BufRead, row: &mut String) -> io::Result<u64> {
    let begin = row.len();
    if input.read_line(row)? == 0 {
        return Ok(0);
    }
    let mut lines = 1;
    while is_open(&row.as_bytes()[begin..]) && closes(input.fill_buf()?) {
        row.truncate(row.trim_end_matches(['\r', '\n']).len());
        row.push(' ');
        input.read_line(row)?;
        lines += 1;
    }
    Ok(lines)
}

/// Whether a quoted field begins in a line and does not end there.
fn is_open(line: &[u8]) -> bool {
    let (mut open, mut before) = (false, None);
    for at in memchr::memchr_iter(b'"', line) {
        // Two marks in succession within a field are one of its text.
        let begins = at == 0 || separates(line[at - 1]) || before == Some(at - 1);
        open = !open && begins;
        before = Some(at);
    }
    open
}

/// Whether the first quotation mark of the line that `rest` begins with ends a field.
fn closes(rest: &[u8]) -> bool {
    let line = &rest[..memchr::memchr(b'\n', rest).unwrap_or(rest.len())];
    let mut at = 0;
    while let Some(mark) = memchr::memchr(b'"', &line[at..]).map(|further| at + further) {
        match line.get(mark + 1) {
            Some(b'"') => at = mark + 2,
            behind => return behind.is_none_or(|byte| separates(*byte) || *byte == b'\r'),
        }
    }
    false
}

/// Whether a byte stands between fields.
fn separates(byte: u8) -> bool {
    [b',', b';', b'\t', b'|'].contains(&byte)
}

#[cfg(test)]
mod tests {
    use super::super::read_tests::{canonical, file};
    use super::super::text::TextReader;
    use super::super::{ReadOptions, read};
    use super::*;

    /// The rows of a text, each with the number of its lines.
    fn rows(mut text: impl BufRead) -> Vec<(u64, String)> {
        let mut rows = Vec::new();
        loop {
            let mut row = String::new();
            match read_row(&mut text, &mut row).unwrap() {
                0 => return rows,
                lines => rows.push((lines, row.trim_end().to_owned())),
            }
        }
    }

    #[test]
    fn a_quoted_field_goes_on_over_line_ends() {
        let of = |text: &str| rows(text.as_bytes());
        let row = |lines: u64, text: &str| (lines, text.to_owned());
        assert_eq!(of("1,\"0\n\"\n2,\"3\r\n\"\r\n"), [row(2, "1,\"0 \""), row(2, "2,\"3 \"")]);
        assert_eq!(
            of("\"Time\n(s)\",\"Speed\n(rpm)\"\n1,2\n"),
            [row(3, "\"Time (s)\",\"Speed (rpm)\""), row(1, "1,2")]
        );
        assert_eq!(of("1,\"a \"\"b\nc\"\"\",2\n"), [row(2, "1,\"a \"\"b c\"\"\",2")]);
    }

    #[test]
    fn a_field_goes_on_wherever_the_file_is_parted_to_read_it() {
        for parted in 0..16 {
            let before = "7".repeat((1 << 16) - parted);
            let text = format!("{before}\n1,\"0\r\n\"\n2,3\n");
            let rows = rows(TextReader::new(text.as_bytes()).unwrap());
            assert_eq!(rows[1..], [(2, "1,\"0 \"".to_owned()), (1, "2,3".to_owned())], "{parted}");
        }
    }

    #[test]
    fn a_mark_that_nothing_closes_swallows_no_row() {
        for text in ["1,\"2,3\n4,5,6", "1,\"2,3\n4,\"5\",6", "12\",3\n\",4", "\"\",1\n\",2"] {
            assert_eq!(rows(text.as_bytes()).len(), 2, "{text}");
        }
    }

    #[test]
    fn a_log_whose_last_field_has_a_line_end_reads_as_without() {
        let plain = canonical(50, |_| None);
        let quoted: String = plain
            .lines()
            .enumerate()
            .map(|(row, line)| match line.rsplit_once(',') {
                Some((before, last)) if row > 0 => format!("{before},\"{last}\n\"\n"),
                _ => format!("{line}\n"),
            })
            .collect();
        let records = [plain, quoted].map(|text| {
            let (_directory, path) = file(text.as_bytes());
            read(&path, &ReadOptions::default()).unwrap().remove(0)
        });
        assert_eq!(records[0].time_s, records[1].time_s);
        assert_eq!(records[0].angle_rad, records[1].angle_rad);
        assert_eq!(records[0].warnings.len(), records[1].warnings.len());
    }
}
