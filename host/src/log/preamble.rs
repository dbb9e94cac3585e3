//! The lines before the data: `# key: value` metadata, what a board or a logger says first, the header.

use std::io::BufRead;
use std::path::Path;

use super::fields::{Separator, Splitter, behind_terminal, trimmed};
use super::hexadecimal::Hexadecimal;
use super::layout::Layout;
use super::line_ends::read_row;
use super::numbers::Thousands;
use super::text::cannot_read;
use super::{Metadata, beside, header, properties, rates, sample};
use crate::error::{BadInput, Result};

/// More columns than any log of a motor has; beyond this the file is something else.
const MOST_COLUMNS: usize = 1000;
/// Lines, and bytes of them, from which the layout is told.
const LOOKED_AT_LINES: usize = 200;
const LOOKED_AT_BYTES: usize = 1 << 16;

/// How SimpleFOC's messages begin, which stand before the lines of its monitor.
const SIMPLEFOC: &str = "MOT: ";

/// Why columns are not understood that have no header.
pub(super) const NAMELESS: &str = "the first row holds numbers, so the columns have no names";

/// What stands before the data, and how the data are written.
#[derive(Debug)]
pub struct Preamble {
    /// The `# key: value` pairs.
    pub meta: Metadata,
    /// The column names, or `None` where the first row is data already.
    pub headers: Option<Vec<String>>,
    /// The units of a row below the header, or beside the numbers, by column; empty where there is none.
    pub units: Vec<String>,
    /// Those beside the numbers alone.
    beside: Vec<String>,
    /// Columns of hexadecimal numbers without a mark.
    hex: Vec<usize>,
    /// What separates the fields.
    pub separator: Separator,
    /// A serial monitor put a time and an arrow before the lines.
    pub stamped: bool,
    /// What stands before the fields of every line.
    tag: String,
    /// The first column of the table.
    first: usize,
    /// Line of the header, or of the first row where there is none.
    pub line: u64,
    /// Lines of text left out before the header.
    pub skipped: usize,
    /// What stands between the thousands of all columns, where the first rows tell.
    pub thousands: Option<char>,
    /// Rows per second, as they tell.
    pub rate: Option<f64>,
    /// The lines after the header that were read to tell the layout, with their numbers.
    pub rows: Vec<(u64, String)>,
    /// Number of lines read.
    pub read: u64,
}

impl Preamble {
    /// A splitter for the rows.
    pub fn splitter(&self) -> Splitter {
        Splitter::of(self.separator.clone(), self.stamped)
            .without_tag(self.tag.clone())
            .begun_at(self.first)
            .without_units(self.beside.clone())
            .with_hex(self.hex.clone())
    }
}

