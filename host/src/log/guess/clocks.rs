//! Which column is the clock, and in which unit it counts: seconds, parts of them in a column of their own, dates in days.

use super::columns::Part;
use super::ranges::Range;
use super::{symbols, words};
use crate::log::samples::REPEAT_SHARE;
use crate::log::timing;
use crate::log::units::{Quantity, Unit};

/// Rows from which a clock is told by its values.
pub(super) const FEWEST_TICKS: usize = 20;
/// What counts rows and tells no time.
const COUNTERS: [&str; 12] =
    ["index", "idx", "frame", "sample", "row", "id", "n", "nr", "no", "number", "count", "seq"];

/// What may rise all the time and tells none either.
const NO_CLOCKS: [&str; 14] = [
    "hz",
    "khz",
    "freq",
    "frequency",
    "frequenz",
    "temp",
    "temperature",
    "temperatur",
    "energy",
    "energie",
    "charge",
    "wh",
    "ah",
    "mah",
];

/// Whether the column at `index` may be a clock though its name does not say so: it always rises, and not by one a row.
pub(super) fn is_clock(name: &str, rows: &[Vec<f64>], index: usize) -> bool {
    let value = |row: &Vec<f64>| row.get(index).copied().unwrap_or(f64::NAN);
    let steps = || rows.windows(2).map(|pair| value(&pair[1]) - value(&pair[0]));
    let counts = words::of(name).iter().any(|word| COUNTERS.contains(&word.as_str()));
    let rises = rows.len() >= FEWEST_TICKS && steps().all(|step| step > 0.0);
    let is_other =
        symbols::is_no_time(name) || words::of(name).iter().any(|word| NO_CLOCKS.contains(&word.as_str()));
    rises && !counts && !is_other && steps().take(FEWEST_TICKS).any(|step| step != 1.0)
}

/// Stamps of these seconds are dates of this century, s since 1970.
const DATED_S: std::ops::Range<f64> = 1e9..2.5e9;
/// A motor is logged faster than this by stamps of another kind only, s.
const FAST_S: f64 = 1e-4;

/// The unit in which stamps are dates of this century.
fn dated(values: &[f64]) -> Option<&'static str> {
    let is_dated = |unit: &&str| {
        Unit::parse(Quantity::Time, unit)
            .is_ok_and(|unit| values.iter().all(|value| DATED_S.contains(&(value * unit.factor))))
    };
    ["s", "ms", "us", "ns"].into_iter().find(is_dated).filter(|_| !values.is_empty())
}

/// The unit that a time is plausible in, where the one that its name tells makes a rate that no motor is logged at: `time_us` in seconds; or
/// a very high one, where another makes dates of its stamps: `timestamp(ms)` of 1.7e9 s.
pub(super) fn plausible(quantity: Quantity, told: &str, values: &[f64]) -> Option<&'static str> {
    let (interval, interval_s) = interval(quantity, told, values)?;
    // Times that stand still have their fraction elsewhere, or too few digits.
    if interval <= 0.0 {
        return None;
    }
    if !timing::is_plausible(interval_s) {
        return timing::plausible_unit(interval);
    }
    if quantity != Quantity::Time || interval_s >= FAST_S {
        return None;
    }
    let is_logged = |unit: &&str| {
        Unit::parse(Quantity::Time, unit).is_ok_and(|unit| timing::is_plausible(interval * unit.factor))
    };
    dated(values).filter(|unit| *unit != told).filter(is_logged)
}

/// The median time from row to row, in the column's own unit and in s if that is `unit`.
pub(super) fn interval(quantity: Quantity, unit: &str, values: &[f64]) -> Option<(f64, f64)> {
    let interval = match quantity {
        Quantity::Time => timing::median_interval(values),
        Quantity::Interval => timing::median(&mut values.to_vec()),
        _ => return None,
    };
    Some((interval, interval * Unit::parse(quantity, unit).ok()?.factor))
}

/// Rows a second by the clock among `parts`, or by the intervals.
pub(super) fn rate_of(parts: &[Part], rows: &[Vec<f64>]) -> Option<f64> {
    let of = |wanted: Quantity| parts.iter().find(|part| part.quantity == wanted);
    let (part, is_clock) =
        of(Quantity::Time).map(|clock| (clock, true)).or(of(Quantity::Interval).map(|part| (part, false)))?;
    let mut values: Vec<f64> = rows.iter().filter_map(|row| row.get(part.index).copied()).collect();
    let interval = if is_clock { timing::median_interval(&values) } else { timing::median(&mut values) };
    let interval_s = interval * Unit::parse(part.quantity, &part.unit).ok()?.factor;
    (interval_s > 0.0).then(|| (1e3 / interval_s).round() / 1e3)
}

/// Rows from which it is told how many repeat the time of the one before.
const COUNTED: usize = 2000;

