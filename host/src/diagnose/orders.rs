//! How many teeth: orders felt out on the record that shows them best.
//!
//! What a shaft stands against tells how strong its teeth are, and little of how many: in any order some ripple holds it as long.
//! When it lets go tells. So every order is tried at many phases and sizes on one record, felt around from the best of
//! them, and the best orders are left to be judged by all records.

use std::f64::consts::TAU;

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use super::ripple::HIGHEST_ORDER;
use super::teeth::{Feeler, Ripple};
use crate::fit::layout::Values;

/// Sizes that are tried, V of a 12 V motor, ...
const SIZES_V: [f64; 6] = [0.1, 0.17, 0.28, 0.42, 0.6, 0.85];
/// ... at so many phases.
const PHASES: usize = 16;
/// So many of each order are felt around.
const FELT: usize = 4;
/// So many orders are left, ...
const LEFT: usize = 6;
/// ... none of which costs so many times more than the best.
const AS_CHEAP: f64 = 1.5;
/// Teeth of a wrong order hold a shaft too: less than this share of what a record showed is left under them.
const HOLDS: f64 = 0.5;

/// `model` with teeth of the orders that fit best on the record that shows teeth best, best first; none where it has no
/// teeth, or these hold it nowhere.
pub(super) fn likely(evidence: &Evidence, model: &Candidate) -> Vec<Values> {
    let values = model.values();
    let without = evidence.fit(&values.without(Kind::Cogging), 0);
    let by_what_shows = |a: &usize, b: &usize| without.records[*a].total_cmp(&without.records[*b]);
    let Some(shows) = evidence.first_runs().max_by(by_what_shows) else { return Vec::new() };
    if model.records[shows] - 1.0 > HOLDS * (without.records[shows] - 1.0) {
        return Vec::new();
    }
    let record = evidence.train.on(vec![evidence.sketch(shows)]);
    let tries = tries(evidence.train.rig.nominal_v / 12.0);
    let Some(mut feeler) = Feeler::new(&record, &values) else { return Vec::new() };
    let mut found: Vec<(f64, Values)> = Vec::new();
    for order in (1..=HIGHEST_ORDER).map(|order| order as f64) {
        feeler.set_order(order);
        let starts = feeler.costs(&tries).into_iter().take(FELT);
        let best = starts.map(|start| feeler.feel(start)).min_by(|a, b| a.0.total_cmp(&b.0));
        found.extend(best.map(|(cost, ripple)| (cost, feeler.with(&ripple))));
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let most = AS_CHEAP * found.first().map_or(0.0, |best| best.0);
    let likely = found.into_iter().filter(|(cost, _)| *cost < most);
    likely.take(LEFT).map(|(_, values)| values).collect()
}

/// Ripples of every size and phase, in units of `unit` volts.
fn tries(unit: f64) -> Vec<Ripple> {
    let of_size = |size: f64| {
        (0..PHASES).map(move |k| {
            let (sine, cosine) = (TAU * k as f64 / PHASES as f64).sin_cos();
            [unit * size * sine, unit * size * cosine, 0.0, 0.0]
        })
    };
    SIZES_V.into_iter().flat_map(of_size).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::diagnose::teeth::settle_teeth;
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    /// Hidden: ten teeth. Of twenty, every second one holds the shaft nearly as long.
    #[test]
    fn the_order_of_teeth_is_found_where_another_holds_the_shaft_as_well() {
        let conditions = Conditions { disturbed: 0.25, spoilt: 0.15 };
        let case = Case::new(39_200_073, &[Hidden::Coast, Hidden::Cogging], conditions);
        assert!(case.sizes.contains("periods=10"), "{}", case.sizes);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let coast = evidence.fit(&base.values().with(Kind::Coast, vec![0.6, 1000.0]), 20);
        let ripple = vec![0.497, -0.255, 0.062, 0.015, 20.0];
        let wrong = evidence.fit(&coast.values().with(Kind::Cogging, ripple), 10);
        assert!(wrong.records[0] < 0.3 * coast.records[0], "{:?}", wrong.records);
        let likely = likely(&evidence, &wrong);
        let order = |values: &Values| values.effects[1].1[4];
        assert!(
            likely.iter().any(|values| order(values) == 10.0),
            "{:?}",
            likely.iter().map(order).collect::<Vec<_>>()
        );
        assert_eq!(order(&settle_teeth(&evidence, wrong).values()), 10.0);
        assert!(super::likely(&evidence, &coast).is_empty(), "a model without teeth has no orders");
    }

    #[test]
    fn ripples_are_tried_at_every_size_all_around() {
        let tries = tries(2.0);
        assert_eq!(tries.len(), SIZES_V.len() * PHASES);
        let sizes: Vec<f64> = tries.iter().map(|r| r[0].hypot(r[1])).collect();
        assert!((sizes[0] - 0.2).abs() < 1e-12 && (sizes[PHASES] - 0.34).abs() < 1e-12);
        assert!(tries.iter().all(|r| r[2] == 0.0 && r[3] == 0.0));
        assert!(tries[..PHASES].iter().map(|r| r[0]).sum::<f64>().abs() < 1e-12);
    }
}
