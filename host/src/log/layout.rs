//! How a table is written, told from its first lines: what separates the fields, where the header stands, whether a row of units follows
//! it, whether a serial monitor stamped the lines, whether each value has its name beside it.

use super::beside;
use super::clock;
use super::fields::{Separator, Splitter};
use super::header::{channels_of, names_of, units_of};
use super::headless::plain;
use super::heads::{scope, tag_of};
use super::numbers::number;
use super::pairs::pairs;
use super::properties;
use super::stamped::stamped;
use super::tektronix;

/// Lines that may stand before a header: what a board prints as it starts, a logger's own words.
pub(super) const MOST_CHATTER: usize = 60;
/// What stands between LabVIEW's remarks and its table.
const LABVIEW_END: &str = "***End_of_Header***";
/// Lines below a header that tell it from other words above numbers, and the share of them that are rows.
const GO_ON: usize = 12;
const NEARLY_ALL: f64 = 0.9;
/// A layout of single lines is one where this share of the lines has it.
pub(super) const MOST: f64 = 0.6;

/// How a table is written.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Layout {
    /// What separates the fields of a row.
    pub separator: Separator,
    /// A serial monitor put a time and an arrow before the lines.
    pub stamped: bool,
    /// A word and a colon before the fields of every line: `DATA: 1,2,3`; empty where there is none.
    pub tag: String,
    /// The line (of those looked at) that holds the names of the columns.
    pub header: Option<usize>,
    /// The first column of the table; what stands before it tells something of the whole.
    pub first: usize,
    /// The names; empty where there is no header.
    pub names: Vec<String>,
    /// The units of a row below the header; empty where there is none.
    pub units: Vec<String>,
    /// The line (of those looked at) from which on rows are sought.
    pub rows: usize,
}

impl Layout {
    /// The layout of a table that begins with `lines`, none of which is blank or a remark.
    pub fn of(lines: &[&str]) -> Layout {
        let special = tektronix::layout(lines).or_else(|| properties::below_names(lines, Layout::of_rows));
        special.unwrap_or_else(|| Layout::of_rows(lines))
    }

    /// The same where no line tells a property of its columns.
    fn of_rows(lines: &[&str]) -> Layout {
        let share = |count: usize| count as f64 >= MOST * lines.len() as f64;
        let is_stamped = share(lines.iter().filter(|line| stamped(line).is_some()).count());
        let bare: Vec<&str> = lines
            .iter()
            .map(|line| if is_stamped { stamped(line).map_or(*line, |(_, rest)| rest) } else { line })
            .collect();
        let mut tag = String::new();
        let layout = named_values(&bare).unwrap_or_else(|| {
            tag = tag_of(&bare).unwrap_or_default();
            let untagged: Vec<&str> = bare
                .iter()
                .map(|line| line.strip_prefix(tag.as_str()).map_or(*line, str::trim_start))
                .collect();
            let lines = if tag.is_empty() { &bare } else { &untagged };
            scope(lines).or_else(|| below_a_header(lines)).unwrap_or_else(|| plain(lines))
        });
        Layout { stamped: is_stamped, tag, ..layout }
    }
}

pub(super) fn new(separator: Separator) -> Layout {
    Layout {
        separator,
        stamped: false,
        tag: String::new(),
        header: None,
        first: 0,
        names: Vec::new(),
        units: Vec::new(),
        rows: 0,
    }
}

/// `t:12 pwm:80 enc:100`: at least two names with numbers in most lines.
fn named_values(lines: &[&str]) -> Option<Layout> {
    let with_names: Vec<(usize, Vec<String>)> = lines
        .iter()
        .enumerate()
        .filter_map(|(number, line)| {
            let pairs = pairs(line);
            let numbers = pairs.iter().filter(|(_, value)| is_number(&line[value.clone()])).count();
            let names = pairs.iter().map(|(name, _)| line[name.clone()].to_owned()).collect();
            (pairs.len() >= 2 && numbers == pairs.len()).then_some((number, names))
        })
        .collect();
    if with_names.len() < 2 || (with_names.len() as f64) < MOST * lines.len() as f64 {
        return None;
    }
    let rows = with_names.first()?.0;
    if is_table_of_words(lines, rows, &with_names) {
        return None;
    }
    // Half a first line has fewer names.
    let (_, names) = with_names.iter().take(5).max_by_key(|(_, names)| names.len())?;
    Some(Layout { names: names.clone(), rows, ..new(Separator::Names(names.clone())) })
}

