//! Which column of a table without names is what, by the course of its numbers alone. It is a guess, and said to be one.
//!
//! What rises evenly is the time. Where one column is the change of another, they are speed and angle. What drives the motor has few
//! values beside what the motor does, and what is made of other columns (an error, a difference of two wheels) is none of them. Where some
//! columns have names, one that is called a time goes before another that rises, and a voltage's or a speed's letter is that of no time.

mod control;
mod rising;
mod undriven;

pub(in crate::log) use undriven::described;

use control::Compared;
use rising::{clock, joined, seconds_apart, stands_beside_row_numbers};

use super::clocks::{is_open_time, plausible};
use super::column_units::unit_of;
use super::columns::Part;
use super::leads::{self, ONE_MOTION, comes_before, is_change, is_speed_of, move_together, only_rises};
use super::one_motion::make_one;
use super::preview::range_of;
use super::{Proposal, Quantity, symbols, words, written};
use crate::log::motion::{different, peak, span};
use crate::log::numbered::counts_rows;
use crate::log::timing::median;

/// Rows that tell a course.
const FEWEST: usize = 20;
/// More columns than this are not compared with each other.
pub(super) const MOST: usize = 16;
/// What parts a column from one that is made of others, in shares of its span.
const MADE: f64 = 1e-3;
/// A column has a number in so many of the rows.
const FILLED: f64 = 0.8;
/// The highest voltage of whole numbers, and of any.
const WHOLE_VOLTS: f64 = 30.0;
pub(super) const VOLTS: f64 = 60.0;

/// What the columns of numbers may be; `names` are theirs, as far as they have any.
pub(super) fn parts(names: &[String], rows: &[Vec<f64>]) -> Vec<Part> {
    let columns = columns(rows);
    let apart = seconds_apart(&columns);
    let columns = apart.map(|seconds| joined(&columns, seconds)).unwrap_or(columns);
    let Some(found) = Found::in_columns(&columns, names) else { return Vec::new() };
    let mut parts = Vec::new();
    let mut add = |quantity: Quantity, index: Option<usize>| {
        let Some(index) = index else { return };
        let named = names.get(index).filter(|_| quantity == Quantity::Time);
        let told = named.and_then(|name| words::said(name).unit);
        let told = told.filter(|unit| plausible(quantity, unit, &columns[index]).is_none());
        let unit = unit_of(quantity, told, &columns[index]);
        let of_time = || quantity == Quantity::Time && told.is_none() && is_open_time(&unit, &columns[index]);
        let is_open = [Quantity::Duty, Quantity::Angle, Quantity::Speed].contains(&quantity);
        let guessed = is_open || of_time();
        parts.push(Part { quantity, index, rest: None, unit, guessed, turn: None });
    };
    add(Quantity::Time, found.time);
    add(drive_of(&columns[found.drive]), Some(found.drive));
    add(Quantity::Angle, found.angle);
    // Beside an angle without a clock it may be the change from row to row: only the rate would tell its unit.
    add(Quantity::Speed, found.speed.filter(|_| found.time.is_some() || found.angle.is_none()));
    let of_both = parts.iter_mut().find(|part| part.quantity == Quantity::Time && Some(part.index) == apart);
    if let (Some(time), Some(seconds)) = (of_both, apart) {
        *time = Part { rest: Some(seconds + 1), unit: "ns".into(), guessed: false, ..time.clone() };
    }
    let said: Vec<words::Said> = columns.iter().map(|_| words::said("")).collect();
    make_one(&mut parts, &said, rows);
    parts
}

