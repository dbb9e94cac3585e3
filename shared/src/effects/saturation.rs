//! Iron that saturates: less torque per ampere at high current.

use super::decay::decay;
use super::spec::{Port, Scale, Spec, TORQUE, strength, Search};
use super::{Effect, Memory, Now, Setting};
use crate::scalar::Scalar;
use crate::step::Drive;

pub(super) const SPEC: Spec = Spec {
    name: "saturation",
    port: Port::Voltage,
    title: "the iron saturates: torque per ampere falls at high current",
    equation: "K_t and k_e scale with (35 + 10 q) / (35 + 45 q + 3 q^2),  q = strength (u / nominal)^2",
    source: "tanh(x) / x, the usual curve of magnetisation with one knee, as its Pade quotient in x^2 = 3 q",
    signature: "jumps of the voltage accelerate less than the model says; slow motion fits",
    // At most two thirds of the torque at stall.
    parameters: &[strength("strength", "1", "loss at stall, where it is small", Scale::One, [0.0, 0.3, 2.0])],
    probes: &[&[0.15], &[0.6], &[2.0]],
    search: Search::Probes,
    laws: TORQUE,
    remembers: false,
    periodic: false,
    by_duty: false,
    contains: &[],
};

/// Gauss's moments of a step, as shares of it, and their weights in a mean.
const MOMENTS: [f64; 3] = [0.112_701_665, 0.5, 0.887_298_335];
const WEIGHTS: [f64; 3] = [5.0 / 18.0, 4.0 / 9.0, 5.0 / 18.0];

/// Field weakening: with the square of a small current, in proportion to a large one.
#[derive(Debug, Clone, Copy)]
pub struct Saturation<S> {
    strength: S,
    per_nominal: S,
    back_emf: S,
    /// Back-EMF that one volt of current adds in a step.
    emf_per_step: S,
    /// Share of its speed that viscous friction takes from the rotor in a step.
    braked: S,
    /// How much of its way to rest a current has gone at each moment since the step began ...
    arrived: [S; 3],
    /// ... and since the moment before.
    passed: [S; 3],
    /// How each moment's voltage counts in the step's last current.
    kept: [S; 3],
}

impl<S: Scalar> Saturation<S> {
    pub(super) fn new(parameters: &[S], setting: &Setting<S>) -> Self {
        let steps = setting.step / setting.tau_e;
        let keeps = |share: f64| decay(S::lit(share) * steps);
        let [early, middle, late] = [0, 1, 2].map(|k| S::lit(WEIGHTS[k]) * keeps(1.0 - MOMENTS[k]));
        let all = early + middle + late;
        let apart = MOMENTS[1] - MOMENTS[0];
        Self {
            strength: parameters[0],
            per_nominal: setting.per_nominal,
            back_emf: setting.back_emf,
            emf_per_step: setting.step * setting.acceleration * setting.back_emf,
            braked: setting.step * setting.damping,
            arrived: MOMENTS.map(|share| S::one() - keeps(share)),
            passed: [MOMENTS[0], apart, apart].map(|share| S::one() - keeps(share)),
            kept: [early / all, middle / all, late / all],
        }
    }

    /// The share of the field that is left at `current`, V.
    #[inline(always)]
    fn field(&self, current: S) -> S {
        let x = current * self.per_nominal;
        let q = self.strength * x * x;
        let base = S::lit(35.0);
        q.mul_add(S::lit(10.0), base) / q.mul_add(S::lit(3.0), S::lit(45.0)).mul_add(q, base)
    }
}

impl<S: Scalar> Effect<S> for Saturation<S> {
    /// A jump of the voltage changes current, field and speed within the step. A first way of the current, along which the
    /// field stays what it was, tells the field; a second one tells the means.
    ///
    /// A voltage counts for the last current by what the winding still knows of it, and for the speed by its mean.
    #[inline(always)]
    fn drive(&self, now: &Now<S>, _memory: &Memory<S>, drive: &mut Drive<S>) {
        let first = now.state.current;
        let emf = self.back_emf * now.state.speed;
        // A resistance in series leaves less current.
        let through = S::one() / (S::one() + drive.series);
        let mut fields = [self.field(first); 4];
        let way = (drive.voltage - fields[0] * emf) * through - first;
        let mut gained = S::zero();
        for k in 0..3 {
            let current = self.arrived[k].mul_add(way, first);
            fields[k + 1] = self.field(current);
            gained += S::lit(WEIGHTS[k]) * fields[k + 1] * current;
        }
        // Dry friction acts against a shaft that turns; one that rests has no back-EMF to gain. The gear's grows with this torque.
        let (speed, zero) = (now.state.speed, S::zero());
        let in_the_gear = drive.meshing * gained.shrink(drive.meshing_knee).abs();
        let forward = S::pick_gt(speed, zero, drive.friction_forward + in_the_gear, zero);
        let backward = S::pick_gt(zero, speed, drive.friction_backward + in_the_gear, zero);
        let others = drive.torque + drive.load_torque + backward - forward;
        gained = (gained + others).mul_add(self.emf_per_step, -(self.braked * emf));
        let (mut torque, mut voltage) = (S::zero(), S::zero());
        let (mut current, mut time) = (first, 0.0);
        for k in 0..3 {
            let field = S::lit(0.5) * (fields[k] + fields[k + 1]);
            let against = field * S::lit(0.5 * (time + MOMENTS[k])).mul_add(gained, emf);
            current += self.passed[k] * ((drive.voltage - against) * through - current);
            time = MOMENTS[k];
            let lost = S::one() - self.field(current);
            let spared = lost * S::lit(time).mul_add(gained, emf);
            voltage += self.kept[k] * spared;
            torque += S::lit(WEIGHTS[k]) * (lost * current - spared) + self.kept[k] * spared;
        }
        drive.torque -= torque;
        drive.weakening -= torque;
        drive.voltage += voltage;
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Kind, Rig, Setting, testing::*};
    use super::Saturation;

