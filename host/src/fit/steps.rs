//! A record on cells of another length: as a program that runs in steps of its own takes it.

use super::grid::{Grid, Place, place};
use super::voltages::mean_voltages;
use super::window::Since;
use crate::log::Record;

impl Grid {
    /// The same samples of `record`, begun alike, on cells of `step_s`, s.
    #[must_use]
    pub(crate) fn in_steps_of(&self, record: &Record, step_s: f64) -> Self {
        let ratio = self.step_s / step_s;
        let moved = |p: &Place| place((p.cell as f64 + p.part) * ratio);
        // A sample may have been put on the end of a cell behind the record's own end.
        let until = record.duration_s() + 2.0 * self.step_s;
        let cells = (until / step_s).ceil() as usize + 1;
        let mut voltages = mean_voltages(record, step_s, cells);
        voltages[0] = self.voltages[0];
        Self {
            step_s,
            voltages,
            guide: Vec::new(),
            seen: Vec::new(),
            places: self.places.iter().map(moved).collect(),
            since: self.since.iter().map(|since| Since { place: moved(&since.place), ..*since }).collect(),
            ..self.clone()
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::fit::grid::tests::record;

    #[test]
    fn samples_keep_their_times_and_cells_their_volt_seconds() {
        let times: Vec<f64> = (0..200).map(|k| f64::from(k) * 0.02).collect();
        let record = record(times.clone(), (0..200).map(|k| f64::from(k % 7) - 3.0).collect());
        let grid = Grid::new(&record, 0.01);
        let other = grid.in_steps_of(&record, 0.003);
        assert_eq!((other.len(), other.places[0]), (grid.len(), grid.places[0]));
        for (place, time) in other.places.iter().zip(&times) {
            assert!((0.003 * (place.cell as f64 + place.part) - time).abs() < 1e-4, "{place:?} {time}");
        }
        let until = |grid: &Grid| -> f64 {
            let cells = (3.6 / grid.step_s).round() as usize;
            grid.step_s * grid.cells()[..cells].iter().sum::<f64>()
        };
        assert!((until(&grid) - until(&other)).abs() < 1e-6, "{} {}", until(&grid), until(&other));
    }
}
