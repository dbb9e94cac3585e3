//! The numbers that a search runs on: those of the core's floating-point unit, or integers where it has none.

use super::Kept;
use super::discrete;
use crate::base::{Base, Units};
use crate::fixed::Fixed as FixedPoint;
use crate::lanes::Lanes;
use crate::linear::{Filter, absolute_error};
use crate::per_unit::PerUnit;
use crate::scalar::Scalar;
use crate::step::State;

/// Candidates that share one pass over the samples. Two fit the registers of a Cortex-M4F.
pub(super) const LANES: usize = 2;
/// Fractional bits: a range of +-64 units.
const BITS: u32 = 25;

/// The record that a search compares its candidates with.
pub struct Record<'a> {
    /// The samples, one or more.
    pub samples: &'a [Kept],
    /// Time between them, s.
    pub step_s: f32,
    /// Counts per V s, roughly; of the motor's sign.
    pub gain: f32,
    /// The largest voltage, V; more than 0.
    pub peak_v: f32,
}

/// How a search simulates its candidates.
pub trait Arithmetic {
    /// Sums of absolute errors, counts, of motors given by gain (counts per V s), tau_m and tau_e (s).
    fn absolute_sums(record: &Record<'_>, motors: &[[f32; 3]], sums: &mut [f64]);
}

/// `f32`, for cores with a floating-point unit.
#[derive(Debug, Clone, Copy)]
pub struct Float;

impl Arithmetic for Float {
    // Not inlined, so that it is compiled, and optimised, with this crate.
    #[inline(never)]
    fn absolute_sums(record: &Record<'_>, motors: &[[f32; 3]], sums: &mut [f64]) {
        for (motors, sums) in motors.chunks(LANES).zip(sums.chunks_mut(LANES)) {
            let filters: [Filter<f32>; LANES] = core::array::from_fn(|lane| {
                discrete::filter(motors[lane.min(motors.len() - 1)], record.step_s)
            });
            let mut found = [0.0; LANES];
            absolute_error(&side_by_side(&filters), record.samples, &mut found);
            sums.copy_from_slice(&found[..sums.len()]);
        }
    }
}

fn side_by_side(filters: &[Filter<f32>; LANES]) -> Filter<Lanes<f32, LANES>> {
    let lanes = |value: fn(&Filter<f32>) -> f32| Lanes(core::array::from_fn(|lane| value(&filters[lane])));
    Filter {
        gain: lanes(|filter| filter.gain),
        from_voltage: lanes(|filter| filter.from_voltage),
        from_sum: lanes(|filter| filter.from_sum),
        from_change: lanes(|filter| filter.from_change),
        restoring: lanes(|filter| filter.restoring),
        keeping: lanes(|filter| filter.keeping),
    }
}

/// 32-bit fixed point on the per-unit step model, for cores without a floating-point unit.
#[derive(Debug, Clone, Copy)]
pub struct Fixed;

impl Arithmetic for Fixed {
    #[inline(never)]
    fn absolute_sums(record: &Record<'_>, motors: &[[f32; 3]], sums: &mut [f64]) {
        // The same units for all candidates: their gains differ from the rough one by a small factor only.
        let speed = f64::from(record.gain.abs() * record.peak_v);
        let steps = record.samples.len().next_power_of_two() as f64;
        let volt = f64::from(record.peak_v);
        let units = Units { volt, speed, angle: speed * f64::from(record.step_s) * steps };
        let one = (1_u32 << BITS) as f32;
        let per_volt = one / record.peak_v;
        let per_count = one / units.angle as f32;
        for (motor, sum) in motors.iter().zip(sums) {
            let [gain, tau_m, tau_e] = motor.map(f64::from);
            let base = Base { gain, tau_m, tau_e, viscous_share: 0.0 };
            let model = PerUnit::<FixedPoint<BITS>>::new(&base, 0.0, record.step_s.into(), &units);
            let mut state = State::rest();
            let mut total = 0_i64;
            for [voltage, _, measured] in record.samples {
                // Rounding towards zero costs a 2^25th of the range.
                let error: FixedPoint<BITS> = state.angle - FixedPoint((measured * per_count) as i32);
                total += i64::from(Scalar::abs(error).0);
                model.advance(&mut state, FixedPoint((voltage * per_volt) as i32));
            }
            *sum = total as f64 * FixedPoint::<BITS>::RESOLUTION * units.angle;
        }
    }
}
