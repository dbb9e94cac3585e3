//! Which column cannot drive a motor: what drives it comes before its motion, and that is told from the numbers alone.
//!
//! A speed is the change of its angle at once, and two wheels start together: neither comes before the other, so neither drives it.

use crate::log::motion::{correlation, ends, peak};

/// How alike a speed and the change of its angle are, more than a speed and what drives it.
pub(super) const ONE_MOTION: f64 = 0.98;
/// So alike are numbers of which one was made of the other.
pub(super) const EXACTLY: f64 = 0.9999;
/// A motion that comes later than its drive is so much more like the late drive, as a share of what is unlike at once.
const CLEARLY: f64 = 0.8;
/// A course that looks the same a row later leaves this of the difference.
const ROUNDING: f64 = 1e-9;
/// What is unlike in the one order, as a share of what is in the other.
const FAR_LESS: f64 = 0.5;
/// What holds its value in this share of the rows was commanded.
const HELD: f64 = 0.8;
/// So many parts of a record are looked at for a change.
const PART: usize = 20;
/// Shares of a step that a motion has gone after one row.
const SHARES: [f64; 4] = [1.0, 0.3, 0.1, 0.03];

/// Whether `speed` is the speed of `angle`, and not what drives it.
pub(super) fn is_speed_of(speed: &[f64], angle: &[f64], time: Option<&Vec<f64>>) -> bool {
    comes_together(speed, &|speed| is_change(angle, speed, time))
}

/// Whether two motions are alike and neither comes before the other.
pub(super) fn move_together(one: &[f64], other: &[f64]) -> bool {
    comes_together(one, &|one| correlation(one, other))
        && comes_together(other, &|other| correlation(other, one))
}

/// Whether a column agrees with a motion at once, and no better where it comes before it.
fn comes_together(column: &[f64], agrees: &dyn Fn(&[f64]) -> f64) -> bool {
    let at_once = agrees(column);
    let held = column.windows(2).filter(|pair| pair[0] == pair[1]).count() as f64;
    if at_once <= ONE_MOTION || held >= HELD * column.len() as f64 && at_once <= EXACTLY {
        return false;
    }
    let a_row_before: Vec<f64> =
        column.first().into_iter().chain(column).copied().take(column.len()).collect();
    let before = late(column).skip(1).map(|late| agrees(&late)).fold(agrees(&a_row_before), f64::max);
    1.0 - before > CLEARLY * (1.0 - at_once) - ROUNDING
}

/// Whether a column rises from each row to the next, as the time of an event and its number do.
pub(super) fn only_rises(values: &[f64]) -> bool {
    values.windows(2).all(|pair| pair[1] > pair[0])
}

/// How alike the way by `angle` and by `speed` are, over so many rows that a count more or less does not matter. A speed that is the
/// difference to the row before has none for the first. Where the clock begins anew, another run does: no way leads from one to the other.
pub(super) fn is_change(angle: &[f64], speed: &[f64], time: Option<&Vec<f64>>) -> f64 {
    let rows = (speed.len() / PART).max(2) + 1;
    let since_before = |k: usize| time.map_or(1.0, |time| time[k] - time[k - 1]);
    let is_one_run = |from: &usize| (from + 1..from + rows).all(|k| since_before(k) >= 0.0);
    let begins: Vec<usize> = (0..(angle.len() + 1).saturating_sub(rows)).filter(is_one_run).collect();
    let way: Vec<f64> = begins.iter().map(|from| angle[from + rows - 1] - angle[*from]).collect();
    let by_speed =
        begins.iter().map(|from| (from + 1..from + rows).map(|k| speed[k] * since_before(k)).sum());
    correlation(&way, &by_speed.collect::<Vec<f64>>())
}

/// Whether a motion follows its drive as a speed does: an angle goes on while the drive holds, and for a while after it was reversed.
pub(super) fn is_speed(drive: &[f64], motion: &[f64]) -> bool {
    !goes_on(drive, motion) && most(&alike(drive, motion)) > most(&alike(drive, &change(motion)))
}

/// A drive is reversed from this share of the highest one way to as much the other way, within so many rows.
const REVERSED: f64 = 0.3;
const REVERSED_WITHIN: usize = 4;
/// A motion goes on by this share of its span, in most reversals, of so many or more.
const GOES_ON: f64 = 0.05;
const FEWEST_REVERSALS: usize = 2;

/// Whether a motion goes on as before although its drive was reversed: an angle does while the shaft still turns, and a speed falls at once.
///
/// Under a controller that switches its drive from one end to the other an angle swings as evenly as a speed would, and nothing else tells.
fn goes_on(drive: &[f64], motion: &[f64]) -> bool {
    let full = REVERSED * peak(drive);
    let (low, high) = ends(motion);
    // A drive does work on what it turns, and accelerates it: which way is forth.
    let along: f64 = change(motion).iter().zip(drive).map(|(change, u)| change * u).sum();
    let (mut way, mut pushed, mut on) = (0.0_f64, 0, Vec::new());
    for k in 0..drive.len() {
        if drive[k].abs() < full {
            continue;
        }
        if way * drive[k] < 0.0 && k - pushed <= REVERSED_WITHIN {
            // By the first row of the new drive the old one has acted to its end.
            let until = (k + 1..drive.len()).find(|i| drive[*i] * drive[k] <= 0.0).unwrap_or(drive.len());
            let further = motion[k..until].iter().map(|x| (x - motion[k]) * way.signum() * along.signum());
            on.push(further.fold(0.0, f64::max));
        }
        (way, pushed) = (drive[k], k);
    }
    let far = on.iter().filter(|on| **on > GOES_ON * (high - low)).count();
    on.len() >= FEWEST_REVERSALS && 2 * far > on.len()
}

/// Whether `driven` goes after `drive`, and `drive` far less after `driven`; a controller's answer comes at once.
pub(super) fn comes_before(drive: &[f64], driven: &[f64]) -> bool {
    let follows = |one: &[f64], other: &[f64]| {
        let (speed, angle) = (alike(one, other), alike(one, &change(other)));
        SHARES.iter().enumerate().map(|(k, _)| speed[k].max(angle[k])).collect::<Vec<f64>>()
    };
    let (after, before) = (follows(drive, driven), follows(driven, drive));
    most(&after[1..]) > after[0] && 1.0 - most(&after) < FAR_LESS * (1.0 - most(&before))
}

/// How alike values are to a drive, for each of the speeds at which a motor may follow it.
fn alike(drive: &[f64], values: &[f64]) -> Vec<f64> {
    late(drive).map(|late| correlation(&late[late.len() - values.len()..], values).abs()).collect()
}

fn most(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

/// What the values change by from row to row.
pub(super) fn change(values: &[f64]) -> Vec<f64> {
    values.windows(2).map(|pair| pair[1] - pair[0]).collect()
}

/// A drive as motors of several speeds follow it.
fn late(drive: &[f64]) -> impl Iterator<Item = Vec<f64>> {
    SHARES.into_iter().map(|share| {
        let mut state = drive[0];
        let follow = |v: &f64| {
            state += share * (v - state);
            state
        };
        drive.iter().map(follow).collect()
    })
}
