//! Variance of the simulation error at each time scale: the noise model.
//!
//! Levels of [`crate::fit::scales`] are pooled over records by the time that they span, an octave each. The variance is that of a
//! Student t distribution, so that a few outliers do not make all else look certain. Quantisation bounds it from below: no model
//! can be known to predict better than a reading is.

use std::collections::BTreeMap;

use crate::fit::grid::Grid;
use crate::fit::layout::Layout;
use crate::fit::scales::{levels, transform};
use crate::fit::search::Problem;
use crate::fit::simulate::predict_one;

/// Degrees of freedom of the errors' distribution: tails much heavier than a normal one's, as disturbed motors have.
pub const FREEDOM: f64 = 6.0;

/// Coefficients of one record's simulation error, level after level, the finest first; the mean of a speed's error last.
#[derive(Debug, Clone)]
pub struct Coefficients {
    /// Octave of each level: log2 of the time it spans in milliseconds, rounded.
    pub octaves: Vec<i32>,
    /// The levels.
    pub levels: Vec<Vec<f64>>,
}

impl Coefficients {
    /// Of the error `measured - simulated` on `grid`.
    pub fn of(grid: &Grid, simulated: &[f64]) -> Self {
        let mut series: Vec<f64> =
            grid.measured.iter().zip(simulated).map(|(y, p)| (y - p).clamp(-1e12, 1e12)).collect();
        let sizes = levels(series.len());
        transform(&mut series);
        let mut first = 0;
        let mut levels: Vec<Vec<f64>> = Vec::new();
        let mut octaves = Vec::new();
        for (j, size) in sizes.into_iter().enumerate() {
            levels.push(series[first..first + size].to_vec());
            octaves.push(octave(grid.interval_s, j));
            first += size;
        }
        if grid.mean_counts()
            && let (Some(last), Some(coarsest)) = (series.last(), levels.last_mut())
        {
            coarsest.push(*last);
        }
        Self { octaves, levels }
    }
}

/// Octave of level `j` where samples come every `interval_s`.
fn octave(interval_s: f64, j: usize) -> i32 {
    (interval_s * 1e3 * 2.0_f64.powi(j as i32 + 1)).log2().round() as i32
}

/// Coefficients of the error of a model on every record of `problem`.
pub fn coefficients(problem: &Problem, layout: &Layout, x: &[f64]) -> Vec<Coefficients> {
    let plain = layout.all_plain(x);
    let of = |grid: &Grid| Coefficients::of(grid, &predict_one(&layout.kinds, &plain, &problem.rig, grid));
    problem.count_passes(1);
    problem.grids.iter().map(of).collect()
}

/// Variance of the error at each octave, in the square of the measured unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    variances: BTreeMap<i32, (f64, usize)>,
    mean_square: f64,
}

impl Noise {
    /// Of `coefficients`, at least `least` (the variance of one reading by its quantisation).
    pub fn of(coefficients: &[Coefficients], least: f64) -> Self {
        let mut pooled: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
        for record in coefficients {
            for (octave, level) in record.octaves.iter().zip(&record.levels) {
                pooled.entry(*octave).or_default().extend(level.iter().map(|d| d * d));
            }
        }
        let all = || pooled.values().flatten();
        let mean_square = (all().sum::<f64>() / all().count().max(1) as f64).max(least);
        let variances = pooled
            .iter()
            .map(|(octave, squares)| (*octave, (variance(squares).max(least), squares.len())))
            .collect();
        Self { variances, mean_square }
    }

    /// At `octave`.
    pub fn variance(&self, octave: i32) -> f64 {
        self.variances.get(&octave).map_or(1.0, |(v, _)| *v)
    }

    /// Mean square of the error itself.
    pub fn mean(&self) -> f64 {
        self.mean_square
    }

    /// How many times `floor` this is, as a ratio of errors: the mean over octaves with enough coefficients, each octave alike, so that
    /// every horizon counts.
    pub fn over(&self, floor: &Self) -> f64 {
        const ENOUGH: usize = 8;
        let ratios = self.variances.iter().filter(|(_, (_, count))| *count >= ENOUGH);
        let (sum, count) = ratios.fold((0.0, 0.0), |(sum, count), (octave, (v, _))| {
            (sum + (v / floor.variance(*octave)).max(1.0).ln(), count + 1.0)
        });
        (0.5 * sum / f64::max(count, 1.0)).exp()
    }

    /// White noise of the quietest octave that has enough coefficients: what is known of the noise where nothing was run twice.
    #[must_use]
    pub fn white(&self) -> Self {
        const ENOUGH: usize = 30;
        let known = self.variances.values().filter(|(_, count)| *count >= ENOUGH);
        let least = known.map(|(v, _)| *v).reduce(f64::min).unwrap_or_else(|| self.mean());
        Self {
            variances: self.variances.iter().map(|(o, (_, n))| (*o, (least, *n))).collect(),
            mean_square: least,
        }
    }

    /// Sets the weights of `problem`'s records: half by this noise, half by its mean alone. The first half makes the fit efficient under
    /// coloured noise; the second keeps it a simulation fit, which slow misfit cannot escape by being called noise (L. Ljung, *System
    /// Identification*, 2nd ed., ch. 8 and 13).
    pub fn weigh(&self, problem: &mut Problem) {
        for grid in &mut problem.grids {
            let weight = |j: usize| 1.0 / self.variance(octave(grid.interval_s, j)).sqrt();
            grid.scales = (0..levels(grid.len()).len()).map(weight).collect();
            grid.even = 1.0 / self.mean().sqrt();
        }
    }
}

/// Scale of a Student t distribution by maximum likelihood.
fn variance(squares: &[f64]) -> f64 {
    let n = squares.len().max(1) as f64;
    let mut v = squares.iter().sum::<f64>() / n + 1e-300;
    for _ in 0..8 {
        v = squares.iter().map(|d| (FREEDOM + 1.0) / (FREEDOM + d / v) * d).sum::<f64>() / n + 1e-300;
    }
    v
}
