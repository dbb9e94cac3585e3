//! Which column is what where the lines carry times of their own: those tell which speed is the change of which angle, as a column of times does.

use super::columns::{self, Part};
use super::{Quantity, by_numbers};
use crate::log::sample::Sample;

/// The parts of a table with or without names. The stamps of its lines tell the time where no column does.
pub(super) fn parts_of(sample: &Sample) -> Vec<Part> {
    let parts = parts_in(&sample.with_units, &sample.rows, sample.names.is_empty());
    let is_timed = |part: &Part| [Quantity::Time, Quantity::Interval].contains(&part.quantity);
    if sample.stamps.is_empty() || parts.iter().any(is_timed) {
        return parts;
    }
    let width = sample.rows.iter().map(Vec::len).max().unwrap_or(0).max(sample.names.len());
    let mut names = sample.with_units.clone();
    names.resize(width, String::new());
    names.push("time_s".into());
    let mut rows = sample.rows.clone();
    for (row, stamp) in rows.iter_mut().zip(&sample.stamps) {
        row.resize(width, f64::NAN);
        row.push(*stamp);
    }
    let mut parts = parts_in(&names, &rows, sample.names.is_empty());
    parts.retain(|part| part.index != width);
    parts
}

fn parts_in(names: &[String], rows: &[Vec<f64>], by_numbers: bool) -> Vec<Part> {
    if by_numbers { by_numbers::parts(names, rows) } else { columns::parts(names, rows) }
}

#[cfg(test)]
mod tests {
    use super::super::propose_for;
    use super::*;

    /// Duty, counts of 1320 a turn, and turns a minute, every 10 ms; the shaft turns by `angle`.
    fn sample(header: &str) -> Sample {
        let angle = |t: f64| 2.0 - 2.0 * (3.0 * t).cos();
        let row = |k: u32| {
            let t = 0.01 * f64::from(k);
            let (duty, speed) = ((200.0 * (3.0 * t + 0.4).sin()).round(), 6.0 * (3.0 * t).sin());
            vec![
                duty,
                (1320.0 * angle(t) / std::f64::consts::TAU).floor(),
                speed * 30.0 / std::f64::consts::PI,
            ]
        };
        let mut sample = Sample::of(header, (0..400).map(row).collect());
        sample.stamped = true;
        sample.stamps = (0..400).map(|k| 12.0 + 0.01 * f64::from(k)).collect();
        sample
    }

    #[test]
    fn stamps_tell_the_counts_of_a_turn_as_a_column_of_times_does() {
        let proposal = propose_for(&sample("duty;ticks;speed [rpm]")).unwrap();
        assert_eq!(proposal.map, "duty=duty:255,angle=ticks:counts,speed=speed [rpm]:rpm");
        let counts: f64 = proposal.counts_per_rev.unwrap().parse().unwrap();
        assert!((counts - 1320.0).abs() < 15.0 && proposal.rate.is_none(), "{counts}");
    }

    #[test]
    fn numbers_behind_stamps_need_no_rate() {
        let mut bare = sample("a;b;c");
        (bare.names, bare.with_units) = (Vec::new(), Vec::new());
        let proposal = propose_for(&bare).unwrap();
        assert!(proposal.map.starts_with("duty=0:255,angle=1:counts"), "{}", proposal.map);
        assert_eq!(proposal.rate, None);
        bare.rows.iter_mut().for_each(|row| row.truncate(2));
        let proposal = propose_for(&bare).unwrap();
        assert_eq!((proposal.map.as_str(), proposal.rate), ("duty=0:255,angle=1:counts", None));
    }
}
