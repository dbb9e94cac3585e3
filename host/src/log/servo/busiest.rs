//! What of long servo logs tells a controller: the parts in which the target moves most.
//!
//! Thousands of controllers are tried, and each goes through every row that it is given. Most rows of a long log add nothing: it goes on with what
//! it began with, or waits. So of more rows than tell a controller those are searched in which the target goes furthest, whichever record they
//! are of; what is found drives all rows.

use std::ops::Range;

use super::driven::filtered_speed;
use crate::log::Record;
use crate::log::repair::{leave_out, part};
use crate::log::timing::median_interval;

/// Most rows that are searched, of all records together.
const MOST: usize = 4_000;
/// A stretch has so many rows, or as many as come in this time, s: several moves of a servo.
const STRETCH: usize = 500;
const SHORTEST_S: f64 = 1.0;
/// So many rows before a stretch belong to it: what the target did there may arrive late.
const BEFORE: usize = 20;
/// Of rows that come faster than this, s, some are left out: a loop is slower.
const FAST_S: f64 = 1e-3;

/// A part of a record that is searched.
pub(super) struct Stretch {
    pub record: Record,
    /// How fast the shaft turns at its first row, rad/s.
    pub speed: f64,
}

/// The stretches of `records` that tell their controller: all of them where they are short.
pub(super) fn busiest(records: &[Record]) -> Vec<Stretch> {
    if rows_of(records) <= MOST {
        return whole(records);
    }
    let slower: Vec<Record> = records.iter().map(not_too_fast).collect();
    if rows_of(&slower) <= MOST {
        return whole(&slower);
    }
    let mut found: Vec<(f64, usize, Range<usize>)> = Vec::new();
    for (number, record) in slower.iter().enumerate() {
        found.extend(stretches(record).into_iter().map(|(way, rows)| (way, number, rows)));
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut left = MOST;
    found.retain(|(.., rows)| {
        let is_taken = rows.len() <= left;
        left -= if is_taken { rows.len() } else { 0 };
        is_taken
    });
    found.sort_by_key(|(_, number, rows)| (*number, rows.start));
    let mut taken: Vec<(usize, Range<usize>)> = Vec::new();
    for (_, number, rows) in found {
        let from = rows.start.saturating_sub(BEFORE);
        match taken.last_mut() {
            Some((last, before)) if *last == number && before.end >= from => before.end = rows.end,
            _ => taken.push((number, from..rows.end)),
        }
    }
    taken.into_iter().map(|(number, rows)| Stretch::of(&slower[number], rows)).collect()
}

impl Stretch {
    fn of(record: &Record, rows: Range<usize>) -> Self {
        // A record begins at rest.
        let speed = if rows.start == 0 { 0.0 } else { filtered_speed(record)[rows.start] };
        Self { record: part(record, rows, 1), speed }
    }
}

/// All rows of `records`.
pub(super) fn whole(records: &[Record]) -> Vec<Stretch> {
    records.iter().map(|record| Stretch { record: record.clone(), speed: 0.0 }).collect()
}

fn rows_of(records: &[Record]) -> usize {
    records.iter().map(Record::len).sum()
}

/// `record` with every so many of its rows that a loop is not much slower.
fn not_too_fast(record: &Record) -> Record {
    let every = (FAST_S / median_interval(&record.time_s)).round() as usize;
    let mut slower = record.clone();
    if every > 1 {
        leave_out(&mut slower, |k| !k.is_multiple_of(every));
    }
    slower
}

/// The stretches that `record` falls into, each with how far its target goes.
fn stretches(record: &Record) -> Vec<(f64, Range<usize>)> {
    let Some(servo) = &record.servo else { return Vec::new() };
    let rows = (SHORTEST_S / median_interval(&record.time_s)).ceil() as usize;
    let starts = (0..record.len()).step_by(rows.max(STRETCH));
    let of = |start: usize| {
        let end = (start + rows.max(STRETCH)).min(record.len());
        // The step that leads to its first row is one of it.
        let target = &servo.target_rad[start.saturating_sub(1)..end];
        (target.windows(2).map(|pair| (pair[1] - pair[0]).abs()).sum::<f64>(), start..end)
    };
    starts.map(of).collect()
}

#[cfg(test)]
mod tests {
    use super::super::Servo;
    use super::*;

    /// A servo whose target is this, and whose shaft is there at once.
    fn servo(rows: usize, interval_s: f64, target: impl Fn(f64) -> f64) -> Record {
        let time_s: Vec<f64> = (0..rows).map(|k| k as f64 * interval_s).collect();
        let target_rad: Vec<f64> = time_s.iter().map(|t| target(*t)).collect();
        let (angle_rad, voltage_v) = (Some(target_rad.clone()), vec![0.0; rows]);
        let servo = Some(Servo { target_rad, gain: None, damping: None });
        Record { time_s, voltage_v, angle_rad, servo, ..Record::default() }
    }

    #[test]
    fn short_logs_are_searched_as_they_are() {
        let records = [servo(2_000, 1e-4, f64::sin), servo(2_000, 0.01, f64::sin)];
        let found = busiest(&records);
        assert!(found.iter().zip(&records).all(|(one, record)| one.record == *record && one.speed == 0.0));
    }

    #[test]
    fn of_logs_that_wait_the_moves_are_searched_with_what_was_before_them() {
        // A step every 30 s, and nothing in the other log.
        let steps = servo(60_000, 0.01, |t| ((t + 1e-6) / 30.0).floor() % 2.0);
        let found = busiest(&[servo(60_000, 0.01, |_| 0.0), steps]);
        let rows: usize = found.iter().map(|one| one.record.len()).sum();
        assert!(
            rows <= MOST + found.len() * BEFORE && found.len() == MOST / STRETCH,
            "{rows} {}",
            found.len()
        );
        for one in &found {
            let target = &one.record.servo.as_ref().unwrap().target_rad;
            assert!(target[0] != target[BEFORE], "from {} s", one.record.time_s[0]);
        }
    }

    #[test]
    fn a_stretch_amid_a_motion_has_its_speed_and_neighbours_are_one() {
        // It goes to and fro all the time from 500 s on.
        let moves = |t: f64| if t < 500.0 { 0.0 } else { (0.5 * t).sin() };
        let found = busiest(&[servo(100_000, 0.01, moves)]);
        assert!(found.iter().all(|one| one.record.time_s[0] >= 499.0));
        let speed = |one: &Stretch| 0.5 * (0.5 * one.record.time_s[0]).cos();
        let is_right = |one: &Stretch| (one.speed - speed(one)).abs() < 0.02 || one.record.time_s[0] < 501.0;
        assert!(found.iter().all(is_right), "{:?}", found.iter().map(|one| one.speed).collect::<Vec<_>>());
        assert!(found.windows(2).all(|pair| pair[0].record.time_s.last() < pair[1].record.time_s.first()));
    }

    #[test]
    fn rows_that_come_faster_than_a_loop_answers_are_left_out() {
        let found = busiest(&[servo(30_000, 1e-4, f64::sin)]);
        assert!(found.len() == 1 && found[0].record.len() == 3_000);
        assert!((median_interval(&found[0].record.time_s) - FAST_S).abs() < 1e-9);
    }
}
