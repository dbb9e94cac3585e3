//! The lines before the data: `# key: value` metadata, then the header.

use std::io::{BufRead, Read};
use std::path::Path;

use super::Metadata;
use super::fields::Splitter;
use super::text::cannot_read;
use crate::error::{BadInput, Result};

/// More columns than any log of a motor has; beyond this the file is something else.
const MOST_COLUMNS: usize = 1000;

/// What stands before the data.
#[derive(Debug)]
pub struct Preamble {
    /// The `# key: value` pairs.
    pub meta: Metadata,
    /// The column names, or `None` where the first row is data already.
    pub headers: Option<Vec<String>>,
    /// The first row, if it was data.
    pub first_row: Option<String>,
    /// What separates the fields.
    pub delimiter: u8,
    /// Line of the header, or of the last line read where there is none.
    pub line: u64,
    /// Lines of text left out before the header.
    pub skipped: usize,
}

/// Reads up to and including the header. `by_number` permits a file without one.
///
/// # Errors
/// Bad input if there is no header, a name occurs twice, or metadata that matters is malformed.
pub fn read(path: &Path, input: &mut impl BufRead, by_number: bool) -> Result<Preamble> {
    let mut meta = Metadata::default();
    let mut number = 0;
    let mut skipped = 0;
    loop {
        let mut line = String::new();
        let count =
            input.by_ref().take(1 << 20).read_line(&mut line).map_err(|error| cannot_read(path, &error))?;
        if count == 0 {
            return Err(BadInput::new(
                path,
                "there is no header line",
                "begin the file with the names of its columns, for example time_s,voltage_v,angle_rad",
            )
            .at_line(number.max(1))
            .into());
        }
        number += 1;
        let text = line.trim();
        if let Some(comment) = text.strip_prefix('#') {
            remember(path, &mut meta, comment, number)?;
        } else if text.len() == 5 && text.starts_with("sep=") {
            // A spreadsheet's own remark; the separator shows in the header too.
        } else if !text.trim_matches([',', ';', '\t']).is_empty() {
            let ahead = input.fill_buf().map_err(|error| cannot_read(path, &error))?;
            if skipped < MOST_CHATTER && header_at(text, ahead) > 0 {
                skipped += 1;
                continue;
            }
            let mut preamble = header(path, meta, text, number, by_number)?;
            preamble.skipped = skipped;
            return Ok(preamble);
        }
    }
}

/// Lines that may stand before a header: what a board prints as it starts, a logger's own words.
const MOST_CHATTER: usize = 60;

/// How many lines from `text` on stand before the header: the first line whose next two are rows of as many numbers,
/// where `text` itself is no such line; 0 where none is. `ahead` is what follows `text`.
fn header_at(text: &str, ahead: &[u8]) -> usize {
    let ahead = String::from_utf8_lossy(&ahead[..ahead.len().min(1 << 14)]);
    // The last line may be cut off by the end of the buffer.
    let whole: Vec<&str> = ahead.lines().map(str::trim).take(2 * MOST_CHATTER).collect();
    let lines: Vec<&str> =
        [text].into_iter().chain(whole).filter(|line| !line.is_empty() && !line.starts_with('#')).collect();
    let is_header = |k: usize| {
        let delimiter = delimiter_of(lines[k]);
        let fields = |line: &str| -> Vec<String> {
            let mut splitter = Splitter::new(delimiter);
            splitter.split(line.as_bytes());
            splitter.iter().map(str::to_owned).collect()
        };
        let number = |text: &String| text.replace(',', ".").parse::<f64>().is_ok();
        let names = fields(lines[k]);
        let row = |line: &str| {
            let values = fields(line);
            values.len() == names.len() && 2 * values.iter().filter(|v| number(v)).count() >= values.len()
        };
        names.len() >= 2 && !names.iter().any(number) && row(lines[k + 1]) && row(lines[k + 2])
    };
    let last = lines.len().saturating_sub(2).min(MOST_CHATTER);
    let numbers = |line: &str| line.split([',', ';', '\t']).all(|v| v.trim().parse::<f64>().is_ok());
    // A candidate below a row of numbers of as many columns is a bad row of the table above.
    let columns = |line: &str| -> (usize, bool) {
        let mut splitter = Splitter::new(delimiter_of(line));
        splitter.split(line.as_bytes());
        (splitter.iter().count(), splitter.iter().any(|v| v.replace(',', ".").parse::<f64>().is_ok()))
    };
    let below_rows = |k: usize| {
        let own = columns(lines[k]).0;
        lines[1..k.max(1)].iter().any(|line| columns(line) == (own, true))
    };
    match (0..last).find(|&k| is_header(k)) {
        Some(k) if !numbers(text) && !below_rows(k) => k,
        _ => 0,
    }
}

