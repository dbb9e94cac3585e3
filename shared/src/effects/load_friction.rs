//! Friction in the gear teeth that grows with the torque they pass.

use super::spec::{DRY, Port, Scale, Spec, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "load_friction",
    port: Port::Torque,
    title: "gear friction that grows with the torque transmitted",
    equation: "f = -share |u| sign(w)",
    source: "tooth-contact losses, e.g. Dohring, Lee, Newman 1993; load-dependent friction of servo models",
    signature: "acceleration is weaker and braking stronger than the model's, in proportion to the current",
    parameters: &[strength("share", "1", "share of the motor torque lost", Scale::One, [0.0, 0.1, 0.95])],
    probes: &[&[0.04], &[0.12], &[0.3]],
    laws: DRY,
    remembers: false,
    contains: &[],
};

/// Friction of `share` times the motor torque.
#[derive(Debug, Clone, Copy)]
pub struct LoadFriction<S> {
    share: S,
}

impl<S: Scalar> LoadFriction<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { share: parameters[0] }
    }
}

impl<S: Scalar> Effect<S> for LoadFriction<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        let friction = self.share * now.state.current.abs();
        drive.friction_forward += friction;
        drive.friction_backward += friction;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    /// Steady: (1 - share) u = b w / c and u = v - k w.
    #[test]
    fn steady_speed_solves_the_balance_of_torques() {
        let (share, v) = (0.2, 6.0);
        let viscous = BASE.viscous_share / BASE.gain;
        let emf = (1.0 - BASE.viscous_share) / BASE.gain;
        let truth = (1.0 - share) * v / (viscous + (1.0 - share) * emf);
        close(steady_speed(Kind::LoadFriction, &[share], v), truth, 1e-9);
    }
}