/// Reads up to the header, and some rows to tell how the table is written. `by_number` permits a file without a header.
///
/// # Errors
/// Bad input if there is no header, or metadata that matters is malformed.
pub fn read(path: &Path, input: &mut impl BufRead, by_number: bool) -> Result<Preamble> {
    let mut lines: Vec<(u64, String)> = Vec::new();
    let mut meta = Metadata::default();
    let mut remarks: Vec<(u64, String)> = Vec::new();
    let mut rate_told = None;
    let (mut number, mut told, mut bytes) = (0, 0, 0);
    while told < LOOKED_AT_LINES && bytes < LOOKED_AT_BYTES {
        let mut line = String::new();
        let lines_of_row = read_row(input, &mut line).map_err(|error| cannot_read(path, &error))?;
        if lines_of_row == 0 {
            break;
        }
        let at = number + 1;
        number += lines_of_row;
        let text = line.trim();
        if let Some(comment) = remark_in(text).or_else(|| remark_of_semicolon(text).filter(|_| told == 0)) {
            if told == 0 {
                if text.starts_with('#') {
                    remember(path, &mut meta, comment, at)?;
                }
                if !is_nothing(comment) {
                    remarks.push((at, comment.trim().to_owned()));
                    // That of the names and that of the units may be the last two.
                    remarks.drain(..remarks.len().saturating_sub(2));
                }
                rate_told = rate_told.or_else(|| rates::told(comment));
            }
        } else if !is_nothing(text) {
            (told, bytes) = (told + 1, bytes + line.len());
            lines.push((at, line));
        }
    }
    if lines.is_empty() {
        return Err(BadInput::new(
            path,
            "there is no header line",
            "begin the file with the names of its columns, for example time_s,voltage_v,angle_rad",
        )
        .at_line(number.max(1))
        .into());
    }
    let texts: Vec<&str> = lines.iter().map(|(_, line)| trimmed(line)).collect();
    let mut layout = Layout::of(&texts);
    let mut line = lines[layout.header.unwrap_or(layout.rows.min(lines.len() - 1))].0;
    if layout.header.is_none() && layout.names.is_empty() {
        if let Some((at, behind)) = behind_remarks(&remarks, &texts) {
            line = at;
            layout = behind;
        } else if !by_number
            && texts[..layout.rows.min(texts.len())].iter().any(|line| line.starts_with(SIMPLEFOC))
        {
            let remedy = "these are the lines of SimpleFOC's monitor(), in the order of its monitor_variables; as it begins with (target, voltage q, \
                 velocity, angle) that is --map voltage=1:V,speed=2:rad/s,angle=3:rad --rate 100 (put your lines per second in the place of \
                 100), or print micros() before them and count from 1";
            return Err(BadInput::new(path, NAMELESS, remedy).at_line(line).into());
        }
    }
    check(path, &layout, &texts, line)?;
    let skipped = layout.header.unwrap_or(layout.rows.min(lines.len()));
    let skipped = if line < lines[0].0 { 0 } else { skipped };
    let before = &texts[..skipped.min(texts.len())];
    let rate = before.iter().find_map(|text| rates::before(text).or_else(|| rates::told(text))).or(rate_told);
    if layout.units.is_empty() {
        layout.units = properties::of_labview(before, &layout.names);
    }
    let below = texts.get(layout.header.map_or(usize::MAX, |header| header + 1)).copied().unwrap_or_default();
    let rigol = rates::rigol(&layout.names, below);
    let rate = rate.or(rigol.map(|(rate, ..)| rate));
    if let Some((_, columns, is_no_row)) = rigol {
        layout.names.truncate(columns);
        layout.units.truncate(columns);
        layout.rows = layout.header.unwrap_or(0) + 1 + usize::from(is_no_row);
    }
    let rows = lines.split_off(layout.rows.min(lines.len()));
    let mut splitter = Splitter::of(layout.separator.clone(), layout.stamped)
        .without_tag(layout.tag.clone())
        .begun_at(layout.first);
    let (mut beside, mut hex) = (beside::Units::default(), Hexadecimal::default());
    let (mut widest, mut thousands) = (0, Thousands::default());
    for (_, row) in &rows {
        splitter.split(row);
        widest = widest.max(splitter.len());
        beside.see(&splitter);
        thousands.see(splitter.iter());
        hex.see(&splitter);
    }
    let (beside, hex) = (beside.of_columns(), hex.columns());
    let mut units = layout.units;
    units.resize(units.len().max(beside.len()), String::new());
    for (unit, beside) in units.iter_mut().zip(&beside).filter(|(unit, _)| unit.is_empty()) {
        unit.clone_from(beside);
    }
    let named = layout.names.len();
    let is_short = layout.header.is_some() && rows.len() >= 2 && (2..named).contains(&widest);
    let is_short = is_short && !layout.names[widest..].iter().all(|name| is_remark(name));
    if is_short {
        // By their numbers the columns are known all the same.
        layout.names.clear();
        units.clear();
    }
    let head = Preamble {
        meta,
        headers: (!layout.names.is_empty()).then_some(layout.names),
        units,
        beside,
        hex,
        separator: layout.separator,
        stamped: layout.stamped,
        tag: layout.tag,
        first: layout.first,
        line,
        skipped,
        thousands: thousands.sign(),
        rate,
        rows,
        read: number,
    };
    if head.headers.is_none() && !by_number {
        let wrong = is_short.then(|| {
            format!("the header has {named} names, the rows have {widest} fields, and nothing tells which names have no column")
        });
        return Err(sample::nameless(path, input, &head, wrong)?.into());
    }
    Ok(head)
}

