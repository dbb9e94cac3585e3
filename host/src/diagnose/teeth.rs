//! Feeling around for teeth.
//!
//! Every tooth that a model slips over too early or too late makes a valley of its own along the ripple's phase and size, and
//! derivatives lead to the bottom of the nearest. So the ripple is tried a step each way along its phase, its size and its
//! harmonic, all eight in one pass; it goes where the cost is least, or the steps are halved.

use motorlens_shared::effects::Kind;

use super::candidate::{Candidate, STEADY};
use super::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::simulate::LANES;

/// First steps: of the phase, rad, of the size, and of the harmonic against the size.
const STEPS: [f64; 3] = [0.3, 0.15, 0.15];
/// Passes.
const ROUNDS: usize = 16;
/// Steps of the search from where that ends.
const THEN: usize = 10;
/// Nothing is left to feel for below this many times the floor, in the increments and in the error itself ...
const AT_THE_FLOOR: f64 = 1.1;
/// ... and above this many in the error itself something else is missing.
const ASTRAY: f64 = 4.0 * STEADY;

/// Sine and cosine, and those of the harmonic.
type Ripple = [f64; 4];

/// `candidate` with its teeth where the cost is least around them; itself where it has none, or nothing is gained.
pub fn settle_teeth(evidence: &Evidence, candidate: Candidate) -> Candidate {
    let values = candidate.values();
    let Some(place) = values.effects.iter().position(|(kind, _)| *kind == Kind::Cogging) else {
        return candidate;
    };
    let done = 1.0 + candidate.excess() < AT_THE_FLOOR && candidate.drift() < AT_THE_FLOOR;
    if done || candidate.drift() > ASTRAY {
        return candidate;
    }
    let layout = candidate.layout.clone();
    let with = |ripple: &Ripple| {
        let mut values = values.clone();
        values.effects[place].1[..4].copy_from_slice(ripple);
        layout.pack(&values)
    };
    let least = |ripples: &[Ripple]| {
        let xs: Vec<Vec<f64>> = ripples.iter().map(with).collect();
        let costs = evidence.train.costs(&layout, Objective::Increments, &xs);
        costs.into_iter().zip(ripples.iter().copied()).min_by(|a, b| a.0.total_cmp(&b.0))
    };
    let own: Ripple = std::array::from_fn(|k| values.effects[place].1[k]);
    let Some(mut best) = least(&[own]) else { return candidate };
    let mut scale = 1.0;
    for _ in 0..ROUNDS {
        match least(&around(&best.1, scale)) {
            Some(next) if next.0 < best.0 => best = next,
            _ => scale *= 0.5,
        }
    }
    let found = evidence.train.search(&layout, Objective::Increments, &with(&best.1), THEN, 3e-5);
    let again = evidence.polish(layout, found);
    if again.merit() < candidate.merit() { again } else { candidate }
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
