//! The evidence: records to fit, records to judge by, and how models are fitted and judged on them.

use std::sync::Arc;

use motorlens_shared::effects::Kind;

use super::candidate::{Candidate, Errors};
use super::chance;
use super::floor::{Repeat, floor, repeats_of};
use crate::fit::cost::Objective;
use crate::fit::grid::Grid;
use crate::fit::layout::{Layout, Values};
use crate::fit::passes::Squares;
use crate::fit::search::{Found, Problem};
use crate::log::{Record, losses};
use crate::motor_file::MotorFile;

/// Share of a record that is fitted where nothing else is there to judge by.
const FITTED_SHARE: f64 = 0.65;

/// Nothing disturbs a motor whose second run of a programme differs from the first by less than so many times the counting: counts of two
/// runs that nothing ties to one another differ by sqrt(3/2) times it.
const CALM: f64 = 1.3;

/// Records fitted and records kept out, as the diagnosis uses them.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// All records to learn from, whole: for free runs.
    pub whole: Problem,
    /// Records of their own to judge by, whole: for free runs. None where the ends of the others judge.
    pub kept_out: Option<Problem>,
    /// Fitted, in guided runs.
    pub train: Problem,
    /// Kept out, in guided runs.
    pub unseen: Problem,
    /// What a perfect model would leave, in noise units of one reading: the unit of a candidate's errors.
    pub floor: Errors,
    /// Whether that was measured, by a repeated programme; else it is what counting alone leaves.
    pub repeated: bool,
    /// Whether two runs of one programme show that counts are lost.
    pub loses_counts: bool,
    repeats: Arc<Vec<Repeat>>,
    /// By how much a reading's noise was raised on each record fitted and on each kept out.
    allowed: [Vec<f64>; 2],
}

impl Evidence {
    /// Splits what there is into records to fit and records to judge by; `start` is near the motor.
    pub fn new(
        whole: Problem,
        start: &Values,
        records: &[Record],
        validation: &[Record],
        motor: &MotorFile,
    ) -> Self {
        let repeats = repeats_of(records);
        let measured = floor(&repeats, &whole, start);
        let loses_counts = repeats.iter().any(|Repeat { places, runs: [first, second] }| {
            let quantum = whole.grids[places[0]].quantum;
            losses::loses_counts(first, second, quantum, whole.rig.reference_speed)
        });
        let guided = |grids: Vec<Grid>| whole.on(grids.into_iter().map(Grid::guided).collect());
        let mut kept_out = (!validation.is_empty()).then(|| whole.on(whole.lay_out(validation, motor)));
        if let Some((kept_out, hz)) = kept_out.as_mut().zip(whole.pulse_hz) {
            kept_out.pulse_at(start, hz);
        }
        let (train, unseen) = if let Some(kept_out) = &kept_out {
            (guided(whole.grids.clone()), guided(kept_out.grids.clone()))
        } else {
            let beginnings = whole.grids.iter().map(|g| g.beginning(FITTED_SHARE)).collect();
            let rests = whole.grids.iter().map(|g| g.rest(FITTED_SHARE)).collect();
            (guided(beginnings), guided(rests))
        };
        let (floor, repeated) = (measured.unwrap_or(Errors::COUNTING), measured.is_some());
        let allowed = [&train, &unseen].map(|problem| vec![1.0; problem.grids.len()]);
        let repeats = Arc::new(repeats);
        Self { whole, kept_out, train, unseen, floor, repeated, loses_counts, repeats, allowed }
    }

    /// Measures the floor anew under `model`, where it is lower so: what two runs differ by may be in the model.
    pub fn lower_floor(&mut self, model: &Values) {
        if let Some(floor) = floor(&self.repeats, &self.whole, model)
            && floor.increments < self.floor.increments
        {
            self.floor = floor;
        }
    }

    /// Lets every record count for as much as it can tell where `model` leaves something to chance. Whether that changed
    /// anything: then errors of before are in other units.
    pub fn allow_for_chance(&mut self, model: &Values) -> bool {
        const SAME: f64 = 1.05;
        let old = self.allowed.clone();
        self.set_allowed(old.each_ref().map(|shares| vec![1.0; shares.len()]));
        let scatter = [&self.train, &self.unseen].map(|problem| chance::scatter(problem, model));
        let measured = self.repeats.iter().map(|repeat| scatter[0][repeat.second()]).sum::<f64>();
        let measured = measured / self.repeats.len().max(1) as f64;
        let new = scatter.map(|own| chance::allowances(&own, measured, &self.floor));
        let same = |(old, new): (&f64, &f64)| (old / new).max(new / old) < SAME;
        let changed = !old.iter().flatten().zip(new.iter().flatten()).all(same);
        self.set_allowed(if changed { new } else { old });
        changed
    }

