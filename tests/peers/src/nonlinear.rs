//! A nonlinear kernel, the same source in lanes and as a scalar.

use motorlens::search::dispatch::Work;
use motorlens_shared::base::Base;
use motorlens_shared::effects::{Kind as Effect, Rig};
use motorlens_shared::linear::Laned;
use motorlens_shared::scalar::Scalar;
use motorlens_shared::simulator::Simulator;
use motorlens_shared::step::State;

/// A motor with stick, Stribeck friction, a dead zone and an unbalanced load: several candidates side by side.
pub struct Nonlinear<'a, E> {
    /// V, held.
    pub voltages: &'a [E],
    /// rad.
    pub measured: &'a [E],
}

impl<E: Scalar> Nonlinear<'_, E> {
    /// Sum of the magnitudes of all errors.
    #[inline(always)]
    pub fn sum<T: Scalar<Element = E>>(&self) -> T {
        let typical =
            |kind: Effect| -> Vec<T> { kind.spec().parameters.iter().map(|p| T::lit(p.typical)).collect() };
        let kinds = [Effect::DeadZone, Effect::Stribeck, Effect::Gravity];
        let parameters = kinds.map(typical);
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
        let effects = kinds.into_iter().zip(parameters.iter().map(|p| &p[..]));
        let simulator = Simulator::new(&base, effects, &rig);
        let mut motion = simulator.start(State::rest());
        let mut sum = T::zero();
        for (index, measured) in self.measured.iter().enumerate() {
            sum += (simulator.read(&motion) - T::splat(*measured)).abs();
            simulator.advance(&mut motion, self.voltages, index);
        }
        sum
    }
}

impl Work for Nonlinear<'_, f32> {
    type Output = f64;

    #[inline(always)]
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> f64 {
        let same = Nonlinear::<T::Element> {
            voltages: bytemuck::cast_slice(self.voltages),
            measured: bytemuck::cast_slice(self.measured),
        };
        same.sum::<T>().lane(0)
    }
}
