//! Feeling around for teeth.
//!
//! Every tooth that a model slips over too early or too late makes a valley of its own along the ripple's phase and size, and
//! derivatives lead to the bottom of the nearest. So the ripple is tried a step each way along its phase, its size and its
//! harmonic, all eight in one pass; it goes where the cost is least, or the steps are halved.

use motorlens_shared::effects::Kind;

use super::candidate::{Candidate, STEADY};
use super::evidence::Evidence;
use super::orders;
use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;

/// First steps: of the phase, rad, of the size, and of the harmonic against the size.
const STEPS: [f64; 3] = [0.3, 0.15, 0.15];
/// Passes.
const ROUNDS: usize = 16;
/// Steps of the search from where that ends.
const THEN: usize = 10;
/// Nothing is left to feel for below this many times the floor, in the increments and in the error itself ...
const AT_THE_FLOOR: f64 = 1.1;
/// ... or, where two runs differ, maybe by the teeth that they slipped over, below this many; ...
const BELOW_CHANCE: f64 = 0.9;
/// ... and above this many in the error itself something else is missing.
const ASTRAY: f64 = 4.0 * STEADY;

/// Sine and cosine, and those of the harmonic; ...
pub(super) type Ripple = [f64; 4];
/// ... among a law's parameters the order follows them.
const ORDER: usize = 4;

/// Teeth of one order in a model, felt for on some records.
pub(super) struct Feeler<'a> {
    problem: &'a Problem,
    layout: Layout,
    values: Values,
    place: usize,
}

impl<'a> Feeler<'a> {
    /// The teeth of `values`; none where it has none.
    pub(super) fn new(problem: &'a Problem, values: &Values) -> Option<Self> {
        let place = values.effects.iter().position(|(kind, _)| *kind == Kind::Cogging)?;
        Some(Self { problem, layout: problem.layout(&values.kinds()), values: values.clone(), place })
    }

    /// The same model with teeth of another order.
    pub(super) fn set_order(&mut self, order: f64) {
        self.values.effects[self.place].1[ORDER] = order;
    }

    /// The ripple that the model has.
    pub(super) fn own(&self) -> Ripple {
        std::array::from_fn(|k| self.values.effects[self.place].1[k])
    }

    /// The model with another ripple.
    pub(super) fn with(&self, ripple: &Ripple) -> Values {
        let mut values = self.values.clone();
        values.effects[self.place].1[..ORDER].copy_from_slice(ripple);
        values
    }

    /// The costs of `ripples`, least first.
    pub(super) fn costs(&self, ripples: &[Ripple]) -> Vec<(f64, Ripple)> {
        let costs = |ripples: &[Ripple]| {
            let xs: Vec<Vec<f64>> = ripples.iter().map(|r| self.layout.pack(&self.with(r))).collect();
            self.problem.costs(&self.layout, Objective::Increments, &xs)
        };
        let mut costs: Vec<(f64, Ripple)> = ripples
            .chunks(LANES)
            .flat_map(|ripples| costs(ripples).into_iter().zip(ripples.to_vec()))
            .collect();
        costs.sort_by(|a, b| a.0.total_cmp(&b.0));
        costs
    }

    /// The ripple to which feeling around from `best`, a cost and its ripple, leads.
    pub(super) fn feel(&self, mut best: (f64, Ripple)) -> (f64, Ripple) {
        let mut scale = 1.0;
        for _ in 0..ROUNDS {
            let next = self.costs(&around(&best.1, scale))[0];
            if next.0 < best.0 {
                best = next;
            } else {
                scale *= 0.5;
            }
        }
        best
    }
}

