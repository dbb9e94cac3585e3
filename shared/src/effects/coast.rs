//! A driver that lets the motor float in the off part of the PWM.

use super::spec::{EXPLICIT, Port, Scale, Spec, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "coast",
    port: Port::Voltage,
    title: "the driver floats in the off part of the PWM instead of braking",
    equation: "back-EMF acts for duty d = |v| / supply only:  v = v_log + share (1 - d) k_e w",
    source: "averaged bridge in discontinuous conduction (fast decay)",
    signature: "no electrical braking at zero command; speed is far from proportional to duty",
    parameters: &[strength("share", "1", "1: floats fully; 0: brakes", Scale::One, [0.0, 0.5, 1.0])],
    probes: &[&[0.3], &[0.6], &[1.0]],
    laws: EXPLICIT,
    remembers: false,
    contains: &[],
};

/// Share of the off part in which no current can brake.
#[derive(Debug, Clone, Copy)]
pub struct Coast<S> {
    share: S,
    per_supply: S,
    back_emf: S,
}

impl<S: Scalar> Coast<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { share: parameters[0], per_supply: setting.per_supply, back_emf: setting.back_emf }
    }
}

impl<S: Scalar> Effect<S> for Coast<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        let duty = (drive.voltage.abs() * self.per_supply).min(S::one());
        let floating = self.share * (S::one() - duty);
        drive.voltage += floating * self.back_emf * now.state.speed;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn at_zero_command_only_friction_brakes() {
        let start = State::moving(0.0, 5.0, 0.0);
        let (_, motion) = run_from(start, Kind::Coast, &[1.0], &[0.0; 100]);
        close(motion.state.speed, 5.0 * libm::exp(-0.1 * BASE.viscous_share / BASE.tau_m), 0.03);
    }

    /// Steady: u = v - d k w with u = viscous w.
    #[test]
    fn half_duty_runs_faster_than_half_speed() {
        let (viscous, emf) = (BASE.viscous_share / BASE.gain, (1.0 - BASE.viscous_share) / BASE.gain);
        let truth = 6.0 / (viscous + 0.5 * emf);
        close(steady_speed(Kind::Coast, &[1.0], 6.0), truth, 1e-6);
    }
}
