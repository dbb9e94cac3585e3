//! How well the data determine each parameter.
//!
//! Residuals of a motor are anything but white, so J^T J alone promises far too narrow intervals. The covariance here is the sandwich
//! H^-1 M H^-1 (Huber 1967, White 1980) of the fit by time scale ([`super::scales`]), whose residuals are nearly uncorrelated: each
//! coefficient adds its own square to M, those of half a second together, within which what an equation misses hangs together (Newey and West
//! 1987). What the parameters have fitted away of a long scale's few coefficients, their leverage of the [noise](super::noise) of that
//! scale, is added again (J. MacKinnon and H. White, *J. Econometrics* 29, 1985), and each of them adds that noise at least: so few do
//! not prove that there is less.

use nalgebra::{DMatrix, DVector};
use serde::Serialize;

use super::cost::Objective;
use super::layout::{Layout, Values};
use super::noise::{Noise, Response, coefficients, reading};
use super::scales::{KEEPING, levels};
use super::search::{PRIOR_WEIGHT, Problem};
use super::simulate::LANES;

/// Coefficients of one block may hang together, s.
const BLOCK_S: f64 = 0.5;
/// Of more coefficients than this in a scale the parameters fit away next to nothing.
const FEW: usize = 64;
/// Two-sided 95 % of the normal distribution.
const WIDTH: f64 = 1.96;
/// An interval of more than this share of the value either way identifies nothing.
const USEFUL: f64 = 0.5;
/// Where the data leave more than this share of the prior's width, the prior speaks.
const PRIOR_SPEAKS: f64 = 0.7;

/// A combination known to this share is known, whatever made it so.
const SHARP: f64 = 0.02;

/// A parameter with its 95 % interval.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Estimate {
    /// `gain`, or `coulomb.level`.
    pub name: String,
    /// Best value.
    pub value: f64,
    /// Unit of the three numbers.
    pub unit: String,
    /// Lower end of the interval.
    pub low: f64,
    /// Upper end.
    pub high: f64,
    /// The interval is finite, useful, and comes from these data and not from a belief.
    pub identifiable: bool,
}

/// A point in search numbers and its covariance.
#[derive(Debug, Clone)]
pub struct Spread {
    /// The axes.
    pub layout: Layout,
    /// Search numbers.
    pub x: Vec<f64>,
    /// Covariance over all axes; zero for fixed ones.
    pub covariance: DMatrix<f64>,
}

/// Every parameter of `values`, fitted on `problem`, with its interval.
pub fn estimates(problem: &Problem, values: &Values) -> Vec<Estimate> {
    let spread = Spread::of(problem, values);
    (0..spread.layout.len()).map(|k| spread.parameter(k)).collect()
}

impl Problem {
    /// The same records, each time scale weighted by the noise that the model at `x` leaves there.
    fn weighed(&self, layout: &Layout, x: &[f64]) -> Self {
        let response = Response::of(self, layout.unpack(x).base.tau_m);
        let noise = Noise::of(&coefficients(self, layout, x), reading(self), response);
        let mut weighed = self.clone();
        noise.weigh(&mut weighed, KEEPING);
        weighed
    }
}

impl Spread {
    /// The spread of `values` as `problem` determines them.
    pub fn of(problem: &Problem, values: &Values) -> Self {
        let layout = problem.layout(&values.kinds());
        let x = layout.pack(values);
        let free = layout.free();
        let n = free.len();
        let problem = problem.weighed(&layout, &x);
        let (mut h, mut m) = (DMatrix::zeros(n, n), DMatrix::zeros(n, n));
        let mut few: Vec<(f64, f64, DVector<f64>)> = Vec::new();
        problem.neighbours(&layout, Objective::Scales, &x, &free, &mut |grid, record, inverse| {
            let mut first = grid.len();
            let sizes = levels(grid.len());
            let coarsest = sizes.len().saturating_sub(1);
            for (j, (size, weight)) in sizes.into_iter().zip(grid.weights()).enumerate() {
                // The mean stands behind them, weighted as the coarsest are.
                let size = size + usize::from(j == coarsest);
                // The plain error beside the coefficients is one more sum of them, each scale alike.
                let counts = 1.0 + (grid.even_weight() / weight).powi(2);
                let is_few = size <= FEW;
                let block =
                    ((BLOCK_S / grid.interval_s / 2.0_f64.powi(j as i32 + 1)).round() as usize).max(1);
                for begin in (first..first + size).step_by(block) {
                    let mut gradient = DVector::zeros(n);
                    for k in begin..(begin + block).min(first + size) {
                        let residual = record[0][k].0[0];
                        let row = DVector::from_fn(n, |f, _| {
                            let f = f + 1;
                            (record[f / LANES][k].0[f % LANES] - residual) * inverse[f]
                        });
                        h.ger(counts, &row, &row, 1.0);
                        if is_few {
                            few.push((counts, residual, row));
                        } else {
                            gradient.axpy(counts * residual, &row, 1.0);
                        }
                    }
                    m.ger(1.0, &gradient, &gradient, 1.0);
                }
                first += size;
            }
        });
        for (f, k) in free.iter().enumerate() {
            if let Some((_, slope)) = layout.axes[*k].doubt(x[*k]) {
                let weight = PRIOR_WEIGHT * slope * slope;
                h[(f, f)] += weight;
                // With no data at all, exactly the prior's width is left.
                m[(f, f)] += weight * PRIOR_WEIGHT;
            }
            h[(f, f)] *= 1.0 + 1e-12;
        }
        // What the records do not answer to at all leaves the others as they are.
        let silent: Vec<usize> = (0..n).filter(|f| h[(*f, *f)] == 0.0).collect();
        silent.iter().for_each(|f| h[(*f, *f)] = 1.0);
        let inverse = h.try_inverse().unwrap_or_else(|| DMatrix::from_element(n, n, f64::INFINITY));
        for (counts, residual, row) in &few {
            let leverage = counts * row.dot(&(&inverse * row));
            let variance = (residual * residual + leverage).max(1.0);
            if variance.is_finite() {
                m.ger(counts * counts * variance, row, row, 1.0);
            }
        }
        let small = &inverse * m * &inverse;
        let mut covariance = DMatrix::zeros(layout.len(), layout.len());
        for (r, a) in free.iter().enumerate() {
            for (c, b) in free.iter().enumerate() {
                covariance[(*a, *b)] = small[(r, c)];
            }
        }
        silent.iter().for_each(|f| covariance[(free[*f], free[*f])] = f64::INFINITY);
        Self { layout, x, covariance }
    }

