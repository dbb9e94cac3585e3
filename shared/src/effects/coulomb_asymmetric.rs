//! Dry friction that differs by direction.

use super::spec::{DRY, Port, Scale, Spec, shape, strength, Search};
use super::{Coulomb, Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "coulomb_asymmetric",
    port: Port::Torque,
    title: "dry friction of different size forwards and backwards",
    equation: "f = -(level + difference) where w > 0, +(level - difference) where w < 0",
    source: "Armstrong-Helouvry, Dupont, Canudas de Wit 1994, section 2",
    signature: "residual torque steps at zero speed by different heights on the two sides",
    parameters: &[
        strength("level", "V", "mean friction torque as a voltage", Scale::Volt, [0.0, 0.2, 10.0]),
        shape("difference", "V", "half of forward less backward", Scale::Volt, [-5.0, 0.05, 5.0]),
    ],
    probes: &[&[0.2, -0.1], &[0.2, 0.1], &[0.7, -0.35], &[0.7, 0.35]],
    search: Search::Probes,
    laws: DRY,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[("coulomb", "level"), ("constant_load", "difference")],
};

/// Dry friction, `forward` against positive and `backward` against negative speed.
#[derive(Debug, Clone, Copy)]
pub struct CoulombAsymmetric<S> {
    forward: S,
    backward: S,
}

impl<S: Scalar> CoulombAsymmetric<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        let (level, difference) = (parameters[0], parameters[1]);
        let zero = S::zero();
        Self { forward: (level + difference).max(zero), backward: (level - difference).max(zero) }
    }
}

impl<S: Scalar> From<Coulomb<S>> for CoulombAsymmetric<S> {
    fn from(same: Coulomb<S>) -> Self {
        Self { forward: same.level, backward: same.level }
    }
}

impl<S: Scalar> Effect<S> for CoulombAsymmetric<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.friction_forward += self.forward;
        drive.friction_backward += self.backward;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn each_direction_loses_its_own_share() {
        close(steady_speed(Kind::CoulombAsymmetric, &[0.5, 0.2], 6.0), BASE.gain * 5.3, 1e-9);
        close(steady_speed(Kind::CoulombAsymmetric, &[0.5, 0.2], -6.0), -BASE.gain * 5.7, 1e-9);
    }
}