    #[test]
    fn it_follows_the_hyperbolic_tangent_up_to_four_times_its_knee() {
        let setting = Setting::new(&BASE, &RIG, 1);
        let saturation = Saturation::new(&[1.0 / 3.0], &setting);
        for x in [0.2, 0.5, 1.0, 2.0, 3.0, 4.0_f64] {
            close(saturation.field(x * RIG.nominal_v), x.tanh() / x, 6e-3);
        }
    }

    /// A motor that reverses every 10 ms is where short steps take it, however short its electrical time constant.
    #[test]
    fn a_reversing_current_weakens_the_field_as_in_short_steps() {
        use crate::base::Base;
        use crate::simulator::Simulator;
        let end = |tau_e: f64, parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let base = Base { tau_e, ..BASE };
            let simulator = Simulator::new(&base, [(Kind::Saturation, &[1.0][..])], &rig);
            let volts: std::vec::Vec<f64> =
                (0..400 * parts).map(|k| if k / (10 * parts) * 7 % 11 < 6 { 9.0 } else { -9.0 }).collect();
            let mut motion = simulator.start(crate::step::State::rest());
            for k in 0..volts.len() {
                simulator.advance(&mut motion, &volts, k);
            }
            motion.state.angle
        };
        for tau_e in [3e-4, 8e-4, 2e-3] {
            let truth = end(tau_e, 32);
            close(end(tau_e, 1), truth, 3e-3 * truth.abs());
        }
    }

    /// A warm winding lets less current through, which saturates less.
    #[test]
    fn behind_a_warm_winding_a_reversing_current_weakens_the_field_as_in_short_steps() {
        use crate::simulator::Simulator;
        let end = |strength: f64, parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let base = crate::base::Base { tau_e: 3e-4, tau_m: 0.018, ..BASE };
            let (heat, iron) = ([0.2, 1e6], [strength]);
            let effects = [(Kind::WindingHeating, &heat[..]), (Kind::Saturation, &iron[..])];
            let simulator = Simulator::new(&base, effects, &rig);
            let volts: std::vec::Vec<f64> =
                (0..3000 * parts).map(|k| if k / (10 * parts) * 7 % 11 < 6 { 9.0 } else { -9.0 }).collect();
            let mut motion = simulator.start(crate::step::State::rest());
            (0..volts.len()).for_each(|k| simulator.advance(&mut motion, &volts, k));
            motion.state.angle
        };
        let truth = end(1.2, 16);
        let done = (truth - end(0.0, 16)).abs();
        let off = (end(1.2, 1) - truth).abs();
        assert!(off < done / 30.0, "off by 1/{:.0}", done / off);
    }

    /// What friction and a load take from the speed within a step, they take from the back-EMF that the field weakens too.
    #[test]
    fn against_friction_and_a_load_a_reversing_current_weakens_the_field_as_in_short_steps() {
        use crate::simulator::Simulator;
        let end = |parts: usize| {
            let rig = Rig { step_s: 1e-3 / parts as f64, ..RIG };
            let base = crate::base::Base { tau_m: 0.018, tau_e: 2e-3, ..BASE };
            let (friction, load, iron) = ([0.6], [0.8], [1.0]);
            let effects =
                [(Kind::Coulomb, &friction[..]), (Kind::ConstantLoad, &load[..]), (Kind::Saturation, &iron[..])];
            let simulator = Simulator::new(&base, effects, &rig);
            let volts: std::vec::Vec<f64> =
                (0..3000 * parts).map(|k| if k / (10 * parts) * 7 % 11 < 6 { 9.0 } else { -9.0 }).collect();
            let mut motion = simulator.start(crate::step::State::rest());
            (0..volts.len()).for_each(|k| simulator.advance(&mut motion, &volts, k));
            motion.state.angle
        };
        let truth = end(32);
        let off = (end(1) / truth - 1.0).abs();
        assert!(off < 3e-4, "{off:e} of {truth}");
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
        close(motion.state.angle, 6.0 * (36.5 / 41.8175) / 2.0, 1e-4);
    }
}
