//! The records as the selection sees them: guided grids, what repeats one another, and the noise that a second run shows.

use super::noise::{Coefficients, Noise};
use crate::fit::grid::Grid;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::simulate::predict_one;
use crate::log::Record;
use crate::log::repeats::find_repeats;

/// Records to learn from. Nothing here changes while models are compared, but for the noise of the second runs, which is
/// measured once the base model is known.
#[derive(Debug)]
pub struct Dataset {
    /// Simulations that start at the beginning of each record and are never tied to the measurement again.
    pub whole: Problem,
    /// The same for fits: laws tied to an angle act at the measured one, so that a model that drifts keeps their phase.
    pub train: Problem,
    /// Pairs of records that run one programme, by their places.
    pub repeats: Vec<(usize, usize)>,
    /// Variance of one reading by its quantisation, in the square of the measured unit.
    pub reading: f64,
}

impl Dataset {
    /// Of records laid out as `whole`.
    pub fn new(whole: &Problem, records: &[Record]) -> Self {
        let train = whole.on(whole.grids.iter().cloned().map(Grid::guided).collect());
        let least = |grid: &Grid| grid.quantum * grid.quantum / 12.0;
        let reading = whole.grids.iter().map(least).fold(f64::MAX, f64::min);
        let range = whole.grids.iter().flat_map(|g| &g.measured).fold(0.0_f64, |a, y| a.max(y.abs()));
        let repeats = find_repeats(records);
        Self { whole: whole.clone(), train, repeats, reading: reading.max((1e-7 * range).powi(2)) }
    }

    /// The records in cells of twice the length, one of each programme, weighted by `noise`: for candidates that are only compared.
    pub fn screen(&self, noise: &Noise) -> Problem {
        let second = |k: &usize| self.repeats.iter().any(|(_, second)| second == k);
        let held = self.train.hold_s.is_some();
        let sketch = |k: usize| {
            let grid = &self.train.grids[k];
            if held { grid.clone() } else { grid.coarse() }
        };
        let mut problem =
            self.train.on((0..self.train.grids.len()).filter(|k| !second(k)).map(sketch).collect());
        noise.weigh(&mut problem);
        problem
    }

    /// What a perfect model would leave at each time scale, from records that repeat a programme: half the variance of what they
    /// differ by beyond `model`, which takes off what differs in their voltages. None without repeats.
    pub fn repeat_noise(&self, model: &Values) -> Option<Noise> {
        let kinds = model.kinds();
        let layout = self.train.layout(&kinds);
        let plain = layout.all_plain(&layout.pack(model));
        let errors = |k: usize| -> Vec<f64> {
            let grid = &self.train.grids[k];
            let run = predict_one(&kinds, &plain, &self.train.rig, grid);
            grid.measured.iter().zip(run).map(|(y, p)| y - p).collect()
        };
        let pair = |&(first, second): &(usize, usize)| {
            let (a, b) = (errors(first), errors(second));
            let n = a.len().min(b.len());
            let grid = &self.train.grids[first];
            let alike = n * 20 >= a.len().max(b.len()) * 19 && n >= 2;
            alike.then(|| {
                let mut zero = grid.first(n);
                zero.measured = vec![0.0; n];
                let apart: Vec<f64> =
                    (0..n).map(|k| (a[k] - b[k]) * std::f64::consts::FRAC_1_SQRT_2).collect();
                Coefficients::of(&zero, &apart)
            })
        };
        let apart: Vec<Coefficients> = self.repeats.iter().filter_map(pair).collect();
        (!apart.is_empty()).then(|| Noise::of(&apart, self.reading))
    }
}