fn remember(path: &Path, meta: &mut Metadata, comment: &str, line: u64) -> Result<()> {
    if let Some((key, value)) = comment.split_once(':') {
        meta.insert(key.trim(), value.trim())
            .map_err(|why| BadInput::new(path, why, "correct or remove this line").at_line(line))?;
    }
    Ok(())
}

fn header(path: &Path, meta: Metadata, text: &str, line: u64, by_number: bool) -> Result<Preamble> {
    let delimiter = delimiter_of(text);
    let mut splitter = Splitter::new(delimiter);
    if !splitter.split(text.as_bytes()) {
        return Err(BadInput::new(
            path,
            "a quotation mark in the header is not closed",
            "close or remove it",
        )
        .at_line(line)
        .into());
    }
    let names: Vec<String> = splitter.iter().map(str::to_owned).collect();
    if names.len() > MOST_COLUMNS {
        return Err(BadInput::new(
            path,
            format!("{} columns are more than a log has", names.len()),
            "write one sample per line and one quantity per column",
        )
        .at_line(line)
        .into());
    }
    if names.iter().all(|name| name.replace(',', ".").parse::<f64>().is_ok()) {
        if by_number {
            return Ok(Preamble {
                meta,
                headers: None,
                first_row: Some(text.to_owned()),
                delimiter,
                line,
                skipped: 0,
            });
        }
        return Err(BadInput::new(
            path,
            "the first row holds numbers, so the columns have no names",
            "add a header line such as time_s,voltage_v,angle_rad, or give numbers: --map time=0:s,voltage=1:V,angle=2:rad",
        )
        .at_line(line)
        .into());
    }
    for (index, name) in names.iter().enumerate() {
        if !by_number && !name.is_empty() && names[..index].contains(name) {
            return Err(BadInput::new(
                path,
                format!("two columns are called \"{name}\""),
                "rename one of them, or pick by number: --map time=0:s,...",
            )
            .at_line(line)
            .in_column(name)
            .into());
        }
    }
    Ok(Preamble { meta, headers: Some(names), first_row: None, delimiter, line, skipped: 0 })
}

/// The separator that occurs most often outside quotes.
fn delimiter_of(header: &str) -> u8 {
    let count = |wanted: char| {
        let mut quoted = false;
        header
            .chars()
            .filter(|&c| {
                quoted ^= c == '"';
                !quoted && c == wanted
            })
            .count()
    };
    // A semicolon or tab wins over commas: those may then be decimal commas.
    [';', '\t'].into_iter().find(|&candidate| count(candidate) > 0).map_or(b',', |candidate| candidate as u8)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn preamble(text: &str) -> Result<Preamble> {
        read(Path::new("x.csv"), &mut text.as_bytes(), false)
    }

    #[test]
    fn metadata_comes_before_a_header_in_any_common_separator() {
        for header in
            ["time_s,voltage_v", "time_s; voltage_v", "time_s\tvoltage_v", "\"time_s\",\"voltage_v\""]
        {
            let text = format!("# a remark\n# gear_ratio: 104\n\n{header}\r\n1,2\r\n");
            let preamble = preamble(&text).unwrap();
            assert_eq!(preamble.headers.unwrap(), ["time_s", "voltage_v"], "{header}");
            assert_eq!(preamble.meta.gear_ratio(), Some(104.0));
            assert_eq!(preamble.line, 4);
        }
    }

    #[test]
    fn malformed_metadata_is_named_by_line() {
        let message = preamble("# a: b\n# gear_ratio: lots\nt,u\n").unwrap_err().to_string();
        assert!(message.starts_with("x.csv, line 2: gear_ratio \"lots\""), "{message}");
    }

    #[test]
    fn a_header_that_is_missing_or_double_is_refused() {
        for (text, place, cause) in [
            ("# only: remarks\n", "line 1", "no header line"),
            ("0.0,1.0\n0.1,1.0\n", "line 1", "no names"),
            ("t,u,t\n", "line 1, column t", "two columns"),
        ] {
            let message = preamble(text).unwrap_err().to_string();
            assert!(message.contains(place) && message.contains(cause), "{message}");
        }
    }
}