/// The layout of rows below a header that is the last of the `remarks`, as NumPy writes it, or the last but one where that of the units follows
/// it; and the line of that header.
fn behind_remarks(remarks: &[(u64, String)], texts: &[&str]) -> Option<(u64, Layout)> {
    let below = |count: usize| {
        let told = &remarks[remarks.len().checked_sub(count)?..];
        let (at, _) = told.first()?;
        let all: Vec<&str> =
            told.iter().map(|(_, text)| text.as_str()).chain(texts.iter().copied()).collect();
        let layout = Layout::of(&all);
        let is_whole = layout.header == Some(0) && (count == 1 || !layout.units.is_empty());
        is_whole.then(|| (*at, Layout { rows: layout.rows.saturating_sub(count), ..layout }))
    };
    let are_units = remarks.last().is_some_and(|(_, text)| header::is_of_units(text));
    are_units.then(|| below(2)).flatten().or_else(|| below(1))
}

/// Whether a column is called one of remarks, which rows may leave out.
fn is_remark(name: &str) -> bool {
    const REMARKS: [&str; 10] =
        ["", "comment", "comments", "note", "notes", "remark", "remarks", "message", "event", "bemerkung"];
    REMARKS.contains(&name.to_lowercase().as_str())
}

/// What a line says that is a remark: behind `#`, MATLAB's `%` or `//`.
pub fn remark_in(text: &str) -> Option<&str> {
    ["#", "%", "//"].into_iter().find_map(|mark| text.strip_prefix(mark))
}

/// What a line says that is a remark behind a semicolon, which may also stand before the fields of a row.
fn remark_of_semicolon(text: &str) -> Option<&str> {
    let remark = text.strip_prefix("; ")?;
    (!remark.contains(';') && remark.contains(char::is_alphabetic)).then_some(remark)
}

/// Blank lines, rows of nothing but separators, the banner of a terminal, and a spreadsheet's remark on its own separator.
pub fn is_nothing(text: &str) -> bool {
    let text = behind_terminal(text);
    let remark = text.trim_matches('"');
    let separator =
        remark.len() <= 5 && remark.get(..4).is_some_and(|start| start.eq_ignore_ascii_case("sep="));
    // PuTTY begins every session so, and MicroPython every line that somebody types.
    separator
        || text.starts_with("=~=~=~")
        || text.starts_with(">>>")
        || text.trim_matches([',', ';', '\t', '|', '-', '+', ':', '=', '_', ' ']).is_empty()
}

fn remember(path: &Path, meta: &mut Metadata, comment: &str, line: u64) -> Result<()> {
    if let Some((key, value)) = comment.split_once(':') {
        meta.insert(key.trim(), value.trim())
            .map_err(|why| BadInput::new(path, why, "correct or remove this line").at_line(line))?;
    }
    Ok(())
}

