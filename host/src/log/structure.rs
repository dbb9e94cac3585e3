//! One file with several tests: told apart by a clock that starts anew, and by a column that names the state.

use super::guess::quoted;
use super::only::Only;
use super::samples::FEWEST_SAMPLES;
use super::several::ELEMENT;
use super::timing::median_interval;
use super::{Record, Warning, repair};

/// What columns with the state of a routine are called.
const NAMES: [&str; 12] = [
    "state",
    "test",
    "test_state",
    "teststate",
    "phase",
    "mode",
    "segment",
    "trial",
    "run",
    "experiment",
    "test_name",
    "zustand",
];
/// More states than this are no states.
const MOST: usize = 200;
/// A test ends where the state changes and the clock makes a step of more than so many intervals.
const STEP_INTERVALS: f64 = 3.0;

/// Where the column of the state stands among `headers`, if there is one.
pub(super) fn state_column(headers: &[String]) -> Option<usize> {
    headers.iter().position(|header| is_state(header))
}

/// Whether this is what a column of states is called; of `/arm/State` the last part counts.
pub(super) fn is_state(header: &str) -> bool {
    let last = header.rsplit(['/', ':']).next().unwrap_or_default();
    NAMES.contains(&last.trim().to_lowercase().as_str())
}

/// Where a file may be cut, as samples of its one record.
#[derive(Debug, Clone, Default)]
pub(super) struct Structure {
    /// The clock starts anew at these samples.
    pub restarts: Vec<usize>,
    /// Text stands before these samples, whose rows have no clock.
    pub at_text: bool,
    /// The state is another from these samples on.
    pub states: Vec<(usize, String)>,
    /// The column that says the states, where they are motors rather.
    pub whose: Option<String>,
}

impl Structure {
    /// Takes the state of sample `sample`.
    pub fn saw(&mut self, sample: usize, state: &str) {
        if self.states.len() <= MOST && self.states.last().is_none_or(|(_, last)| last != state) {
            self.states.push((sample, state.to_owned()));
        }
    }

    /// The tests in `record`. Where the clock runs on through a change of state there is no cut: rest and running out between two
    /// tests are data too.
    pub fn tests(&self, mut record: Record) -> Vec<Record> {
        let step = STEP_INTERVALS * median_interval(&record.time_s);
        let usable = self.states.len() <= MOST;
        let breaks = |k: usize| {
            k > 0 && k < record.len() && {
                let by = record.time_s[k] - record.time_s[k - 1];
                by < 0.0 || by > step
            }
        };
        let by_state: Vec<usize> =
            self.states.iter().map(|(k, _)| *k).filter(|k| usable && breaks(*k)).collect();
        let mut cuts: Vec<usize> = self.restarts.iter().chain(&by_state).copied().collect();
        cuts.sort_unstable();
        cuts.dedup();
        if cuts.is_empty() {
            return vec![record];
        }
        let ends = cuts.iter().copied().chain([record.len()]);
        let begins = [0].into_iter().chain(cuts.iter().copied());
        let kept: Vec<(usize, usize)> = begins.zip(ends).filter(|(a, b)| b - a >= FEWEST_SAMPLES).collect();
        if kept.is_empty() {
            return vec![record];
        }
        let by_motor = self.whose.as_ref().map(|column| match column.as_str() {
            ELEMENT => "each is an element of a list".to_owned(),
            column => format!("by \"{column}\", perhaps of several motors"),
        });
        let how = match (by_motor.as_deref(), by_state.is_empty()) {
            (Some(how), _) => how,
            (None, true) if self.at_text => "lines that are no rows stand between them",
            (None, true) => "its clock starts anew between them",
            (None, false) => "by its column of states and its clock",
        };
        let left: usize = record.len() - kept.iter().map(|(a, b)| b - a).sum::<usize>();
        let left =
            if left > 0 { format!("; {left} samples of shorter parts are left out") } else { String::new() };
        let mut warnings = std::mem::take(&mut record.warnings);
        repair::cut_already(&mut warnings);
        warnings.push(Warning {
            place: record.path.display().to_string(),
            what: format!(
                "several_tests: the file holds several tests ({how}); read as {} records{left}",
                kept.len()
            ),
            fix: self.fix(&record),
        });
        let part = |(number, &(begin, end)): (usize, &(usize, usize))| {
            let mut part = repair::part(&record, begin..end, number + 1);
            let state = self.states.iter().rev().find(|(from, _)| usable && *from <= begin);
            if let Some((_, state)) = state.filter(|(_, state)| !state.is_empty()) {
                part.name = match self.whose.as_deref() {
                    // It has its number.
                    Some(ELEMENT) => format!("{} {state}", record.name),
                    Some(column) => format!("{} {column} {state} {}", record.name, number + 1),
                    None => format!("{} {state} {}", record.name, number + 1),
                };
            }
            part.warnings = std::mem::take(&mut warnings);
            part
        };
        kept.iter().enumerate().map(part).collect()
    }

    /// What to do about the tests in `record`.
    fn fix(&self, record: &Record) -> String {
        let (Some(column), Some((_, value))) = (&self.whose, self.states.first()) else {
            return "nothing; --skip and --judge-by take the records by their names".into();
        };
        let only = Only { column: column.clone(), value: value.clone() };
        let map = record.map.clone().unwrap_or_default().with_only(only).written();
        format!("nothing, if all are of one motor; otherwise read each alone: --map {}", quoted(&map))
    }
}

#[cfg(test)]
mod tests {
    use crate::log::read_tests::file;
    use crate::log::{ReadOptions, Record, read};

    fn rows(time: impl Fn(u32) -> f64, state: impl Fn(u32) -> &'static str) -> Vec<Record> {
        let row = |k: u32| {
            format!(
                "{:.3},{},{:.1},{:.5}\n",
                time(k),
                state(k),
                (0.3 * f64::from(k)).sin(),
                0.01 * f64::from(k)
            )
        };
        let text = "time_s,state,voltage_v,angle_rad\n".to_owned() + &(0..300).map(row).collect::<String>();
        let (_directory, path) = file(text.as_bytes());
        read(&path, &ReadOptions::default()).unwrap()
    }

    #[test]
    fn a_clock_that_starts_anew_begins_a_record() {
        let records = rows(|k| f64::from(k % 100) * 0.01, |_| "x");
        assert_eq!(records.iter().map(Record::len).collect::<Vec<_>>(), [100, 100, 100]);
        assert!(records[0].warnings[0].what.contains("read as 3 records"), "{:?}", records[0].warnings);
    }

    #[test]
    fn tests_are_named_by_their_state_where_the_clock_breaks_and_not_cut_where_it_runs_on() {
        let state = |k| if k < 120 { "forward" } else { "reverse" };
        let broken = rows(|k| f64::from(k) * 0.01 + if k < 120 { 0.0 } else { 0.1 }, state);
        let names: Vec<&str> = broken.iter().map(|r| r.name.as_str()).collect();
        assert_eq!(names, ["run forward 1", "run reverse 2"]);
        assert_eq!(rows(|k| f64::from(k) * 0.01, state).len(), 1);
    }
}
