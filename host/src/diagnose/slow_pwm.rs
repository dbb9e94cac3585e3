//! A bridge that coasts under a slow PWM: when its pulses come is found beside the model.

use motorlens_shared::effects::Kind;

use super::candidate::Candidate;
use super::evidence::Evidence;
use super::stage::{self, Effort};
use super::step::{TO_THE_END, prune};
use super::worth::{EQUAL, worth};
use crate::fit::cost::Objective;
use crate::fit::layout::Values;
use crate::fit::pulses::{CLOSELY, ROUGHLY};
use crate::fit::search::Problem;

/// A bridge that leaves less than so many times the floor on every record shows no pulses.
const SHOWS: f64 = 1.2;
/// Rounds of timing and fitting, and the steps of a fit.
const ROUNDS: usize = 3;
const STEPS: usize = 10;
/// Steps of the search by which likely frequencies are compared ...
const ROUGH: usize = 3;
/// ... on so many records.
const FEW: usize = 3;
/// ... the best of which are searched on.
const FINALS: usize = 4;
/// So many effects are tried with the pulses where none helps without.
const BESIDE: usize = 2;
/// A round must gain so much merit ...
const GAIN: f64 = 0.01;
/// ... and all together so much where they do not explain what is seen.
const PLAINLY: f64 = 0.2;
/// The best of the frequencies must leave no more than this share of the cost without pulses.
const PROMISES: f64 = 0.95;

/// `values` under pulses of `frequency`, Hz: how much of a period the current needs to rise stays as it was. What the winding no
/// longer is late by may be a delay.
fn at(values: &Values, frequency: f64) -> Values {
    let mut values = values.clone();
    let before = values.base.tau_e;
    for (_, p) in values.effects.iter_mut().filter(|(kind, _)| *kind == Kind::Coast) {
        values.base.tau_e *= p[1] / frequency;
        p[1] = frequency;
    }
    let late = before - values.base.tau_e;
    for (_, p) in values.effects.iter_mut().filter(|(kind, _)| *kind == Kind::Delay) {
        p[0] = (p[0] + late).max(0.0);
    }
    values
}

impl Evidence {
    /// Finds when the pulses of `model`'s bridge come, and fits it anew; none where that gains little: a mirror of the frequency
    /// takes a part of what pulses leave, too.
    pub fn time_pulses(&mut self, model: &Candidate) -> Option<Candidate> {
        self.gained(model, |gained, timed| gained > if timed.explains() { EQUAL } else { PLAINLY })
    }

    /// The same where the gain in merit is `enough`.
    fn gained(&mut self, model: &Candidate, enough: impl Fn(f64, &Candidate) -> bool) -> Option<Candidate> {
        // Two runs whose pulses come at other times differ by them: then they are in the floor.
        let shows = model.worst() > SHOWS || model.calm == Some(false);
        if !model.kinds().contains(&Kind::Coast) || !shows {
            return None;
        }
        let mut trial = self.clone();
        let timed = trial.timed(&model.values(), model)?;
        trial.lower_floor(&timed.values());
        let [timed, model] = [&timed, model].map(|c| c.over(&self.floor, &trial.floor));
        if !enough(model.merit() - timed.merit(), &timed) {
            return None;
        }
        *self = trial;
        Some(timed)
    }

    /// The same with a delay beside the bridge, where the winding's lag may stand for both.
    pub fn time_late_pulses(&mut self, model: &Candidate) -> Option<Candidate> {
        let kinds = model.kinds();
        if kinds != [Kind::Coast] {
            return None;
        }
        let late = self.fit(&model.values().with(Kind::Delay, vec![0.0]), 0);
        self.gained(&late, |gained, timed| gained > EQUAL && timed.explains())
    }

