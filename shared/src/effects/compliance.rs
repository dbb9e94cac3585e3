//! A springy shaft or belt between motor and load.

use super::spec::{Port, Scale, Spec, between_masses, shape, Search};
use super::{Effect, Setting};
use crate::scalar::Scalar;
use crate::step::State;

pub(super) const SPEC: Spec = Spec {
    name: "compliance",
    port: Port::Transmission,
    title: "a springy shaft, belt or harmonic drive: the load swings against the motor",
    equation: "load: dw_l/dt = (2 pi frequency)^2 (x - x_l) + 2 damping (2 pi frequency) (w - w_l), less its friction",
    source: "two-mass resonance; the symplectic step keeps its energy",
    signature: "ringing at one frequency after every jump of the voltage",
    parameters: &[
        shape("frequency", "Hz", "where the load swings with the motor held", Scale::One, [1.5, 8.0, 80.0]),
        shape("load_share", "1", "load's share of the inertia", Scale::One, [0.05, 0.45, 0.9]),
        shape("damping", "1", "damping ratio of that swing", Scale::One, [0.002, 0.05, 1.0]),
        shape("load_damping", "1", "load's share of the viscous friction", Scale::One, [0.0, 0.3, 1.0]),
    ],
    probes: &[
        &[3.5, 0.45, 0.05, 0.3], &[5.0, 0.45, 0.05, 0.3], &[7.0, 0.45, 0.05, 0.3], &[10.0, 0.45, 0.05, 0.3],
        &[14.0, 0.45, 0.05, 0.3], &[20.0, 0.45, 0.05, 0.3], &[28.0, 0.45, 0.05, 0.3], &[40.0, 0.45, 0.05, 0.3],
    ],
    search: Search::Probes,
    laws: between_masses(4),
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// A spring and a damper between rotor and load.
#[derive(Debug, Clone, Copy)]
pub struct Compliance<S> {
    stiffness: S,
    damping: S,
    load_per_rotor: S,
    /// Share of its speed that the load keeps over a step against its own friction.
    keep: S,
}

impl<S: Scalar> Compliance<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let rate = parameters[0] * S::lit(core::f64::consts::TAU);
        let share = parameters[1];
        Self {
            stiffness: rate * rate,
            damping: S::lit(2.0) * parameters[2] * rate,
            load_per_rotor: share / (S::one() - share),
            keep: S::one() - setting.step * setting.damping * parameters[3] / share,
        }
    }
}

impl<S: Scalar> Effect<S> for Compliance<S> {
    #[inline(always)]
    fn couple(&self, part: S, s: &mut State<S>) {
        // Rotor and load arrive first, both at the speeds of before; then the shaft pulls at both.
        s.load_angle += s.load_speed * part;
        let pull = self.damping * (s.speed - s.load_speed) + self.stiffness * (s.angle - s.load_angle);
        let kick = pull * part;
        s.load_speed = self.keep.mul_add(s.load_speed, kick);
        s.speed -= kick * self.load_per_rotor;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};

    #[test]
    fn load_and_rotor_turn_at_the_no_load_speed_in_steady_motion() {
        let (_, motion) = run(Kind::Compliance, &[8.0, 0.45, 0.2, 0.3], &[6.0; 3000]);
        close(motion.state.speed, BASE.gain * 6.0, 1e-3);
        close(motion.state.load_speed, BASE.gain * 6.0, 1e-3);
    }

    /// With the rotor held by a heavy inertia the load swings at the stated frequency.
    #[test]
    fn load_swings_at_the_stated_frequency() {
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let spring = super::Compliance::new(&[8.0, 1e-9, 1e-6, 0.0], &setting);
        let mut s = crate::step::State::rest();
        s.load_angle = 0.1;
        let (mut crossings, part) = (0, 2.5e-4);
        for _ in 0..4000 {
            let before = s.load_angle;
            super::Effect::couple(&spring, part, &mut s);
            crossings += usize::from(before * s.load_angle < 0.0);
        }
        assert_eq!(crossings, 16); // eight swings in one second
    }

    /// A load whose angle is a part of a step further on than the rotor's would show a negative delay.
    #[test]
    fn the_load_is_seen_where_short_steps_have_it() {
        use crate::effects::Rig;
        use crate::simulator::Simulator;
        let run = |parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let spring = [12.0, 0.4, 0.1, 0.3];
            let simulator = Simulator::new(&BASE, [(Kind::Compliance, &spring[..])], &rig);
            let volts: std::vec::Vec<f64> =
                (0..800 * parts).map(|k| if k / (50 * parts) * 7 % 11 < 6 { 9.0 } else { -9.0 }).collect();
            let mut motion = simulator.start(crate::step::State::rest());
            let mut angles = std::vec::Vec::new();
            for k in 0..volts.len() {
                simulator.advance(&mut motion, &volts, k);
                if (k + 1) % parts == 0 {
                    angles.push([motion.state.load_angle, motion.state.load_speed]);
                }
            }
            angles
        };
        let (coarse, fine) = (run(1), run(32));
        let late = |(a, b): (&[f64; 2], &[f64; 2])| [(b[0] - a[0]) * b[1], b[1] * b[1]];
        let sums = coarse.iter().zip(&fine).map(late).fold([0.0; 2], |s, x| [s[0] + x[0], s[1] + x[1]]);
        // How much later the coarse run has the load where it was, s.
        let lag = sums[0] / sums[1];
        assert!(lag.abs() < 5e-5, "{lag:e} s");
    }

    /// Rates: damping and inertia of the load are shares of the whole.
    #[test]
    fn behind_a_soft_spring_the_load_is_braked_by_its_own_friction() {
        let setting = super::super::Setting::new(&BASE, &RIG, 1);
        let spring = super::Compliance::new(&[1e-3, 0.4, 0.0, 0.3], &setting);
        let mut s = crate::step::State { load_speed: 2.0, ..crate::step::State::rest() };
        for _ in 0..400 {
            super::Effect::couple(&spring, 1e-3, &mut s);
        }
        let rate = BASE.viscous_share / BASE.tau_m * 0.3 / 0.4;
        close(s.load_speed, 2.0 * libm::exp(-0.4 * rate), 2e-3);
    }
}
