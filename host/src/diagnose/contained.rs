//! Laws that contain others: a richer law takes a simpler one's place, and a sum goes by the name of its parts while more
//! is looked for.
//!
//! Both at once would fight over the same torque: dry friction beside Stribeck's has no level of its own.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::layout::Values;

/// Steps of a search whose start is another law's minimum.
const STEPS: usize = 14;

/// The simpler effects of which `kind` is made, each with the place of its parameter in `kind`.
pub fn parts(kind: Kind) -> impl Iterator<Item = (Kind, usize)> {
    let spec = kind.spec();
    let part = |(name, parameter): &(&str, &str)| Some((Kind::by_name(name)?, spec.place(parameter)?));
    spec.contains.iter().filter_map(part)
}

/// Whether a model of `kinds` describes what `kind` does: by itself, within a richer law, or by its parts.
pub fn covers(kinds: &[Kind], kind: Kind) -> bool {
    let within = |simple: Kind| kinds.iter().any(|rich| rich.spec().holds(simple.name()));
    within(kind) || (kind.spec().is_sum() && parts(kind).all(|(part, _)| within(part)))
}

/// Whether `kind` may join `kinds`: it brings more than a part that could join by itself.
pub fn may_join(kinds: &[Kind], kind: Kind) -> bool {
    !(covers(kinds, kind) || kind.spec().is_sum() && parts(kind).any(|(part, _)| covers(kinds, part)))
}

/// `model` with its sums taken apart: each part can then give way to a richer law.
pub fn apart(evidence: &Evidence, model: &Candidate) -> Candidate {
    let mut values = model.values();
    let Some(place) = values.effects.iter().position(|(kind, _)| kind.spec().is_sum()) else {
        return model.clone();
    };
    let (sum, parameters) = values.effects.remove(place);
    for (part, at) in parts(sum) {
        values = values.with(part, vec![parameters[at]]);
    }
    evidence.fit(&values, 2)
}

/// `model` with the parts of a sum put together.
pub fn together(evidence: &Evidence, model: Candidate, library: &[Kind]) -> Candidate {
    let values = model.values();
    let has = |kind: Kind| values.effects.iter().find(|(k, _)| *k == kind);
    for sum in library.iter().filter(|kind| kind.spec().is_sum()) {
        let Some(found) = parts(*sum).map(|(part, _)| has(part)).collect::<Option<Vec<_>>>() else {
            continue;
        };
        let mut parameters = vec![0.0; found.len()];
        let mut joined = values.clone();
        for ((part, at), (_, own)) in parts(*sum).zip(found) {
            parameters[at] = own[0];
            joined = joined.without(part);
        }
        let joined = evidence.fit(&joined.with(*sum, parameters), 2);
        // A load greater than the friction is no friction's difference.
        return if joined.merit() < model.merit() + 0.01 { joined } else { model };
    }
    model
}

/// `model` with `kind` in the place of the simpler effects that it contains; none where there are none.
pub fn richer(evidence: &Evidence, model: &Candidate, kind: Kind) -> Option<Candidate> {
    let problem = &evidence.train;
    let old = model.values();
    let kept: Vec<(usize, f64)> = parts(kind)
        .filter_map(|(part, at)| Some((at, old.effects.iter().find(|(k, _)| *k == part)?.1[0])))
        .collect();
    if kept.is_empty() {
        return None;
    }
    let rest = parts(kind).fold(old, |values, (part, _)| values.without(part));
    let spec = kind.spec();
    let start = |probe: &&[f64]| {
        let scaled = probe.iter().zip(spec.parameters).map(|(x, p)| x * p.scale.unit(&problem.rig));
        let mut parameters: Vec<f64> = scaled.collect();
        for (at, value) in &kept {
            parameters[*at] = *value;
        }
        rest.with(kind, parameters)
    };
    let tries: Vec<Values> = spec.probes.iter().map(start).collect();
    let layout = problem.layout(&tries[0].kinds());
    let xs: Vec<Vec<f64>> = tries.iter().map(|values| layout.pack(values)).collect();
    let costs = problem.costs(&layout, Objective::Increments, &xs);
    let best = (0..xs.len()).min_by(|a, b| costs[*a].total_cmp(&costs[*b]))?;
    let found = problem.search(&layout, Objective::Increments, &xs[best], STEPS, 3e-4);
    Some(evidence.polish(layout, found))
}

/// Every model that has a simpler effect in the place of one of `model`'s that contains it.
pub fn simpler(evidence: &Evidence, model: &Candidate) -> Vec<Candidate> {
    let values = model.values();
    let place = |(rich, parameters): &(Kind, Vec<f64>)| {
        let without = values.without(*rich);
        let others = without.kinds();
        let part = |(part, at): (Kind, usize)| {
            (!covers(&others, part)).then(|| evidence.fit(&without.with(part, vec![parameters[at]]), STEPS))
        };
        parts(*rich).filter_map(part).collect::<Vec<_>>()
    };
    values.effects.iter().flat_map(place).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_part_that_is_there_already_does_not_join_again() {
        use Kind::{ConstantLoad, Coulomb, CoulombAsymmetric, Delay, Spring, Stribeck};
        assert!(may_join(&[Coulomb], Stribeck) && may_join(&[Coulomb], ConstantLoad));
        assert!(!may_join(&[Stribeck], Coulomb) && !may_join(&[Coulomb], Coulomb));
        assert!(!may_join(&[Spring], ConstantLoad) && may_join(&[ConstantLoad], Spring));
        // Its one part is there, and the other can join by itself.
        assert!(!may_join(&[Coulomb], CoulombAsymmetric) && !may_join(&[Spring], CoulombAsymmetric));
        assert!(may_join(&[Delay], CoulombAsymmetric));
    }

    #[test]
    fn a_sum_is_covered_by_its_parts_and_by_laws_that_contain_them() {
        use Kind::{ConstantLoad, Coulomb, CoulombAsymmetric, Stribeck};
        assert!(covers(&[Coulomb, ConstantLoad], CoulombAsymmetric));
        assert!(covers(&[Stribeck, ConstantLoad], CoulombAsymmetric));
        assert!(!covers(&[Coulomb], CoulombAsymmetric));
    }
}
