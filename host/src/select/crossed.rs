//! Cross-validated simulation error: each record is simulated by a model that was fitted to the others.
//!
//! The likelihood of [`super::score`] says whether an effect is there; this says whether the model with it simulates what it has not
//! seen (M. Stone, *J. R. Stat. Soc. B* 36, 1974). Where one record is all there is, each piece of it is simulated by a fit to what is before
//! and behind it (P. Burman, E. Chow and D. Nolan, *Biometrika* 81, 1994): its beginning alone may tell nothing of what its end shows.

use std::ops::Range;
use std::sync::Arc;

use crate::diagnose::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Layout;
use crate::fit::loss::bounded;
use crate::fit::noise::Noise;
use crate::fit::scales::CHOOSING;
use crate::fit::search::{Beginning, Problem};
use crate::fit::simulate::predict_one;
use crate::fit::sketch::Sketch;

/// Folds at most.
const FOLDS: usize = 6;
/// Pieces of a single record, which tell how sure the error is as records do elsewhere.
const PIECES: usize = 4;
/// Samples from which on a part of a record is fitted.
const FEWEST: usize = 16;
/// All of the records, in cells of two milliseconds.
const SKETCH: Sketch = Sketch { samples: f64::MAX, cell_s: 2.01e-3, interval_s: 0.0 };
/// Steps of a fit from the parameters of all records.
const STEPS: usize = 4;

/// Records to fit, and records to simulate, from which sample on.
#[derive(Debug, Clone)]
pub struct Fold {
    fit: Problem,
    /// Which of all records, or of their parts, those to fit are.
    places: Vec<usize>,
    /// Records to simulate, and what of them counts.
    test: Vec<(Arc<Grid>, Range<usize>)>,
}

/// Each piece of the records of one programme, and the parts before and behind it to fit.
fn pieces(train: &Problem) -> Vec<Fold> {
    let whole: Vec<Arc<Grid>> = train.grids.iter().cloned().map(Arc::new).collect();
    let fold = |piece: usize| {
        let mut fold = Fold { fit: train.on(Vec::new()), places: Vec::new(), test: Vec::new() };
        for (k, grid) in train.grids.iter().enumerate() {
            let end = |piece: usize| grid.len() * piece / PIECES;
            let own = end(piece)..end(piece + 1);
            for (side, part) in [0..own.start, own.end..grid.len()].into_iter().enumerate() {
                if part.len() >= FEWEST {
                    fold.fit.grids.push(grid.only(part));
                    fold.places.push((k * PIECES + piece) * 2 + side);
                }
            }
            fold.test.push((whole[k].clone(), own));
        }
        fold
    };
    (0..PIECES).map(fold).filter(|fold| !fold.fit.grids.is_empty()).collect()
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
        return pieces(train);
    }
    let fold_of =
        |k: usize| leaders.iter().position(|l| *l == leader(k)).unwrap_or(0) % FOLDS.min(leaders.len());
    let fold = |f: usize| {
        let places: Vec<usize> = (0..count).filter(|k| fold_of(*k) != f).collect();
        let kept = places.iter().map(|k| train.grids[*k].clone());
        let test = (0..count)
            .filter(|k| fold_of(*k) == f)
            .map(|k| (Arc::new(train.grids[k].clone()), 0..train.grids[k].len()));
        Fold { fit: train.on(kept.collect()), places, test: test.collect() }
    };
    (0..FOLDS.min(leaders.len())).map(fold).collect()
}