/// Options that read a table without names of these `parts`, and what else its columns hold; `stamped` says that the lines carry times of their own.
pub(super) fn propose_with(parts: &[Part], rows: &[Vec<f64>], stamped: bool) -> Option<Proposal> {
    if parts.is_empty() {
        return None;
    }
    let names: Vec<String> = (0..columns(rows).len()).map(|k| k.to_string()).collect();
    let mut proposal = written(&names, parts, rows, stamped);
    let unused =
        (0..names.len()).filter(|k| parts.iter().all(|part| part.index != *k && part.rest != Some(*k)));
    proposal.preview.extend(unused.map(|k| format!("{:<8} {}", "unused", range_of(rows, k))));
    proposal.unknown_units.insert(
        0,
        "no name tells what a column holds, so this is a guess by their numbers alone: compare it below"
            .into(),
    );
    Some(proposal)
}

/// The same of rows that nothing else is known of.
#[cfg(test)]
fn propose(rows: &[Vec<f64>]) -> Option<Proposal> {
    propose_with(&parts(&[], rows), rows, false)
}

/// The columns of the rows that are complete; one that is blank in many of them tells nothing and changes nowhere.
pub(super) fn columns(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut widths: Vec<f64> = rows.iter().map(|row| row.len() as f64).collect();
    let width = median(&mut widths) as usize;
    let value = |row: &Vec<f64>, k: usize| row.get(k).copied().filter(|value| value.is_finite());
    let told = |k: usize| rows.iter().filter(|row| value(row, k).is_some()).count() as f64;
    let is_blank: Vec<bool> = (0..width).map(|k| told(k) < FILLED * rows.len() as f64).collect();
    let complete = |row: &&Vec<f64>| (0..width).all(|k| is_blank[k] || value(row, k).is_some());
    let complete: Vec<&Vec<f64>> = rows.iter().filter(complete).collect();
    let column = |k: usize| complete.iter().map(|row| if is_blank[k] { 0.0 } else { row[k] }).collect();
    (0..width).map(column).collect()
}

/// The places of what is found.
struct Found {
    time: Option<usize>,
    drive: usize,
    angle: Option<usize>,
    speed: Option<usize>,
}

impl Found {
    fn in_columns(columns: &[Vec<f64>], names: &[String]) -> Option<Found> {
        if columns.len() > MOST || columns.first()?.len() < FEWEST {
            return None;
        }
        let time = clock(columns, names);
        let is_count = time
            .is_some_and(|k| stands_beside_row_numbers(columns, k) && candidates(columns, time).is_empty());
        let time = time.filter(|_| !is_count);
        let found = Found::by_clock(columns, names, time, None)?;
        match Compared::in_columns(columns) {
            Some(compared) if found.is_driven_by(compared) => {
                Found::by_clock(columns, names, time, Some(compared))
            }
            _ => Some(found),
        }
    }

    fn is_driven_by(&self, compared: Compared) -> bool {
        [compared.set_point, compared.measured].contains(&self.drive)
    }