    /// Standard deviation of search number `k`.
    pub fn deviation(&self, k: usize) -> f64 {
        let v = self.covariance[(k, k)];
        if v.is_finite() { v.max(0.0).sqrt() } else { f64::INFINITY }
    }

    /// Parameter `k` with its interval.
    pub fn parameter(&self, k: usize) -> Estimate {
        let a = &self.layout.axes[k];
        let half = WIDTH * self.deviation(k);
        let (x, value) = (self.x[k], self.layout.plain(k, self.x[k]));
        let end = |x: f64| self.layout.plain(k, x.clamp(a.low, a.high));
        let (low, high) = (end(x - half), end(x + half));
        let useful = (high - low) < 2.0 * USEFUL * value.abs() && half.is_finite();
        let from_data = a.prior.is_none_or(|(_, width)| half < WIDTH * PRIOR_SPEAKS * width);
        Estimate {
            name: a.name.clone(),
            value,
            unit: a.unit.into(),
            low,
            high,
            identifiable: a.fixed || useful && from_data,
        }
    }

    /// A positive function of the parameters with `slope` of its logarithm along the first axes.
    pub fn ratio(&self, name: &str, unit: &str, value: f64, slope: &[f64]) -> Estimate {
        let n = slope.len();
        let s = DVector::from_column_slice(slope);
        let variance = (s.transpose() * self.covariance.view((0, 0), (n, n)) * &s)[(0, 0)];
        let half = WIDTH * if variance.is_finite() { variance.max(0.0).sqrt() } else { f64::INFINITY };
        let believed: f64 = (0..n)
            .filter_map(|k| self.layout.axes[k].prior.map(|p| (slope[k] * p.1).powi(2)))
            .sum::<f64>()
            .sqrt();
        Estimate {
            name: name.into(),
            value,
            unit: unit.into(),
            low: value * (-half).exp(),
            high: value * half.min(700.0).exp(),
            identifiable: half < USEFUL
                && (half < SHARP || believed == 0.0 || half < WIDTH * PRIOR_SPEAKS * believed),
        }
    }
}

#[cfg(test)]
mod tests {
    use motorlens_shared::effects::Kind;
    use motorlens_shared::excitation::Programme;
    use motorlens_virtual_motor::{Motor, Run, VirtualMotor};

    use super::*;
    use crate::diagnose::discover::{Options, discover};
    use crate::exam::case::record;
    use crate::log::Record;
    use crate::motor_file::MotorFile;

    fn disturbed(motor: &Motor, seed: u64) -> Vec<Record> {
        let run = Run { disturbance: 0.03, ..Run::at(200.0) };
        let play = |(k, programme): (usize, &Programme)| {
            record(&mut VirtualMotor::new(motor, &[], 31 * seed + k as u64), programme, 200, &run)
        };
        Programme::default_protocol(motor.nominal_v as f32).training.iter().enumerate().map(play).collect()
    }

    /// The time constant of a filter is nothing to a reading that is held.
    #[test]
    fn a_parameter_that_moves_nothing_leaves_the_intervals_of_the_others_as_they_are() {
        let motor = Motor::paper();
        let found = discover(
            &disturbed(&motor, 3),
            &[],
            &MotorFile::default(),
            &Options { most: 0, ..Options::default() },
            &mut |_| (),
        )
        .unwrap();
        let held = found.model.values().with(Kind::SensorLag, vec![0.0, 0.015]);
        let all = estimates(&found.evidence.whole, &held);
        let of = |name: &str| all.iter().find(|estimate| estimate.name == name).unwrap();
        assert!(of("gain").identifiable && of("gain").high < 1.2 * of("gain").low, "{:?}", of("gain"));
        assert!(!of("sensor_lag.time").identifiable);
    }

    /// Of forty intervals, each of which holds the truth nineteen times of twenty, seven lie beside it once in two hundred times.
    #[test]
    fn under_a_disturbance_intervals_hold_the_truth_as_often_as_they_promise() {
        let options = Options { library: Vec::new(), ..Options::default() };
        let (mut beside, mut narrow, mut told) = (0, 0, String::new());
        for seed in 1..=20 {
            let motor = Motor::hidden(seed);
            let records = disturbed(&motor, seed);
            let known = MotorFile::default();
            let found = discover(&records, &[], &known, &options, &mut |_| ()).unwrap();
            for estimate in estimates(&found.evidence.whole, &found.model.values()) {
                let truth = match estimate.name.as_str() {
                    "gain" => motor.gain(),
                    "tau_m" => motor.mechanical_time_constant(),
                    _ => continue,
                };
                beside += usize::from(!(estimate.low..=estimate.high).contains(&truth));
                narrow += usize::from(estimate.high < 1.1 * estimate.low);
                told += &format!("{} {truth} in {} .. {}\n", estimate.name, estimate.low, estimate.high);
            }
        }
        assert!(beside <= 6 && narrow >= 20, "{beside} beside the truth, {narrow} useful:\n{told}");
    }
}
