//! Effects that nobody chose.

use motorlens_shared::effects::Kind as Law;
use motorlens_virtual_motor::{Effect, Kind, Motor};
use rand::rngs::ChaCha8Rng;
use rand::seq::IndexedRandom;
use rand::{RngExt, SeedableRng};

/// Effects that can hardly be told apart when both are present: at most one of each group is picked.
const ALIKE: [&[Kind]; 5] = [
    &[Kind::Coulomb, Kind::CoulombAsymmetric, Kind::Stribeck],
    &[Kind::DeadZone, Kind::VoltageDrop],
    &[Kind::Coast, Kind::Freewheel],
    &[Kind::Backlash, Kind::Compliance],
    &[Kind::Delay, Kind::SensorLag],
];

/// None, one or two effects (in 10, 60 and 30 of 100 cases), visible on this motor; the same seed picks the same.
pub fn hidden(seed: u64, motor: &Motor) -> Vec<Effect> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x6566_6665_6374_7321);
    let wanted = match rng.random_range(0..10) {
        0 => 0,
        1..=6 => 1,
        _ => 2,
    };
    let kinds: Vec<Kind> = Kind::all().collect();
    let mut effects: Vec<Effect> = Vec::new();
    while effects.len() < wanted {
        let Some(&kind) = kinds.choose(&mut rng) else { break };
        if !effects.iter().any(|other| alike(other.kind(), kind)) {
            let strength = 0.3 + 0.7 * rng.random::<f64>();
            effects.push(Effect::graded(kind, strength, &mut rng, motor));
        }
    }
    effects
}

/// Whether the two are one, or one contains the other, or they can hardly be told apart when both are present.
pub fn alike(a: Kind, b: Kind) -> bool {
    let within = |rich: Kind, simple: Kind| {
        Law::by_name(rich.row().name).is_some_and(|law| law.spec().holds(simple.row().name))
    };
    a == b
        || within(a, b)
        || within(b, a)
        || ALIKE.iter().any(|group| group.contains(&a) && group.contains(&b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn seeds_pick_none_one_and_two_effects_of_every_kind_and_repeat_themselves() {
        let motor = Motor::paper();
        let mut kinds = HashSet::new();
        let mut numbers = [0; 3];
        for seed in 0..400 {
            let effects = hidden(seed, &motor);
            assert_eq!(effects, hidden(seed, &motor));
            numbers[effects.len()] += 1;
            kinds.extend(effects.iter().map(Effect::kind));
        }
        assert_eq!(kinds.len(), Kind::all().count());
        assert!(numbers[0] > 15 && numbers[1] > 180 && numbers[2] > 80, "{numbers:?}");
    }
}