    /// What is found beside a clock, or without one; what a controller compares does not drive, and of the two only one was measured.
    fn by_clock(
        columns: &[Vec<f64>],
        names: &[String],
        time: Option<usize>,
        compared: Option<Compared>,
    ) -> Option<Found> {
        let mut candidates = candidates(columns, time);
        candidates.retain(|k| compared.is_none_or(|compared| compared.set_point != *k));
        let constant = (0..columns.len()).find(|k| span(&columns[*k]) == 0.0 && columns[*k][0] != 0.0);
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for &angle in &candidates {
            let speeds = candidates.iter().filter(|speed| **speed != angle);
            pairs.extend(speeds.map(|&speed| {
                (is_change(&columns[angle], &columns[speed], time.map(|k| &columns[k])), angle, speed)
            }));
        }
        pairs.retain(|(alike, ..)| *alike > ONE_MOTION);
        pairs.sort_by(|one, other| other.0.total_cmp(&one.0));
        // Every column is of one pair, and something has to be left that drives the motor.
        let (mut moving, mut chosen) = (Vec::new(), None);
        for (_, angle, speed) in pairs {
            let leaves = candidates.len() - moving.len() > 2 || constant.is_some();
            if leaves && !moving.contains(&angle) && !moving.contains(&speed) {
                moving.extend([angle, speed]);
                chosen = chosen.or(Some((angle, speed)));
            }
        }
        let rest: Vec<usize> = candidates.iter().copied().filter(|k| !moving.contains(k)).collect();
        let motions = motions(columns, &candidates, time);
        let is_motion = |k: usize| motions.iter().any(|(angle, speed)| [*angle, *speed].contains(&k));
        // Without a clock what rises in every row is the time of an event, or its number.
        let is_event = |k: usize| time.is_none() && only_rises(&columns[k]);
        let is_called_speed = |k: usize| names.get(k).is_some_and(|name| symbols::is_of_speed(name));
        let is_measured = |k: usize| compared.is_some_and(|compared| compared.measured == k);
        let may_drive =
            |k: &usize| !is_motion(*k) && !is_event(*k) && !is_called_speed(*k) && !is_measured(*k);
        let alike = |drive: usize, k: usize| move_together(&columns[drive], &columns[k]);
        let driving = by_levels(columns, rest.iter().copied().filter(may_drive)).into_iter();
        let (drive, angle, speed) = match chosen {
            Some((angle, speed)) => {
                let drive = driving.chain(constant).find(|drive| !alike(*drive, speed))?;
                (drive, Some(angle), Some(speed))
            }
            None => {
                let moved = |drive: usize| {
                    let motion = rest.iter().copied().find(|k| *k != drive && !alike(drive, *k))?;
                    (!comes_before(&columns[motion], &columns[drive])).then_some((drive, motion))
                };
                let (drive, motion) = driving.chain(constant).find_map(moved)?;
                if is_speed(&columns[drive], &columns[motion]) {
                    (drive, None, Some(motion))
                } else {
                    (drive, Some(motion), None)
                }
            }
        };
        Some(Found { time, drive, angle, speed })
    }
}

/// Whether column `k` is one before it once more, or what is missing of it to a target, or the difference of two.
pub(super) fn is_made(columns: &[Vec<f64>], k: usize) -> bool {
    let own = &columns[k];
    let near = MADE * span(own);
    let is_constant = |of: &dyn Fn(usize) -> f64| span(&(0..own.len()).map(of).collect::<Vec<_>>()) <= near;
    let before: Vec<&Vec<f64>> = columns[..k].iter().filter(|other| span(other) > 0.0).collect();
    before.iter().enumerate().any(|(place, one)| {
        let is_other = is_constant(&|i| own[i] - one[i]) || is_constant(&|i| own[i] + one[i]);
        let is_difference = |other: &&&Vec<f64>| {
            is_constant(&|i| own[i] - (one[i] - other[i])) || is_constant(&|i| own[i] + (one[i] - other[i]))
        };
        is_other || before[place + 1..].iter().any(|other| is_difference(&other))
    })
}

/// The columns that are neither the time nor made of others, and change.
fn candidates(columns: &[Vec<f64>], time: Option<usize>) -> Vec<usize> {
    let free = |k: &usize| Some(*k) != time && !counts_rows(&columns[*k]) && span(&columns[*k]) > 0.0;
    (0..columns.len()).filter(free).filter(|k| !is_made(columns, *k)).collect()
}

/// The angles, each with its own speed, which drive nothing.
fn motions(columns: &[Vec<f64>], candidates: &[usize], time: Option<usize>) -> Vec<(usize, usize)> {
    let pairs = candidates.iter().flat_map(|&angle| candidates.iter().map(move |&speed| (angle, speed)));
    let is_pair = |(angle, speed): &(usize, usize)| {
        let is_event = time.is_none() && only_rises(&columns[*speed]);
        angle != speed
            && !is_event
            && is_speed_of(&columns[*speed], &columns[*angle], time.map(|k| &columns[k]))
    };
    pairs.filter(is_pair).collect()
}