/// Whether words between separators are values, as in `FWD,120,ON,7`: below a header, or others in other rows.
fn is_table_of_words(lines: &[&str], rows: usize, with_names: &[(usize, Vec<String>)]) -> bool {
    let first = lines[rows];
    let Some(separator) = [';', '\t', ','].into_iter().find(|separator| first.contains(*separator)) else {
        return false;
    };
    if first.contains([':', '=']) || first.split(separator).any(|field| field.trim().contains(' ')) {
        return false;
    }
    let width = |line: &str| line.split(separator).count();
    let is_below = rows > 0 && width(lines[rows - 1]) == width(first);
    let last = with_names.last().map(|(_, names)| names);
    let alike = with_names.iter().filter(|(_, names)| Some(names) == last).count();
    is_below || (alike as f64) < MOST * with_names.len() as f64
}

/// The first line whose next two are rows of as many numbers, and rather one that many more rows follow: what an oscilloscope tells of
/// its channels looks like a few.
fn below_a_header(lines: &[&str]) -> Option<Layout> {
    // What LabVIEW says first has rows of its own.
    let first = lines.iter().rposition(|line| line.starts_with(LABVIEW_END)).map_or(0, |k| k + 1);
    let last = lines.len().saturating_sub(2).min(first + MOST_CHATTER);
    let of_share = |least: f64| {
        (first..last).find_map(|k| header_at(lines, k).filter(|found| rows_below(lines, found) >= least))
    };
    let found = of_share(NEARLY_ALL).or_else(|| of_share(MOST)).or_else(|| of_share(0.0))?;
    // A candidate below rows of as many numbers is a bad row of the table above; one such line may be half of a row. Remarks with numbers
    // begin with a word of their own.
    let k = found.header?;
    let begin = |line: &str| fields(line, &found.separator).into_iter().next().unwrap_or_default();
    let is_remark = |line: &str| {
        let word = begin(line);
        !is_number(&word) && lines.iter().filter(|other| begin(other) == word).count() == 1
    };
    let alike = |line: &&&str| row(line, &found.separator) == Some(found.names.len()) && !is_remark(line);
    let alike = lines[first..k].iter().filter(alike).count();
    (alike <= 1 && (alike == 0 || k == first + 1)).then_some(found)
}

/// Share of the next lines below a header that are rows.
fn rows_below(lines: &[&str], found: &Layout) -> f64 {
    let next = &lines[found.rows..(found.rows + GO_ON).min(lines.len())];
    next.iter().filter(|line| row(line, &found.separator).is_some()).count() as f64 / next.len() as f64
}

fn header_at(lines: &[&str], k: usize) -> Option<Layout> {
    for separator in [
        Separator::Byte(b';'),
        Separator::Byte(b'\t'),
        Separator::Byte(b'|'),
        Separator::Byte(b','),
        Separator::DecimalCommas,
        Separator::Blanks,
    ] {
        for units in [false, true] {
            let first = k + 1 + usize::from(units);
            let (Some(one), Some(two)) = (lines.get(first), lines.get(first + 1)) else { continue };
            let Some(width) =
                row(one, &separator).filter(|width| *width >= 2 && row(two, &separator) == Some(*width))
            else {
                continue;
            };
            let ends_open = |line| fields(line, &separator).last().is_some_and(String::is_empty);
            let names = names_of(lines[k], &separator, width).or_else(|| {
                // A separator behind the last number of every row makes no column.
                let open = width > 2 && ends_open(*one) && ends_open(*two);
                let mut names = open.then(|| names_of(lines[k], &separator, width - 1))??;
                names.push(String::new());
                Some(names)
            });
            let names = names.or_else(|| units.then(|| channels_of(lines[k], &separator, width))?);
            let Some(names) = names else { continue };
            let units = if units { units_of(lines[k + 1], &separator, width) } else { Some(Vec::new()) };
            let Some(units) = units else { continue };
            return Some(Layout { header: Some(k), names, units, rows: first, ..new(separator) });
        }
    }
    None
}

