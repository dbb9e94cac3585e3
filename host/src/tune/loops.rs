//! The loops on the base model with a delay, by their phase margin; with a spring or a gap behind the rotor, on rotor and load.
//!
//! Plant: gain / (s (tau_m s + 1)(tau_e s + 1)) e^(-s delay). The velocity's PI cancels the mechanical pole, ki = kp / tau_m. The
//! position's PD puts its zero where the poles of tau_m s^2 + (1 + gain kd) s + gain kp are equal, and its natural frequency as high
//! as the margin allows. Both crossovers are found by bisection on the loop itself. Source: Franklin, Powell, Emami-Naeini,
//! Feedback Control of Dynamic Systems, chapter 6.
//!
//! With compliance or backlash the plant is that of two masses, seen where the encoder sits. Its resonance may cross unity again: the margin
//! is the smallest of all crossovers, a loop whose curve goes round -1 (Nyquist) has none, and the gain may double. Gears with a gap
//! touch or stand apart: where the rotor is seen, both loops hold the margin; where the load is, nothing is seen of the rotor apart.

use motorlens_shared::effects::Kind;
use nalgebra::Complex;
use serde::Serialize;

use crate::fit::layout::BaseValues;
use crate::model_file::Model;

/// How far a loop is from the edge.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Margins {
    /// The crossover that has this phase margin, Hz.
    pub crossover_hz: f64,
    /// Phase margin, degrees; negative of a loop that is not stable.
    pub phase_deg: f64,
    /// Factor by which the gain may rise.
    pub gain: f64,
    /// More delay that it bears, s.
    pub delay_s: f64,
}

/// Gains of a loop in volts per unit of the output shaft.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Loop {
    /// Proportional: V s/rad of a velocity loop, V/rad of a position loop.
    pub kp: f64,
    /// Integral, V/rad.
    pub ki: f64,
    /// Derivative, V s/rad.
    pub kd: f64,
    /// Its margins.
    pub margins: Margins,
}

impl Loop {
    /// Whether it reaches unity where it is looked at: a loop that is weaker than that controls nothing, and its margins say nothing.
    fn crosses(&self) -> bool {
        self.margins.crossover_hz > FROM / std::f64::consts::TAU
    }
}

/// What the loop's open chain is at an angular frequency.
type Chain<'a> = &'a dyn Fn(f64) -> Complex<f64>;

/// The gain of a loop on two masses may rise by this: a resonance that is just below unity crosses it in the next motor.
const LEAST_GAIN: f64 = 2.0;

/// A spring or teeth that touch, between rotor and load.
#[derive(Debug, Clone, Copy)]
struct Shaft {
    load_share: f64,
    load_damping: f64,
    /// Acceleration of the load per angle, 1/s^2, and per speed, 1/s, by which the rotor is ahead.
    stiffness: f64,
    loss: f64,
    /// The encoder sits on the load.
    load_is_seen: bool,
    /// There is a gap, in which the shaft pulls at nothing.
    opens: bool,
}

/// What is controlled.
#[derive(Debug, Clone, Copy)]
pub(super) struct Plant {
    base: BaseValues,
    delay_s: f64,
    shaft: Option<Shaft>,
}

impl Plant {
    /// The motor of `model`, seen `delay_s` later.
    pub(super) fn of(model: &Model, delay_s: f64) -> Self {
        let of = |kind: Kind| {
            let own = model.effects.iter().find(|e| e.effect == kind)?;
            Some(own.parameters.iter().map(|p| p.value).collect::<Vec<f64>>())
        };
        let load_is_seen = !model.rig.encoder_on_motor;
        let shaft = match (of(Kind::Compliance).as_deref(), of(Kind::Backlash).as_deref()) {
            (Some(&[frequency, load_share, damping, load_damping]), _) => {
                let rate = std::f64::consts::TAU * frequency;
                let (stiffness, loss) = (rate * rate, 2.0 * damping * rate);
                Some(Shaft { load_share, load_damping, stiffness, loss, load_is_seen, opens: false })
            }
            (None, Some(&[_, load_share, load_damping, contact, damping])) => {
                let rate = std::f64::consts::TAU * contact;
                // The contact's frequency is that of rotor against load: the load has its part of the push.
                let part = 1.0 - load_share;
                let (stiffness, loss) = (part * rate * rate, part * 2.0 * damping * rate);
                Some(Shaft { load_share, load_damping, stiffness, loss, load_is_seen, opens: true })
            }
            _ => None,
        };
        Self { base: model.base, delay_s, shaft }
    }

