//! The times of evenly sampled rows, where a file tells their interval or their rate as one number beside them: `dt`, `Ts`, `fs`; or a text as
//! the only number of a column.

use std::fmt;
use std::ops::RangeInclusive;
use std::path::Path;

use super::table::{Column, Values};
use crate::log::Warning;
use crate::log::guess::words;
use crate::log::mapping::Mapping;
use crate::log::units::Quantity;

/// What the column of times is called that such a number makes.
pub const TIME: &str = "time_s";
/// What an interval in seconds is called, and what a rate in Hz, in small letters.
const INTERVALS: [&str; 14] = [
    "dt",
    "dt_s",
    "ts",
    "delta_t",
    "sample_time",
    "sampletime",
    "sampling_time",
    "sample_interval",
    "sampling_interval",
    "sample_period",
    "sampling_period",
    "control_dt",
    "timestep",
    "abtastzeit",
];
/// A servo's log has a row for each of its actions.
const RATES: [&str; 15] = [
    "fs",
    "fs_hz",
    "rate_hz",
    "sample_hz",
    "sample_rate",
    "samplerate",
    "sample_rate_hz",
    "sampling_rate",
    "sampling_rate_hz",
    "sample_frequency",
    "sampling_frequency",
    "action_hz",
    "control_hz",
    "loop_hz",
    "abtastrate",
];
/// Intervals of a motor's log, s.
const PLAUSIBLE_S: RangeInclusive<f64> = 1e-6..=1.0;

/// Intervals that differ by more than this share are two.
const SAME: f64 = 1e-3;

/// What tells the time from row to row.
#[derive(Debug, Clone, PartialEq)]
pub struct Clock {
    taken: Told,
    /// Numbers that tell another interval.
    others: Vec<Told>,
}

/// A number of the file that is an interval or a rate by its name.
#[derive(Debug, Clone, PartialEq)]
struct Told {
    name: String,
    number: f64,
    interval_s: f64,
}

impl Told {
    fn by((called, number): (&str, f64)) -> Option<Told> {
        let name = called.rsplit('.').next()?;
        let interval_s = if is_interval(name) {
            number
        } else if is_rate(name) {
            1.0 / number
        } else {
            return None;
        };
        let told = Told { name: called.to_owned(), number, interval_s };
        PLAUSIBLE_S.contains(&interval_s).then_some(told)
    }

    /// Rows per second, as a person writes them.
    fn rate_hz(&self) -> f64 {
        (1e4 / self.interval_s).round() / 1e4
    }
}

impl fmt::Display for Told {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} = {} makes {} rows a second", self.name, self.number, self.rate_hz())
    }
}

/// The clock of the rows of `log` as one of the `parameters` tells it; none where the log has one.
pub fn clock(log: &[Column], parameters: &[Column]) -> Option<Clock> {
    let one = |parameter: &Column| match &parameter.values {
        Values::Numbers(numbers) => numbers.first().copied().filter(|_| numbers.len() == 1),
        Values::Texts(_) => None,
    };
    let numbers = parameters.iter().filter_map(|parameter| Some((parameter.name.as_str(), one(parameter)?)));
    among(log.iter().map(|column| column.name.as_str()), numbers)
}

/// Whether a single number that is called so may be the interval or the rate of the rows.
pub fn may_tell(name: &str) -> bool {
    let name = name.rsplit('.').next().unwrap_or_default();
    is_interval(name) || is_rate(name)
}

/// Whether a number that is called so is the interval of the rows.
pub fn is_interval(name: &str) -> bool {
    INTERVALS.contains(&in_small_letters(name).as_str())
}

/// Whether a number that is called so is the rate of the rows.
pub fn is_rate(name: &str) -> bool {
    RATES.contains(&in_small_letters(name).as_str())
}

/// A name as both lists have it: `Sample time` is `sample_time`.
fn in_small_letters(name: &str) -> String {
    name.to_lowercase().replace(' ', "_")
}

/// The clock of the rows of columns that are called so, as one of single `numbers` with their names tells it; none where they have one.
pub fn among<'n>(
    mut columns: impl Iterator<Item = &'n str>,
    numbers: impl Iterator<Item = (&'n str, f64)>,
) -> Option<Clock> {
    let is_clock =
        |name: &str| matches!(words::said(name).quantity, Some((Quantity::Time | Quantity::Interval, _)));
    if columns.any(is_clock) {
        return None;
    }
    let mut all = numbers.filter_map(Told::by);
    let taken = all.next()?;
    let others = all.filter(|other| (other.interval_s / taken.interval_s - 1.0).abs() > SAME).collect();
    Some(Clock { taken, others })
}

/// Whether the times of a clock are read where this mapping is given.
pub fn is_read_by(map: &Mapping) -> bool {
    map.source(Quantity::Interval).is_none()
        && map.source(Quantity::Time).is_none_or(|source| source.column == TIME)
}

impl Clock {
    /// The times of so many rows.
    pub fn times(&self, rows: usize) -> Column {
        let times = (0..rows).map(|row| row as f64 * self.taken.interval_s).collect();
        Column { name: TIME.into(), values: Values::Numbers(times) }
    }

