//! Which part of which record is fitted, judged by, or left out: `--skip 3.2..4.0`, `--judge-by run2:5..`.

use std::str::FromStr;

use super::samples::FEWEST_SAMPLES;
use super::{Record, repair};
use crate::error::{Error, Result};

/// A time range of one record or of all: `3.2..4.0`, `run2:3.2..`, `run2:..4.0`, `run2`.
///
/// Times are those of the log's own clock, as messages about it print them.
#[derive(Debug, Clone, PartialEq)]
pub struct Range {
    /// Name of the record, of its file, or the start of the path; all records where absent.
    record: Option<String>,
    from_s: f64,
    to_s: f64,
}

impl FromStr for Range {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let wrong = || {
            format!(
                "\"{text}\" is no range: write 3.2..4.0, 3.2.., run2:3.2..4.0 (of one record), or run2 (all of it), in seconds"
            )
        };
        let (record, times) = match text.rsplit_once(':') {
            Some((record, times)) if times.contains("..") => (Some(record), times),
            _ if text.contains("..") => (None, text),
            _ => (Some(text), ".."),
        };
        let (from_s, to_s) = times_of(times).ok_or_else(wrong)?;
        if record.is_some_and(str::is_empty) || from_s >= to_s {
            return Err(wrong());
        }
        Ok(Self { record: record.map(str::to_owned), from_s, to_s })
    }
}

fn times_of(text: &str) -> Option<(f64, f64)> {
    let (from, to) = text.split_once("..")?;
    let number = |text: &str, open: f64| match text.trim() {
        "" => Some(open),
        text => text.parse::<f64>().ok().filter(|t| t.is_finite()),
    };
    Some((number(from, f64::NEG_INFINITY)?, number(to, f64::INFINITY)?))
}

impl Range {
    fn is_of(&self, record: &Record) -> bool {
        let Some(wanted) = self.record.as_deref() else { return true };
        let file = record.path.file_name().is_some_and(|name| name == wanted);
        wanted == record.name
            || wanted == super::stem(&record.path)
            || file
            || record.path.as_os_str() == wanted
    }

    fn holds(&self, time_s: f64) -> bool {
        (self.from_s..=self.to_s).contains(&time_s)
    }

    fn touches(&self, record: &Record) -> bool {
        self.is_of(record) && record.time_s.iter().any(|t| self.holds(*t))
    }

    fn named(&self) -> String {
        let bound = |t: f64| if t.is_finite() { t.to_string() } else { String::new() };
        let record = self.record.as_ref().map_or_else(String::new, |name| format!("{name}:"));
        format!("{record}{}..{}", bound(self.from_s), bound(self.to_s))
    }
}

/// What is left out of records, and what of them judges.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Division {
    /// Left out.
    pub skip: Vec<Range>,
    /// Kept out of every fit, and judged by.
    pub judge_by: Vec<Range>,
}

impl Division {
    fn is_empty(&self) -> bool {
        self.skip.is_empty() && self.judge_by.is_empty()
    }

    /// What is left of `record`, each part with whether it judges; all of a record that is `kept_out` does. What stands before and after a
    /// range become records of their own: no voltage is held through what was left out.
    pub fn parts(&self, record: Record, kept_out: bool) -> Vec<(Record, bool)> {
        if self.is_empty() {
            return vec![(record, kept_out)];
        }
        let within = |ranges: &[Range], t: f64| ranges.iter().any(|r| r.is_of(&record) && r.holds(t));
        let role = |t: f64| (!within(&self.skip, t)).then(|| kept_out || within(&self.judge_by, t));
        let roles: Vec<Option<bool>> = record.time_s.iter().map(|t| role(*t)).collect();
        let mut begin = 0;
        let mut ranges = Vec::new();
        for end in 1..=roles.len() {
            if end == roles.len() || roles[end] != roles[begin] {
                if let Some(judges) = roles[begin].filter(|_| end - begin >= FEWEST_SAMPLES) {
                    ranges.push((begin..end, judges));
                }
                begin = end;
            }
        }
        let whole = ranges.len() == 1;
        let mut parts = Vec::new();
        for (number, (range, judges)) in ranges.into_iter().enumerate() {
            let mut part = if whole && range.len() == record.len() {
                record.clone()
            } else {
                repair::part(&record, range, number + 1)
            };
            if number > 0 {
                part.warnings.clear();
            }
            parts.push((part, judges));
        }
        parts
    }
}

