//! The times of evenly sampled rows, where a file tells their interval or their rate as one number beside them: `dt`, `Ts`, `fs`.

use std::ops::RangeInclusive;

use super::table::{Column, Values};
use crate::log::guess::words;
use crate::log::units::Quantity;

/// What an interval in seconds is called, and what a rate in Hz, in small letters.
const INTERVALS: [&str; 6] = ["dt", "ts", "delta_t", "sample_time", "sampletime", "sampling_interval"];
const RATES: [&str; 7] =
    ["fs", "fs_hz", "rate_hz", "sample_rate", "samplerate", "sampling_rate", "sampling_frequency"];
/// Intervals of a motor's log, s.
const PLAUSIBLE_S: RangeInclusive<f64> = 1e-6..=1.0;

/// The times of the rows of `log` as one of the `parameters` tells them; none where the log has a clock.
pub fn clock(log: &[Column], parameters: &[Column]) -> Option<Column> {
    let is_clock = |column: &Column| {
        let quantity = words::said(&column.name).quantity;
        matches!(quantity, Some((Quantity::Time | Quantity::Interval, _)))
    };
    let rows = log.iter().all(|column| !is_clock(column)).then(|| log.first())??.values.len();
    let interval_s = parameters.iter().find_map(interval_s)?;
    let times = (0..rows).map(|row| row as f64 * interval_s).collect();
    Some(Column { name: "time_s".into(), values: Values::Numbers(times) })
}

/// The time from row to row, s, that a single number tells by its name.
fn interval_s(parameter: &Column) -> Option<f64> {
    let Values::Numbers(numbers) = &parameter.values else { return None };
    let [number] = numbers[..] else { return None };
    let name = parameter.name.rsplit('.').next()?.to_lowercase();
    let interval_s = if INTERVALS.contains(&name.as_str()) {
        number
    } else if RATES.contains(&name.as_str()) {
        1.0 / number
    } else {
        return None;
    };
    PLAUSIBLE_S.contains(&interval_s).then_some(interval_s)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_number_that_tells_the_interval_or_the_rate_is_the_clock_where_there_is_none() {
        let column = |name: &str, numbers: &[f64]| Column {
            name: name.into(),
            values: Values::Numbers(numbers.to_vec()),
        };
        let log = [column("u", &[1.0, 2.0, 3.0]), column("omega", &[0.0, 1.0, 2.0])];
        let times = column("time_s", &[0.0, 0.5, 1.0]);
        assert_eq!(clock(&log, &[column("J", &[0.1]), column("data.Ts", &[0.5])]), Some(times.clone()));
        assert_eq!(clock(&log, &[column("fs", &[2.0])]), Some(times));
        let with_clock = [column("t", &[0.0, 0.1, 0.2]), log[0].clone()];
        assert_eq!(clock(&with_clock, &[column("dt", &[0.5])]), None);
        for other in [column("dt", &[0.0]), column("dt", &[0.5, 0.5]), column("tau", &[0.5])] {
            assert_eq!(clock(&log, &[other]), None);
        }
    }
}
