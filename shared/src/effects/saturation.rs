//! Iron that saturates: less torque per ampere at high current.

use super::decay::decay;
use super::spec::{Port, Scale, Spec, TORQUE, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "saturation",
    port: Port::Voltage,
    title: "the iron saturates: torque per ampere falls at high current",
    equation: "K_t and k_e scale with (5 + q) / (5 + 6 q),  q = strength (u / nominal)^2",
    source: "tanh(x) / x, the usual curve of magnetisation with one knee, as its Pade quotient in x^2 = 3 q",
    signature: "jumps of the voltage accelerate less than the model says; slow motion fits",
    parameters: &[strength("strength", "1", "loss at stall, where it is small", Scale::One, [0.0, 0.3, 8.0])],
    probes: &[&[0.15], &[0.6], &[2.0]],
    laws: TORQUE,
    remembers: false,
    contains: &[],
};

/// Field weakening: with the square of a small current, in proportion to a large one.
#[derive(Debug, Clone, Copy)]
pub struct Saturation<S> {
    strength: S,
    per_nominal: S,
    back_emf: S,
    /// How much of its way to rest the current has gone by the middle of a step, and by its end.
    arrived: [S; 2],
}

impl<S: Scalar> Saturation<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let arrived = |share: f64| S::one() - decay(S::lit(share) * setting.step / setting.tau_e);
        let (strength, per_nominal, back_emf) = (parameters[0], setting.per_nominal, setting.back_emf);
        Self { strength, per_nominal, back_emf, arrived: [arrived(0.5), arrived(1.0)] }
    }
}

impl<S: Scalar> Saturation<S> {
    /// The share of the field that is left at `current`, V.
    #[inline(always)]
    fn field(&self, current: S) -> S {
        let x = current * self.per_nominal;
        let q = self.strength * x * x;
        let five = S::lit(5.0);
        (five + q) / q.mul_add(S::lit(6.0), five)
    }
}

impl<S: Scalar> Effect<S> for Saturation<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        // A jump of the voltage changes current and field within the step: by Simpson's rule over the current's way.
        let first = now.state.current;
        let emf = self.back_emf * now.state.speed;
        let lost = S::one() - self.field(first);
        let way = drive.voltage - emf + lost * emf - first;
        let [middle, last] = self.arrived.map(|part| part.mul_add(way, first));
        let (in_middle, at_last) = (S::one() - self.field(middle), S::one() - self.field(last));
        let mean = |a: S, b: S, c: S| (S::lit(4.0).mul_add(b, a) + c) * S::lit(1.0 / 6.0);
        drive.torque -= mean(lost * first, in_middle * middle, at_last * last);
        drive.voltage += emf * mean(lost, in_middle, at_last);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn it_follows_the_hyperbolic_tangent_up_to_twice_its_knee() {
        for x in [0.2, 0.5, 1.0, 1.5, 2.0_f64] {
            let q = x * x / 3.0;
            close((5.0 + q) / (5.0 + 6.0 * q), x.tanh() / x, 6e-3);
        }
    }

    /// A motor held by a spring ends where the weakened torque balances it: u = v.
    #[test]
    fn stalled_torque_is_weakened_as_stated() {
        use crate::simulator::Simulator;
        let (weak, spring) = ([0.6], [2.0, 0.0]);
        let s = Simulator::new(&BASE, [(Kind::Saturation, &weak[..]), (Kind::Spring, &spring[..])], &RIG);
        let mut motion = s.start(crate::step::State::rest());
        let volts = [6.0; 8000];
        for k in 0..volts.len() {
            s.advance(&mut motion, &volts, k);
        }
        close(motion.state.angle, 6.0 * (5.15 / 5.9) / 2.0, 1e-6);
    }
}
