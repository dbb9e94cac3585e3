//! Shaking: searches begun again beside where one ended, for laws whose cost has more than one lowest place.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use super::teeth::turn;
use crate::fit::cost::Objective;
use crate::fit::layout::Values;

/// Searches `leader` again from beside where it ended, where the cost of its last law has more than one lowest place.
pub fn shake(evidence: &Evidence, leader: &mut Candidate) {
    let values = leader.values();
    let Some((kind, last)) = values.effects.last() else { return };
    let mut starts: Vec<Values> =
        beside(*kind, last).into_iter().map(|beside| values.without(*kind).with(*kind, beside)).collect();
    starts.extend(swapped(&values, evidence.train.prior.tau_e.0));
    for start in starts {
        if leader.explains() {
            return;
        }
        let layout = leader.layout.clone();
        let found = evidence.train.search(&layout, Objective::Increments, &layout.pack(&start), SHAKES, 3e-4);
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
    let times = |place: usize, share: &f64| with(&|p| p[place] *= share);
    match kind {
        Kind::Coast | Kind::DeadZone => SHARES.iter().map(|share| times(0, share)).collect(),
        Kind::Backlash => {
            let shape = [1, 2].into_iter().flat_map(|place| A_LITTLE.map(|share| times(place, &share)));
            SHARES.iter().map(|share| times(0, share)).chain(shape).collect()
        }
        Kind::Cogging => ANGLES.iter().map(|angle| with(&|p| turn(p, *angle))).collect(),
        _ => Vec::new(),
    }
}

/// A filter of the reading and the electrical time constant follow one another and could change places: what the latter took of
/// the former, beyond `name_plate`, is given back.
pub fn swapped(values: &Values, name_plate: f64) -> Option<Values> {
    let mut swapped = values.clone();
    let (kind, last) = swapped.effects.last_mut()?;
    let taken = values.base.tau_e - name_plate;
    if *kind != Kind::SensorLag || taken < BENT * name_plate {
        return None;
    }
    last[0] += taken;
    swapped.base.tau_e = name_plate;
    Some(swapped)
}

/// Share of itself by which an electrical time constant has plainly taken something over.
const BENT: f64 = 0.5;

/// Shares of the first parameter, of what a gap's load has of inertia and friction, and angles (rad) of a ripple, from which a leader
/// is searched again ...
const SHARES: [f64; 4] = [0.85, 1.15, 0.7, 1.4];
const A_LITTLE: [f64; 2] = [0.9, 1.1];
const ANGLES: [f64; 4] = [-0.3, 0.3, -0.6, 0.6];
/// ... and the steps of each search.
const SHAKES: usize = 10;

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    #[test]
    fn gaps_are_searched_again_at_other_widths_teeth_at_other_phases_and_friction_not_at_all() {
        let gaps = beside(Kind::Backlash, &[0.1, 0.3, 0.2]);
        assert_eq!(gaps[1], [0.1 * 1.15, 0.3, 0.2]);
        assert_eq!(gaps[4..6], [[0.1, 0.3 * 0.9, 0.2], [0.1, 0.3 * 1.1, 0.2]]);
        let turned = beside(Kind::Cogging, &[0.3, 0.0, 0.0, 0.0, 12.0]);
        for (p, angle) in turned.iter().zip(ANGLES) {
            assert!((p[1].atan2(p[0]) - angle).abs() < 1e-12 && p[4] == 12.0);
        }
        assert!(beside(Kind::Coulomb, &[0.3]).is_empty());
    }

    /// Left alone the search ends with 4.3 ms of the filter's 6.7 in the electrical time constant, and 2.8 x the floor.
    #[test]
    fn a_filter_takes_back_what_the_electrical_time_constant_took_of_it() {
        let conditions = Conditions { disturbed: 0.25, spoilt: 0.15 };
        let case = Case::new(36_000_220, &[Hidden::SensorLag], conditions);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let start = base.values().with(Kind::SensorLag, vec![0.0027, 0.0]);
        let mut ended = evidence.fit(&start, 20);
        assert!(!ended.explains(), "the case no longer needs it");
        shake(&evidence, &mut ended);
        assert!(ended.explains_all(), "{:?}", ended.records);
        let lag = ended.values().effects[0].1[0];
        assert!((lag - 0.006_739).abs() < 2e-4, "{lag}");
    }
}