    /// What the margins suppose, where that is not a rigid shaft.
    pub(super) fn told(&self) -> Option<&'static str> {
        let shaft = self.shaft?;
        Some(match (shaft.opens, shaft.load_is_seen) {
            (false, _) => "The margins are those of rotor and load with the springy shaft between them.",
            (true, false) => {
                "The margins hold for rotor and load with the gears touching, and for the rotor alone within the gap."
            }
            (true, true) => {
                "The margins are those of gears that touch: within the gap the encoder on the load sees nothing of the rotor, and the \
                 loop may keep moving in it, which the steps with all effects tell."
            }
        })
    }

    /// Speed per volt at an angular frequency, of what is seen; with the gears apart, of the rotor alone.
    fn speed(&self, touches: bool, omega: f64) -> Complex<f64> {
        let base = &self.base;
        let s = Complex::new(0.0, omega);
        let one = Complex::new(1.0, 0.0);
        let delay = Complex::from_polar(1.0, -omega * self.delay_s);
        let Some(shaft) = self.shaft else {
            return delay * base.gain / ((one + s * base.tau_m) * (one + s * base.tau_e));
        };
        let Shaft { load_share, load_damping, stiffness, loss, .. } = shaft;
        let (per_volt, damping) = (base.gain / base.tau_m, base.viscous_share / base.tau_m);
        let back_emf = (1.0 - base.viscous_share) / base.gain;
        // tau_e du/dt = v - back_emf w - u; the rotor has what is left of inertia and friction, the load its share of both.
        let rotor = per_volt / (1.0 - load_share);
        let rotor_damping = damping * (1.0 - load_damping) / (1.0 - load_share);
        let load = s + damping * load_damping / load_share;
        let pull = if touches { Complex::new(stiffness, 0.0) / s + loss } else { Complex::new(0.0, 0.0) };
        let follows = pull / (load + pull);
        let held_back = follows * load * (load_share / (1.0 - load_share));
        let of_rotor =
            delay * rotor / ((s + rotor_damping + held_back) * (one + s * base.tau_e) + rotor * back_emf);
        if shaft.load_is_seen { of_rotor * follows } else { of_rotor }
    }

    /// Margins under a controller: the smaller ones, where gears touch or stand apart.
    fn margins(&self, control: &dyn Fn(Complex<f64>) -> Complex<f64>) -> Margins {
        // A resonance is a hundredth of its frequency wide, and less.
        let per_decade = if self.shaft.is_some() { 1000 } else { 200 };
        let of = |touches: bool| {
            let chain = |omega: f64| self.speed(touches, omega) * control(Complex::new(0.0, omega));
            margins(&chain, per_decade)
        };
        let touching = of(true);
        if !self.shaft.is_some_and(|shaft| shaft.opens && !shaft.load_is_seen) {
            return touching;
        }
        let apart = of(false);
        let worse = if apart.phase_deg < touching.phase_deg { apart } else { touching };
        let (gain, delay_s) = (apart.gain.min(touching.gain), apart.delay_s.min(touching.delay_s));
        Margins { gain, delay_s, ..worse }
    }

    /// Whether a loop has this phase margin, rad.
    fn holds(&self, margins: &Margins, margin: f64) -> bool {
        margins.phase_deg.to_radians() >= margin && (self.shaft.is_none() || margins.gain >= LEAST_GAIN)
    }
}

/// PI of the velocity; none where no gain holds the margin.
pub(super) fn velocity(plant: &Plant, margin: f64) -> Option<Loop> {
    let BaseValues { gain, tau_m, .. } = plant.base;
    let of =
        |kp: f64| plant.margins(&|s: Complex<f64>| Complex::new(kp, 0.0) + Complex::new(kp / tau_m, 0.0) / s);
    let kp = largest(&|kp| plant.holds(&of(kp), margin), 1.0 / gain)?;
    Some(Loop { kp, ki: kp / tau_m, kd: 0.0, margins: of(kp) }).filter(Loop::crosses)
}