/// Rows a second, to three digits, where the times of a log have too few digits to tell its samples apart: whole seconds, say.
pub(super) fn rate_of_coarse(parts: &[Part], rows: &[Vec<f64>]) -> Option<f64> {
    let time = parts.iter().find(|part| part.quantity == Quantity::Time && part.rest.is_none())?;
    let second = Unit::parse(Quantity::Time, &time.unit).ok()?.factor;
    let motions = || parts.iter().filter(|part| [Quantity::Angle, Quantity::Speed].contains(&part.quantity));
    let is_read = |row: &&Vec<f64>| {
        motions()
            .map(|part| part.index)
            .chain([time.index])
            .all(|k| row.get(k).is_some_and(|x| x.is_finite()))
    };
    let read: Vec<&Vec<f64>> = rows.iter().take(COUNTED).filter(is_read).collect();
    let at = |k: usize| read[k][time.index] * second;
    let steps = || 1..read.len();
    // What stands there twice was printed twice.
    let is_again = |k: usize| {
        let mut both = read[k].iter().zip(read[k - 1]);
        both.all(|(one, other)| one == other || one.is_nan() && other.is_nan())
    };
    let repeats = steps().filter(|k| at(*k) == at(k - 1) && !is_again(*k)).count();
    if repeats as f64 <= REPEAT_SHARE * read.len() as f64 || steps().any(|k| at(k) < at(k - 1)) {
        return None;
    }
    let mut changes = steps().filter(|k| at(*k) > at(k - 1));
    let (first, last) = (changes.next()?, changes.next_back()?);
    let rate = (last - first) as f64 / (at(last) - at(first));
    timing::to_three_digits(rate)
}

/// Share of its steps that rise in a clock; a file may hold several recordings.
pub(super) const RISES: f64 = 0.95;
/// What rises in fewer of its steps is none.
const STANDS: f64 = 0.5;

/// Share of the steps of a column that rise; of too few rows, none.
fn rising(values: impl Iterator<Item = f64> + Clone) -> f64 {
    let steps = values.clone().skip(1).count();
    let rising = values.clone().zip(values.skip(1)).filter(|(before, after)| after > before).count();
    if steps + 1 < FEWEST_TICKS { 0.0 } else { rising as f64 / steps as f64 }
}

/// Whether `values`, whose name is that of a time, stand still or go back where another column that is called so rises: they are the
/// interval, or another measure of it. Whole seconds may stand: their fraction is elsewhere.
pub(super) fn stands_beside_a_clock<V: Iterator<Item = f64> + Clone>(
    values: V,
    others: impl IntoIterator<Item = V>,
) -> bool {
    let has_fractions = || values.clone().any(|value| value.fract() != 0.0);
    let is_clock = |other: V| rising(other) >= RISES;
    has_fractions() && rising(values.clone()) < STANDS && others.into_iter().any(is_clock)
}

/// Seconds that stand still for many rows have their fraction in a column of its own: `sec,nanosec`.
pub(super) fn add_fractions(parts: &mut [Part], names: &[String], rows: &[Vec<f64>]) {
    const FRACTIONS: [(&str, &str); 10] = [
        ("nanosec", "ns"),
        ("nsec", "ns"),
        ("nanos", "ns"),
        ("_ns", "ns"),
        ("usec", "us"),
        ("microsec", "us"),
        ("_us", "us"),
        ("msec", "ms"),
        ("millisec", "ms"),
        // As C's ftime() calls it.
        ("millitm", "ms"),
    ];
    let Some(time) = parts.iter_mut().find(|part| part.quantity == Quantity::Time) else { return };
    let values = |k: usize| rows.iter().map(move |row| row.get(k).copied().unwrap_or(f64::NAN));
    let seconds: Vec<f64> = values(time.index).collect();
    let whole = seconds.iter().all(|v| v.fract() == 0.0);
    let stands = seconds.windows(2).filter(|pair| pair[0] == pair[1]).count();
    if !whole || 2 * stands < rows.len() {
        return;
    }
    let found = names.iter().enumerate().find_map(|(k, name)| {
        let name = name.to_lowercase();
        let ends = |(end, _): &&(&str, &str)| {
            name.ends_with(end) || name.trim_end_matches("onds").trim_end_matches('s').ends_with(end)
        };
        let (_, unit) = FRACTIONS.iter().find(ends)?;
        let second = 1.0 / Unit::parse(Quantity::Time, unit).ok()?.factor;
        (k != time.index && values(k).all(|value| value < second)).then_some((k, *unit))
    });
    if let Some((k, unit)) = found {
        (time.rest, time.guessed) = (Some(k), false);
        unit.clone_into(&mut time.unit);
    }
}

/// Days, as Excel counts them from 1900 and MATLAB from the year 0, of the last and the next decades, ...
const DATES: [std::ops::Range<f64>; 2] = [30_000.0..70_000.0, 700_000.0..800_000.0];
/// ... whose steps are too short for seconds: of an interval below a second they are.
const SHORT_FOR_SECONDS: f64 = 1.2e-5;
/// Their unit.
pub(super) const DAYS: &str = "s*86400";

