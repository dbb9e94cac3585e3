//! Which column of a table without names is what, by the course of its numbers alone. It is a guess, and said to be one.
//!
//! What rises evenly is the time. Where one column is the change of another, they are speed and angle. What drives the motor has few
//! values beside what the motor does, and what is made of other columns (an error, a difference of two wheels) is none of them.

use super::columns::{Part, agree, unit_of};
use super::preview::range_of;
use super::{Proposal, Quantity, words, written};
use crate::log::motion::{correlation, peak, span};
use crate::log::timing::{jitter, median, median_interval};

/// Rows that tell a course.
const FEWEST: usize = 20;
/// More columns than this are not compared with each other.
const MOST: usize = 16;
/// Share of its steps that rise in a clock, and of those that are about as long as the middle one; a file may hold two recordings.
const RISES: f64 = 0.95;
const EVEN: f64 = 0.8;
/// How alike a speed and the change of its angle are, more than a speed and what drives it.
const ONE_MOTION: f64 = 0.98;
/// So many parts of a record are looked at for that.
const PART: usize = 20;
/// What parts a column from one that is made of others, in shares of its span.
const MADE: f64 = 1e-3;
/// The highest voltage of whole numbers, and of any.
const WHOLE_VOLTS: f64 = 30.0;
const VOLTS: f64 = 60.0;

/// What the columns of numbers may be.
pub(super) fn parts(rows: &[Vec<f64>]) -> Vec<Part> {
    let columns = columns(rows);
    let Some(found) = Found::in_columns(&columns) else { return Vec::new() };
    let mut parts = Vec::new();
    let mut add = |quantity: Quantity, index: Option<usize>| {
        let Some(index) = index else { return };
        let unit = unit_of(quantity, None, &columns[index]);
        // As where a name leaves it open, times in whole numbers may be of any unit.
        let whole = || columns[index].iter().all(|value| value.fract() == 0.0);
        let guessed =
            [Quantity::Angle, Quantity::Speed].contains(&quantity) || quantity == Quantity::Time && whole();
        parts.push(Part { quantity, index, rest: None, unit, guessed, turn: None });
    };
    add(Quantity::Time, found.time);
    add(drive_of(&columns[found.drive]), Some(found.drive));
    add(Quantity::Angle, found.angle);
    add(Quantity::Speed, found.speed);
    let said: Vec<words::Said> = columns.iter().map(|_| words::said("")).collect();
    let turn = agree(&mut parts, &said, rows);
    if let Some(angle) = parts.iter_mut().find(|part| part.quantity == Quantity::Angle) {
        angle.turn = turn;
    }
    parts
}

/// Options that read a table without names, and what else its columns hold.
pub(in crate::log) fn propose(rows: &[Vec<f64>]) -> Option<Proposal> {
    let parts = parts(rows);
    if parts.is_empty() {
        return None;
    }
    let names: Vec<String> = (0..columns(rows).len()).map(|k| k.to_string()).collect();
    let mut proposal = written(&names, &parts, rows, false);
    let unused = (0..names.len()).filter(|k| parts.iter().all(|part| part.index != *k));
    proposal.preview.extend(unused.map(|k| format!("{:<8} {}", "unused", range_of(rows, k))));
    proposal.unknown_units.insert(
        0,
        "the columns have no names, so this is a guess by their numbers alone: compare it below".into(),
    );
    Some(proposal)
}

/// What is known of columns that are not understood: the one that may be the time, and the range of each.
pub(in crate::log) fn described(rows: &[Vec<f64>]) -> String {
    let columns = columns(rows);
    let time =
        clock(&columns).map(|k| format!("column {k} rises evenly and may be the time; ")).unwrap_or_default();
    let ranges: Vec<String> = (0..columns.len().min(MOST)).map(|k| range_of(rows, k)).collect();
    format!("{time}the columns hold {}", ranges.join(", "))
}

/// The columns of the rows that are complete.
fn columns(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let mut widths: Vec<f64> = rows.iter().map(|row| row.len() as f64).collect();
    let width = median(&mut widths) as usize;
    let complete = |row: &&Vec<f64>| row.len() >= width && row[..width].iter().all(|value| value.is_finite());
    let complete: Vec<&Vec<f64>> = rows.iter().filter(complete).collect();
    (0..width).map(|k| complete.iter().map(|row| row[k]).collect()).collect()
}

/// The places of what is found.
struct Found {
    time: Option<usize>,
    drive: usize,
    angle: Option<usize>,
    speed: Option<usize>,
}

