//! Equations that contain others: a richer equation takes a simpler one's place, and a sum goes by the name of its parts while more
//! is looked for.
//!
//! Both at once would fight over the same torque: dry friction beside Stribeck's has no level of its own.

use motorlens_shared::effects::Kind;

use crate::fit::layout::Values;

/// The simpler effects of which `kind` is made, each with the place of its parameter in `kind`.
pub fn parts(kind: Kind) -> impl Iterator<Item = (Kind, usize)> {
    let spec = kind.spec();
    let part = |(name, parameter): &(&str, &str)| Some((Kind::by_name(name)?, spec.place(parameter)?));
    spec.contains.iter().filter_map(part)
}

/// Whether a model of `kinds` describes what `kind` does: by itself, within a richer equation, or by its parts.
pub fn covers(kinds: &[Kind], kind: Kind) -> bool {
    let within = |simple: Kind| kinds.iter().any(|rich| rich.spec().holds(simple.name()));
    within(kind) || (kind.spec().is_sum() && parts(kind).all(|(part, _)| within(part)))
}

/// Whether `kind` may join `kinds`: it brings more than a part that could join by itself.
pub fn may_join(kinds: &[Kind], kind: Kind) -> bool {
    !(covers(kinds, kind) || kind.spec().is_sum() && parts(kind).any(|(part, _)| covers(kinds, part)))
}

/// Whether `kind` takes the place of a simpler equation of `kinds`.
pub fn replaces(kinds: &[Kind], kind: Kind) -> bool {
    parts(kind).any(|(part, _)| kinds.contains(&part))
}

/// `values` with `kind` of `parameters`: in the place of the simpler equations that it contains, whose sizes it keeps.
pub fn extended(values: &Values, kind: Kind, mut parameters: Vec<f64>) -> Values {
    let mut rest = values.clone();
    for (part, at) in parts(kind) {
        if let Some(own) = values.parameters(part) {
            parameters[at] = own[0];
        }
        rest = rest.without(part);
    }
    rest.with(kind, parameters)
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