/// Number of fields of a row: a line at least half of which are numbers or times.
pub(super) fn row(line: &str, separator: &Separator) -> Option<usize> {
    let values = fields(line, separator);
    let numbers = values.iter().filter(|value| is_number(value)).count();
    let decimal = |value: &String| {
        let (whole, part) = value.split_once(',').unwrap_or(("", ""));
        !part.is_empty() && part.bytes().all(|b| b.is_ascii_digit()) && whole.parse::<i64>().is_ok()
    };
    if *separator == Separator::DecimalCommas && !values.iter().all(decimal) {
        return None;
    }
    // A word and its number are a remark on the log.
    let is_remark = values.len() == 2 && numbers == 1 && values.iter().all(|value| !value.is_empty());
    (numbers > 0 && 2 * numbers >= values.len() && !is_remark).then_some(values.len())
}

pub(super) fn fields(line: &str, separator: &Separator) -> Vec<String> {
    let mut splitter = Splitter::of(separator.clone(), false);
    splitter.split(line);
    splitter.iter().map(|field| field.trim_matches('\u{fffd}').trim().to_owned()).collect()
}

/// A number, with its unit beside it perhaps, or a time.
pub(super) fn is_number(text: &str) -> bool {
    is_bare_number(text) || beside::unit(text).is_some()
}

