//! Rivals: what could stand in an accepted effect's place without the records telling.
//!
//! Each accepted effect is taken out and every other one tried in its place. What comes near there is searched to its end,
//! as the accepted model was: a search that stopped half way excludes nothing.

use motorlens_shared::effects::Kind;

use super::candidate::{Candidate, STANDS_OUT};
use super::climb::Climb;
use super::contained::covers;
use super::evidence::Evidence;
use super::stage::Effort;
use super::step::{TO_THE_END, look};
use super::teeth::settle_teeth;
use super::worth::as_good;
use crate::fit::cost::Objective;

/// Models that the records cannot tell apart: each has another effect, its last, in the place of the first one's last.
#[derive(Debug, Clone)]
pub struct Rivals {
    /// The accepted model, then the others by merit; two at least.
    pub models: Vec<Candidate>,
}

impl Rivals {
    /// The effects that stand for one another, the accepted one first.
    pub fn kinds(&self) -> Vec<Kind> {
        self.models.iter().map(last).collect()
    }
}

/// A model this much worse in merit after a stage (a factor of two in error and more) would not catch up when searched on.
const WITHIN_REACH: f64 = 0.9;

/// The rivals of each effect that `climb` accepted, in the order in which they were.
pub fn rivals(evidence: &Evidence, climb: &Climb, library: &[Kind]) -> Vec<Rivals> {
    let model = climb.model();
    let given = climb.rungs[0].kinds();
    let accepted = model.kinds().iter().copied().filter(|kind| !given.contains(kind));
    accepted.filter_map(|kind| rivals_of(evidence, climb, kind, library)).collect()
}

/// Merit by which a rival is better than the accepted model, and not only as good.
const BETTER: f64 = 0.05;

/// The rival to be believed in the place of `climb`'s model, which was the simplest of those that were near while their searches
/// had not come to an end: one that is plainly better then, by at most a parameter larger, and no richer name for the same.
pub fn better(evidence: &Evidence, climb: &Climb, rivals: &[Rivals]) -> Option<Candidate> {
    let model = climb.model();
    let nested = |a: Kind, b: Kind| covers(&[a], b) || covers(&[b], a);
    let others = rivals.iter().flat_map(|set| set.models[1..].iter().map(|c| (c, last(&set.models[0]))));
    let others = others.filter(|(c, own)| !nested(last(c), *own) && c.size() <= model.size() + 1);
    // What shows on one record weighs little in the mean of all.
    let even = |c: &Candidate| c.worst() < model.worst().max(STANDS_OUT);
    let others = others.filter(|(c, _)| even(c));
    let best = others.map(|(c, _)| c).min_by(|a, b| a.merit().total_cmp(&b.merit()))?;
    let least = best.merit() + BETTER;
    (least < model.merit() && least < to_its_end(evidence, model.clone()).merit()).then(|| best.clone())
}

fn rivals_of(evidence: &Evidence, climb: &Climb, kind: Kind, library: &[Kind]) -> Option<Rivals> {
    let model = climb.model();
    let tried = if model.kinds().len() == climb.rungs[0].kinds().len() + 1 {
        climb.first.clone()
    } else {
        let without = evidence.fit(&model.values().without(kind), TO_THE_END);
        look(evidence, &without, library, Effort::LATER, &mut |_| ())
    };
    let near = |c: &Candidate| c.foretold == model.foretold && c.merit() <= model.merit() + WITHIN_REACH;
    let tried = tried.into_iter().filter(|c| !same(c, model) && near(c));
    let mut others: Vec<Candidate> =
        tried.map(|c| to_its_end(evidence, c)).filter(|c| as_good(c, model)).collect();
    others.sort_by(|a, b| a.merit().total_cmp(&b.merit()));
    let models: Vec<Candidate> = std::iter::once(at_last(evidence, model, kind)).chain(others).collect();
    (models.len() > 1).then_some(Rivals { models })
}

/// The better of `candidate` and of where a longer search leads it.
fn to_its_end(evidence: &Evidence, candidate: Candidate) -> Candidate {
    let longer = evidence.finish(settle_teeth(evidence, evidence.fit(&candidate.values(), TO_THE_END)));
    if longer.merit() < candidate.merit() { longer } else { candidate }
}

/// `model` with `kind` as its last effect.
fn at_last(evidence: &Evidence, model: &Candidate, kind: Kind) -> Candidate {
    let values = model.values();
    let own = values.effects.iter().find(|(k, _)| *k == kind);
    let Some((_, parameters)) = own.filter(|_| last(model) != kind) else { return model.clone() };
    let layout = evidence.train.layout(&[values.without(kind).kinds().as_slice(), &[kind]].concat());
    let x = layout.pack(&values.without(kind).with(kind, parameters.clone()));
    let found = evidence.train.search(&layout, Objective::Increments, &x, 0, 1e-3);
    evidence.judge(&layout, vec![found]).swap_remove(0)
}

