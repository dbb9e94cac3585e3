//! Orders of torque ripple: to which of them the records answer.
//!
//! A simulation at the measured angle answers linearly to the sine and the cosine of a small ripple, because its phase is that of the measured
//! shaft. So one probe of each tells the best size of both, and what it would be worth, order by order. A strong cogging torque holds the
//! shaft and lets it go at once, which answers to no small probe: it shows where the shaft hardly moves.

use motorlens_shared::effects::Kind;

use super::tangent::Tangent;
use crate::fit::grid::Quantity;
use crate::fit::layout::Values;
use crate::fit::search::Problem;
use crate::fit::simulate::LANES;
use crate::log::motion::mean;

/// Highest order looked for, periods per motor revolution.
pub const HIGHEST_ORDER: usize = 24;
/// Lowest order looked for on `problem`: a torque that repeats once a turn of the output shaft is gravity's.
fn lowest_order(problem: &Problem) -> usize {
    if problem.rig.gear_ratio == 1.0 { 2 } else { 1 }
}

/// Size of a probe, V of a 12 V motor.
const PROBE_V: f64 = 0.02;
/// Orders that are tried in earnest.
const MOST: usize = 3;

/// Parameters of a pure sine; its harmonic is left to the search.
fn ripple(sine: f64, cosine: f64, order: f64) -> Vec<f64> {
    vec![sine, cosine, 0.0, 0.0, order]
}

/// Starting parameters (sine, cosine, order) of the orders that take most away from the error of `model`.
pub fn answering(problem: &Problem, tangent: &Tangent, model: &Values, kind: Kind) -> Vec<Vec<f64>> {
    let probe = PROBE_V * problem.rig.nominal_v / 12.0;
    let kinds = [model.kinds(), vec![kind]].concat();
    let layout = problem.layout(&kinds);
    let orders: Vec<f64> = (lowest_order(problem)..=HIGHEST_ORDER).map(|order| order as f64).collect();
    let mut found: Vec<(f64, Vec<f64>)> = Vec::new();
    for orders in orders.chunks(LANES / 2) {
        let with =
            |sine: f64, cosine: f64, order: f64| layout.pack(&model.with(kind, ripple(sine, cosine, order)));
        let xs: Vec<Vec<f64>> =
            orders.iter().flat_map(|order| [with(probe, 0.0, *order), with(0.0, probe, *order)]).collect();
        let gains = tangent.pairs(problem, &layout, &xs);
        found.extend(
            orders
                .iter()
                .zip(gains)
                .map(|(order, (gain, [s, c]))| (gain, ripple(s * probe, c * probe, *order))),
        );
    }
    found.sort_by(|a, b| b.0.total_cmp(&a.0));
    let mut chosen: Vec<Vec<f64>> = Vec::new();
    for (_, start) in found {
        let order = start[start.len() - 1];
        // Half of a chosen order would only imitate it by its harmonic.
        if chosen.len() < MOST && !chosen.iter().any(|c| c[c.len() - 1] == 2.0 * order) {
            chosen.push(start);
        }
    }
    chosen
}

/// Time over which the torque is balanced, s.
const SPAN_S: f64 = 0.02;
/// A shaft stands where the motor turns by no more than this, rad, or a count, in that time, before it and after it.
const STANDS: f64 = 0.1;
/// Orders must hold this share of the square of what the shaft stands against ...
const HOLDS: f64 = 0.04;
/// ... and so many are tried.
const MOST_HOLDING: usize = 3;

/// Sums over the spans in which the shaft stands: of the squares and the product of a ripple's sine and cosine, and of theirs with
/// the torque.
#[derive(Debug, Clone, Copy, Default)]
struct Balance {
    ss: f64,
    cc: f64,
    sc: f64,
    st: f64,
    ct: f64,
}

impl Balance {
    fn add(&mut self, phase: f64, torque: f64) {
        let (s, c) = phase.sin_cos();
        self.ss += s * s;
        self.cc += c * c;
        self.sc += s * c;
        self.st += s * torque;
        self.ct += c * torque;
    }