/// Whether times in a unit of fractions begin anew with every second, so that the seconds stand in another column.
pub(super) fn is_below_a_second(unit: Option<&str>, values: impl Iterator<Item = f64> + Clone) -> bool {
    let second =
        unit.and_then(|unit| Unit::parse(Quantity::Time, unit).ok()).map_or(1.0, |unit| 1.0 / unit.factor);
    let inside = values.clone().all(|value| (0.0..second).contains(&value));
    let falls = values.clone().zip(values.skip(1)).any(|(before, after)| after < before);
    second > 1.0 && inside && falls
}

/// Longer steps are none of seconds: at two readings a second and fewer a motor tells nothing, and two a millisecond are usual.
pub(super) const LONG_FOR_SECONDS: f64 = 0.4;

/// Whole steps are not seconds, and long ones neither.
pub(super) fn time_unit(values: &[f64], range: &Range) -> &'static str {
    let step = timing::median_interval(values);
    let is_date = DATES.iter().any(|dates| dates.contains(&range.low) && dates.contains(&range.high));
    match step {
        _ if is_date && !range.is_whole() && step < SHORT_FOR_SECONDS => DAYS,
        _ if step < if range.is_whole() { 1.0 } else { LONG_FOR_SECONDS } => "s",
        _ if step < 500.0 => "ms",
        _ if step < 200_000.0 => "us",
        _ => "ns",
    }
}

/// Whether times that are read in `unit`, which nothing tells, may be of any other too: whole numbers may; those with a fraction are of
/// seconds or of days, or only their interval tells.
pub(super) fn is_open_time(unit: &str, values: &[f64]) -> bool {
    !["s", DAYS].contains(&unit) || values.iter().all(|value| value.fract() == 0.0)
}

#[cfg(test)]
mod tests {
    use super::super::propose;
    use super::*;

    /// Three tests end to end: the true interval stands where the clock that the rows are meant for runs on.
    #[test]
    fn a_time_that_stands_is_not_the_clock_beside_one_that_rises() {
        let row = |k: f64| {
            let real = if k % 80.0 == 0.0 { 0.0 } else { 0.025 };
            vec![real, 0.025 * (k + 1.0), 90.0 * (k / 40.0).floor() % 180.0, 30.0 * (0.1 * k).sin()]
        };
        let rows: Vec<Vec<f64>> = (0..240).map(|k| row(f64::from(k))).collect();
        let names = ["Ts_real_s", "time_s", "PWM_input", "omega_rad_s"].map(str::to_owned);
        let map = propose(&names, &rows).unwrap().map;
        assert!(map.starts_with("time=time_s:s,"), "{map}");
        // Whole seconds stand, and another clock may be that of something else.
        let whole = |k: f64| (0.01 * k).floor();
        let of = |time: fn(f64) -> f64| (0..240).map(move |k| time(f64::from(k)));
        assert!(!stands_beside_a_clock(of(whole), [of(|k| 0.01 * k)]));
        assert!(stands_beside_a_clock(of(|_| 0.025), [of(|k| 0.01 * k)]));
        assert!(!stands_beside_a_clock(of(|_| 0.025), [of(|_| 0.5)]), "none that rises");
    }

    #[test]
    fn times_of_too_few_digits_tell_the_rate_and_rows_twice_or_of_several_rates_do_not() {
        let names = ["t", "u", "theta"].map(str::to_owned);
        let rate = |row: &dyn Fn(usize) -> [f64; 3]| {
            let rows: Vec<Vec<f64>> = (0..600).map(|k| row(k).to_vec()).collect();
            rate_of_coarse(&super::super::parts(&names, &rows), &rows)
        };
        let (volts, angle) = (|k: usize| (0.1 * k as f64).sin(), |k: usize| (0.01 * k as f64).powi(2));
        assert_eq!(rate(&|k: usize| [(k / 100) as f64, volts(k), angle(k)]), Some(100.0));
        assert_eq!(rate(&|k: usize| [0.01 * k as f64, volts(k), angle(k)]), None);
        assert_eq!(rate(&|k: usize| [0.01 * (k / 2) as f64, volts(k / 2), angle(k / 2)]), None);
        let in_turn = |k: usize| {
            let t = 0.01 * (k / 2) as f64;
            if k.is_multiple_of(2) { [t, volts(k), f64::NAN] } else { [t, f64::NAN, angle(k)] }
        };
        assert_eq!(rate(&in_turn), None);
    }

    #[test]
    fn stamps_are_read_in_the_unit_that_makes_dates_of_them_where_that_of_their_name_makes_a_rate_of_none() {
        let stamps =
            |step: f64| (0..50).map(|k| 1_682_182_614.614 + step * f64::from(k)).collect::<Vec<f64>>();
        for (told, step, taken) in [("ms", 0.004, Some("s")), ("s", 0.004, None), ("us", 1000.0, None)] {
            assert_eq!(plausible(Quantity::Time, told, &stamps(step)), taken, "{told}");
        }
        let in_ms: Vec<f64> = stamps(0.004).iter().map(|s| 1e3 * s).collect();
        assert_eq!(plausible(Quantity::Time, "us", &in_ms), Some("ms"));
    }
}