    fn set_allowed(&mut self, new: [Vec<f64>; 2]) {
        let problems = [&mut self.train, &mut self.unseen];
        for ((problem, old), new) in problems.into_iter().zip(&self.allowed).zip(&new) {
            for ((grid, old), new) in problem.grids.iter_mut().zip(old).zip(new) {
                grid.sigma *= new / old;
            }
        }
        self.allowed = new;
    }

    /// `candidate` in the units of now.
    pub fn again(&self, candidate: &Candidate) -> Candidate {
        let layout = candidate.layout.clone();
        let found = self.train.search(&layout, Objective::Increments, &candidate.found.x, 0, 1e-3);
        self.judge(&layout, vec![found]).swap_remove(0)
    }

    /// Evidence in which nothing is kept out.
    pub fn all_of(problem: &Problem) -> Self {
        let allowed = vec![1.0; problem.grids.len()];
        Self {
            whole: problem.clone(),
            kept_out: None,
            train: problem.clone(),
            unseen: problem.clone(),
            floor: Errors::COUNTING,
            repeated: false,
            loses_counts: false,
            repeats: Arc::default(),
            allowed: [allowed.clone(), allowed],
        }
    }

    /// The records fitted, one of each programme, sketched: a second run tells the floor, and little of the physics.
    pub fn programmes(&self) -> Problem {
        self.train.on(self.first_runs().map(|k| self.sketch(k)).collect())
    }

    /// The places of the records fitted that run no programme of an earlier one.
    pub fn first_runs(&self) -> impl Iterator<Item = usize> {
        (0..self.train.grids.len()).filter(|k| !self.is_second_run(*k))
    }

    /// The record fitted at place `k` in coarse cells, for candidates that are only compared; not where readings are held for about
    /// the time of one.
    pub fn sketch(&self, k: usize) -> Grid {
        let grid = &self.train.grids[k];
        if self.train.hold_s.is_none() { grid.coarse() } else { grid.clone() }
    }

    /// Whether the record fitted at place `k` runs the programme of an earlier one.
    pub fn is_second_run(&self, k: usize) -> bool {
        self.repeats.iter().any(|repeat| repeat.second() == k)
    }

    /// Candidate passes so far.
    pub fn simulations(&self) -> u64 {
        self.train.simulations.get() + self.unseen.simulations.get()
    }

    /// The highest voltage that the rig has shown to bear, V.
    pub fn highest_voltage(&self) -> f64 {
        let cells = self.whole.grids.iter().flat_map(|g| g.cells());
        cells.fold(0.0_f64, |p, v| p.max(v.abs())).max(0.5 * self.whole.rig.nominal_v)
    }

    /// The errors on both of fits of one layout, up to eight.
    pub fn judge(&self, layout: &Layout, found: Vec<Found>) -> Vec<Candidate> {
        let xs: Vec<Vec<f64>> = found.iter().map(|found| found.x.clone()).collect();
        let [train, unseen] = [&self.train, &self.unseen].map(|problem| problem.squares(layout, &xs));
        let over = |squares: Squares| Errors::of(squares.mean()).over(&self.floor);
        let calm = self.floor.increments < CALM && self.floor.position < CALM;
        let candidate = |((found, train), unseen): ((Found, Vec<Squares>), Vec<Squares>)| Candidate {
            layout: layout.clone(),
            found,
            train: over(train.iter().copied().sum()),
            unseen: over(unseen.iter().copied().sum()),
            records: train.into_iter().chain(unseen).map(|squares| over(squares).increments).collect(),
            calm: self.repeated.then_some(calm),
            foretold: self.loses_counts && layout.kinds.contains(&Kind::LostCounts),
        };
        found.into_iter().zip(train).zip(unseen).map(candidate).collect()
    }

    /// Searches `values` in increments, then lets the error itself correct the drift of the parameters.
    pub fn fit(&self, values: &Values, iterations: usize) -> Candidate {
        let layout = self.train.layout(&values.kinds());
        let x = layout.pack(values);
        let rough = self.train.search(&layout, Objective::Increments, &x, iterations, 1e-4);
        self.polish(layout, rough)
    }