    /// How much of the torque's square the ripple holds, and its sine and cosine; none where the phases are too few.
    fn solved(&self) -> Option<(f64, [f64; 2])> {
        let determinant = self.ss * self.cc - self.sc * self.sc;
        let sine = (self.st * self.cc - self.ct * self.sc) / determinant;
        let cosine = (self.ct * self.ss - self.st * self.sc) / determinant;
        (determinant > 1e-9 * self.ss * self.cc)
            .then_some((sine * self.st + cosine * self.ct, [sine, cosine]))
    }
}

/// Starting parameters of the orders whose cogging torque holds the shaft best where it stands: there the voltage, less the back-EMF, is
/// their torque.
pub fn holding(problem: &Problem, model: &Values) -> Vec<Vec<f64>> {
    let held = shares(problem, model).into_iter().filter(|(share, _)| *share > HOLDS);
    held.take(MOST_HOLDING).map(|(_, start)| start).collect()
}

/// What share of the square of the torque that it stands against every order holds, most first.
fn shares(problem: &Problem, model: &Values) -> Vec<(f64, Vec<f64>)> {
    let turns = problem.rig.gear_ratio;
    let mut balances = [Balance::default(); HIGHEST_ORDER];
    let mut whole = 0.0;
    for grid in problem.grids.iter().filter(|grid| grid.quantity == Quantity::Angle) {
        let span = ((SPAN_S / grid.interval_s).round() as usize).max(1);
        let still = (STANDS / turns).max(1.01 * grid.quantum);
        let way = |first: usize| grid.measured[first + span] - grid.measured[first];
        let spans = (grid.skip + span..grid.len().saturating_sub(2 * span)).step_by(span);
        let stands =
            |first: &usize| [first - span, *first, first + span].iter().all(|k| way(*k).abs() < still);
        for first in spans.filter(stands) {
            let last = first + span;
            let volts = mean(&grid.cells()[grid.places[first].cell..grid.places[last].cell]);
            let torque = volts - way(first) / (grid.time_s[last] - grid.time_s[first]) / model.base.gain;
            let angle = mean(&grid.measured[first..=last]);
            whole += torque * torque;
            for (k, balance) in balances.iter_mut().enumerate() {
                balance.add((k + 1) as f64 * turns * angle, torque);
            }
        }
    }
    let solved = balances.iter().enumerate().skip(lowest_order(problem) - 1).filter_map(|(k, balance)| {
        let (held, [sine, cosine]) = balance.solved()?;
        Some((held / whole, ripple(sine, cosine, (k + 1) as f64)))
    });
    let mut shares: Vec<(f64, Vec<f64>)> = solved.collect();
    shares.sort_by(|a, b| b.0.total_cmp(&a.0));
    shares
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    /// Twelve periods of cogging torque a turn, which let go at once: small probes answer to any order but theirs.
    #[test]
    fn teeth_that_hold_the_shaft_show_where_it_stands() {
        let case = Case::new(32_000_206, &[Hidden::Cogging], Conditions { disturbed: 0.25, spoilt: 0.15 });
        assert!(case.sizes.contains("periods=12"), "{}", case.sizes);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let shares = shares(&evidence.train, &base.values());
        assert!(shares[0].1[4] == 12.0 && shares[0].0 > 0.3, "{shares:?}");
    }

    #[test]
    fn once_a_turn_of_the_output_shaft_nothing_is_cogging() {
        let case = Case::new(32, &[Hidden::Gravity], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let mut problem = evidence.train.clone();
        assert!(problem.rig.gear_ratio > 1.0 && lowest_order(&problem) == 1);
        problem.rig.gear_ratio = 1.0;
        assert!(shares(&problem, &base.values()).iter().all(|(_, start)| start[4] >= 2.0));
    }

    #[test]
    fn dry_friction_holds_the_shaft_at_any_angle() {
        let case = Case::new(32_000_000, &[Hidden::Coulomb], Conditions { disturbed: 0.25, spoilt: 0.15 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let shares = shares(&evidence.train, &base.values());
        assert!(shares[0].0 < 0.1, "{shares:?}");
    }
}
