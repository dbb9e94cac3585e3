//! Columns that drive nothing whatever they are called: the difference of two others, the change of another, a clock.

use super::by_numbers;
use super::clocks::FEWEST_TICKS;
use super::leads::{EXACTLY, change, only_rises};
use crate::log::motion::{correlation, span};

/// The columns of complete rows, and the place of the clock.
pub(super) struct Columns {
    all: Vec<Vec<f64>>,
    time: Option<usize>,
}

impl Columns {
    /// Those of a table.
    pub fn of(rows: &[Vec<f64>], time: Option<usize>) -> Columns {
        Columns { all: by_numbers::columns(rows), time }
    }

    /// Whether column `k` is made of others, or rises from each row to the next; of a few rows, and among very many columns, nothing is.
    pub fn is_made(&self, k: usize) -> bool {
        let Some(own) = self.all.get(k).filter(|own| own.len() >= FEWEST_TICKS && span(own) > 0.0) else {
            return false;
        };
        let is_few = self.all.len() <= by_numbers::MOST;
        only_rises(own) || is_few && (by_numbers::is_made(&self.all, k) || self.is_change(own, k))
    }

    /// Whether `own`, at `k`, is what another column changes by from the row before, or that in a second.
    fn is_change(&self, own: &[f64], k: usize) -> bool {
        let since_before = self.time.and_then(|time| self.all.get(time)).map(|time| change(time));
        let rates = |of: &Vec<f64>| match &since_before {
            Some(since_before) => change(of).iter().zip(since_before).map(|(by, in_s)| by / in_s).collect(),
            None => change(of),
        };
        let is_of = |of: &Vec<f64>| correlation(&rates(of), &own[1..]).abs() > EXACTLY;
        (0..self.all.len()).any(|other| other != k && Some(other) != self.time && is_of(&self.all[other]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_error_a_change_and_a_clock_are_made_and_a_drive_is_not() {
        let (mut speed, mut rows) = (0.0, Vec::new());
        for k in 0..200_u32 {
            let (t, before, drive) = (0.02 * f64::from(k), speed, [6.0, -3.0, 0.0, 4.5][k as usize / 20 % 4]);
            speed += 0.02 * (2.0 * drive - speed);
            let target = f64::from(k / 50);
            rows.push(vec![t, speed, target, target - speed, (speed - before) / 0.02, 7e6 + 2e4 * t, drive]);
        }
        let columns = Columns::of(&rows, Some(0));
        let made: Vec<bool> = (0..7).map(|k| columns.is_made(k)).collect();
        assert_eq!(made[3..], [true, true, true, false]);
        assert!(!made[1], "a speed");
        assert!(!Columns::of(&rows[..10], Some(0)).is_made(3), "too few rows");
    }
}
