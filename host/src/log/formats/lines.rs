//! What a line of values with names holds: Teleplot's `>name:value`, `name: value` as boards print it, or several such, behind the stamp of a
//! monitor or a logger.

use std::collections::{BTreeMap, BTreeSet};

use crate::log::beside;
use crate::log::numbers::number;
use crate::log::pairs::pairs;
use crate::log::stamped::stamped;

/// Lines of the same names from which they are a kind.
const FEWEST_OF_A_KIND: usize = 3;

/// A value with its name.
#[derive(Debug, PartialEq)]
pub struct Entry<'a> {
    /// Teleplot's mark stands before it.
    pub marked: bool,
    /// Its name.
    pub name: &'a str,
    /// Its unit, or nothing.
    pub unit: &'a str,
    /// Stamp, ms, and the value as it stands there.
    pub values: Vec<(Option<f64>, &'a str)>,
}

/// The value of a line that holds one.
fn entry(line: &str) -> Option<Entry<'_>> {
    let (marked, rest) = line.strip_prefix('>').map_or((false, line), |rest| (true, rest));
    let (rest, flags) = rest.split_once('|').unwrap_or((rest, ""));
    // Points of a curve and bodies in space are no course over time.
    if flags.contains("xy") || flags.contains("3D") {
        return None;
    }
    let (rest, unit) = rest.split_once('§').unwrap_or((rest, ""));
    let (name, rest) = rest.split_once(':').or_else(|| rest.split_once('=').filter(|_| !marked))?;
    let name = name.trim();
    if name.is_empty()
        || !marked && (!name.starts_with(char::is_alphabetic) || rest.contains([':', ';', ',', '=']))
    {
        return None;
    }
    let value = |text| -> Option<(Option<f64>, &str)> {
        let (stamp, value) =
            str::split_once(text, ':').map_or((None, text), |(stamp, value)| (Some(stamp), value));
        let stamp = match stamp {
            Some(stamp) => Some(number(stamp.trim()).filter(|stamp| stamp.is_finite())?),
            None => None,
        };
        let value = value.trim();
        (!value.is_empty() && (marked || number(value).is_some())).then_some((stamp, value))
    };
    let values =
        rest.split(';').filter(|text| !text.trim().is_empty()).map(value).collect::<Option<Vec<_>>>()?;
    (!values.is_empty()).then_some(Entry { marked, name, unit, values })
}

/// The values of a line, and its stamp.
#[derive(Debug, PartialEq)]
pub struct Line<'a> {
    /// When it was received or said, as it stands there.
    pub stamp: Option<&'a str>,
    /// One value or more.
    pub entries: Vec<Entry<'a>>,
}

impl Line<'_> {
    /// Whether Teleplot's mark stands before it.
    pub fn is_marked(&self) -> bool {
        self.entries.iter().any(|entry| entry.marked)
    }
}

/// What a line holds; none where it holds no values with names.
pub fn line_of(line: &str) -> Option<Line<'_>> {
    let line = line.trim();
    let (stamp, said) = stamped(line).map_or((None, line), |(stamp, said)| (Some(stamp), said));
    let entries = entry(said).map_or_else(|| several(said), |entry| vec![entry]);
    (!entries.is_empty()).then_some(Line { stamp, entries })
}

/// The values of a line that holds some, each behind its name and with its unit perhaps: `pwm=80, supply=12.1 V`.
fn several(line: &str) -> Vec<Entry<'_>> {
    if line.starts_with('>') || !line.contains([':', '=']) {
        return Vec::new();
    }
    let entry = |(name, value): (std::ops::Range<usize>, std::ops::Range<usize>)| {
        let text = &line[value];
        let unit = if number(text).is_some() { "" } else { beside::unit(text)? };
        let value = text.strip_suffix(unit)?.trim_end();
        Some(Entry { marked: false, name: &line[name], unit, values: vec![(None, value)] })
    };
    pairs(line).into_iter().map(entry).collect::<Option<Vec<_>>>().unwrap_or_default()
}

/// Whether the lines take turns in what they hold: names that come again and again, and no line with the names of all. A line without one of
/// its names is of the same kind, and remarks that come once in succession are of none.
pub fn are_of_kinds(lines: &[&Line<'_>]) -> bool {
    let names =
        |line: &Line<'_>| line.entries.iter().map(|entry| entry.name.to_owned()).collect::<BTreeSet<_>>();
    let all: Vec<BTreeSet<String>> = lines.iter().map(|line| names(line)).collect();
    let mut kinds: BTreeMap<&BTreeSet<String>, usize> = BTreeMap::new();
    for names in &all {
        *kinds.entry(names).or_default() += 1;
    }
    kinds.retain(|_, count| *count >= FEWEST_OF_A_KIND);
    let whole: BTreeSet<String> = kinds.keys().flat_map(|names| names.iter().cloned()).collect();
    let rarest = kinds.values().min().copied().unwrap_or(0);
    let turns = all.windows(2).filter(|pair| pair[0] != pair[1]).count();
    kinds.len() > 1 && !kinds.contains_key(&whole) && turns >= rarest
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_line_has_a_name_a_stamp_a_unit_and_flags() {
        let of = |line| {
            let mut entries = line_of(line)?.entries;
            (entries.len() == 1)
                .then(|| entries.remove(0))
                .map(|entry| (entry.name, entry.unit, entry.values))
        };
        assert_eq!(of(">u:5.2"), Some(("u", "", vec![(None, "5.2")])));
        assert_eq!(of(">u:120:5.2§V|g"), Some(("u", "V", vec![(Some(120.0), "5.2")])));
        assert_eq!(of(">u:1:5;2:6\r\n"), Some(("u", "", vec![(Some(1.0), "5"), (Some(2.0), "6")])));
        assert_eq!(of("12:00:01.5 -> >u:5"), Some(("u", "", vec![(None, "5")])));
        assert_eq!(of("PWM: 80"), Some(("PWM", "", vec![(None, "80")])));
        assert_eq!(of("Speed: 15.2 rpm"), Some(("Speed", "rpm", vec![(None, "15.2")])));
        assert_eq!(of("12:00:01 - motor: u = 5V"), Some(("u", "V", vec![(None, "5")])));
        for line in [">track:1:2|xy", ">u:", "hello", "t:1 u:2", "ready: yes", "12:30:01", ">u:noon:5"] {
            assert_eq!(of(line), None, "{line}");
        }
    }

    #[test]
    fn a_line_of_several_values_has_each_with_its_name_and_unit() {
        let of = |line| {
            let line = line_of(line)?;
            let all = line.entries.iter().map(|entry| [entry.name, entry.unit, entry.values[0].1]);
            Some((line.stamp, all.collect::<Vec<_>>()))
        };
        for (line, stamp, values) in [
            ("u:1 w:2", None, [["u", "", "1"], ["w", "", "2"]]),
            ("12:34:56.789 - u: 1, w: 2", Some("12:34:56.789"), [["u", "", "1"], ["w", "", "2"]]),
            ("I (1234) motor: u=5.2V w=15 rpm", Some("1234"), [["u", "V", "5.2"], ["w", "rpm", "15"]]),
        ] {
            assert_eq!(of(line), Some((stamp, values.to_vec())), "{line}");
        }
        for line in ["u:1 state:run", "pwm,80,enc,7", "12:34:56.789 - 80,7", ">u:1 w:2"] {
            assert_eq!(of(line), None, "{line}");
        }
    }
}
