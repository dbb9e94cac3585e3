//! A model fitted to the records, with its noise and its score.

use motorlens_shared::effects::Kind;

use super::dataset::Dataset;
use super::noise::{Noise, coefficients};
use super::score::{Gain, scores};
use crate::compare::free_run::{free_runs, pooled};
use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Found;

/// A gain that is worth more parameters: natural logarithms (a factor of 20,000 in likelihood) ...
pub const WORTH: f64 = 10.0;
/// ... and standard errors. On 24 plain motors, half of them disturbed, no effect of the library came to more than 7 and 2.
pub const SURE: f64 = 2.2;

/// A model and how well it predicts.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Its axes.
    pub layout: Layout,
    /// Where the search ended.
    pub found: Found,
    /// What it leaves, by time scale.
    pub noise: Noise,
    /// Held-out log-likelihood, block by block.
    pub scores: Vec<f64>,
}

impl Fitted {
    /// Fits `layout` from `x`: so many `rounds` of weighing by the model's own noise and searching for at most `steps`.
    pub fn new(data: &Dataset, layout: Layout, x: &[f64], rounds: usize, steps: usize) -> Self {
        let mut problem = data.train.clone();
        let mut x = x.to_vec();
        let mut noise = Noise::of(&coefficients(&problem, &layout, &x), data.reading);
        let mut found = None;
        for _ in 0..rounds.max(1) {
            noise.weigh(&mut problem);
            let best = problem.search(&layout, Objective::Scales, &x, steps, 1e-4);
            x.clone_from(&best.x);
            noise = Noise::of(&coefficients(&problem, &layout, &x), data.reading);
            found = Some(best);
        }
        noise.weigh(&mut problem);
        let errors = coefficients(&problem, &layout, &x);
        let scores = scores(&problem, &layout, &x, &errors, &noise);
        let found = found.unwrap_or_else(|| problem.search(&layout, Objective::Scales, &x, 0, 1e-3));
        data.train.simulations.set(data.train.simulations.get() + problem.simulations.get());
        Self { layout, found, noise, scores }
    }

    /// Fits the model `values`.
    pub fn of(data: &Dataset, values: &Values, rounds: usize, steps: usize) -> Self {
        let layout = data.train.layout(&values.kinds());
        let x = layout.pack(values);
        Self::new(data, layout, &x, rounds, steps)
    }

    /// Plain parameters.
    pub fn values(&self) -> Values {
        self.layout.unpack(&self.found.x)
    }

    /// Effects in order.
    pub fn kinds(&self) -> &[Kind] {
        &self.layout.kinds
    }

    /// Number of fitted parameters.
    pub fn size(&self) -> usize {
        self.layout.free().len()
    }

    /// Sum of the scores.
    pub fn score(&self) -> f64 {
        self.scores.iter().sum()
    }

    /// By how much it is better than `other`.
    pub fn gain_over(&self, other: &Self) -> Gain {
        Gain::of(&self.scores, &other.scores)
    }

    /// Root mean square of the simulation error on the records themselves, never tied to the measurement, in the measured unit.
    pub fn simulation_error(&self, data: &Dataset) -> f64 {
        pooled(&free_runs(&data.whole, &self.values())).map_or(f64::MAX, |m| m.rmse)
    }

    /// Whether it is better than `other` beyond doubt.
    pub fn beats(&self, other: &Self) -> bool {
        let gain = self.gain_over(other);
        gain.total > WORTH && gain.sure > SURE
    }
}
