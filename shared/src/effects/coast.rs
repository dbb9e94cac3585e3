//! A driver that lets the motor float in the off part of the PWM.
//!
//! Of a PWM period T the driver gives the whole supply V for the duty d, switches off for the share f, and shorts the
//! winding for what is left: mixed decay, which is fast first and slow then. With u the current, E the back-EMF and D
//! the drop of two diodes:
//!
//! ```text
//! driven         d T                  tau u' = V - E - u
//! floating       f T                  tau u' = -(V + D) - E - u   until u = 0: the diodes return it to the supply
//!                                     terminals at E, no current  for the rest
//! shorted        (1 - d - f) T        tau u' = -E - u
//! ```
//! Where the diodes have ended the current, the short leaves u_0 = -E (1 - e^(-(1-d-f)T/tau)) for the next period, and
//! u_b = (V - E)(1 - e^(-dT/tau)) + u_0 e^(-dT/tau) is there when the driver switches off. The diodes conduct for the
//! share min(f, tau/T ln(1 + |u_b| / (V + D +- E))) of the period, + where u_b > 0. That is exact for a current that
//! ends within the period, and for one that never ends, where the share is f whatever the current began with. The mean
//! voltage at the terminals then makes the mean current; the winding's own lag stays with the base model.

use super::decay::decay;
use super::pwm::{Pwm, remember};
use super::spec::{EXPLICIT, Port, Scale, Spec, shape, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "coast",
    port: Port::Voltage,
    title: "the driver floats in the off part of the PWM instead of braking",
    equation: "v = v_log + f k_e w - g (supply + 1.4 V + k_e w),  f = share (1 - d),  d = |v_log| / supply; \
               g, at most f: share of the PWM period in which diodes return the current",
    source: "mean of a bridge over a PWM period, in discontinuous and continuous conduction",
    signature: "no electrical braking at zero command; speed is far from proportional to duty",
    parameters: &[
        // Bridges float in most of the off part or in none; a few per cent are what another equation leaves over.
        strength("share", "1", "share of the off part in which the driver floats; in the rest it brakes", Scale::One, [0.1, 0.5, 1.0]),
        shape("frequency", "Hz", "frequency of the PWM", Scale::One, [50.0, 500.0, 20_000.0]),
    ],
    probes: &[
        &[0.4, 300.0], &[0.4, 700.0], &[0.7, 300.0], &[0.7, 700.0], &[1.0, 300.0], &[1.0, 700.0], &[0.7, 4000.0],
    ],
    search: Search::Damped(0.5),
    laws: EXPLICIT,
    remembers: true,
    periodic: false,
    by_duty: true,
    contains: &[],
};

/// Drop of the two silicon diodes through which the current returns, V.
pub const DIODES_V: f64 = 1.4;

/// Mean of a bridge that floats for a share of the off part.
#[derive(Debug, Clone, Copy)]
pub struct Coast<S> {
    share: S,
    pwm: Pwm<S>,
}

impl<S: Scalar> Coast<S> {
    /// Fixes the parameters (in the order of the row).
    pub fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { share: parameters[0], pwm: Pwm::new(parameters[1], setting) }
    }

    /// Mean voltage at the terminals under a `command` (0 or more) against `emf`, V.
    #[inline(always)]
    pub fn mean(&self, command: S, emf: S) -> S {
        let (zero, one) = (S::zero(), S::one());
        let off = self.pwm.off(command);
        let floating = self.share * off;
        let begun = emf * (decay((off - floating) * self.pwm.period) - one);
        let driven = decay((one - off) * self.pwm.period);
        let left = (self.pwm.supply - emf) * (one - driven) + begun * driven;
        let way = S::pick_gt(left, zero, one, -one);
        let against = way.mul_add(emf, self.pwm.supply + S::lit(DIODES_V));
        let conducting = self.pwm.conducting(left.abs(), against).min(floating);
        command + floating * emf - way * against * conducting
    }
}

impl<S: Scalar> Effect<S> for Coast<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        let v = drive.voltage;
        let way = S::pick_gt(S::zero(), v, -S::one(), S::one());
        drive.voltage = way * self.mean(way * v, way * self.pwm.emf(now, memory));
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        remember(now, after, memory);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use super::{Coast, DIODES_V};
    use crate::base::Base;
    use crate::effects::Setting;
    use crate::step::State;

    /// Mean voltage at the terminals of a switched bridge after many periods, in fine steps.
    fn switched(command: f64, emf: f64, [share, frequency]: [f64; 2], tau: f64) -> f64 {
        const PARTS: usize = 20_000;
        let (supply, duty) = (RIG.supply_v, command / RIG.supply_v);
        let floated = duty + (1.0 - duty) * share;
        let h = 1.0 / (frequency * PARTS as f64);
        let (mut u, mut sum) = (0.0_f64, 0.0);
        for _ in 0..(20.0 * tau * frequency) as usize + 3 {
            sum = 0.0;
            for k in 0..PARTS {
                let phase = (k as f64 + 0.5) / PARTS as f64;
                let floats = phase >= duty && phase < floated;
                let terminal = match phase {
                    p if p < duty => supply,
                    _ if !floats => 0.0,
                    _ if u == 0.0 => emf,
                    _ => -(supply + DIODES_V).copysign(u),
                };
                let next = u + h / tau * (terminal - emf - u);
                // A diode lets no current through the other way.
                u = if floats && next * u <= 0.0 { 0.0 } else { next };
                sum += terminal;
            }
        }
        sum / PARTS as f64
    }

    #[test]
    fn the_mean_is_that_of_a_switched_bridge_in_all_its_states() {
        for tau in [3e-4, 2e-3] {
            for shape in [[0.4, 300.0], [1.0, 300.0], [0.7, 1000.0], [0.3, 8000.0], [1.0, 8000.0]] {
                let setting = Setting::new(&Base { tau_e: tau, ..BASE }, &RIG, 1);
                let coast = Coast::new(&shape, &setting);
                for command in [0.0, 2.0, 6.0, 11.0, 12.0] {
                    for emf in [-6.0, -1.0, 0.0, 1.0, 6.0, 9.0] {
                        let (law, truth) = (coast.mean(command, emf), switched(command, emf, shape, tau));
                        assert!(
                            (law - truth).abs() < 0.02,
                            "{law} {truth} V: {command} V, {emf} V, {shape:?}, {tau}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn at_zero_command_only_friction_brakes() {
        let start = State::moving(0.0, 5.0, 0.0);
        let (_, motion) = run_from(start, Kind::Coast, &[1.0, 500.0], &[0.0; 100]);
        close(motion.state.speed, 5.0 * libm::exp(-0.1 * BASE.viscous_share / BASE.tau_m), 0.01);
    }

    /// A slow PWM loses no time to the diodes. Steady: u = v - d k w with u = viscous w.
    #[test]
    fn half_duty_of_a_slow_pwm_runs_faster_than_half_speed() {
        let (viscous, emf) = (BASE.viscous_share / BASE.gain, (1.0 - BASE.viscous_share) / BASE.gain);
        let truth = 6.0 / (viscous + 0.5 * emf);
        close(steady_speed(Kind::Coast, &[1.0, 0.01], 6.0), truth, 1e-3);
        close(steady_speed(Kind::Coast, &[1.0, 0.01], -6.0), -truth, 1e-3);
    }
}