/// PD of the position; none where no gains hold the margin.
pub(super) fn position(plant: &Plant, margin: f64) -> Option<Loop> {
    let BaseValues { gain, tau_m, .. } = plant.base;
    let gains = |omega_n: f64| {
        let kp = tau_m * omega_n * omega_n / gain;
        // Where back-EMF and friction damp more than that already, nothing is added.
        let kd = ((2.0 * tau_m * omega_n - 1.0) / gain).max(0.0);
        (kp, kd)
    };
    let of = |(kp, kd): (f64, f64)| plant.margins(&|s: Complex<f64>| (Complex::new(kp, 0.0) + s * kd) / s);
    let held = |omega_n: f64| plant.holds(&of(gains(omega_n)), margin);
    let (kp, kd) = gains(largest(&held, 1.0 / tau_m)?);
    Some(Loop { kp, ki: 0.0, kd, margins: of((kp, kd)) }).filter(Loop::crosses)
}

/// The largest number that `holds`, about `scale`: bisection of its logarithm. None where none of those tried does.
fn largest(holds: &dyn Fn(f64) -> bool, scale: f64) -> Option<f64> {
    let (mut low, mut high) = (scale * 1e-3, scale * 1e4);
    let mut found = None;
    for _ in 0..60 {
        let middle = (low * high).sqrt();
        if holds(middle) { (low, found) = (middle, Some(middle)) } else { high = middle }
    }
    found
}

/// The lowest frequency at which a loop is looked at, rad/s.
const FROM: f64 = 1e-2;

