//! A gap in the gear.

use super::spec::{Port, Scale, Spec, between_masses, shape, strength, Search};
use super::{Effect, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "backlash",
    port: Port::Transmission,
    title: "a gap in the gear: the load follows only after the gap is crossed",
    equation: "the gear contact pushes with stiffness (|x - x_load| - gap/2) + damping (w - w_load) while it touches, and never pulls",
    source: "two masses, modified dead zone: Nordin, Gutman 2002",
    signature: "after each reversal the rotor turns freely for the width of the gap, then is braked at once",
    parameters: &[
        strength("gap", "rad", "free angle at the output shaft", Scale::Degree, [0.02, 1.0, 12.0]),
        shape("load_share", "1", "load's share of the inertia", Scale::One, [0.05, 0.45, 0.9]),
        shape("load_damping", "1", "load's share of the viscous friction", Scale::One, [0.0, 0.3, 1.0]),
        shape("contact", "Hz", "natural frequency of rotor against load while the gear contact touches", Scale::One, [60.0, 150.0, 400.0]),
        shape("contact_damping", "1", "damping ratio of that contact", Scale::One, [0.02, 0.3, 1.5]),
    ],
    probes: &[
        &[0.3, 0.3, 0.3, 150.0, 0.3], &[0.8, 0.3, 0.3, 150.0, 0.3], &[1.6, 0.3, 0.3, 150.0, 0.3], &[3.2, 0.3, 0.3, 150.0, 0.3],
        &[0.3, 0.6, 0.3, 150.0, 0.3], &[0.8, 0.6, 0.3, 150.0, 0.3], &[1.6, 0.6, 0.3, 150.0, 0.3], &[3.2, 0.6, 0.3, 150.0, 0.3],
    ],
    search: Search::Probes,
    laws: between_masses(8),
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// A gap of `2 half_gap` between rotor and load.
#[derive(Debug, Clone, Copy)]
pub struct Backlash<S> {
    half_gap: S,
    share: S,
    /// Share of its speed that the load keeps over a step in the gap.
    keep: S,
    /// Change of the relative speed over a step in contact, per overlap and per way that they closed in.
    push: S,
    damp: S,
}

impl<S: Scalar> Backlash<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let share = parameters[1];
        let rate = parameters[3] * S::lit(core::f64::consts::TAU);
        let loss = S::lit(2.0) * parameters[4] * rate;
        // The damping acts on the speed at the step's end.
        let held = S::one() / (S::one() + loss * setting.step);
        Self {
            half_gap: parameters[0] * S::lit(0.5),
            share,
            keep: S::one() - setting.step * setting.damping * parameters[2] / share,
            push: rate * rate * setting.step * held,
            damp: loss * held,
        }
    }
}

impl<S: Scalar> Effect<S> for Backlash<S> {
    #[inline(always)]
    fn couple(&self, part: S, s: &mut State<S>) {
        let coasted = self.keep * s.load_speed;
        s.load_angle += S::lit(0.5) * part * (s.load_speed + coasted);
        s.load_speed = coasted;
        // How far rotor and load overlap (signed). Gears that met within the step were braked for a part of it: as far as
        // they overlap.
        let overlap = (s.angle - s.load_angle).shrink(self.half_gap);
        let closing = part * (s.speed - s.load_speed);
        let braked = closing - closing.shrink(overlap.abs());
        let change = self.push * overlap + self.damp * braked;
        let zero = S::zero();
        let passed = S::pick_gt(overlap * change, zero, change, zero);
        s.speed -= self.share * passed;
        s.load_speed += (S::one() - self.share) * passed;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use crate::step::State;

    #[test]
    fn load_lags_by_half_the_gap_in_steady_motion() {
        let (_, motion) = run(Kind::Backlash, &[0.1, 0.4, 0.3, 150.0, 0.3], &[6.0; 2000]);
        let lag = motion.state.angle - motion.state.load_angle;
        assert!((0.05..0.0502).contains(&lag), "{lag}: the teeth bend a little");
        close(motion.state.speed, BASE.gain * 6.0, 1e-3);
    }

    /// Rotor and load meet at a speed of 2 rad/s; the contact of damping ratio z throws them apart with
    /// e^(-pi z / sqrt(1 - z^2)) of it, but for the teeth's letting go where they would begin to pull.
    #[test]
    fn contact_keeps_the_momentum_and_gives_back_what_its_damping_leaves() {
        let (share, damping, part) = (0.4, 0.1, 1e-5);
        let setting = super::super::Setting { step: part, ..super::super::Setting::new(&BASE, &RIG, 1) };
        let gap = super::Backlash::new(&[0.1, share, 0.0, 100.0, damping], &setting);
        let mut state = State { speed: 2.0, angle: 0.0499, ..State::rest() };
        for _ in 0..2000 {
            state.angle += part * state.speed;
            super::Effect::couple(&gap, part, &mut state);
        }
        close((1.0 - share) * state.speed + share * state.load_speed, 2.0 * (1.0 - share), 1e-9);
        let rebound = (state.load_speed - state.speed) / 2.0;
        let linear = libm::exp(-core::f64::consts::PI * damping / libm::sqrt(1.0 - damping * damping));
        assert!((linear..linear + 0.04).contains(&rebound), "{rebound} {linear}");
    }

    /// Gears that meet just before the end of a step are braked for that moment only: where they meet within it makes
    /// no jump, which no search could find its way across.
    #[test]
    fn the_moment_of_meeting_makes_no_jump() {
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let gap = super::Backlash::new(&[0.1, 0.4, 0.0, 150.0, 0.5], &setting);
        let after = |overlap: f64| {
            let mut state = State { speed: 2.0, angle: 0.05 + overlap, ..State::rest() };
            super::Effect::couple(&gap, 1e-4, &mut state);
            state.speed
        };
        close(after(1e-9), 2.0, 1e-6);
        close(after(2e-6) - 2.0, 2.0 * (after(1e-6) - 2.0), 1e-6);
    }

    /// Rates: damping and inertia of the load are shares of the whole.
    #[test]
    fn in_the_gap_the_load_is_braked_by_its_own_friction() {
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let gap = super::Backlash::new(&[9.0, 0.4, 0.3, 150.0, 0.3], &setting);
        let mut state = State { load_speed: 2.0, ..State::rest() };
        for _ in 0..400 {
            super::Effect::couple(&gap, 1e-3, &mut state);
        }
        let rate = BASE.viscous_share / BASE.tau_m * 0.3 / 0.4;
        close(state.load_speed, 2.0 * libm::exp(-0.4 * rate), 2e-3);
    }
}