    fn timed(&mut self, values: &Values, model: &Candidate) -> Option<Candidate> {
        let mut frequency = self.likeliest(values, model)?;
        let mut values = at(values, frequency);
        let mut best: Option<Candidate> = None;
        for _ in 0..ROUNDS {
            self.set_pulses(&values, frequency);
            frequency = self.whole.pulse_hz?;
            values = at(&values, frequency);
            let timed = self.fit(&values, STEPS);
            values = timed.values();
            if best.as_ref().is_some_and(|best| timed.merit() > best.merit() - GAIN) {
                break;
            }
            best = Some(timed);
        }
        // The last fit was refused: its pulses are not those of the best.
        let best = best?.values();
        self.set_pulses(&best, frequency);
        Some(self.fit(&best, STEPS))
    }

    /// Lets the pulses of about `frequency`, Hz, come when the records show under `values`.
    fn set_pulses(&mut self, values: &Values, frequency: f64) {
        self.whole.time_pulses(values, frequency, true, CLOSELY);
        self.train.pulse_like(&self.whole);
        let Some(found) = self.whole.pulse_hz else { return };
        if let Some(kept_out) = &mut self.kept_out {
            kept_out.pulse_at(values, found);
        }
        self.unseen.pulse_like(self.kept_out.as_ref().unwrap_or(&self.whole));
    }

    /// The frequency under whose pulses `values` come nearest to the records that `model` fits worst.
    fn likeliest(&self, values: &Values, model: &Candidate) -> Option<f64> {
        let mut plain = self.whole.clone();
        plain.forget_pulses();
        let mut worst: Vec<usize> = self.first_runs().collect();
        worst.sort_by(|a, b| model.records[*b].total_cmp(&model.records[*a]));
        worst.truncate(FEW);
        let few = |problem: &Problem| problem.on(worst.iter().map(|k| problem.grids[*k].clone()).collect());
        let (mut free, mut guided) = (few(&plain), few(&self.train));
        let mut tried = |values: &Values, frequency: f64| {
            let values = at(values, frequency);
            free.time_pulses(&values, frequency, true, ROUGHLY);
            guided.pulse_like(&free);
            let layout = guided.layout(&values.kinds());
            let found = guided.search(&layout, Objective::Increments, &layout.pack(&values), ROUGH, 1e-3);
            free.pulse_hz.map(|hz| (found.cost, hz, layout.unpack(&found.x)))
        };
        let likely = plain.likely_pulses(values);
        let mut found: Vec<_> = likely.into_iter().filter_map(|hz| tried(values, hz)).collect();
        found.sort_by(|a, b| a.0.total_cmp(&b.0));
        // Mirrors of the frequency are told from it by how far each comes down.
        let finals = found.into_iter().take(FINALS).filter_map(|(_, hz, values)| tried(&values, hz));
        let best = finals.min_by(|a, b| a.0.total_cmp(&b.0));
        let own = few(&self.train);
        let layout = own.layout(&values.kinds());
        let own = own.costs(&layout, Objective::Increments, &[layout.pack(values)])[0];
        best.filter(|(cost, ..)| *cost < PROMISES * own).map(|best| best.1)
    }
}

