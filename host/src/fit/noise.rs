//! Variance of the simulation error at each time scale: the noise model.
//!
//! Levels of [`crate::fit::scales`] are pooled over records by the time that they span, an octave each. The variance is that of a
//! Student t distribution, so that a few outliers do not make all else look certain. Quantisation bounds it from below: no model
//! can be known to predict better than a reading is. What a disturbance torque can leave bounds it from above: a torque that
//! grew towards longer times would be something that the model lacks.

use std::collections::BTreeMap;
use std::f64::consts::TAU;

use super::grid::Grid;
use super::layout::Layout;
use super::loss::{MOST, bounded};
use super::scales::{KEEPING, append_coefficients, levels};
use super::search::Problem;
use super::simulate::predict_one;

/// Degrees of freedom of the errors' distribution: tails much heavier than a normal one's, as disturbed motors have.
pub const FREEDOM: f64 = 6.0;

/// Coefficients of one record's simulation error, level after level, the finest first; the mean of a speed's error last.
#[derive(Debug, Clone)]
pub struct Coefficients {
    /// Octave of each level: log2 of the time it spans in milliseconds, rounded.
    pub octaves: Vec<i32>,
    /// The levels.
    pub levels: Vec<Vec<f32>>,
    /// Sum of squares of the error itself, an angle's less what its mean may be off at no cost, and of how many samples.
    squares: (f64, usize),
}

impl Coefficients {
    /// Of the error `measured - simulated` on `grid`.
    pub fn of(grid: &Grid, simulated: &[f64]) -> Self {
        let mut series: Vec<f64> =
            grid.measured.iter().zip(simulated).map(|(y, p)| bounded(y - p, MOST)).collect();
        let count = series.len();
        let sizes = levels(count);
        let mean = series.iter().sum::<f64>() / count.max(1) as f64;
        let mean = if grid.mean_counts() { 0.0 } else { bounded(mean, grid.even_offset) };
        let squares = (series.iter().map(|e| (e - mean).powi(2)).sum(), count);
        append_coefficients(&mut series);
        let mut first = count;
        let mut levels: Vec<Vec<f32>> = Vec::new();
        let mut octaves = Vec::new();
        for (j, size) in sizes.into_iter().enumerate() {
            levels.push(series[first..first + size].iter().map(|d| *d as f32).collect());
            octaves.push(octave(grid.interval_s, j));
            first += size;
        }
        if grid.mean_counts()
            && let (Some(last), Some(coarsest)) = (series.last(), levels.last_mut())
        {
            coarsest.push(*last as f32);
        }
        Self { octaves, levels, squares }
    }

    /// The same with `factor` times a `signal` beside the error: residuals in units of `noise`, the plain error's before the coefficients.
    #[must_use]
    pub fn with(&self, signal: &[f64], factor: f64, noise: &Noise) -> Self {
        let mut signal = &signal[self.squares.1.min(signal.len())..];
        let mut with = self.clone();
        for (octave, level) in with.octaves.iter().zip(&mut with.levels) {
            let unit = factor * noise.variance(*octave).sqrt();
            let own = signal.split_off(..level.len().min(signal.len())).unwrap_or_default();
            for (d, s) in level.iter_mut().zip(own) {
                *d += (unit * s) as f32;
            }
        }
        with
    }
}

/// Octave of level `j` where samples come every `interval_s`.
pub(crate) fn octave(interval_s: f64, j: usize) -> i32 {
    (interval_s * 1e3 * 2.0_f64.powi(j as i32 + 1)).log2().round() as i32
}

/// Coefficients of the error of a model on every record of `problem`.
pub fn coefficients(problem: &Problem, layout: &Layout, x: &[f64]) -> Vec<Coefficients> {
    let plain = layout.all_plain(x);
    let of = |grid: &Grid| Coefficients::of(grid, &predict_one(&layout.kinds, &plain, &problem.rig, grid));
    problem.count_passes(1);
    problem.grids.iter().map(of).collect()
}

/// Variance of one reading of `problem`'s records by its quantisation, in the square of the measured unit.
pub fn reading(problem: &Problem) -> f64 {
    let least = |grid: &Grid| grid.quantum * grid.quantum / 12.0;
    let counted = problem.grids.iter().map(least).fold(f64::MAX, f64::min);
    let range = problem.grids.iter().flat_map(|g| &g.measured).fold(0.0_f64, |a, y| a.max(y.abs()));
    counted.max((1e-7 * range).powi(2))
}

/// Variance of the error at each octave, in the square of the measured unit.
#[derive(Debug, Clone, PartialEq)]
pub struct Noise {
    /// As it is, and of how many coefficients.
    left: BTreeMap<i32, (f64, usize)>,
    /// As much of it as noise may be.
    noise: BTreeMap<i32, f64>,
    mean_square: f64,
}

