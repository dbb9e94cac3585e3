//! How far a model is from a record.

use serde::{Deserialize, Serialize};

use crate::log::motion::mean;

/// Errors of an open-loop simulation, in the measured unit (rad, or rad/s where only speed was measured).
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub struct Measures {
    /// Root of the mean square error.
    pub rmse: f64,
    /// Mean absolute error.
    pub ae: f64,
    /// Largest absolute error.
    pub me: f64,
    /// Integral of the absolute error over time (times seconds), summed over records.
    pub iae: f64,
    /// 100 (1 - |error| / |measured - its mean|): 100 is perfect, 0 no better than a constant.
    pub nrmse_fit_percent: f64,
    /// Samples compared.
    pub samples: usize,
    /// Share of what the motor does in a second that is missed: rms change of the error over that of what was measured. Runs that a
    /// disturbance sets off keep their distance, and that counts but once.
    #[serde(skip)]
    pub strayed: f64,
}

/// Over so long a change counts, s.
const A_WHILE_S: f64 = 1.0;

impl Measures {
    /// Share of the motion that is missed: the error over the rms of what was measured about its mean.
    pub fn missed(&self) -> f64 {
        1.0 - 0.01 * self.nrmse_fit_percent
    }
}

/// Sums from which [`Measures`] are made, over any number of records.
#[derive(Debug, Clone, Copy, Default)]
pub struct Sums {
    square: f64,
    absolute: f64,
    largest: f64,
    integral: f64,
    spread: f64,
    /// Squares of the changes of error and measurement within a while.
    changes: [f64; 2],
    samples: usize,
}

impl Sums {
    /// Adds a record: times (s), measured and simulated values.
    pub fn add(&mut self, time_s: &[f64], measured: &[f64], simulated: &[f64]) {
        let mean = mean(measured);
        for (k, (y, p)) in measured.iter().zip(simulated).enumerate() {
            let error = (y - p).abs();
            self.square += error * error;
            self.absolute += error;
            self.largest = self.largest.max(error);
            self.spread += (y - mean) * (y - mean);
            if k > 0 {
                let before = (measured[k - 1] - simulated[k - 1]).abs();
                self.integral += 0.5 * (error + before) * (time_s[k] - time_s[k - 1]);
            }
        }
        let whole = time_s.last().zip(time_s.first()).map_or(0.0, |(last, first)| last - first);
        let mut from = 0;
        for k in 0..measured.len() {
            while time_s[k] - time_s[from] > A_WHILE_S.min(0.5 * whole) {
                let change = [
                    measured[k] - simulated[k] - measured[from] + simulated[from],
                    measured[k] - measured[from],
                ];
                self.changes = [0, 1].map(|i| self.changes[i] + change[i] * change[i]);
                from += 1;
            }
        }
        self.samples += measured.len();
    }

    /// The measures of everything added; none without a sample.
    pub fn measures(&self) -> Option<Measures> {
        let n = self.samples as f64;
        (self.samples > 0).then(|| Measures {
            rmse: (self.square / n).sqrt(),
            ae: self.absolute / n,
            me: self.largest,
            iae: self.integral,
            nrmse_fit_percent: 100.0 * (1.0 - (self.square / self.spread.max(1e-300)).sqrt()),
            samples: self.samples,
            strayed: (self.changes[0] / self.changes[1].max(1e-300)).sqrt(),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_constant_error_gives_the_same_number_three_times() {
        let time: Vec<f64> = (0..11).map(|k| f64::from(k) * 0.1).collect();
        let measured: Vec<f64> = time.iter().map(|t| t.sin()).collect();
        let simulated: Vec<f64> = measured.iter().map(|y| y - 0.5).collect();
        let mut sums = Sums::default();
        sums.add(&time, &measured, &simulated);
        let m = sums.measures().unwrap();
        assert!((m.rmse - 0.5).abs() < 1e-12 && (m.ae - 0.5).abs() < 1e-12 && (m.me - 0.5).abs() < 1e-12);
        assert!((m.iae - 0.5).abs() < 1e-12, "{}", m.iae);
        assert_eq!(Sums::default().measures(), None);
    }

    /// A torque sets an integrating shaft off once; what it does afterwards is right.
    #[test]
    fn a_run_that_was_set_off_and_keeps_its_distance_has_strayed_little() {
        let time: Vec<f64> = (0..2000).map(|k| f64::from(k) * 0.01).collect();
        let measured: Vec<f64> = time.iter().map(|t| (2.0 * t).sin()).collect();
        let run = |t: &f64| (2.0 * t).sin() + if *t > 10.0 { 1.0 } else { 0.0 };
        let mut sums = Sums::default();
        sums.add(&time, &measured, &time.iter().map(run).collect::<Vec<_>>());
        let m = sums.measures().unwrap();
        assert!(m.missed() > 0.9 && m.strayed < 0.25, "{m:?}");
        let mut half = Sums::default();
        half.add(&time, &measured, &measured.iter().map(|y| 0.5 * y).collect::<Vec<_>>());
        assert!((half.measures().unwrap().strayed - 0.5).abs() < 1e-9);
    }
}