/// The records to fit and those to judge by, of `fitted` and `kept_out` ones divided by `division`.
///
/// # Errors
/// Wrong usage where a range touches no record, or nothing is left to fit.
pub fn divide(
    fitted: Vec<Record>,
    kept_out: Vec<Record>,
    division: &Division,
) -> Result<(Vec<Record>, Vec<Record>)> {
    if division.is_empty() {
        return Ok((fitted, kept_out));
    }
    let known = fitted.len();
    let records: Vec<Record> = fitted.into_iter().chain(kept_out).collect();
    for (option, ranges) in [("--skip", &division.skip), ("--judge-by", &division.judge_by)] {
        if let Some(range) = ranges.iter().find(|range| !records.iter().any(|record| range.touches(record))) {
            return Err(nothing_there(option, range, &records));
        }
    }
    let (mut fitted, mut judged) = (Vec::new(), Vec::new());
    for (place, record) in records.into_iter().enumerate() {
        for (part, judges) in division.parts(record, place >= known) {
            if judges { &mut judged } else { &mut fitted }.push(part);
        }
    }
    if fitted.is_empty() {
        return Err(Error::usage(
            "--skip and --judge-by leave nothing to fit",
            "leave out less: every fit needs a record",
        ));
    }
    Ok((fitted, judged))
}

fn nothing_there(option: &str, range: &Range, records: &[Record]) -> Error {
    let there: Vec<String> = records
        .iter()
        .take(12)
        .map(|record| {
            let (first, last) = (record.time_s.first(), record.time_s.last());
            format!("{} {:.3}..{:.3}", record.name, first.unwrap_or(&0.0), last.unwrap_or(&0.0))
        })
        .collect();
    Error::usage(
        format!("{option} {} touches no record", range.named()),
        format!("the records, and the seconds from which to which they run: {}", there.join(", ")),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn record(name: &str) -> Record {
        let time_s: Vec<f64> = (0..1000).map(|k| f64::from(k) * 0.01).collect();
        Record {
            name: name.into(),
            path: format!("{name}.csv").into(),
            voltage_v: time_s.clone(),
            angle_rad: Some(time_s.clone()),
            time_s,
            ..Record::default()
        }
    }

    fn division(skip: &[&str], judge_by: &[&str]) -> Division {
        Division { skip: ranges(skip), judge_by: ranges(judge_by) }
    }

    fn ranges(texts: &[&str]) -> Vec<Range> {
        texts.iter().map(|text| text.parse().unwrap()).collect()
    }

    #[test]
    fn what_is_skipped_divides_a_record_and_belongs_to_no_part() {
        let (fitted, judged) = divide(
            vec![record("a"), record("b")],
            vec![],
            &division(&["a:3.2..4.0"], &["b:5..", "a:9..9.5"]),
        )
        .unwrap();
        let of = |records: &[Record]| -> Vec<(String, f64, f64)> {
            records.iter().map(|r| (r.name.clone(), r.time_s[0], r.time_s[r.len() - 1])).collect()
        };
        assert_eq!(
            of(&fitted),
            [
                ("a part 1".into(), 0.0, 3.19),
                ("a part 2".into(), 4.01, 8.99),
                ("a part 4".into(), 9.51, 9.99),
                ("b part 1".into(), 0.0, 4.99)
            ]
        );
        assert_eq!(of(&judged), [("a part 3".into(), 9.0, 9.5), ("b part 2".into(), 5.0, 9.99)]);
    }

    #[test]
    fn a_record_by_its_name_is_all_of_it() {
        let (fitted, judged) =
            divide(vec![record("a"), record("b")], vec![], &division(&[], &["b.csv"])).unwrap();
        assert_eq!((fitted.len(), judged[0].len()), (1, 1000));
        assert_eq!(judged[0].name, "b");
    }

    #[test]
    fn a_range_that_is_none_or_touches_nothing_is_answered_with_those_there_are() {
        for text in ["4..3", ":3..4", ""] {
            assert!(text.parse::<Range>().is_err(), "{text}");
        }
        for text in ["c:3..4", "20..30", "3-4"] {
            let error = divide(vec![record("a")], vec![], &division(&[text], &[])).unwrap_err().to_string();
            assert!(error.contains("touches no record") && error.contains("a 0.000..9.990"), "{error}");
        }
        assert!(divide(vec![record("a")], vec![], &division(&["a"], &[])).is_err());
    }
}
