//! Equations of which one contains the other.

use motorlens_shared::effects::Kind;

/// Those of `kinds` that contain no other of them: of nested equations that fit alike the simpler suffices.
pub fn simplest(kinds: &[Kind]) -> Vec<Kind> {
    let rich = |k: &Kind| kinds.iter().any(|other| nested(*k, *other).is_some_and(|(_, rich)| rich == *k));
    kinds.iter().copied().filter(|k| !rich(k)).collect()
}

/// The simpler and the richer of two equations of which one contains the other.
pub(super) fn nested(a: Kind, b: Kind) -> Option<(Kind, Kind)> {
    let within = |(simple, rich): &(Kind, Kind)| simple != rich && rich.spec().holds(simple.name());
    [(a, b), (b, a)].into_iter().find(within)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn laws_that_contain_another_one_are_no_rivals_of_it() {
        let all = [Kind::Stribeck, Kind::Coulomb, Kind::DeadZone, Kind::CoulombAsymmetric];
        assert_eq!(simplest(&all), [Kind::Coulomb, Kind::DeadZone]);
        assert_eq!(simplest(&[Kind::Stribeck, Kind::CoulombAsymmetric]).len(), 2);
    }
}