    /// The better of a fit in increments and its correction by the error itself.
    ///
    /// Where a disturbance makes the error drift, the correction would follow the drift: then it is refused.
    pub fn polish(&self, layout: Layout, rough: Found) -> Candidate {
        let fine = self.train.search(&layout, Objective::Position, &rough.x, 3, 1e-3);
        let mut judged = self.judge(&layout, vec![rough, fine]);
        // Of equals the first one.
        judged.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
        judged.swap_remove(0)
    }

    /// `model` with the viscous share that is usual, where it fits no worse so: bent by what a model lacks, it would lead every
    /// further effect astray.
    ///
    /// A plain motor shows tau_m + b tau_e and tau_m tau_e alone: these stay.
    pub fn straightened(&self, model: &Candidate) -> Candidate {
        const NO_WORSE: f64 = 0.01;
        let mut values = model.values();
        let (usual, width) = self.train.prior.viscous_share;
        let base = &mut values.base;
        let (sum, product) = (base.tau_m + base.viscous_share * base.tau_e, base.tau_m * base.tau_e);
        let root = sum * sum - 4.0 * usual * product;
        if (base.viscous_share - usual).abs() < width || root < 0.0 {
            return model.clone();
        }
        base.viscous_share = usual;
        base.tau_m = 0.5 * (sum + root.sqrt());
        base.tau_e = product / base.tau_m;
        let layout = model.layout.clone();
        let found = self.train.search(&layout, Objective::Increments, &layout.pack(&values), 0, 1e-3);
        let straight = self.judge(&layout, vec![found]).swap_remove(0);
        if straight.merit() < model.merit() + NO_WORSE { straight } else { model.clone() }
    }

    /// An accepted model's parameters, corrected by the error itself until it stops falling.
    ///
    /// The increments leave a slow drift undetermined, which the error of a long run shows. Where a disturbance
    /// makes the drift, the correction does not help on unseen records and is refused.
    pub fn finish(&self, accepted: Candidate) -> Candidate {
        let fine = self.train.search(&accepted.layout, Objective::Position, &accepted.found.x, 10, 1e-6);
        let fine = self.judge(&accepted.layout, vec![fine]).swap_remove(0);
        let better = fine.unseen.position <= accepted.unseen.position
            && fine.unseen.increments < accepted.unseen.increments * 1.05;
        if better { fine } else { accepted }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;

    #[test]
    fn a_programme_that_was_run_twice_is_searched_once_and_judged_twice() {
        let case = Case::new(4, &[], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (whole, start) = setup::problem(&case.records, &case.motor);
        let evidence = Evidence::new(whole, &start, &case.records, &case.held_out, &case.motor);
        assert!(evidence.repeated);
        let names = |problem: &Problem| problem.grids.iter().map(|g| g.name.clone()).collect::<Vec<_>>();
        let (all, once) = (names(&evidence.train), names(&evidence.programmes()));
        assert_eq!(once, all[..all.len() - 1], "the last record repeats the third one's programme");
    }

    #[test]
    fn a_plain_motor_fits_as_well_with_the_usual_viscous_share_as_with_any() {
        let case = Case::new(4, &[], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (whole, start) = setup::problem(&case.records, &case.motor);
        let evidence = Evidence::new(whole, &start, &case.records, &case.held_out, &case.motor);
        let fitted = evidence.fit(&start, 10);
        let judged = |values: &Values| {
            let found = evidence.train.search(
                &fitted.layout,
                Objective::Increments,
                &fitted.layout.pack(values),
                0,
                1e-3,
            );
            evidence.judge(&fitted.layout, vec![found]).swap_remove(0)
        };
        let mut bent = fitted.values();
        let base = &mut bent.base;
        let (sum, product) = (base.tau_m + base.viscous_share * base.tau_e, base.tau_m * base.tau_e);
        base.viscous_share = 0.55;
        base.tau_m = 0.5 * (sum + (sum * sum - 4.0 * 0.55 * product).sqrt());
        base.tau_e = product / base.tau_m;
        let straight = evidence.straightened(&judged(&bent));
        assert_eq!(straight.values().base.viscous_share, evidence.train.prior.viscous_share.0);
        assert!((straight.merit() - judged(&bent).merit()).abs() < 1e-6);
        // The share alone, without the time constants that go with it, is another motor.
        bent.base.viscous_share = 0.0;
        assert!(judged(&bent).merit() > straight.merit() + 0.1);
    }
}