/// The columns by how many different values they have, fewest first.
fn by_levels(columns: &[Vec<f64>], among: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut sorted: Vec<usize> = among.collect();
    sorted.sort_by_cached_key(|k| different(columns[*k].iter().copied()).len());
    sorted
}

/// Whether a motion is a speed by how it follows its drive; under one voltage a speed settles.
fn is_speed(drive: &[f64], motion: &[f64]) -> bool {
    if span(drive) > 0.0 {
        return leads::is_speed(drive, motion);
    }
    let change = leads::change(motion);
    let fifth = (change.len() / 5).max(1);
    let last = change[change.len() - fifth..].iter().sum::<f64>() / fifth as f64;
    let fastest =
        change.windows(fifth).map(|part| part.iter().sum::<f64>().abs() / fifth as f64).fold(0.0, f64::max);
    last.abs() < 0.5 * fastest
}

/// Whether what drives the motor is told in volts or as a duty.
fn drive_of(values: &[f64]) -> Quantity {
    let peak = peak(values);
    let whole = values.iter().all(|value| value.fract() == 0.0);
    let is_volts = peak > 1.2 && peak <= if whole { WHOLE_VOLTS } else { VOLTS };
    if is_volts { Quantity::Voltage } else { Quantity::Duty }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn map(row: impl Fn(f64) -> Vec<f64>) -> String {
        let rows: Vec<Vec<f64>> = (0..200).map(|k| row(f64::from(k))).collect();
        propose(&rows).map(|proposal| proposal.map).unwrap_or_default()
    }

    /// Levels of a duty and the speed that follows them.
    fn duty(k: f64) -> f64 {
        [100.0, -50.0, 0.0, 75.0][(k / 50.0) as usize % 4]
    }

    fn angle(k: f64) -> f64 {
        (0..k as u32)
            .map(|i| duty(f64::from(i)))
            .scan(0.0, |w, u| {
                *w += 0.1 * (0.1 * u - *w);
                Some(*w)
            })
            .sum()
    }

    #[test]
    fn time_drive_angle_and_speed_are_told_by_their_numbers_in_any_order() {
        let speed = |k: f64| 50.0 * (angle(k + 1.0) - angle(k - 1.0));
        assert_eq!(
            map(|k| vec![duty(k), angle(k), 0.01 * k, speed(k)]),
            "time=2:s,duty=0:100,angle=1:rad,speed=3:rad/s"
        );
        // A jitter, and two recordings in one file.
        let time = |k: f64| 0.01 * (k % 100.0) + 0.002 * (k * k).sin();
        assert_eq!(map(|k| vec![time(k), duty(k), angle(k)]), "time=0:s,duty=1:100,angle=2:rad");
        assert_eq!(map(|k| vec![10.0 * k, duty(k), speed(k)]), "time=0:ms,duty=1:100,speed=2:rad/s");
    }

    #[test]
    fn seconds_and_nanoseconds_in_two_columns_are_one_time() {
        let stamp = |k: f64| [1.7e9 + (k / 100.0).floor(), 1e7 * (k % 100.0)];
        let row = |k: f64| vec![stamp(k)[0], stamp(k)[1], f64::NAN, angle(k), duty(k)];
        assert_eq!(map(row), "time=0+1:ns,duty=4:100,angle=3:rad");
    }

    #[test]
    fn what_is_made_of_other_columns_and_the_number_of_a_row_are_none_of_them() {
        let row = |k: f64| {
            vec![k, duty(k), angle(k), 135.0 - angle(k), 2.0 * angle(k) + k.sin(), angle(k) + k.sin()]
        };
        assert_eq!(map(row), "duty=1:100,angle=2:rad");
        let change = |k: f64| angle(k) - angle((k - 1.0).max(0.0));
        assert_eq!(
            map(|k| vec![k, duty(k), angle(k), change(k)]),
            "duty=1:100,angle=2:rad",
            "no clock tells its unit"
        );
        let rows: Vec<Vec<f64>> = (0..200).map(|k| row(f64::from(k))).collect();
        let proposal = propose(&rows).unwrap();
        assert_eq!((proposal.rate.as_deref(), proposal.preview.len()), (Some("100"), 6));
        assert!(
            proposal.assumptions().starts_with("no name tells what a column holds"),
            "{}",
            proposal.assumptions()
        );
    }

    /// A position loop whose drive is at one end or the other, from 0 to 135 degrees in whole numbers.
    #[test]
    fn an_angle_that_swings_under_a_switching_drive_is_no_speed() {
        let (mut x, mut w) = (0.0_f64, 0.0);
        let rows: Vec<Vec<f64>> = (0..200)
            .map(|_| {
                let u = (10.0 * (135.0 - x).round()).clamp(-100.0, 100.0);
                let row = vec![u, x.round(), 135.0 - x.round()];
                w += 0.01 * (0.1 * u - w);
                x += w;
                row
            })
            .collect();
        assert_eq!(propose(&rows).unwrap().map, "duty=0:100,angle=1:deg");
    }

    #[test]
    fn a_count_that_rises_evenly_beside_the_number_of_a_row_is_no_time() {
        assert_eq!(map(|k| vec![k, 64.0, (2.6 * (k - 3.0).max(0.0)).floor()]), "duty=1:255,angle=2:deg");
        assert_eq!(map(|k| vec![k, 64.0, 10.0 * k]), "", "a clock, and nothing that moves");
    }

    /// Three runs at one level each, one after the other, in the order drive, time, speed, angle.
    #[test]
    fn several_runs_in_one_file_are_compared_run_by_run() {
        let row = |k: f64| {
            let (run, t) = ((k / 67.0).floor(), 0.01 * (k % 67.0));
            let u = [-100.0, -80.0, -60.0][run as usize];
            let (gone, settled) = (1.0 - (-t / 0.1).exp(), 11.0 * u);
            let angle = -4864.0 - 1100.0 * run + settled * (t - 0.1 * gone);
            vec![u, t, (settled * gone).round(), angle.round()]
        };
        let map = map(row);
        assert!(map.starts_with("time=1:s,duty=0:100,angle=3:") && map.contains(",speed=2:"), "{map}");
    }

    #[test]
    fn a_speed_that_no_unit_makes_that_of_the_angle_is_left_out() {
        let change = |k: f64| angle(k) - angle((k - 1.0).max(0.0));
        // Two tests, by a clock that begins anew.
        let map = map(|k| vec![10.0 * (k % 120.0), duty(k), angle(k), change(k)]);
        assert_eq!(map, "time=0:ms,duty=1:100,angle=2:rad");
    }

    #[test]
    fn a_column_that_is_blank_in_most_rows_hides_none_of_the_others() {
        let speed = |k: f64| 50.0 * (angle(k + 1.0) - angle(k - 1.0));
        let blank = |k: f64| if k == 0.0 { 7.0 } else { f64::NAN };
        assert_eq!(map(|k| vec![duty(k), blank(k), 0.01 * k, speed(k)]), "time=2:s,duty=0:100,speed=3:rad/s");
    }

    #[test]
    fn a_drive_comes_before_its_motion_however_many_values_it_has() {
        // A sweep, and an encoder that stands at first: fewer values, and no drive.
        let sweep = |k: f64| 0.8 * (3e-5 * k * k).sin();
        let turned = |k: f64| {
            let follows = |speed: &mut f64, i: u32| {
                *speed += 0.05 * ((sweep(f64::from(i)) - 0.1).max(0.0) - *speed);
                Some(*speed)
            };
            (30.0 * (0..k as u32).scan(0.0, follows).sum::<f64>()).round()
        };
        assert_eq!(map(|k| vec![0.005 * k, turned(k), sweep(k)]), "time=0:s,duty=2:1,angle=1:counts");
    }
}
