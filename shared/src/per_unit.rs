//! The motor counted in per-unit quantities, for boards without a floating-point unit.

use crate::base::{Base, Coefficients, Units};
use crate::scalar::Scalar;
use crate::step::{Drive, Laws, State, step};

/// Base model and Coulomb friction in the numbers of `S`, scaled by [`Units`].
#[derive(Debug, Clone, Copy)]
pub struct PerUnit<S> {
    coefficients: Coefficients<S>,
    friction: S,
}

impl<S: Scalar> PerUnit<S> {
    /// Prepares steps of `step_s` seconds; `coulomb_v` is the friction as a voltage.
    #[must_use]
    pub fn new(base: &Base<f64>, coulomb_v: f64, step_s: f64, units: &Units) -> Self {
        Self {
            coefficients: Coefficients::new(base, step_s).per_unit(units),
            friction: S::lit(coulomb_v / units.volt),
        }
    }

    /// One step under a voltage counted in `units.volt`.
    #[inline(always)]
    pub fn advance(&self, state: &mut State<S>, voltage: S) {
        let mut drive = Drive::plain(voltage);
        drive.friction_forward = self.friction;
        drive.friction_backward = self.friction;
        step(&self.coefficients, Laws { dry: true, ..Laws::default() }, state, &drive);
    }
}

/// Largest difference of angle (rad) between per-unit in `S` and the reference in `f64`, at 1 kHz.
#[cfg(test)]
pub(crate) fn compare<S: Scalar + ToF64>(
    base: &Base<f64>,
    coulomb_v: f64,
    volts: &[f64],
    units: &Units,
) -> f64 {
    let one = Units { volt: 1.0, speed: 1.0, angle: 1.0 };
    let reference = PerUnit::<f64>::new(base, coulomb_v, 1e-3, &one);
    let scaled = PerUnit::<S>::new(base, coulomb_v, 1e-3, units);
    let (mut a, mut b) = (State::rest(), State::rest());
    let mut worst: f64 = 0.0;
    for v in volts {
        reference.advance(&mut a, *v);
        scaled.advance(&mut b, S::lit(v / units.volt));
        worst = worst.max((a.angle - b.angle.to_f64() * units.angle).abs());
    }
    worst
}

#[cfg(test)]
pub(crate) trait ToF64 {
    fn to_f64(self) -> f64;
}
#[cfg(test)]
impl<const F: u32> ToF64 for crate::fixed::Fixed<F> {
    fn to_f64(self) -> f64 {
        self.to_f64()
    }
}