/// What is worth adding to `model` once it is known when the pulses of its bridge come; of the best of `found` with one.
pub fn worthy(evidence: &mut Evidence, found: &[Candidate], model: &Candidate) -> Option<Candidate> {
    if evidence.whole.pulse_hz.is_some() {
        return None;
    }
    let mut best: Option<(Candidate, Evidence)> = None;
    for candidate in found.iter().filter(|c| c.kinds().contains(&Kind::Coast)).take(BESIDE) {
        let mut trial = evidence.clone();
        let Some(timed) = trial.gained(candidate, |gained, _| gained > EQUAL) else { continue };
        // The last effect stood for what the pulses leave, too: it is looked for anew, and judged, beside them.
        let last = candidate.kinds()[candidate.kinds().len() - 1];
        let without = trial.fit(&timed.values().without(last), TO_THE_END);
        let anew = stage::run(&trial, &without, &[last], Effort::LATER, &mut |_| ()).into_iter().next();
        let timed = prune(&trial, anew.filter(|anew| anew.merit() < timed.merit()).unwrap_or(timed));
        let least = best.as_ref().map_or(model.merit() - PLAINLY, |(best, _)| best.merit() - EQUAL);
        if timed.merit() < least && worth(&timed, &without) {
            best = Some((timed, trial));
        }
    }
    let (best, timed) = best?;
    *evidence = timed;
    Some(best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::{Discovery, Options, Verdict, discover};
    use crate::exam::case::{Case, Conditions};
    use motorlens_virtual_motor::Kind as Hidden;

    fn found(seed: u64, hidden: &[Hidden], library: Vec<Kind>) -> Discovery {
        let case = Case::new(seed, hidden, Conditions { disturbed: 0.25, spoilt: 0.15 });
        let options = Options { library, ..Options::default() };
        discover(&case.records, &case.held_out, &case.motor, &options, &mut |_| ()).unwrap()
    }

    /// Hidden: 476.536 Hz. The law of a mean leaves 4.5 x the floor under a PRBS.
    #[test]
    fn pulses_of_a_slow_pwm_are_found_and_explain_every_record() {
        let found = found(26_000_214, &[Hidden::Coast], vec![Kind::Coast, Kind::Delay, Kind::SupplySag]);
        let hz = found.evidence.whole.pulse_hz.expect("the records show them");
        assert!((hz - 476.536).abs() < 1e-3, "{hz} Hz");
        assert_eq!(found.effects, [Kind::Coast]);
        let (base, model) = (&found.climb.rungs[0], found.climb.model());
        assert!(model.worst() < SHOWS, "{:?}", model.records);
        assert!(model.drift() < 0.003 * base.drift(), "{} of {}", model.drift(), base.drift());
        let mut mean = found.evidence.clone();
        for problem in [&mut mean.whole, &mut mean.train, &mut mean.unseen] {
            problem.forget_pulses();
        }
        let mean = mean.fit(&model.values(), 10);
        assert!(mean.worst() > 3.0, "{:?}: the case no longer shows it", mean.records);
    }

    /// Hidden: 323.762 Hz.
    #[test]
    fn a_motor_whose_pulses_are_found_is_explained() {
        let found = found(34_000_414, &[Hidden::Coast], vec![Kind::Coast, Kind::Delay, Kind::SupplySag]);
        assert_eq!(found.effects, [Kind::Coast]);
        assert_eq!(found.verdict, Verdict::Explained);
        let hz = found.evidence.whole.pulse_hz.expect("the records show them");
        assert!((hz - 323.762).abs() < 1e-2, "{hz} Hz");
    }

    /// Without pulses the winding's lag stands for both, and no delay helps.
    #[test]
    fn a_delay_beside_a_slow_pwm_comes_with_its_pulses() {
        let found = found(
            31_200_005,
            &[Hidden::Delay, Hidden::Coast],
            vec![Kind::Coast, Kind::Delay, Kind::SupplySag],
        );
        assert_eq!(found.effects, [Kind::Coast, Kind::Delay]);
        assert_eq!(found.verdict, Verdict::Explained);
    }

    #[test]
    fn a_motor_without_such_a_bridge_has_no_pulses() {
        let found = found(31_200_005, &[Hidden::Delay], vec![Kind::Coast, Kind::Delay]);
        assert_eq!(found.evidence.whole.pulse_hz, None);
        assert!(!found.effects.contains(&Kind::Coast), "{:?}", found.effects);
    }

    /// Two runs of the multisine differ by their pulses more than by noise: teeth beside the bridge would be lost in that.
    #[test]
    fn pulses_by_which_two_runs_differ_are_taken_out_of_the_floor() {
        let hidden = [Hidden::Cogging, Hidden::Coast];
        let found = found(34_200_023, &hidden, vec![Kind::Coast, Kind::Cogging, Kind::Delay]);
        assert_eq!(found.effects, [Kind::Coast, Kind::Cogging]);
        let case = Case::new(34_200_023, &hidden, Conditions { disturbed: 0.25, spoilt: 0.15 });
        let (before, _) =
            crate::diagnose::discover::prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let [before, after] = [&before, &found.evidence].map(|evidence| evidence.floor.increments);
        assert!(after < 0.8 * before, "{before} -> {after}");
    }
}
