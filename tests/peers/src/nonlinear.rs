//! A nonlinear kernel, the same source in lanes and as a scalar.

use motorlens::search::dispatch::Work;
use motorlens_shared::base::Base;
use motorlens_shared::effects::together::{Nothing, With};
use motorlens_shared::effects::{DeadZone, Gravity, Named, Rig, Setting, Stribeck};
use motorlens_shared::linear::Laned;
use motorlens_shared::scalar::Scalar;
use motorlens_shared::simulator::{Prepared, Simulator};
use motorlens_shared::step::State;

/// A motor with stick, Stribeck friction, a dead zone and an unbalanced load: several candidates side by side.
///
/// `BLOCKS` blocks of lanes go side by side: one block alone waits for its own results most of the time.
pub struct Nonlinear<'a, E, const BLOCKS: usize = 1> {
    /// V, held.
    pub voltages: &'a [E],
    /// rad.
    pub measured: &'a [E],
}

/// An effect of the size that one meets.
#[inline(always)]
fn typical<T: Scalar, E: Named<T>>(setting: &Setting<T>) -> E {
    let parameters: Vec<T> = E::SPEC.parameters.iter().map(|p| T::lit(p.typical)).collect();
    E::named(&parameters, setting)
}

impl<E: Scalar, const BLOCKS: usize> Nonlinear<'_, E, BLOCKS> {
    /// Sum of the magnitudes of all errors.
    #[inline(always)]
    pub fn sums<T: Scalar<Element = E>>(&self) -> [T; BLOCKS] {
        let base = Base {
            gain: T::lit(0.57),
            tau_m: T::lit(0.045),
            tau_e: T::lit(6e-4),
            viscous_share: T::lit(0.06),
        };
        let rig = Rig {
            step_s: 1e-3,
            gear_ratio: 104.0,
            encoder_on_motor: false,
            nominal_v: 12.0,
            supply_v: 12.0,
            reference_speed: 6.9,
            count_rad: 1.26e-3,
        };
        // Known to the compiler, as in the host's inner loop.
        let prepared = Prepared::new(&base, &[], &rig);
        let setting = prepared.setting;
        let friction =
            With(typical::<T, Stribeck<T>>(&setting), With(typical::<T, Gravity<T>>(&setting), Nothing));
        let simulator = Simulator::with(prepared, With(typical::<T, DeadZone<T>>(&setting), friction));
        // Each block begins elsewhere, or the compiler could see that they do the same.
        let start = |block: usize| State::moving(T::zero(), T::zero(), T::lit(1e-3 * block as f64));
        let mut motions: [_; BLOCKS] = std::array::from_fn(|block| simulator.start(start(block)));
        let mut sums = [T::zero(); BLOCKS];
        for (index, measured) in self.measured.iter().enumerate() {
            for (motion, sum) in motions.iter_mut().zip(&mut sums) {
                *sum += (simulator.read(motion) - T::splat(*measured)).abs();
                simulator.advance(motion, self.voltages, index);
            }
        }
        sums
    }
}

impl<const BLOCKS: usize> Work for Nonlinear<'_, f32, BLOCKS> {
    type Output = f64;

    #[inline(always)]
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> f64 {
        let same = Nonlinear::<T::Element, BLOCKS> {
            voltages: bytemuck::cast_slice(self.voltages),
            measured: bytemuck::cast_slice(self.measured),
        };
        same.sums::<T>().map(|sum| sum.lane(0)).iter().sum()
    }
}
