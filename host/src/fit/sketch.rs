//! Less of the records, for candidates that only have to be compared with one another: longer cells, fewer samples, beginnings.

use super::grid::{Grid, Place};
use super::search::Problem;
use super::window::Since;

/// How much of the records is kept.
#[derive(Debug, Clone, Copy)]
pub struct Sketch {
    /// Samples at most; beyond that the beginnings of the records serve.
    pub samples: f64,
    /// Longest cell, s, to which shorter ones are joined.
    pub cell_s: f64,
    /// Shortest time between samples, s; where they come faster every second one is kept, again and again.
    pub interval_s: f64,
}

impl Problem {
    /// The records as `sketch` has them; where readings are held their cells are those of the holding.
    #[must_use]
    pub fn sketch(mut self, sketch: Sketch) -> Self {
        let share = sketch.samples / self.samples().max(1) as f64;
        let held = self.hold_s.is_some();
        let drawn = |grid: Grid| {
            let mut grid = if share < 1.0 { grid.beginning(share) } else { grid };
            while !held && 2.0 * grid.step_s <= sketch.cell_s {
                grid = grid.coarse();
            }
            while 2.0 * grid.interval_s <= sketch.interval_s {
                grid = grid.every_second();
            }
            grid
        };
        self.grids = self.grids.into_iter().map(drawn).collect();
        self
    }
}

impl Grid {
    /// The same in cells of twice the length.
    fn coarse(self) -> Self {
        let last = self.guide.len().is_multiple_of(2).then(|| self.guide.last().copied()).flatten();
        let halved = |cells: &[f64]| -> Vec<f64> {
            let (first, cells) = cells.split_at(cells.len().min(1));
            let pairs = cells.chunks(2).map(|pair| pair.iter().sum::<f64>() / pair.len() as f64);
            first.iter().copied().chain(pairs).collect()
        };
        let place = |p: &Place| {
            let half = (p.cell % 2) as f64;
            Place { cell: p.cell / 2, part: 0.5 * (half + p.part) }
        };
        let guide: Vec<f64> = self.guide.iter().copied().step_by(2).chain(last).collect();
        // A sample near an end that goes is near the next that stays.
        let near = |end: usize| {
            [(2 * end).saturating_sub(1), 2 * end].iter().any(|k| self.seen.get(*k) == Some(&true))
        };
        Self {
            step_s: 2.0 * self.step_s,
            voltages: halved(&self.voltages),
            seen: (0..guide.len()).map(near).collect(),
            guide,
            places: self.places.iter().map(place).collect(),
            since: self.since.iter().map(|since| Since { place: place(&since.place), ..*since }).collect(),
            ..self
        }
    }

    /// Every second sample.
    fn every_second(self) -> Self {
        Self {
            time_s: self.time_s.iter().copied().step_by(2).collect(),
            places: self.places.iter().copied().step_by(2).collect(),
            since: self.since.iter().copied().step_by(2).collect(),
            measured: self.measured.iter().copied().step_by(2).collect(),
            interval_s: 2.0 * self.interval_s,
            skip: self.skip.div_ceil(2),
            ..self
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::tests::record;

    /// Every volt-second, every sample and the end of the guide stay where they were, whether the cells are even or odd
    /// in number.
    #[test]
    fn coarse_cells_keep_voltage_and_times() {
        for n in [1000_u32, 1001] {
            let times: Vec<f64> = (0..n).map(|k| f64::from(k) * 5e-3).collect();
            let volts = (0..n).map(|k| f64::from(k % 7) - 2.0).collect();
            let fine = Grid::new(&record(times, volts), 0.01).guided();
            let coarse = fine.clone().coarse();
            assert!((coarse.step_s / fine.step_s - 2.0).abs() < 1e-12);
            let impulse = |g: &Grid, cells: usize| g.step_s * g.cells()[..cells].iter().sum::<f64>();
            assert!((impulse(&coarse, 1200) - impulse(&fine, 2400)).abs() < 1e-9);
            assert_eq!(coarse.guide.len(), coarse.voltages.len());
            for (a, b) in coarse.places.iter().zip(&fine.places) {
                let time = |g: &Grid, p: &Place| g.step_s * (p.cell as f64 + p.part);
                assert!((time(&coarse, a) - time(&fine, b)).abs() < 1e-9, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn every_second_sample_stays_where_and_when_it_was() {
        let times: Vec<f64> = (0..1001).map(|k| f64::from(k) * 1e-3).collect();
        let fine = Grid::new(&record(times, vec![1.0; 1001]), 0.01);
        let thin = fine.clone().every_second();
        assert_eq!((thin.len(), thin.time_s[7], thin.places[7]), (501, fine.time_s[14], fine.places[14]));
        assert!((thin.interval_s / fine.interval_s - 2.0).abs() < 1e-12);
    }
}
