//! Cross-validated simulation error: each record is simulated by a model that was fitted to the others.
//!
//! The likelihood of [`super::score`] says whether an effect is there; this says whether the model with it simulates what it has not
//! seen (M. Stone, *J. R. Stat. Soc. B* 36, 1974). Where one record is all there is, its end is simulated by a fit to its beginning.

use super::noise::Noise;
use crate::diagnose::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Layout;
use crate::fit::search::Problem;
use crate::fit::simulate::predict_one;
use crate::fit::sketch::Sketch;

/// Folds at most.
const FOLDS: usize = 6;
/// Share of a single record that is fitted.
const BEGINNING: f64 = 0.6;
/// All of the records, in cells of two milliseconds.
const SKETCH: Sketch = Sketch { samples: f64::MAX, cell_s: 2.01e-3, interval_s: 0.0 };
/// Steps of a fit from the parameters of all records.
const STEPS: usize = 4;

/// Records to fit, and records to simulate, from which sample on.
#[derive(Debug, Clone)]
pub struct Fold {
    fit: Problem,
    test: Vec<(Grid, usize)>,
}

/// The folds of records laid out as `train`, of which `repeats` run one programme: those stay together.
pub fn folds(train: &Problem, repeats: &[(usize, usize)]) -> Vec<Fold> {
    let train = &train.clone().sketch(SKETCH);
    let count = train.grids.len();
    let leader = |k: usize| repeats.iter().find(|(_, second)| *second == k).map_or(k, |(first, _)| *first);
    let mut leaders: Vec<usize> = (0..count).map(leader).collect();
    leaders.sort_unstable();
    leaders.dedup();
    if leaders.len() < 2 {
        let fit = train.on(train.grids.iter().map(|g| g.beginning(BEGINNING)).collect());
        let test = train.grids.iter().map(|g| (g.clone(), (g.len() as f64 * BEGINNING) as usize)).collect();
        return vec![Fold { fit, test }];
    }
    let fold_of =
        |k: usize| leaders.iter().position(|l| *l == leader(k)).unwrap_or(0) % FOLDS.min(leaders.len());
    let fold = |f: usize| {
        let kept = (0..count).filter(|k| fold_of(*k) != f).map(|k| train.grids[k].clone());
        let test = (0..count).filter(|k| fold_of(*k) == f).map(|k| (train.grids[k].clone(), 0));
        Fold { fit: train.on(kept.collect()), test: test.collect() }
    };
    (0..FOLDS.min(leaders.len())).map(fold).collect()
}

/// Mean logarithm of the root mean square error over all records, each simulated by the model at `x` as the other folds fit it.
pub fn crossed(data: &Evidence, layout: &Layout, x: &[f64], noise: &Noise) -> f64 {
    let (mut sum, mut count) = (0.0, 0.0);
    for Fold { fit, test } in &data.folds {
        let mut fit = fit.clone();
        noise.weigh(&mut fit);
        let found = fit.search(layout, Objective::Scales, x, STEPS, 1e-3);
        let plain = layout.all_plain(&found.x);
        data.train.count_passes_of(&fit);
        for (grid, from) in test {
            let run = predict_one(&layout.kinds, &plain, &fit.rig, grid);
            let errors: Vec<f64> =
                grid.measured.iter().zip(run).skip(*from).map(|(y, p)| (y - p).clamp(-1e9, 1e9)).collect();
            let n = errors.len().max(1) as f64;
            let mean = if grid.quantity == Quantity::Angle { errors.iter().sum::<f64>() / n } else { 0.0 };
            let square = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n;
            sum += 0.5 * (square + data.reading).ln();
            count += 1.0;
        }
    }
    sum / f64::max(count, 1.0)
}