/// Refuses what is no table of samples, or one whose numbers cannot be told apart.
fn check(path: &Path, layout: &Layout, lines: &[&str], line: u64) -> Result<()> {
    let refuse = |why: String, remedy: &str| Err(BadInput::new(path, why, remedy).at_line(line).into());
    let names = &layout.names;
    if layout.header.is_some_and(|k| lines.get(k).is_some_and(|line| line.matches('"').count() % 2 == 1)) {
        return refuse("a quotation mark in the header is not closed".into(), "close or remove it");
    }
    if names.len() > MOST_COLUMNS {
        return refuse(
            format!("{} columns are more than a log has", names.len()),
            "write one sample per line and one quantity per column",
        );
    }
    // Commas between the columns and within the numbers, and some numbers without a comma.
    if layout.separator != Separator::Byte(b',') || layout.header.is_none() {
        return Ok(());
    }
    let rows: Vec<Vec<&str>> = lines.iter().skip(layout.rows).map(|line| line.split(',').collect()).collect();
    let whole = |field: &&str| {
        let digits = field.trim().trim_start_matches(['-', '+']);
        !digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())
    };
    let wide =
        |row: &&Vec<&str>| row.len() > names.len() && row.len() <= 2 * names.len() && row.iter().all(whole);
    let wide: Vec<_> = rows.iter().filter(wide).collect();
    if rows.len() >= 2 && 2 * wide.len() > rows.len() {
        return refuse(
            format!(
                "the rows have up to {} fields under {} names: commas separate the columns and are decimal commas too, and in \"{}\" nothing \
                 tells which is which, because some numbers have no decimals",
                wide.iter().map(|row| row.len()).max().unwrap_or(0),
                names.len(),
                wide[0].join(",")
            ),
            "write the log with semicolons between the columns (0,01;5,2), with decimal points (0.01,5.2), or with decimals in every \
             number (0,01,5,20), which can be told apart",
        );
    }
    Ok(())
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
            let between = ["; ", "\t"].iter().find(|between| header.contains(*between)).unwrap_or(&",");
            let text = format!("# a remark\n# gear_ratio: 104\n\n{header}\r\n1{between}2\r\n");
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
        // The words of a logger, which no mapping asked for.
        assert_eq!(preamble("# supply_volts: 12 V\nt,u\n1,2\n").unwrap().meta.supply_volts(), Some(12.0));
    }

    #[test]
    fn a_header_that_is_missing_is_refused() {
        for (text, place, cause) in
            [("# only: remarks\n", "line 1", "no header line"), ("0.0,1.0\n0.1,1.0\n", "line 1", "no names")]
        {
            let message = preamble(text).unwrap_err().to_string();
            assert!(message.contains(place) && message.contains(cause), "{message}");
        }
    }

    #[test]
    fn the_remarks_of_spreadsheets_and_numpy_are_understood() {
        for (text, line) in [
            ("sep=;\r\nt;u\r\n1;2\r\n3;4\r\n", 2),
            ("\"sep=;\"\nt;u\n1;2\n3;4\n", 2),
            ("sep=\t\nt\tu\n1\t2\n3\t4\n", 2),
            ("# t u\n1e0 2e0\n3e0 4e0\n", 1),
            (
                "\u{feff}# by hand\n// motor: M1, 20:1\n; of May\n%\n% t,u\n1,2\n3,4\n"
                    .trim_start_matches('\u{feff}'),
                5,
            ),
        ] {
            let preamble = preamble(text).unwrap();
            assert_eq!(preamble.headers.unwrap(), ["t", "u"], "{text}");
            assert_eq!((preamble.line, preamble.skipped, preamble.rows.len()), (line, 0, 2), "{text}");
        }
    }

    #[test]
    fn a_remark_of_units_below_the_one_of_the_names_is_no_header() {
        for (units, told) in [
            ("%[#],[V],[rad],[rad/s]", ["#", "V", "rad", "rad/s"]),
            ("%[-],[V],[rad],[rad/s]", ["-", "V", "rad", "rad/s"]),
            ("% s, V, rad, rpm", ["s", "V", "rad", "rpm"]),
        ] {
            let text =
                format!("%Operator:\n%ticks,voltage,position,velocity\n{units}\n1,0,2,3\n2,0,3,4\n3,1,4,5\n");
            let preamble = preamble(&text).unwrap();
            assert_eq!(preamble.headers.unwrap(), ["ticks", "voltage", "position", "velocity"], "{units}");
            assert_eq!(preamble.units, told);
            assert_eq!((preamble.line, preamble.skipped, preamble.rows.len()), (2, 0, 3), "{units}");
        }
        // Names may look like units, and what stands above them is another remark.
        let names = preamble("# measured by me\n# t V w\n1 2 3\n4 5 6\n").unwrap();
        assert_eq!((names.headers.unwrap(), names.line), (["t", "V", "w"].map(str::to_owned).to_vec(), 2));
    }

    #[test]
    fn decimal_commas_between_commas_are_told_apart_or_refused_precisely() {
        let told = preamble("t,u,w\n0,00,5,40,0,10\n0,01,5,40,0,20\n").unwrap();
        assert_eq!(told.separator, Separator::DecimalCommas);
        let message = preamble("t,u,w\n0,01,5,2,1\n0,02,5,2\n0,03,5,2,2\n").unwrap_err().to_string();
        for words in ["line 1", "up to 5 fields under 3 names", "decimal commas", "semicolons"] {
            assert!(message.contains(words), "{message}");
        }
    }
}
