//! The spectrum of what the voltages of a record would have to bring: where it peaks pulses may come.

use std::f64::consts::TAU;

use rustfft::FftPlanner;
use rustfft::num_complex::Complex;

use super::leg::Leg;

/// The spectrum of a record by frequency.
pub(super) struct Spectrum {
    bins: Vec<Complex<f64>>,
    /// Sum of the powers of all bins before each.
    up_to: Vec<f64>,
    /// Bins a hertz.
    fineness: f64,
}

impl Spectrum {
    pub(super) fn new(leg: &Leg, n: usize, planner: &mut FftPlanner<f64>) -> Self {
        let wanted = leg.wanted();
        let mut bins: Vec<Complex<f64>> =
            wanted.iter().enumerate().map(|(n, v)| leg.bridge.harmonic(n) * v).collect();
        bins.resize(n, Complex::default());
        planner.plan_fft_inverse(n).process(&mut bins);
        let mut up_to = vec![0.0];
        bins.iter().for_each(|c| up_to.push(up_to[up_to.len() - 1] + c.norm_sqr()));
        Self { bins, up_to, fineness: n as f64 * leg.grid.step_s }
    }

    fn bin(&self, hz: f64) -> usize {
        ((hz * self.fineness).round() as usize).min(self.bins.len() - 1)
    }

    /// How much a frequency stands out from those around it.
    fn height(&self, hz: f64) -> f64 {
        const AROUND: usize = 400;
        let k = self.bin(hz);
        let (from, to) = (k.saturating_sub(AROUND), (k + AROUND).min(self.bins.len()));
        let mean = (self.up_to[to] - self.up_to[from]) / (to - from) as f64;
        self.bins[k].norm_sqr() / mean.max(1e-300)
    }

    /// The phase at the record's beginning.
    pub(super) fn phase(&self, hz: f64, step: f64) -> f64 {
        -self.bins[self.bin(hz)].arg() / TAU - 0.5 * hz * step
    }
}

/// Peaks that are looked at.
const PEAKS: usize = 150;

/// The frequencies from `range`, Hz, that stand out most over all records together.
pub(super) fn peaks(spectra: &[Spectrum], range: (f64, f64)) -> Vec<f64> {
    const APART: usize = 6;
    let finest = spectra.iter().map(|s| s.fineness).fold(0.0, f64::max);
    let bins = (range.0 * finest) as usize..(range.1 * finest) as usize;
    let height = |k: usize| spectra.iter().map(|s| s.height(k as f64 / finest)).sum::<f64>();
    let mut order: Vec<(f64, usize)> = bins.map(|k| (height(k), k)).collect();
    order.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut peaks: Vec<usize> = Vec::new();
    for (_, k) in order {
        if peaks.iter().all(|p| p.abs_diff(k) > APART) {
            peaks.push(k);
        }
        if peaks.len() == PEAKS {
            break;
        }
    }
    peaks.into_iter().map(|k| k as f64 / finest).collect()
}
