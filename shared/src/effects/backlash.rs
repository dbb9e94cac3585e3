//! A gap in the gear.

use super::spec::{EXPLICIT, Port, Scale, Spec, shape, strength};
use super::{Effect, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "backlash",
    port: Port::Transmission,
    title: "a gap in the gear: the load follows only after the gap is crossed",
    equation: "|x - x_load| <= gap/2; at contact both go on with their common momentum",
    source: "two masses with inelastic contact (Nordin, Gutman 2002)",
    signature: "after each reversal the rotor turns freely for the width of the gap, then is braked at once",
    parameters: &[
        strength("gap", "rad", "free angle at the output shaft", Scale::Degree, [0.02, 1.0, 12.0]),
        shape("load_share", "1", "load's share of the inertia", Scale::One, [0.05, 0.45, 0.9]),
    ],
    probes: &[
        &[0.3, 0.3], &[0.8, 0.3], &[1.6, 0.3], &[3.2, 0.3],
        &[0.3, 0.6], &[0.8, 0.6], &[1.6, 0.6], &[3.2, 0.6],
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
}

impl<S: Scalar> Backlash<S> {
    pub(super) fn new(parameters: &[S], _setting: &Setting<S>) -> Self {
        Self { half_gap: parameters[0] * S::lit(0.5), share: parameters[1] }
    }
}

impl<S: Scalar> Effect<S> for Backlash<S> {
    #[inline(always)]
    fn couple(&self, part: S, s: &mut State<S>) {
        s.load_angle += part * s.load_speed;
        let lead = s.angle - s.load_angle;
        // How far rotor and load overlap (signed), and whether they still close in on each other.
        let overlap = lead.shrink(self.half_gap);
        let closing = overlap * (s.speed - s.load_speed);
        let zero = S::zero();
        let common = self.share.mul_add(s.load_speed - s.speed, s.speed);
        s.speed = S::pick_gt(closing, zero, common, s.speed);
        s.load_speed = S::pick_gt(closing, zero, common, s.load_speed);
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
        let (_, motion) = run(Kind::Backlash, &[0.1, 0.4], &[6.0; 2000]);
        close(motion.state.angle - motion.state.load_angle, 0.05, 1e-9);
        close(motion.state.speed, BASE.gain * 6.0, 1e-6);
    }

    #[test]
    fn contact_keeps_the_momentum() {
        let share = 0.4;
        let mut state = State { speed: 2.0, ..State::rest() };
        state.angle = 0.06;
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let gap = super::Backlash::new(&[0.1, share], &setting);
        super::Effect::couple(&gap, 1e-3, &mut state);
        close(state.speed, 2.0 * (1.0 - share), 1e-12);
        close(state.speed, state.load_speed, 0.0);
        close(state.angle - state.load_angle, 0.05, 1e-12);
    }
}
