//! Friction in the gear contact that grows with the torque it passes.

use super::spec::{MESHING, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "load_friction",
    port: Port::Torque,
    title: "gear friction that grows with the torque transmitted",
    equation: "f = -share (sqrt(u^2 + knee^2) - knee) sign(w)",
    source: "tooth-contact losses, e.g. Dohring, Lee, Newman 1993; load-dependent friction of servo models",
    signature: "acceleration is weaker and braking stronger than the model's, in proportion to the current",
    parameters: &[
        strength("share", "1", "share of the motor torque lost", Scale::One, [0.0, 0.1, 0.95]),
        shape("knee", "V", "torque above which it is lost, as a voltage", Scale::Volt, [0.01, 0.2, 3.0]),
    ],
    probes: &[&[0.04, 0.15], &[0.12, 0.15], &[0.3, 0.15]],
    search: Search::Probes,
    laws: MESHING,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Friction of `share` times a motor torque well above `knee`.
#[derive(Debug, Clone, Copy)]
pub struct LoadFriction<S> {
    share: S,
    knee: S,
}

impl<S: Scalar> LoadFriction<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { share: parameters[0], knee: parameters[1] }
    }
}

impl<S: Scalar> Effect<S> for LoadFriction<S> {
    #[inline(always)]
    fn drive(&self, _now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        drive.meshing = self.share;
        drive.meshing_knee = self.knee;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Rig, testing::*};

    /// Steady, far above the knee: (1 - share) u + share knee = b w / c and u = v - k w.
    #[test]
    fn steady_speed_solves_the_balance_of_torques() {
        let (share, v, knee) = (0.2, 6.0, 0.01);
        let viscous = BASE.viscous_share / BASE.gain;
        let emf = (1.0 - BASE.viscous_share) / BASE.gain;
        let truth = ((1.0 - share) * v + share * knee) / (viscous + (1.0 - share) * emf);
        close(steady_speed(Kind::LoadFriction, &[share, knee], v), truth, 1e-4);
    }

    /// The gear contact loses of the torque that saturated iron leaves: f u - share (f u - knee) = b w / c and v = u + f k w, f: the field's share.
    #[test]
    fn behind_saturated_iron_the_teeth_pass_less() {
        use crate::simulator::Simulator;
        let (share, knee, strength, v) = (0.3, 0.01, 1.0, 12.0);
        let base = crate::base::Base { viscous_share: 0.6, ..BASE };
        let effects = [(Kind::LoadFriction, &[share, knee][..]), (Kind::Saturation, &[strength][..])];
        let simulator = Simulator::new(&base, effects, &RIG);
        let mut motion = simulator.start(crate::step::State::rest());
        (0..5000).for_each(|k| simulator.advance(&mut motion, &[v; 5000], k));
        let (w, u) = (motion.state.speed, motion.state.current);
        let field = (v - u) / (w * (1.0 - base.viscous_share) / base.gain);
        assert!(field < 0.9, "iron that does not saturate shows nothing: {field}");
        let passed = field * u;
        close(passed - share * (passed - knee), w * base.viscous_share / base.gain, 2e-3);
    }

    /// A motor that reverses every 10 ms is where short steps take it: the current that turns within a step is lost on both
    /// sides of zero.
    #[test]
    fn a_reversing_current_is_lost_as_in_short_steps() {
        use crate::base::Base;
        use crate::simulator::Simulator;
        let end = |tau_e: f64, share: f64, parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let base = Base { tau_e, ..BASE };
            let simulator = Simulator::new(&base, [(Kind::LoadFriction, &[share, 0.2][..])], &rig);
            let volts: std::vec::Vec<f64> =
                (0..400 * parts).map(|k| if k / (10 * parts) * 7 % 11 < 6 { 9.0 } else { -9.0 }).collect();
            let mut motion = simulator.start(crate::step::State::rest());
            (0..volts.len()).for_each(|k| simulator.advance(&mut motion, &volts, k));
            motion.state.angle
        };
        for tau_e in [2e-3, 3e-3] {
            let truth = end(tau_e, 0.3, 32);
            let done = (truth - end(tau_e, 0.0, 32)).abs();
            let off = (end(tau_e, 0.3, 1) - truth).abs();
            assert!(off < done / 2000.0, "off by 1/{:.0}", done / off);
        }
    }
}