pub(super) fn is_bare_number(text: &str) -> bool {
    number(text).is_some() || clock::moment(text).is_some()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layout(text: &str) -> Layout {
        Layout::of(&text.lines().collect::<Vec<_>>())
    }

    #[test]
    fn the_separator_follows_from_the_rows_whatever_the_header_is_written_with() {
        for (text, separator) in [
            ("a b c\n1 2 3\n4 5 6", Separator::Blanks),
            ("  a    b   c\n 1.0   2   3\n 4   5   6", Separator::Blanks),
            ("a (s)  b (V)  c (rad/s)\n1 2 3\n4 5 6", Separator::Blanks),
            ("a (s) b (V) c (rad/s)\n1 2 3\n4 5 6", Separator::Blanks),
            ("date time b c\n2024-05-01 12:00:00 2 3\n2024-05-01 12:00:01 5 6", Separator::Blanks),
            ("a b c\n1,2,3\n4,5,6", Separator::Byte(b',')),
            ("a;b;c\n1,0;2;3\n4,5;5;6", Separator::Byte(b';')),
            ("a,b,c\n1,0,2,0,3,0\n4,5,5,1,6,2", Separator::DecimalCommas),
            ("a\tb\tc\n1\t2\t3\n4\t5\t6", Separator::Byte(b'\t')),
        ] {
            let found = layout(text);
            assert_eq!(found.separator, separator, "{text}");
            assert_eq!((found.header, found.names.len(), found.rows), (Some(0), 3, 1), "{text}");
        }
    }

    #[test]
    fn chatter_units_half_lines_and_stamps_are_told_apart_from_the_table() {
        let found = layout("rst:0x1 (POWERON)\nentry 0x40\nt,u\n(ms),(V)\n1,2\n3,4");
        assert_eq!((found.header, found.rows), (Some(2), 4));
        assert_eq!(found.units, ["ms", "V"]);
        let found = layout("5,1\nt,u,w\n1,2,3\n3,4,5\n5,6,7");
        assert_eq!((found.header, found.rows), (Some(1), 2));
        let found = layout("12:00:00.1 -> t,u\n12:00:00.2 -> 1,2\n12:00:00.3 -> 3,4");
        assert!(found.stamped && found.names == ["t", "u"]);
    }

    #[test]
    fn separators_at_the_ends_and_remarks_of_labview_make_no_columns() {
        for (text, names) in [
            ("boot\nt,u,\n1,2\n3,4", vec!["t", "u"]),
            ("boot\nt,u\n1,2,\n3,4,", vec!["t", "u", ""]),
            ("Of\tA\tB\nX0\t0\t0\nDx\t1\t1\n***End_of_Header***\nt\tu\tComment\n1\t2\n3\t4", vec!["t", "u"]),
        ] {
            assert_eq!(layout(text).names, names, "{text}");
        }
    }

    #[test]
    fn values_that_carry_their_names_need_no_header() {
        let found = layout("hello\npwm:80 enc:1\nt:12 pwm:80 enc:2\nt:13 pwm:80 enc:3");
        assert_eq!(
            (found.names, found.header, found.rows),
            (vec!["t".into(), "pwm".into(), "enc".into()], None, 1)
        );
    }

    #[test]
    fn a_word_before_every_row_and_what_an_oscilloscope_says_first_are_no_columns() {
        let found = layout("DATA: t,u\nDATA: 1,2\nDATA: 3,4\nDATA: 5,6");
        assert_eq!((found.tag.as_str(), found.header, found.names.len()), ("DATA:", Some(0), 2));
        assert_eq!(layout("DATA,1,2\nDATA,3,4\nDATA,5,6").header, None);
        assert_eq!(layout("time,1,2\n0,3,4\n1,5,6").names, ["time", "1", "2"]);
        let remarks = "Model,MSO54\nVersion,1.20\nUnits,s\nScale,0.4\nInterval,0.01\nUnits,V,V\nOffset,0,0\nGain,1,1\nLabel,,\n";
        let found = layout(&format!("{remarks}TIME,CH1,CH2\n{}", "1,2,3\n".repeat(20)));
        assert_eq!(found.names, ["TIME", "CH1", "CH2"]);
        let found = layout("Name\tu\tName\tw\nType\tR\tType\tR\nUnit\tV\tUnit\trad\n0\t1\t0\t2\n1\t1\t1\t2");
        assert_eq!(found.names, ["Time", "u", "Time", "w"]);
        assert_eq!((found.units, found.rows), (["", "V", "", "rad"].map(String::from).to_vec(), 3));
        let found = layout("X,u,w,Comment\n\t1\t2\t\n\t3\t4\t\n\t3\t4\t".replace(',', "\t").as_str());
        assert_eq!((found.names.len(), found.separator), (4, Separator::Byte(b'\t')));
    }

    #[test]
    fn columns_behind_the_last_name_are_called_by_their_places() {
        let found =
            layout("\"Time\",\"data\"\n0.920,0,0.0005,0.040\n0.922,0,0.0005,0.039\n0.924,0,0.0005,0.038");
        assert_eq!(
            (found.header, found.names, found.rows),
            (Some(0), ["Time", "data", "2", "3"].map(String::from).to_vec(), 1)
        );
        assert_eq!(layout("t,u\n0.1,2\n0.2,2,9\n0.3,2").names.len(), 2, "one row alone is a bad row");
        assert_eq!(layout("t,u\n0,1,2,5\n0,2,2,5\n0,3,2,5").names.len(), 2, "decimal commas");
    }

    #[test]
    fn channels_that_are_called_by_numbers_have_names_above_their_units() {
        let found = layout("x-axis,1,2\nsecond,Volt,Volt\n0.00,1.5,2.5\n0.01,1.5,2.6\n0.02,1.5,2.7");
        assert_eq!(found.names, ["x-axis", "CH1", "CH2"]);
        assert_eq!((found.units.len(), found.rows), (3, 2));
        assert_eq!(layout("x,1,2\n0.00,1,2\n0.01,1,2").names, ["x", "1", "2"]);
    }

    #[test]
    fn numbers_alone_have_no_header() {
        assert_eq!(layout("1,2\n3,4\n5,6").header, None);
        assert_eq!(layout("1 2\n3 4\n5 6").separator, Separator::Blanks);
        assert_eq!(layout("t,u").header, Some(0));
        for first in ["12,0.0897,,3.5,", "12.0,-1e-3,,,2", "1,2,,,"] {
            assert_eq!(layout(&format!("{first}\n12,0.1,3,3,2\n12,0.2,,3,2")).header, None, "{first}");
        }
        let found = layout("12,5;;0,3\n12,5;7,5;0,2\n12,5;8,5;0,1");
        assert_eq!((found.header, found.separator), (None, Separator::Byte(b';')));
        assert_eq!(layout("t,,u\n1,,2\n2,,3").header, Some(0));
        for text in
            ["data = [\n1 2 3;\n3 4 5;\n5 6 7;\n7 8 9;\n];", "x = [\n [1, 2, 3],\n [3, 4, 5],\n [5, 6, 7]\n]"]
        {
            let found = layout(text);
            assert_eq!((found.header, found.rows), (None, 1), "{text}");
        }
        let found = layout("Setup done\nStarting ...\n1,2,3\n3,4,5\n5,6,7\n7,8,9");
        assert_eq!((found.header, found.names.len(), found.rows), (None, 0, 2));
    }
}
