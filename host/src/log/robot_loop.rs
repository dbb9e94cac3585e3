//! A robot's loop logs its entries one after the other in each turn, many of them only when they change: which of them has the clock,
//! and which value holds.

/// One turn of the robot's loop logs its entries within this share of the turn, and within so many seconds.
const TURN_SHARE: f64 = 0.1;
const LONGEST_TURN_S: f64 = 2e-3;

/// Of several series the one that was logged most often (the first of equals): it has the most turns of the loop, where others are
/// logged only when they change.
pub fn clock<'v, T>(all: impl Iterator<Item = &'v [T]>) -> Option<&'v [T]> {
    all.fold(None, |best: Option<&[T]>, next| match best {
        Some(best) if best.len() >= next.len() => Some(best),
        _ => Some(next),
    })
}

/// How far behind the first entry of a turn of the loop its others may be logged, s.
pub fn turn_s(times: &[f64]) -> f64 {
    turn_of(super::timing::median_interval(times))
}

/// The same where it turns every `interval_s`.
pub fn turn_of(interval_s: f64) -> f64 {
    (TURN_SHARE * interval_s).min(LONGEST_TURN_S)
}

/// Where the last of `times` up to `time_s` stands, whose value holds until the next.
pub fn held_at(times: &[f64], time_s: f64) -> Option<usize> {
    times.partition_point(|time| *time <= time_s).checked_sub(1)
}
