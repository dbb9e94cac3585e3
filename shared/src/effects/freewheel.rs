//! A driver that cannot brake: in the off part of the PWM the current goes on through a diode across the winding until it ends.
//!
//! A transistor with a diode across the motor, an H-bridge that switches one side only, a speed controller without synchronous rectification.
//! Of a PWM period T the driver gives the whole supply V for the duty d. With u the current and E the back-EMF:
//!
//! ```text
//! driven         d T                  tau u' = V - E - u
//! freewheeling   (1 - d) T            tau u' = -E - u       until u = 0: the diode lets nothing through the other way
//!                                     terminals at E, no current  for the rest
//! ```
//! A current that has ended is u_b = (V - E)(1 - e^(-dT/tau)) when the driver switches off the next time, and the diode conducts for the share
//! g = min(1 - d, tau/T ln(1 + u_b / E)) of the period. That is exact for a current that ends within the period, and for one that never
//! ends, where the share is 1 - d whatever it began with. With a fast PWM the mean voltage is d V or E, whichever is higher: a
//! motor faster than its voltage runs down by friction alone.
//!
//! The diode's own drop is left out: with a fast PWM it takes the same from every voltage, as dry friction does, which records tell it
//! from by nothing else.

use super::decay::decay;
use super::pwm::{Pwm, remember};
use super::spec::{EXPLICIT, Port, Scale, Search, Spec, shape, strength};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::{Drive, State};

pub(super) const SPEC: Spec = Spec {
    name: "freewheel",
    port: Port::Voltage,
    title: "the driver cannot brake: off, the current goes on through a diode until it ends",
    equation: "v = v_log + share (off - g) k_e w,  off = 1 - |v_log| / supply; \
               g, at most off: share of the PWM period in which the diode conducts",
    source: "mean of a one-quadrant chopper over a PWM period, in discontinuous and continuous conduction",
    signature: "speeds up at once and runs down slowly, also where the voltage is lowered and not taken off",
    parameters: &[
        // A driver brakes or does not; a few per cent are what another equation leaves over.
        strength("share", "1", "share of the braking voltage that is missing; 1: never brakes", Scale::One, [0.1, 0.5, 1.0]),
        shape("frequency", "Hz", "frequency of the PWM", Scale::One, [50.0, 500.0, 20_000.0]),
    ],
    probes: &[&[0.5, 500.0], &[1.0, 500.0], &[0.5, 8000.0], &[1.0, 8000.0]],
    search: Search::Damped(0.5),
    laws: EXPLICIT,
    remembers: true,
    periodic: false,
    by_duty: true,
    contains: &[],
};

/// Mean of a chopper.
#[derive(Debug, Clone, Copy)]
pub struct Freewheel<S> {
    share: S,
    pwm: Pwm<S>,
}

impl<S: Scalar> Freewheel<S> {
    /// Fixes the parameters (in the order of the row).
    pub fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        Self { share: parameters[0], pwm: Pwm::new(parameters[1], setting) }
    }

    /// What the terminals have more than a `command` (0 or more) against `emf` in the mean, V.
    #[inline(always)]
    pub fn beside(&self, command: S, emf: S) -> S {
        let (zero, one) = (S::zero(), S::one());
        let off = self.pwm.off(command);
        let begun = ((self.pwm.supply - emf) * (one - decay((one - off) * self.pwm.period))).max(zero);
        // A shaft that is driven against its motion keeps the current up: the diode conducts all the time.
        let lasting = S::pick_gt(emf, zero, self.pwm.conducting(begun, emf.max(zero)), off);
        (off - lasting.min(off)) * emf
    }
}

impl<S: Scalar> Effect<S> for Freewheel<S> {
    #[inline(always)]
    fn drive(&self, now: &Now<S>, memory: &Memory<S>, drive: &mut Drive<S>) {
        let v = drive.voltage;
        let emf = self.pwm.emf(now, memory);
        let (zero, one) = (S::zero(), S::one());
        // Switched off, no side conducts.
        let turning = S::pick_gt(zero, emf, -one, one);
        let way = S::pick_gt(v, zero, one, S::pick_gt(zero, v, -one, turning));
        drive.voltage = (self.share * way).mul_add(self.beside(way * v, way * emf), v);
    }
    #[inline(always)]
    fn settle(&self, now: &Now<S>, after: &State<S>, memory: &mut Memory<S>) {
        remember(now, after, memory);
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, testing::*};
    use super::Freewheel;
    use crate::base::Base;
    use crate::effects::Setting;
    use crate::step::State;

    /// Mean voltage at the terminals of a chopper after many periods, in fine steps.
    fn switched(command: f64, emf: f64, frequency: f64, tau: f64) -> f64 {
        const PARTS: usize = 20_000;
        let (supply, duty) = (RIG.supply_v, command / RIG.supply_v);
        let h = 1.0 / (frequency * PARTS as f64);
        let (mut u, mut sum) = (0.0_f64, 0.0);
        for _ in 0..(20.0 * tau * frequency) as usize + 3 {
            sum = 0.0;
            for k in 0..PARTS {
                let driven = (k as f64 + 0.5) / (PARTS as f64) < duty;
                let terminal = match (driven, u > 0.0 || emf < 0.0) {
                    (true, _) => supply,
                    (false, true) => 0.0,
                    (false, false) => emf,
                };
                u += h / tau * (terminal - emf - u);
                u = if driven { u } else { u.max(0.0) };
                sum += terminal;
            }
        }
        sum / PARTS as f64
    }

    #[test]
    fn the_mean_is_that_of_a_switched_chopper_in_all_its_states() {
        for tau in [3e-4, 2e-3] {
            for frequency in [300.0, 1000.0, 8000.0] {
                let setting = Setting::new(&Base { tau_e: tau, ..BASE }, &RIG, 1);
                let law = Freewheel::new(&[1.0, frequency], &setting);
                for command in [0.0, 2.0, 6.0, 11.0, 12.0] {
                    for emf in [-6.0, -1.0, 0.0, 1.0, 6.0, 9.0] {
                        let mean = command + law.beside(command, emf);
                        // At zero command nothing conducts whichever way the shaft turns: see drive().
                        let truth = switched(command, emf, frequency, tau);
                        assert!(
                            (mean - truth).abs() < 0.03,
                            "{mean} {truth} V: {command} V, {emf} V, {frequency} Hz, {tau}"
                        );
                    }
                }
            }
        }
    }

    #[test]
    fn a_motor_faster_than_its_voltage_runs_down_by_friction_alone() {
        for (speed, volts) in [(5.0, 0.0), (-5.0, 0.0), (5.0, 2.0), (-5.0, -2.0)] {
            let start = State::moving(0.0, speed, 0.0);
            // So fast that no pulse of current is left.
            let (_, motion) = run_from(start, Kind::Freewheel, &[1.0, 1e6], &[volts; 100]);
            close(motion.state.speed, speed * libm::exp(-0.1 * BASE.viscous_share / BASE.tau_m), 0.01);
        }
    }

    /// Steady, each pulse has its current to itself: u = d (v - k w) with u = viscous w.
    #[test]
    fn half_duty_of_a_slow_pwm_runs_faster_than_half_speed() {
        let (viscous, emf) = (BASE.viscous_share / BASE.gain, (1.0 - BASE.viscous_share) / BASE.gain);
        let truth = 6.0 / (viscous + 0.5 * emf);
        close(steady_speed(Kind::Freewheel, &[1.0, 0.01], 6.0), truth, 1e-3);
        close(steady_speed(Kind::Freewheel, &[1.0, 0.01], -6.0), -truth, 1e-3);
    }
}