    /// Rows per second.
    pub fn rate_hz(&self) -> f64 {
        self.taken.rate_hz()
    }

    /// What is asked where a rate is proposed by it.
    pub fn question(&self) -> String {
        let taken = &self.taken;
        let others =
            self.others.iter().map(|other| format!(", and {other}: put the right rate in its place"));
        format!("{taken}{}", others.collect::<String>())
    }

    /// What is said of the log at `path` whose rows have these times.
    pub fn said(&self, path: &Path) -> Warning {
        let (taken, place) = (&self.taken, path.display().to_string());
        if self.others.is_empty() {
            return Warning {
                place,
                what: format!("no column tells the time, so a number beside the rows does: {taken}"),
                fix:
                    "nothing, if that is right; else say the rows per second, which goes before it: --rate HZ"
                        .into(),
            };
        }
        let all: Vec<&Told> = std::iter::once(taken).chain(&self.others).collect();
        let joined = |each: &dyn Fn(&Told) -> String, between: &str| {
            all.iter().map(|told| each(told)).collect::<Vec<_>>().join(between)
        };
        Warning {
            place,
            what: format!(
                "no column tells the time, and the numbers beside the rows disagree about it: {}; the first was taken",
                joined(&|told| told.to_string(), ", ")
            ),
            fix: format!(
                "say which is right: {}",
                joined(&|told| format!("--rate {}", told.rate_hz()), " or ")
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::table::Table;
    use super::*;
    use crate::log::{ReadOptions, Record};

    fn column(name: &str, numbers: &[f64]) -> Column {
        Column { name: name.into(), values: Values::Numbers(numbers.to_vec()) }
    }

    #[test]
    fn one_number_that_tells_the_interval_or_the_rate_is_the_clock_where_there_is_none() {
        let log = [column("u", &[1.0, 2.0, 3.0]), column("omega", &[0.0, 1.0, 2.0])];
        let times = |parameters: &[Column]| clock(&log, parameters).map(|clock| clock.times(3));
        let expected = Some(column("time_s", &[0.0, 0.5, 1.0]));
        assert_eq!(times(&[column("J", &[0.1]), column("data.Ts", &[0.5])]), expected);
        assert_eq!(times(&[column("fs", &[2.0])]), expected);
        for (name, number) in [("config.action_hz", 2.0), ("sampling_rate_hz", 2.0), ("control_dt", 0.5)] {
            assert_eq!(times(&[column(name, &[number])]), expected, "{name}");
        }
        assert_eq!(times(&[column("pwm_hz", &[20.0])]), None, "that of the driver");
        let with_clock = [column("t", &[0.0, 0.1, 0.2]), log[0].clone()];
        assert_eq!(clock(&with_clock, &[column("dt", &[0.5])]), None);
        for other in [column("dt", &[0.0]), column("dt", &[0.5, 0.5]), column("tau", &[0.5])] {
            assert_eq!(clock(&log, &[other]), None);
        }
    }

    /// The record of 60 rows without a clock, with numbers beside them.
    fn record(beside: &[(&str, f64)], rate_hz: Option<f64>, map: Option<&str>) -> Record {
        let course = |of: fn(f64) -> f64| (0..60).map(|k| of(0.1 * f64::from(k))).collect::<Vec<_>>();
        let mut columns =
            vec![column("voltage_v", &course(f64::sin)), column("angle_rad", &course(f64::cos))];
        columns.extend(beside.iter().map(|(name, number)| column(name, &[*number])));
        let map = map.map(|map| map.parse().unwrap());
        let options = ReadOptions { rate_hz, map, ..ReadOptions::default() };
        let table = Table::of(columns, Vec::new()).unwrap();
        table.records(Path::new("log.mat"), &options).unwrap().remove(0)
    }

    fn said(record: &Record) -> String {
        record.warnings.iter().map(|warning| format!("{}; {}\n", warning.what, warning.fix)).collect()
    }

    #[test]
    fn the_number_that_was_taken_for_the_clock_is_said_and_a_rate_goes_before_it() {
        let by_file = record(&[("dt", 0.02), ("Ts", 0.02)], None, None);
        assert!((by_file.time_s[50] - 1.0).abs() < 1e-9);
        assert!(said(&by_file).contains("dt = 0.02 makes 50 rows a second"), "{}", said(&by_file));
        // As pasted from a proposal, too.
        for map in [None, Some("time=time_s:s,voltage=voltage_v:V,angle=angle_rad:rad")] {
            let by_rate = record(&[("dt", 0.02)], Some(100.0), map);
            assert!((by_rate.time_s[50] - 0.5).abs() < 1e-9, "{map:?}");
            assert!(!said(&by_rate).contains("dt =") && !said(&by_rate).contains("--rate is not used"));
        }
    }

    #[test]
    fn numbers_that_disagree_about_the_interval_are_said_with_the_rate_of_either() {
        let said = said(&record(&[("dt", 0.02), ("fs", 25.0), ("Ts", 0.02)], None, None));
        assert!(said.contains("dt = 0.02 makes 50") && said.contains("fs = 25 makes 25"), "{said}");
        assert!(said.contains("--rate 50 or --rate 25") && !said.contains("Ts"), "{said}");
    }
}
