//! The inner loop of every linear search: 6 multiply-adds, one magnitude and two additions per sample and lane.

use super::discrete::Filter;
use super::laned::Laned;
use super::prepare::Sample;
use crate::scalar::Scalar;

/// Samples summed in the lanes' own precision before the sum moves to `f64`.
///
/// 512 errors of one size lose at most 512 x 2^-24 = 3e-5 of their sum in `f32`, in practice 1e-6.
pub const FLUSH: usize = 512;

/// The filter's memory. Zero is a motor at rest.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct State<T> {
    sum: T,
    change: T,
}

impl<T: Scalar> Default for State<T> {
    #[inline(always)]
    fn default() -> Self {
        Self { sum: T::zero(), change: T::zero() }
    }
}

impl<T: Scalar> Filter<T> {
    /// Prediction minus measurement at the next sample.
    #[inline(always)]
    pub fn error(&self, state: &mut State<T>, sample: Sample<T::Element>) -> T {
        let [voltage, integral, measured] = sample.map(T::splat);
        let error = self.gain.mul_add(integral, -measured);
        let error = self.from_voltage.mul_add(voltage, error);
        let error = self.from_sum.mul_add(state.sum, error);
        let error = self.from_change.mul_add(state.change, error);
        let driven = self.restoring.mul_add(state.sum, voltage);
        state.sum += state.change;
        state.change = self.keeping.mul_add(state.change, driven);
        error
    }
}

/// Adds to `sums`, lane by lane, the magnitudes of all errors of one record. Times the step, this is its IAE.
///
/// # Panics
/// Where `sums` has fewer numbers than `T` has lanes.
#[inline(always)]
pub fn absolute_error<T: Laned>(filter: &Filter<T>, samples: &[Sample<T::Element>], sums: &mut [f64]) {
    let mut state = State::default();
    for block in samples.chunks(FLUSH) {
        let mut sum = T::zero();
        for sample in block {
            sum += filter.error(&mut state, *sample).abs();
        }
        let finished = sum; // a copy: the running sum itself must stay in registers
        flush(&finished, sums);
    }
}

/// Out of line on purpose: were the conversion to `f64` in sight, the compiler would split the lanes of the
/// whole loop to suit the `f64` vectors, which are half as many, and lose half of the speed.
#[inline(never)]
fn flush<T: Laned>(block: &T, sums: &mut [f64]) {
    for lane in 0..T::LANES {
        sums[lane] += block.lane(lane);
    }
}

#[cfg(test)]
mod tests {
    use super::absolute_error;
    use crate::lanes::Lanes;
    use crate::linear::{Filter, Hold, Kind, Laned, Prepare, Sample};
    use crate::motor::Combinations;
    use crate::scalar::Scalar;
    use std::vec::Vec;

    const STEP: f64 = 1e-3;

    /// 12 s of a sine at 1 kHz with the angle of an ideal integrator.
    fn record<T: Scalar>() -> Vec<Sample<T>> {
        let mut prepare = Prepare::new(STEP, Hold::First, Kind::Angle);
        (0..12_000)
            .map(|k| {
                let t = f64::from(k) * STEP;
                let angle = 3.0 * (1.0 - libm::cos(1.57 * t)) + 0.4;
                prepare.push_as(5.0 * libm::sin(1.57 * t), angle)
            })
            .collect()
    }

    fn candidates() -> [Filter<f64>; 16] {
        core::array::from_fn(|k| {
            let k = k as f64;
            let m = Combinations::from_gain_and_rates(0.7 + 0.02 * k, 8.0 + k, 900.0 + 50.0 * k);
            Filter::new(&m, STEP, Hold::First, Kind::Angle)
        })
    }

    fn sums<T: Laned>() -> Vec<f64> {
        let record = record::<T::Element>();
        let mut all = Vec::new();
        for block in candidates().chunks(T::LANES) {
            let mut sums = [0.0; 16];
            absolute_error(&Filter::<T>::gather(block), &record, &mut sums);
            all.extend_from_slice(&sums[..block.len()]);
        }
        all
    }

    #[test]
    fn any_lane_width_gives_the_same_bits() {
        let one = sums::<f32>();
        assert_eq!(one, sums::<Lanes<f32, 8>>());
        assert_eq!(one, sums::<Lanes<f32, 16>>());
        // A width that does not divide the 16 candidates: the last block is not full.
        assert_eq!(one, sums::<Lanes<f32, 5>>());
    }

    #[test]
    fn slow_ringing_poles_keep_their_digits_in_single_precision() {
        // The paper's printed Table 1 at 1 kHz: d1 + d2 = 1 - 2e-5, of which f32 would keep two digits.
        let m = crate::motor::PaperMotor::printed_table_1().combinations();
        let filter = Filter::new(&m, STEP, Hold::First, Kind::Angle);
        let (mut single, mut double) = ([0.0], [0.0]);
        absolute_error(&Filter::<f32>::gather(&[filter]), &record(), &mut single);
        absolute_error(&filter, &record(), &mut double);
        assert!((single[0] / double[0] - 1.0).abs() < 2e-5, "{single:?} {double:?}");
    }

    #[test]
    fn single_precision_stays_within_its_stated_error_of_double() {
        for (single, double) in sums::<f32>().iter().zip(sums::<f64>()) {
            assert!((single / double - 1.0).abs() < 2e-5, "{single} {double}");
        }
    }
}