/// `candidate` with its teeth where the cost is least around them, or with teeth of another order where these fit better; itself
/// where it has none, or nothing is gained.
pub fn settle_teeth(evidence: &Evidence, candidate: Candidate) -> Candidate {
    let done = |c: &Candidate| {
        let floor = if c.calm == Some(false) { BELOW_CHANCE } else { AT_THE_FLOOR };
        c.increments() < floor && c.drift() < floor
    };
    let felt = |values: &Values| {
        let feeler = Feeler::new(&evidence.train, values)?;
        let own = feeler.costs(&[feeler.own()])[0];
        let best = feeler.with(&feeler.feel(own).1);
        let layout = feeler.layout.clone();
        let found = evidence.train.search(&layout, Objective::Increments, &layout.pack(&best), THEN, 3e-5);
        Some(evidence.judge(&layout, vec![found]).swap_remove(0))
    };
    // What a tooth that is slipped over or not makes of the error itself is chance.
    let less = |a: &Candidate, b: &Candidate| a.increments() < b.increments();
    let mut best = candidate;
    if done(&best) || best.drift() > ASTRAY {
        return best;
    }
    let Some(around) = felt(&best.values()) else { return best };
    if less(&around, &best) {
        best = around;
    }
    if !done(&best) {
        let others = orders::likely(evidence, &best);
        for other in others.iter().filter_map(felt) {
            if less(&other, &best) {
                best = other;
            }
        }
    }
    best
}

/// The neighbours of a ripple at `scale` of the first steps.
fn around(ripple: &Ripple, scale: f64) -> [Ripple; LANES] {
    let [phase, size, harmonic] = STEPS.map(|step| scale * step);
    let whole = ripple[0].hypot(ripple[1]);
    std::array::from_fn(|lane| {
        let sign = if lane % 2 == 0 { 1.0 } else { -1.0 };
        let mut beside = *ripple;
        match lane / 2 {
            0 => turn(&mut beside, sign * phase),
            1 => beside = ripple.map(|part| part * (1.0 + sign * size)),
            part => beside[part] += sign * harmonic * whole,
        }
        beside
    })
}

/// Moves a ripple (what follows its four parts stays) ahead by `angle`, rad of its period.
pub fn turn(ripple: &mut [f64], angle: f64) {
    for (k, angle) in [(0, angle), (2, 2.0 * angle)] {
        let (sine, cosine) = (ripple[k], ripple[k + 1]);
        ripple[k] = sine * angle.cos() - cosine * angle.sin();
        ripple[k + 1] = sine * angle.sin() + cosine * angle.cos();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    #[test]
    fn a_ripple_has_a_neighbour_each_way_along_phase_size_and_harmonic() {
        let around = around(&[0.3, 0.4, 0.0, 0.1], 0.5);
        for (turned, angle) in [(around[0], 0.15), (around[1], -0.15)] {
            let at = |part: usize, x: f64| turned[part] * x.sin() + turned[part + 1] * x.cos();
            assert!((at(0, 0.7 - angle) - (0.3 * 0.7_f64.sin() + 0.4 * 0.7_f64.cos())).abs() < 1e-12);
            assert!((at(2, 2.0 * (0.7 - angle)) - 0.1 * 1.4_f64.cos()).abs() < 1e-12);
        }
        assert!((around[2][0] - 0.3 * 1.075).abs() < 1e-12 && (around[3][3] - 0.1 * 0.925).abs() < 1e-12);
        assert!(
            (around[4][2] - 0.5 * 0.075).abs() < 1e-12 && (around[7][3] - 0.1 + 0.5 * 0.075).abs() < 1e-12
        );
    }

    /// A search ended at the ripple that this begins with, a valley beside that of the hidden one.
    #[test]
    fn teeth_in_the_valley_beside_the_right_one_are_felt_out_of_it() {
        let conditions = Conditions { disturbed: 0.25, spoilt: 0.15 };
        let case = Case::new(26_200_048, &[Hidden::Cogging, Hidden::CoulombAsymmetric], conditions);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let friction = evidence.fit(&base.values().with(Kind::CoulombAsymmetric, vec![0.75, -0.45]), 20);
        let ripple = vec![-0.1193, 0.0283, 0.04, -0.0057, 12.0];
        let searched = evidence.fit(&friction.values().with(Kind::Cogging, ripple), THEN);
        let felt = settle_teeth(&evidence, searched.clone());
        assert!(felt.merit() < searched.merit() - 0.05, "{} after {}", felt.merit(), searched.merit());
    }
}