/// How a torque on the shaft shows in what is measured.
#[derive(Debug, Clone, Copy)]
pub struct Response {
    tau_m_s: f64,
    angle: bool,
}

impl Response {
    /// Of a motor whose mechanical time constant is `tau_m_s`, in the records of `problem`.
    pub fn of(problem: &Problem, tau_m_s: f64) -> Self {
        let angle = problem.grids.first().is_none_or(|grid| !grid.mean_counts());
        Self { tau_m_s: tau_m_s.clamp(1e-3, 2.0), angle }
    }

    /// Variance of a coefficient that spans `2^octave` ms under a white torque, but for a factor: the squared gain of the motor at the
    /// middle of the wavelet's band, three quarters of a period in that time.
    fn power(self, octave: i32) -> f64 {
        let frequency_hz = 750.0 / 2.0_f64.powi(octave);
        let speed = 1.0 / (1.0 + (TAU * frequency_hz * self.tau_m_s).powi(2));
        if self.angle { speed / frequency_hz.powi(2) } else { speed }
    }
}

impl Noise {
    /// Of `coefficients`, at least `least` (the variance of one reading by its quantisation), of a motor with this `response`.
    pub fn of(coefficients: &[Coefficients], least: f64, response: Response) -> Self {
        let mut pooled: BTreeMap<i32, Vec<f64>> = BTreeMap::new();
        for record in coefficients {
            for (octave, level) in record.octaves.iter().zip(&record.levels) {
                pooled.entry(*octave).or_default().extend(level.iter().map(|d| f64::from(*d).powi(2)));
            }
        }
        let (sum, count) = coefficients.iter().fold((0.0, 0), |a, c| (a.0 + c.squares.0, a.1 + c.squares.1));
        let left = |squares: &Vec<f64>| (variance(squares).max(least), squares.len());
        Self {
            left: pooled.iter().map(|(octave, squares)| (*octave, left(squares))).collect(),
            noise: disturbed(pooled, response).into_iter().map(|(o, v)| (o, v.max(least))).collect(),
            mean_square: (sum / count.max(1) as f64).max(least),
        }
    }

    /// The same where all that is left is noise: that of a model which the records cannot better.
    #[must_use]
    pub fn with_all_left(&self) -> Self {
        let noise = self.noise.iter().map(|(octave, v)| (*octave, v.max(self.left(*octave)))).collect();
        Self { noise, ..self.clone() }
    }

    /// Of the noise at `octave`.
    pub fn variance(&self, octave: i32) -> f64 {
        self.noise.get(&octave).copied().unwrap_or(1.0)
    }

    fn left(&self, octave: i32) -> f64 {
        self.left.get(&octave).map_or(1.0, |(v, _)| *v)
    }

    /// Mean square of the error itself.
    pub fn mean(&self) -> f64 {
        self.mean_square
    }

    /// How many times `floor` this is, as a ratio of errors: the mean over octaves with enough coefficients, each octave alike, so that
    /// every horizon counts.
    pub fn over(&self, floor: &Self) -> f64 {
        const ENOUGH: usize = 8;
        let ratios = self.left.iter().filter(|(_, (_, count))| *count >= ENOUGH);
        let (sum, count) = ratios.fold((0.0, 0.0), |(sum, count), (octave, (v, _))| {
            (sum + (v / floor.left(*octave)).max(1.0).ln(), count + 1.0)
        });
        (0.5 * sum / f64::max(count, 1.0)).exp()
    }

    /// White noise of the quietest octave that has enough coefficients: what is known of the noise where nothing was run twice.
    #[must_use]
    pub fn white(&self) -> Self {
        const ENOUGH: usize = 30;
        let known = self.left.values().filter(|(_, count)| *count >= ENOUGH);
        let least = known.map(|(v, _)| *v).reduce(f64::min).unwrap_or_else(|| self.mean());
        Self {
            left: self.left.iter().map(|(o, (_, n))| (*o, (least, *n))).collect(),
            noise: self.noise.keys().map(|o| (*o, least)).collect(),
            mean_square: least,
        }
    }

    /// Sets the weights of `problem`'s records: each time scale by this noise, and the plain error by its mean and so much: the first makes
    /// the fit efficient under coloured noise, the second keeps it a simulation fit (L. Ljung, *System Identification*, 2nd ed., ch. 8
    /// and 13).
    pub fn weigh(&self, problem: &mut Problem, plain: f64) {
        for grid in &mut problem.grids {
            let weight = |j: usize| 1.0 / self.variance(octave(grid.interval_s, j)).sqrt();
            grid.scales = (0..levels(grid.len()).len()).map(weight).collect();
            grid.even = (plain / self.mean()).max(f64::MIN_POSITIVE).sqrt();
            grid.even_offset = if plain < KEEPING { f64::INFINITY } else { grid.offset() };
        }
    }
}

