//! A gap in the gear.

use super::spec::{EXPLICIT, Port, Scale, Spec, shape, strength};
use super::{Effect, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "backlash",
    port: Port::Transmission,
    title: "a gap in the gear: the load follows only after the gap is crossed",
    equation: "|x - x_load| <= gap/2; at contact w - w_load becomes -rebound (w - w_load), the common momentum stays",
    source: "two masses (Nordin, Gutman 2002) with Newton's coefficient of restitution",
    signature: "after each reversal the rotor turns freely for the width of the gap, then is braked at once",
    parameters: &[
        strength("gap", "rad", "free angle at the output shaft", Scale::Degree, [0.02, 1.0, 12.0]),
        shape("load_share", "1", "load's share of the inertia", Scale::One, [0.05, 0.45, 0.9]),
        shape("load_damping", "1", "load's share of the viscous friction", Scale::One, [0.0, 0.3, 1.0]),
        shape("rebound", "1", "speed after a contact as a share of that before", Scale::One, [0.0, 0.3, 0.9]),
    ],
    probes: &[
        &[0.3, 0.3, 0.3, 0.3], &[0.8, 0.3, 0.3, 0.3], &[1.6, 0.3, 0.3, 0.3], &[3.2, 0.3, 0.3, 0.3],
        &[0.3, 0.6, 0.3, 0.3], &[0.8, 0.6, 0.3, 0.3], &[1.6, 0.6, 0.3, 0.3], &[3.2, 0.6, 0.3, 0.3],
    ],
    laws: EXPLICIT,
    remembers: false,
    contains: &[],
};

/// A gap of `2 half_gap` between rotor and load.
#[derive(Debug, Clone, Copy)]
pub struct Backlash<S> {
    half_gap: S,
    share: S,
    /// Share of its speed that the load keeps over a step in the gap.
    keep: S,
    /// 1 + rebound.
    turn: S,
}

impl<S: Scalar> Backlash<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let share = parameters[1];
        Self {
            half_gap: parameters[0] * S::lit(0.5),
            share,
            keep: S::one() - setting.step * setting.damping * parameters[2] / share,
            turn: S::one() + parameters[3],
        }
    }
}

impl<S: Scalar> Effect<S> for Backlash<S> {
    #[inline(always)]
    fn couple(&self, part: S, s: &mut State<S>) {
        let coasted = self.keep * s.load_speed;
        s.load_angle += S::lit(0.5) * part * (s.load_speed + coasted);
        s.load_speed = coasted;
        let lead = s.angle - s.load_angle;
        // How far rotor and load overlap (signed), and whether they still close in on each other.
        let overlap = lead.shrink(self.half_gap);
        let closing = s.speed - s.load_speed;
        let zero = S::zero();
        let passed = S::pick_gt(overlap * closing, zero, self.turn * closing, zero);
        s.speed -= self.share * passed;
        s.load_speed += (S::one() - self.share) * passed;
        // The overlap is shared out by inertia, so that the common centre stays where it is.
        s.angle -= overlap * self.share;
        s.load_angle += overlap * (S::one() - self.share);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn load_lags_by_half_the_gap_in_steady_motion() {
        let (_, motion) = run(Kind::Backlash, &[0.1, 0.4, 0.3, 0.3], &[6.0; 2000]);
        close(motion.state.angle - motion.state.load_angle, 0.05, 1e-6);
        close(motion.state.speed, BASE.gain * 6.0, 1e-3);
    }

    #[test]
    fn contact_keeps_the_momentum() {
        let (share, rebound) = (0.4, 0.25);
        let mut state = State { speed: 2.0, ..State::rest() };
        state.angle = 0.06;
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let gap = super::Backlash::new(&[0.1, share, 0.0, rebound], &setting);
        super::Effect::couple(&gap, 1e-3, &mut state);
        close((1.0 - share) * state.speed + share * state.load_speed, 2.0 * (1.0 - share), 1e-12);
        close(state.load_speed - state.speed, rebound * 2.0, 1e-12);
        close(state.angle - state.load_angle, 0.05, 1e-12);
    }

    /// Rates: damping and inertia of the load are shares of the whole.
    #[test]
    fn in_the_gap_the_load_is_braked_by_its_own_friction() {
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let gap = super::Backlash::new(&[9.0, 0.4, 0.3, 0.0], &setting);
        let mut state = State { load_speed: 2.0, ..State::rest() };
        for _ in 0..400 {
            super::Effect::couple(&gap, 1e-3, &mut state);
        }
        let rate = BASE.viscous_share / BASE.tau_m * 0.3 / 0.4;
        close(state.load_speed, 2.0 * libm::exp(-0.4 * rate), 2e-3);
    }
}