/// Margins by a fine walk along the frequencies, of a chain that integrates once: the smallest of all crossings.
fn margins(chain: Chain, per_decade: i32) -> Margins {
    use std::f64::consts::{FRAC_PI_2, PI, TAU};
    let at = |k: i32| FROM * 10_f64.powf(f64::from(k) / f64::from(per_decade));
    let mut before = chain(at(0));
    // By Nyquist the curve of 1 + L, which begins below the axis and ends at 1, comes there without a turn round 0.
    let mut turned = (before + 1.0).arg();
    let (mut omega, mut phase, mut delay_s) = (FROM, PI, PI / FROM);
    let (mut below, mut above) = (0.0_f64, 0.0_f64);
    for k in 1..7 * per_decade {
        let now = chain(at(k));
        turned += ((now + 1.0) / (before + 1.0)).arg();
        let [size_before, size] = [before.norm(), now.norm()];
        if (size_before >= 1.0) != (size >= 1.0) {
            let part = size_before.ln() / (size_before / size).ln();
            let crossing = at(k - 1) * (at(k) / at(k - 1)).powf(part);
            // From -1 on, which is 0, in -pi .. pi.
            let angle = (-before).arg() + part * (now / before).arg();
            let margin = (angle + PI).rem_euclid(TAU) - PI;
            if margin.abs() < phase {
                (omega, phase) = (crossing, margin.abs());
            }
            delay_s = delay_s.min(margin.rem_euclid(TAU) / crossing);
        }
        if (before.im >= 0.0) != (now.im >= 0.0) && now.re < 0.0 {
            let kept = if size < 1.0 { &mut below } else { &mut above };
            *kept = kept.max(size);
        }
        before = now;
    }
    let stable = turned.abs() < FRAC_PI_2;
    let size = if stable || above == 0.0 { below } else { above };
    Margins {
        crossover_hz: omega / TAU,
        phase_deg: (if stable { phase } else { -phase }).to_degrees(),
        gain: if size > 0.0 { 1.0 / size } else { f64::MAX },
        delay_s: if stable { delay_s } else { 0.0 },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const BASE: BaseValues = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };

    fn rigid(delay_s: f64) -> Plant {
        Plant { base: BASE, delay_s, shaft: None }
    }

    fn springy(hertz: f64, load_is_seen: bool) -> Plant {
        let rate = std::f64::consts::TAU * hertz;
        let (stiffness, loss) = (rate * rate, 0.1 * rate);
        let shaft =
            Shaft { load_share: 0.45, load_damping: 0.3, stiffness, loss, load_is_seen, opens: false };
        Plant { shaft: Some(shaft), ..rigid(3e-3) }
    }

    /// With the mechanical pole cancelled the loop is kp gain / (tau_m s) with a lag: its margin is known.
    #[test]
    fn a_velocity_loop_has_the_margin_that_was_asked_and_crosses_where_that_puts_it() {
        let delay = 3e-3;
        let found = velocity(&rigid(delay), 60_f64.to_radians()).unwrap();
        assert!((found.margins.phase_deg - 60.0).abs() < 0.1, "{found:?}");
        let omega = found.margins.crossover_hz * std::f64::consts::TAU;
        let spent = omega * delay + (omega * BASE.tau_e).atan();
        assert!((spent - 30_f64.to_radians()).abs() < 2e-3, "{spent}");
        let kp = BASE.tau_m * omega / BASE.gain * (1.0 + (omega * BASE.tau_e).powi(2)).sqrt();
        assert!((found.kp / kp - 1.0).abs() < 2e-3, "{found:?}");
    }

    #[test]
    fn more_delay_makes_both_loops_slower_and_keeps_their_margins() {
        for design in [velocity, position] {
            let [fast, slow] = [2e-3, 1e-2].map(|delay| design(&rigid(delay), 60_f64.to_radians()).unwrap());
            assert!(slow.margins.crossover_hz < 0.6 * fast.margins.crossover_hz, "{fast:?} {slow:?}");
            assert!(slow.margins.phase_deg > 59.9 && slow.margins.gain > 2.0, "{slow:?}");
        }
    }

    /// With the pole cancelled nothing is ever further than a quarter turn from the edge.
    #[test]
    fn a_margin_that_no_gain_has_gives_no_loop() {
        for design in [velocity, position] {
            let found = design(&rigid(3e-3), 100_f64.to_radians());
            assert!(found.is_none(), "{found:?}");
        }
    }

    #[test]
    fn a_shaft_that_hardly_gives_leaves_the_rigid_loops() {
        for design in [velocity, position] {
            let stiff = design(&rigid(3e-3), 60_f64.to_radians()).unwrap();
            for seen in [false, true] {
                let given = design(&springy(2000.0, seen), 60_f64.to_radians()).unwrap();
                assert!((given.kp / stiff.kp - 1.0).abs() < 0.02, "{stiff:?} {given:?}");
            }
        }
    }

    /// Gains of the rigid loop have not the margin on two masses that they were designed for, and those designed on two masses do.
    #[test]
    fn the_margin_of_a_springy_shaft_is_that_of_two_masses() {
        let margin = 60_f64.to_radians();
        for seen in [false, true] {
            let plant = springy(8.0, seen);
            let kp = velocity(&rigid(3e-3), margin).unwrap().kp;
            let there = plant
                .margins(&|s: Complex<f64>| Complex::new(kp, 0.0) + Complex::new(kp / BASE.tau_m, 0.0) / s);
            assert!(!plant.holds(&there, margin), "{there:?}");
            for design in [velocity, position] {
                let found = design(&plant, margin).unwrap();
                assert!(found.margins.phase_deg > 59.9 && found.margins.gain >= LEAST_GAIN, "{found:?}");
            }
        }
        // Seen behind the spring, a loop that hurries beyond the resonance is not stable.
        let hasty = springy(8.0, true)
            .margins(&|s: Complex<f64>| Complex::new(8.0, 0.0) + Complex::new(160.0, 0.0) / s);
        assert!(hasty.phase_deg < 0.0 && hasty.gain < 1.0 && hasty.delay_s == 0.0, "{hasty:?}");
    }

    /// Where the encoder sits on the rotor, the gap takes the load off: the loop is as fast as the rotor alone allows.
    #[test]
    fn with_a_gap_the_rotor_alone_holds_the_margin_too() {
        let touching = springy(150.0, false);
        let gap = Plant { shaft: touching.shaft.map(|shaft| Shaft { opens: true, ..shaft }), ..touching };
        let margin = 60_f64.to_radians();
        let [spring, teeth] = [touching, gap].map(|plant| velocity(&plant, margin).unwrap());
        assert!(teeth.kp < spring.kp && teeth.margins.phase_deg > 59.9, "{spring:?} {teeth:?}");
    }
}