impl Found {
    fn in_columns(columns: &[Vec<f64>]) -> Option<Found> {
        if columns.len() > MOST || columns.first()?.len() < FEWEST {
            return None;
        }
        let time = clock(columns);
        let free = |k: &usize| Some(*k) != time && !numbers_rows(&columns[*k]) && span(&columns[*k]) > 0.0;
        let candidates: Vec<usize> =
            (0..columns.len()).filter(free).filter(|k| !is_made(columns, *k)).collect();
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
        // A motion has to be left too.
        let driving = if chosen.is_none() && rest.len() < 2 { None } else { levels(columns, &rest) };
        let drive = driving.or(constant)?;
        let (angle, speed) = match chosen {
            Some((angle, speed)) => (Some(angle), Some(speed)),
            None => {
                let motion = rest.iter().copied().find(|k| *k != drive)?;
                if is_speed(&columns[drive], &columns[motion]) {
                    (None, Some(motion))
                } else {
                    (Some(motion), None)
                }
            }
        };
        Some(Found { time, drive, angle, speed })
    }
}

/// The column that rises most evenly, but for one that numbers the rows.
fn clock(columns: &[Vec<f64>]) -> Option<usize> {
    let unevenness = |values: &Vec<f64>| {
        let middle = median_interval(values);
        let steps = || values.windows(2).map(|pair| pair[1] - pair[0]);
        let share = |holds: &dyn Fn(f64) -> bool| {
            steps().filter(|step| holds(*step)).count() as f64 / (values.len() - 1).max(1) as f64
        };
        let is_clock = middle > 0.0
            && share(&|step| step > 0.0) >= RISES
            && share(&|step| (0.5 * middle..=2.0 * middle).contains(&step)) >= EVEN;
        is_clock.then(|| jitter(values) / middle)
    };
    let clocks =
        columns.iter().enumerate().filter(|(_, values)| values.len() >= FEWEST && !numbers_rows(values));
    let clocks = clocks.filter_map(|(k, values)| Some((k, unevenness(values)?)));
    clocks.min_by(|one, other| one.1.total_cmp(&other.1)).map(|(k, _)| k)
}

/// Whether a column counts the rows.
fn numbers_rows(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] - pair[0] == 1.0)
}

/// Whether column `k` is one before it once more, or what is missing of it to a target, or the difference of two.
fn is_made(columns: &[Vec<f64>], k: usize) -> bool {
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

/// How alike the way by `angle` and by `speed` are, over so many rows that a count more or less does not matter. A speed that is the
/// difference to the row before has none for the first.
fn is_change(angle: &[f64], speed: &[f64], time: Option<&Vec<f64>>) -> f64 {
    let rows = (speed.len() / PART).max(2) + 1;
    let way: Vec<f64> = angle.windows(rows).map(|part| part[rows - 1] - part[0]).collect();
    let since_before = |k: usize| time.map_or(1.0, |time| time[k] - time[k - 1]);
    let by_speed =
        (0..way.len()).map(|from| (from + 1..from + rows).map(|k| speed[k] * since_before(k)).sum());
    correlation(&way, &by_speed.collect::<Vec<f64>>())
}

/// The column that has the fewest values.
fn levels(columns: &[Vec<f64>], among: &[usize]) -> Option<usize> {
    let different = |k: usize| {
        let mut values = columns[k].clone();
        values.sort_by(f64::total_cmp);
        values.dedup();
        values.len()
    };
    among.iter().copied().min_by_key(|k| different(*k))
}

/// Whether a motion follows its drive as a speed does: an angle goes on while the drive holds.
fn is_speed(drive: &[f64], motion: &[f64]) -> bool {
    const SHARES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];
    let change: Vec<f64> = motion.windows(2).map(|pair| pair[1] - pair[0]).collect();
    let alike = |values: &[f64]| {
        let smoothed = |share: f64| {
            let mut state = drive[0];
            let late: Vec<f64> = drive
                .iter()
                .map(|v| {
                    state += share * (v - state);
                    state
                })
                .collect();
            correlation(&late[late.len() - values.len()..], values).abs()
        };
        SHARES.into_iter().map(smoothed).fold(0.0, f64::max)
    };
    if span(drive) > 0.0 {
        return alike(motion) > alike(&change);
    }
    // Under one voltage a speed settles.
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
    fn what_is_made_of_other_columns_and_the_number_of_a_row_are_none_of_them() {
        let row = |k: f64| {
            vec![k, duty(k), angle(k), 135.0 - angle(k), 2.0 * angle(k) + k.sin(), angle(k) + k.sin()]
        };
        assert_eq!(map(row), "duty=1:100,angle=2:rad");
        let rows: Vec<Vec<f64>> = (0..200).map(|k| row(f64::from(k))).collect();
        let proposal = propose(&rows).unwrap();
        assert_eq!((proposal.rate.as_deref(), proposal.preview.len()), (Some("100"), 6));
        assert!(
            proposal.assumptions().starts_with("the columns have no names"),
            "{}",
            proposal.assumptions()
        );
    }

    #[test]
    fn where_nothing_drives_a_motion_the_columns_are_described() {
        let rows: Vec<Vec<f64>> = (0..60).map(|k| vec![f64::from(k) * 0.01, f64::from(k * k)]).collect();
        assert_eq!(propose(&rows), None);
        assert!(described(&rows).starts_with("column 0 rises evenly"), "{}", described(&rows));
    }
}