/// So many coefficients speak for a torque that goes on at longer times as it is at shorter ones (a unit information prior: R. Kass and
/// L. Wasserman, *J. Am. Stat. Assoc.* 90, 1995). A model of three parameters fits the two coefficients of the longest octave to the last
/// digit, which is no proof that the motor has no noise there.
const BELIEVED: f64 = 1.0;

/// Variances of `pooled` squares by octave, as a disturbance can make them: what such a torque leaves, mapped back through the motor's
/// `response`, does not rise from one octave to the next longer one. Octaves where it would are pooled (isotonic regression: R. Barlow et
/// al., *Statistical Inference under Order Restrictions*, 1972). So what a wrong model leaves at long times is not called noise, and the few
/// coefficients there need not tell their variance by themselves.
fn disturbed(pooled: BTreeMap<i32, Vec<f64>>, response: Response) -> Vec<(i32, f64)> {
    struct Pool {
        octaves: Vec<i32>,
        squares: Vec<f64>,
        torque: f64,
    }
    let mut pools: Vec<Pool> = Vec::new();
    for (octave, squares) in pooled {
        let squares: Vec<f64> = squares.iter().map(|d| d / response.power(octave)).collect();
        let torque = variance(&squares);
        pools.push(Pool { octaves: vec![octave], squares, torque });
        while let [.., shorter, longer] = &mut pools[..]
            && longer.torque > shorter.torque
        {
            shorter.octaves.append(&mut longer.octaves);
            shorter.squares.append(&mut longer.squares);
            shorter.torque = variance(&shorter.squares);
            pools.pop();
        }
    }
    let (mut noise, mut shorter) = (Vec::new(), None);
    for Pool { octaves, squares, torque } in pools {
        let count = squares.len() as f64;
        let torque = (count * torque + BELIEVED * shorter.unwrap_or(torque)) / (count + BELIEVED);
        noise.extend(octaves.into_iter().map(|o| (o, torque * response.power(o))));
        shorter = Some(torque);
    }
    noise
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

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(variances: &[f64], response: Response) -> Noise {
        let level =
            |v: &f64| (0..64).map(|k| v.sqrt() as f32 * if k % 2 == 0 { 1.0 } else { -1.0 }).collect();
        let record = Coefficients {
            octaves: (3..3 + variances.len() as i32).collect(),
            levels: variances.iter().map(level).collect(),
            squares: (1.0, 1),
        };
        Noise::of(&[record], 0.0, response)
    }

    #[test]
    fn what_a_white_torque_leaves_is_noise_at_every_scale() {
        for angle in [false, true] {
            let response = Response { tau_m_s: 0.05, angle };
            let white: Vec<f64> = (3..12).map(|octave| response.power(octave)).collect();
            let noise = noise(&white, response);
            for (octave, v) in (3..12).zip(&white) {
                assert!((noise.variance(octave) / noise.left(octave) - 1.0).abs() < 1e-6, "{octave} {v}");
            }
        }
    }

    /// A slow misfit of an angle: sixty-four times the variance an octave, where a torque makes sixteen at most.
    #[test]
    fn what_rises_faster_towards_long_times_than_a_torque_can_make_it_is_not_called_noise() {
        let response = Response { tau_m_s: 0.05, angle: true };
        let steep: Vec<f64> = (0..9).map(|k| 64.0_f64.powi(k)).collect();
        let noise = noise(&steep, response);
        assert!(noise.variance(11) < 0.2 * noise.left(11), "{noise:?}");
        assert!(noise.over(&noise.white()) > 8.0, "what is left is told as it is");
    }

    /// The longest octave of two records has two coefficients, and a model of as many parameters fits them.
    #[test]
    fn two_coefficients_that_are_fitted_to_the_last_digit_do_not_tell_that_there_is_no_noise() {
        let response = Response { tau_m_s: 0.05, angle: true };
        let level = |v: f64, count: usize| vec![v.sqrt() as f32; count];
        let levels: Vec<Vec<f32>> =
            (3..9).map(|o| level(response.power(o), 64)).chain([level(1e-12, 2)]).collect();
        let record = Coefficients { octaves: (3..10).collect(), levels, squares: (1.0, 1) };
        let noise = Noise::of(&[record], 0.0, response);
        assert!(noise.variance(9) > 0.3 * response.power(9), "{noise:?}");
        assert!((noise.variance(8) / response.power(8) - 1.0).abs() < 1e-6, "{noise:?}");
    }

    #[test]
    fn counting_noise_alike_at_all_scales_stays_as_it_is() {
        let response = Response { tau_m_s: 0.05, angle: true };
        let noise = noise(&[2.0; 6], response);
        let raised = |octave| noise.variance(octave) / noise.left(octave);
        assert!((3..9).all(|octave| (1.0..1.6).contains(&raised(octave))), "{noise:?}");
    }
}
