//! Dry friction of one size in both directions.

use super::spec::{DRY, Port, Scale, Spec, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "coulomb",
    port: Port::Torque,
    title: "dry (Coulomb) friction, the same at every speed",
    equation: "f = -level sign(w); at rest, whatever holds it there up to level",
    source: "Coulomb 1785; set-valued form and its implicit step: Moreau 1988",
    signature: "residual torque is a step at zero speed; small voltages do not move the shaft",
    parameters: &[strength("level", "V", "friction torque as a voltage", Scale::Volt, [0.0, 0.2, 10.0])],
    probes: &[&[0.05], &[0.2], &[0.6], &[1.2]],
    search: Search::Probes,
    laws: DRY,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Dry friction of size `level`.
#[derive(Debug, Clone, Copy)]
pub struct Coulomb<S> {
    pub(super) level: S,
}

impl<S: Scalar> Coulomb<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { level: parameters[0] }
    }
}

impl<S: Scalar> Effect<S> for Coulomb<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.friction_forward += self.level;
        drive.friction_backward += self.level;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn steady_speed_loses_gain_times_level() {
        close(steady_speed(Kind::Coulomb, &[0.5], 6.0), BASE.gain * 5.5, 1e-9);
        close(steady_speed(Kind::Coulomb, &[0.5], -6.0), -BASE.gain * 5.5, 1e-9);
    }

    #[test]
    fn below_the_level_the_shaft_does_not_move_at_all() {
        assert_eq!(steady_speed(Kind::Coulomb, &[0.5], 0.49), 0.0);
    }

    #[test]
    fn coasting_stops_exactly_and_in_finite_time() {
        let start = State::moving(0.0, 4.0, 0.0);
        let (angles, motion) = run_from(start, Kind::Coulomb, &[0.5], &[0.0; 1000]);
        assert_eq!(motion.state.speed, 0.0);
        assert_eq!(angles[900], angles[999]);
    }
}