/// Logarithm of the root mean square error on each record, or on each piece of the only one, simulated by the model at `x` as the other
/// folds fit it.
pub fn crossed(data: &Evidence, layout: &Layout, x: &[f64], noise: &Noise) -> Vec<f64> {
    let mut errors_ln = Vec::new();
    let mut beginning = Beginning::default();
    for Fold { fit, places, test } in data.folds() {
        let mut fit = fit.clone();
        noise.weigh(&mut fit, CHOOSING);
        let (_, x) = fit.race_on(layout, Objective::Scales, x, STEPS, 1e-3, places, &mut beginning);
        let plain = layout.all_plain(&x);
        data.train.count_passes_of(&fit);
        for (grid, range) in test {
            let moving = (!grid.rests()).then(|| {
                let mut tested = fit.on(vec![(**grid).clone()]);
                tested.begin_under(layout, &x);
                tested
            });
            let grid = moving.as_ref().map_or(&**grid, |tested| &tested.grids[0]);
            let run = predict_one(&layout.kinds, &plain, &fit.rig, grid);
            let pairs = grid.measured[range.clone()].iter().zip(&run[range.clone()]);
            let errors: Vec<f64> = pairs.map(|(y, p)| bounded(y - p, 1e9)).collect();
            let n = errors.len().max(1) as f64;
            let mean = if grid.quantity == Quantity::Angle { errors.iter().sum::<f64>() / n } else { 0.0 };
            let square = errors.iter().map(|e| (e - mean).powi(2)).sum::<f64>() / n;
            errors_ln.push(0.5 * (square + data.reading).ln());
        }
    }
    errors_ln
}

/// By how much a model simulates unseen records better than another.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fall {
    /// Mean over the records of what the logarithm of the error falls by; negative where it rises.
    mean: f64,
    /// Its standard error.
    error: f64,
    /// Records or pieces.
    records: usize,
    /// Whether they were simulated by different fits.
    apart: bool,
}

impl Fall {
    /// Of `new` below `old`, logarithms of errors record by record ([`crossed`]), simulated by different fits or by one.
    pub fn of(new: &[f64], old: &[f64], apart: bool) -> Self {
        let falls: Vec<f64> = old.iter().zip(new).map(|(old, new)| old - new).collect();
        let n = falls.len().max(1) as f64;
        let mean = falls.iter().sum::<f64>() / n;
        let variance = falls.iter().map(|fall| (fall - mean).powi(2)).sum::<f64>() / (n - 1.0).max(1.0);
        Self { mean, error: (variance / n).sqrt(), records: falls.len(), apart }
    }

    /// What of a rise exceeds its standard error: under a disturbance each record drifts by chance.
    pub fn rise(self) -> f64 {
        (-self.mean - self.error).max(0.0)
    }

    /// What of a fall exceeds its standard error; negative where it rises.
    pub fn sure(self) -> f64 {
        self.mean - self.error
    }

    /// Whether the error falls by at least a factor of e^`least`, and by `sure` standard errors for so many records or pieces; of one
    /// fit or one record that cannot be said.
    pub fn is_beyond_doubt(self, least: f64, sure: impl Fn(usize) -> f64) -> bool {
        self.apart && self.records > 1 && self.mean > least && self.mean > sure(self.records) * self.error
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fall_that_all_records_share_is_beyond_doubt_and_one_of_a_single_record_is_not() {
        let old = [0.0; 5];
        let sure = |_: usize| 3.0;
        let shared = [-0.5, -0.4, -0.6, -0.5, -0.45];
        assert!(Fall::of(&shared, &old, true).is_beyond_doubt(0.1, sure));
        assert!(!Fall::of(&[-2.5, 0.0, 0.0, 0.0, 0.0], &old, true).is_beyond_doubt(0.1, sure));
        assert!(!Fall::of(&[-0.05; 5], &old, true).is_beyond_doubt(0.1, sure), "less than a tenth");
        assert!(!Fall::of(&[-0.5], &[0.0], true).is_beyond_doubt(0.1, sure), "one record");
        assert!(!Fall::of(&shared, &old, false).is_beyond_doubt(0.1, sure), "pieces of one record");
    }

    #[test]
    fn a_rise_counts_where_records_share_it() {
        let old = [0.0; 4];
        assert!((Fall::of(&[0.1; 4], &old, true).rise() - 0.1).abs() < 1e-12);
        assert_eq!(Fall::of(&[0.3, -0.25, 0.2, -0.15], &old, true).rise(), 0.0);
        assert_eq!(Fall::of(&[-0.1; 4], &old, true).rise(), 0.0);
        assert!((Fall::of(&[0.2], &[0.0], true).rise() - 0.2).abs() < 1e-12);
    }
}
