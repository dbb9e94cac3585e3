//! Speeds that are means: over the time since the sample before, or over a window of their own.
//!
//! What counts edges over a window gives y(t) = (x(t) - x(t - T)) / T. Half a window of it is delay, and the rest is no filter of first order.

use super::grid::{Grid, Place, Quantity};
use crate::log::timing;

/// Where the mean of a reading begins.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Since {
    /// Before the record's start `part` is negative.
    pub place: Place,
    /// The inverse of its length, 1/s.
    pub rate: f64,
}

impl Grid {
    /// The same with its speed read as `quantity`; an angle stays what it is.
    #[must_use]
    pub fn read_as(self, quantity: Quantity) -> Self {
        let window_s = match (self.quantity, quantity) {
            (Quantity::Angle, _) | (_, Quantity::Angle) => return self,
            (_, Quantity::Speed) => return Self { quantity, since: Vec::new(), ..self },
            (_, Quantity::MeanSpeed) => None,
            (_, Quantity::WindowSpeed(length)) => Some(length),
        };
        let usual = timing::median_interval(&self.time_s);
        let before =
            |k: usize| window_s.unwrap_or(if k == 0 { usual } else { self.time_s[k] - self.time_s[k - 1] });
        let since = self.places.iter().enumerate().map(|(k, place)| {
            let place = match (window_s, k) {
                (None, 1..) => self.places[k - 1],
                _ => place.earlier(before(k) / self.step_s),
            };
            Since { place, rate: 1.0 / before(k) }
        });
        Self { quantity, since: since.collect(), ..self }
    }
}

impl Place {
    /// So many `cells` before.
    fn earlier(self, cells: f64) -> Self {
        let position = self.cell as f64 + self.part - cells;
        let cell = (position.ceil() - 1.0).max(0.0);
        let part = position - cell;
        // Whole cells exactly: their readings need no interpolation.
        let part = if (part - 1.0).abs() < 1e-6 { 1.0 } else { part };
        Self { cell: cell as usize, part }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::tests::record;

    #[test]
    fn a_window_begins_its_length_before_each_sample_also_before_the_record() {
        let times: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.02).collect();
        let angle = Grid::new(&record(times, vec![1.0; 100]), 0.01);
        let grid = Grid { quantity: Quantity::Speed, ..angle }.read_as(Quantity::WindowSpeed(0.05));
        assert_eq!(grid.quantity, Quantity::WindowSpeed(0.05));
        assert_eq!(grid.quantity.speed_in_words().unwrap(), "the mean over the last 50 ms");
        for (since, place) in grid.since.iter().zip(&grid.places) {
            let at = |p: &Place| grid.step_s * (p.cell as f64 + p.part);
            assert!((at(place) - at(&since.place) - 0.05).abs() < 1e-9, "{since:?} {place:?}");
            assert!((since.rate - 20.0).abs() < 1e-9);
            assert!(since.place.part > 0.0 || since.place.cell == 0);
        }
    }
}
