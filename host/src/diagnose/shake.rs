//! Shaking: searches begun again beside where one ended, for laws whose cost has more than one lowest place.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use super::teeth::turn;
use crate::fit::cost::Objective;

/// Searches `leader` again from beside where it ended, where the cost of its last law has more than one lowest place.
pub fn shake(evidence: &Evidence, leader: &mut Candidate) {
    let values = leader.values();
    let Some((kind, last)) = values.effects.last() else { return };
    for beside in beside(*kind, last) {
        if leader.explains() {
            return;
        }
        let layout = leader.layout.clone();
        let start = layout.pack(&values.without(*kind).with(*kind, beside));
        let found = evidence.train.search(&layout, Objective::Increments, &start, SHAKES, 3e-4);
        let again = evidence.polish(layout, found);
        if again.merit() < leader.merit() {
            *leader = again;
        }
    }
}

/// From where a law is searched again: kinks make valleys along the size, teeth along the phase.
fn beside(kind: Kind, parameters: &[f64]) -> Vec<Vec<f64>> {
    let with = |change: &dyn Fn(&mut [f64])| {
        let mut changed = parameters.to_vec();
        change(&mut changed);
        changed
    };
    match kind {
        Kind::Coast | Kind::DeadZone | Kind::Backlash => {
            SHARES.iter().map(|share| with(&|p| p[0] *= share)).collect()
        }
        Kind::Cogging => ANGLES.iter().map(|angle| with(&|p| turn(p, *angle))).collect(),
        _ => Vec::new(),
    }
}

/// Shares of the first parameter, and angles (rad) of a ripple, from which a leader is searched again ...
const SHARES: [f64; 4] = [0.85, 1.15, 0.7, 1.4];
const ANGLES: [f64; 4] = [-0.3, 0.3, -0.6, 0.6];
/// ... and the steps of each search.
const SHAKES: usize = 10;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_searched_again_at_other_widths_teeth_at_other_phases_and_friction_not_at_all() {
        assert_eq!(beside(Kind::Backlash, &[0.1, 0.3])[1], [0.1 * 1.15, 0.3]);
        let turned = beside(Kind::Cogging, &[0.3, 0.0, 0.0, 0.0, 12.0]);
        for (p, angle) in turned.iter().zip(ANGLES) {
            assert!((p[1].atan2(p[0]) - angle).abs() < 1e-12 && p[4] == 12.0);
        }
        assert!(beside(Kind::Coulomb, &[0.3]).is_empty());
    }
}
