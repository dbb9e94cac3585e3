//! Drag that grows with the square of speed.

use super::spec::{TORQUE, Port, Scale, Spec, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "quadratic_drag",
    port: Port::Torque,
    title: "drag that grows with the square of speed (fan, churning oil)",
    equation: "f = -drag w |w|",
    source: "Newton's drag law",
    signature: "residual torque bends against speed, alike in both directions; top speed is too high in the model",
    parameters: &[strength("drag", "V s^2/rad^2", "torque per square of speed", Scale::VoltPerSpeedSquared, [0.0, 0.3, 12.0])],
    probes: &[&[0.1], &[0.5], &[1.5]],
    search: Search::Probes,
    laws: TORQUE,
    remembers: true,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Torque of `drag` times the square of speed, against it.
#[derive(Debug, Clone, Copy)]
pub struct QuadraticDrag<S> {
    drag: S,
}

impl<S: Scalar> QuadraticDrag<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { drag: parameters[0] }
    }
}

impl<S: Scalar> Effect<S> for QuadraticDrag<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        // The speed in the middle of the step: a drag that acts late brakes too little whenever the motor speeds up.
        let w = memory.store.mul_add(S::lit(0.5), now.state.speed);
        drive.torque -= self.drag * w * w.abs();
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        memory.store = after.speed - now.state.speed;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    /// Steady: w / gain + drag w^2 = v.
    #[test]
    fn steady_speed_solves_the_quadratic() {
        let (drag, v) = (0.02, 9.0);
        let truth = (-1.0 / BASE.gain + libm::sqrt(1.0 / (BASE.gain * BASE.gain) + 4.0 * drag * v)) / (2.0 * drag);
        close(steady_speed(Kind::QuadraticDrag, &[drag], v), truth, 1e-9);
        close(steady_speed(Kind::QuadraticDrag, &[drag], -v), -truth, 1e-9);
    }

    #[test]
    fn the_drag_is_that_at_the_middle_of_the_step() {
        let gain = gain_of_half_steps(Kind::QuadraticDrag, &[0.05]);
        assert!(gain > 3.0, "half the step leaves 1/{gain:.1} of the error");
    }
}
