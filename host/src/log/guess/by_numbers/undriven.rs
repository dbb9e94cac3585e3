//! What is said of a table in which no column drives the motor.

use super::{FEWEST, MOST, candidates, clock, columns, motions};
use crate::log::guess::column_units::unit_of;
use crate::log::guess::leads::{move_together, only_rises};
use crate::log::guess::preview::range_of;
use crate::log::units::Quantity;

/// What is known of columns that are not understood: the one that may be the time, why none drives the motor, and the range of each.
pub(in crate::log) fn described(rows: &[Vec<f64>]) -> String {
    let columns = columns(rows);
    let time = clock(&columns, &[]);
    let ranges: Vec<String> = (0..columns.len().min(MOST)).map(|k| range_of(rows, k)).collect();
    let clock = time.map(|k| format!("column {k} rises evenly and may be the time; ")).unwrap_or_default();
    format!("{clock}{}the columns hold {}", no_drive(&columns, time), ranges.join(", "))
}

/// Why none of the columns drives the motor, as far as that is known, and what to do.
fn no_drive(columns: &[Vec<f64>], time: Option<usize>) -> String {
    if columns.len() > MOST || columns.first().is_none_or(|rows| rows.len() < FEWEST) {
        return String::new();
    }
    let candidates = candidates(columns, time);
    let motions = motions(columns, &candidates, time);
    let mut known: Vec<String> = motions
        .iter()
        .map(|(angle, speed)| format!("column {speed} is the speed of column {angle}"))
        .collect();
    let alike = |k: usize, j: usize| move_together(&columns[k], &columns[j]);
    let together = candidates.iter().copied().filter(|&k| candidates.iter().any(|&j| j != k && alike(k, j)));
    let together: Vec<String> = together.map(|k| k.to_string()).collect();
    if motions.is_empty() && !together.is_empty() {
        known.push(format!("columns {} move at once, none before another", together.join(", ")));
    }
    if time.is_none() {
        let rising = candidates.iter().filter(|k| only_rises(&columns[**k]));
        known.extend(rising.map(|k| format!("column {k} only rises (a time? a count?)")));
    }
    if let (Some(_), [only]) = (time, candidates.as_slice()) {
        known.push(format!("beside it there is only column {only}"));
    }
    if known.is_empty() {
        return String::new();
    }
    let all_the_same = motions.first().map(|(angle, speed)| {
        let clock = time.map(|k| format!("time={k}:{},", unit_of(Quantity::Time, None, &columns[k])));
        let rate = if time.is_none() { " --rate 100" } else { "" };
        let clock = clock.unwrap_or_default();
        format!(" (if column {speed} does, say --map {clock}voltage={speed}:V,angle={angle}:rad{rate})")
    });
    format!(
        "{}: no column drives the motor{}, so log its voltage or duty in every row{}; ",
        known.join(", "),
        all_the_same.unwrap_or_default(),
        if candidates.len() == 1 { " (or give a file of each as drive.csv+motion.csv)" } else { "" }
    )
}

#[cfg(test)]
mod tests {
    use super::super::propose;
    use super::*;

    #[test]
    fn where_nothing_drives_a_motion_the_columns_are_described_and_why_none_does() {
        let settles = |k: f64| 50.0 * (1.0 - (-k / 15.0).exp());
        let way = |k: f64| 0.5 * (k - 15.0 * (1.0 - (-k / 15.0).exp()));
        let noise = |k: f64| 0.2 * (k * k).sin();
        for (row, why) in [
            (&(|k| vec![0.01 * k, k * k]) as &dyn Fn(f64) -> Vec<f64>, "beside it there is only column 1"),
            (&|k| vec![0.01 * k, way(k), settles(k) + noise(k)], "column 2 is the speed of column 1"),
            (&|k| vec![0.01 * k, settles(k), way(k)], "voltage=1:V,angle=2:rad"),
            (&|k| vec![settles(k) + noise(k), settles(k) + noise(k + 7.0)], "columns 0, 1 move at once"),
            // An event, and its number.
            (&|k| vec![(5e6 + 4e4 * (k + 1.0).ln()).floor(), 1.0 + k * k], "column 0 only rises"),
        ] {
            let rows: Vec<Vec<f64>> = (0..200).map(|k| row(f64::from(k))).collect();
            assert!(propose(&rows).is_none(), "{why}");
            let said = described(&rows);
            assert!(said.contains(why) && said.contains("no column drives the motor"), "{why}: {said}");
        }
    }
}