fn last(model: &Candidate) -> Kind {
    model.kinds()[model.kinds().len() - 1]
}

/// Whether both say the same, whatever a sum and its parts are called.
fn same(a: &Candidate, b: &Candidate) -> bool {
    let all = |these: &Candidate, those: &Candidate| these.kinds().iter().all(|k| covers(those.kinds(), *k));
    all(a, b) && all(b, a)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::{Options, discover, prepare};
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    const CALM: Conditions = Conditions { disturbed: 0.0, spoilt: 0.0 };

    /// Stribeck's law holds plain friction's: left where its search began, it is far off, and yet no worse.
    #[test]
    fn a_candidate_whose_search_stopped_half_way_is_searched_on_before_it_is_excluded() {
        let case = Case::new(11, &[Hidden::Coulomb], CALM);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let with = |kind: Kind, parameters: &[f64], steps: usize| {
            evidence.fit(&base.values().with(kind, parameters.to_vec()), steps)
        };
        let accepted = with(Kind::Coulomb, &[0.5], 20);
        let level = accepted.values().effects[0].1[0];
        let mut early = with(Kind::Stribeck, &[level, 0.05 * level, 0.2, 0.4], 10);
        let mut bent = early.values();
        bent.base.gain *= 1.0005;
        early.found.x = early.layout.pack(&bent);
        let early = evidence.again(&early);
        let far = early.merit() - accepted.merit();
        assert!(!as_good(&early, &accepted), "merit {} and {}", early.merit(), accepted.merit());
        let first = vec![accepted.clone(), early, with(Kind::Delay, &[0.002], 4)];
        let climb =
            Climb { rungs: vec![base.clone(), accepted], first, refused: Vec::new(), withdrawn: Vec::new() };
        let found: Vec<_> = rivals(&evidence, &climb, &[]).iter().map(Rivals::kinds).collect();
        assert_eq!(found, [[Kind::Coulomb, Kind::Stribeck]], "merit {}", far);
    }

    #[test]
    fn of_two_effects_each_has_its_own_rivals_beside_the_other() {
        let case = Case::new(11, &[Hidden::Coulomb, Hidden::Gravity], CALM);
        let library = vec![Kind::Coulomb, Kind::Gravity, Kind::Stribeck, Kind::Delay];
        let options = Options { library, ..Options::default() };
        let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap();
        assert!(found.effects.contains(&Kind::Gravity), "{:?}", found.effects);
        assert_eq!(found.open_sets(), [[Kind::Coulomb, Kind::Stribeck]]);
        for model in &found.rivals[0].models {
            assert!(
                model.kinds().len() == 2 && model.kinds().contains(&Kind::Gravity),
                "{:?}",
                model.kinds()
            );
        }
    }

    /// A model that is better in the mean of all records, and leaves one that the accepted one does not.
    #[test]
    fn a_rival_that_leaves_a_record_is_not_believed() {
        let case = Case::new(11, &[Hidden::Coulomb], CALM);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let with = |kind: Kind, size: f64| evidence.fit(&base.values().with(kind, vec![size]), 10);
        let (model, friction) = (with(Kind::Delay, 0.002), with(Kind::Coulomb, 0.5));
        let first = vec![model.clone()];
        let climb =
            Climb { rungs: vec![base, model.clone()], first, refused: Vec::new(), withdrawn: Vec::new() };
        let believed = |rival: &Candidate| {
            let models = vec![model.clone(), rival.clone()];
            better(&evidence, &climb, &[Rivals { models }]).map(|c| c.kinds().to_vec())
        };
        assert_eq!(believed(&friction), Some(vec![Kind::Coulomb]));
        let mut uneven = friction;
        uneven.records[0] = model.worst().max(STANDS_OUT) + 0.1;
        assert_eq!(believed(&uneven), None);
    }

    /// A delay explains what a filter does to the reading, with a parameter less; the filter leaves 5 % less.
    #[test]
    fn the_better_of_two_that_explain_is_believed_once_both_are_searched_to_their_end() {
        let conditions = Conditions { disturbed: 0.25, spoilt: 0.15 };
        let case = Case::new(34_200_068, &[Hidden::Coulomb, Hidden::SensorLag], conditions);
        let library = vec![Kind::Coulomb, Kind::Stribeck, Kind::Delay, Kind::SensorLag];
        let options = Options { library, ..Options::default() };
        let found = discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap();
        assert_eq!(found.effects, [Kind::Coulomb, Kind::SensorLag]);
        assert!(found.open_sets().contains(&vec![Kind::SensorLag, Kind::Delay]), "{:?}", found.open_sets());
        let last = found.ladder.last().expect("a rung for the model");
        assert_eq!(last.effects, found.effects);
    }
}
