//! The next experiment: which programme would tell the rivals apart.
//!
//! Every programme that the firmware can play is run through every rival model. What counts is the difference
//! that is left between two rivals after the first one's parameters are partialled out, to first
//! order: a programme is as good as the pair that it separates least.

mod menu;
mod nested;
mod view;

use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::Programme;

use super::contained::extended;
use super::discover::reading_noise;
use super::evidence::Evidence;
use crate::findings::multiple;
use crate::fit::layout::Layout;
use crate::fit::search::Problem;
use crate::select::fitted::Fitted;
use menu::{menu, played};
use nested::nested;
pub use nested::simplest;
use view::{View, increments};

/// What the rig allows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Limits {
    /// Highest voltage, V.
    pub volts: f64,
    /// Longest programme, s.
    pub seconds: f64,
}

impl Limits {
    /// Where nobody says otherwise: the voltage that the records of `evidence` reached, and a few seconds.
    pub fn of(evidence: &Evidence) -> Self {
        Self { volts: evidence.highest_voltage(), seconds: SECONDS }
    }
}

/// Length of a programme where nobody says otherwise, s.
pub const SECONDS: f64 = 8.0;

/// A programme, and what it is expected to show.
#[derive(Debug, Clone)]
pub struct Plan {
    /// What to play.
    pub programme: Programme,
    /// Effects that it separates.
    pub rivals: Vec<Kind>,
    /// rms difference that is left between the two most alike of them, in multiples of the noise of a reading.
    pub separation: f64,
    /// The two most alike.
    pub closest: (Kind, Kind),
}

/// A difference below so many times the noise of a reading is not to be seen.
const LEAST_SHOWN: f64 = 0.1;

/// The programme that best separates `rivals`; none with fewer than two of them.
///
/// An equation and a simpler one that it contains are alike wherever it gains nothing, so no programme separates their fits:
/// among others the richer equation does not count. Where nothing else is left, the programme counts that shows most of
/// what the richer equations would add at their usual size.
pub fn choose(problem: &Problem, rivals: &[&Fitted], limits: Limits) -> Option<Plan> {
    if rivals.len() < 2 {
        return None;
    }
    let kind = |c: &Fitted| c.kinds().last().copied();
    let kinds: Vec<Kind> = rivals.iter().filter_map(|c| kind(c)).collect();
    let simple = simplest(&kinds);
    // Two richer equations of one simpler equation both come down to it.
    let all_nested = simple.len() < 2;
    let judged: Vec<Fitted> = if all_nested {
        rivals.iter().map(|c| in_usual_shape(c)).collect()
    } else {
        rivals.iter().filter(|c| kind(c).is_some_and(|k| simple.contains(&k))).map(|c| (*c).clone()).collect()
    };
    let kinds: Vec<Kind> = judged.iter().filter_map(kind).collect();
    let noise = reading_noise(problem);
    let plans = menu(limits).into_iter().filter_map(|programme| {
        let grid = played(&programme, problem)?;
        let seen: Vec<View> = judged.iter().map(|c| View::new(problem, &c.layout, &c.x, &grid)).collect();
        let mut least = (f64::MAX, (kinds[0], kinds[1]));
        for (a, view) in seen.iter().enumerate() {
            for (b, other) in seen.iter().enumerate().filter(|(b, _)| *b != a) {
                let left = match nested(kinds[a], kinds[b]) {
                    None if all_nested => continue,
                    None => view.left_of(&other.centre),
                    Some((simple, rich)) if rich == kinds[a] => view.added(&judged[a], simple),
                    Some(_) => continue,
                };
                if left < least.0 {
                    least = (left, (kinds[a], kinds[b]));
                }
            }
        }
        let separation = least.0 / noise;
        Some(Plan { programme, rivals: kinds.clone(), separation, closest: least.1 })
    });
    plans.max_by(|a, b| a.separation.total_cmp(&b.separation))
}

/// For each of `missing`, the programme that would show most of it, at its typical size, beside `model`; none where that is nothing beside
/// the `noise` of a reading.
pub fn showing(
    problem: &Problem,
    model: &Fitted,
    missing: &[Kind],
    noise: f64,
    limits: Limits,
) -> Vec<Option<Programme>> {
    let values = model.values();
    let with = |kind: &Kind| {
        let extended = extended(&values, *kind, kind.spec().typical(&problem.rig).collect());
        let layout = problem.layout(&extended.kinds());
        let x = layout.pack(&extended);
        (layout, x)
    };
    let extended: Vec<(Layout, Vec<f64>)> = missing.iter().map(with).collect();
    let mut best: Vec<Option<(f64, Programme)>> = vec![None; missing.len()];
    for programme in if missing.is_empty() { Vec::new() } else { menu(limits) } {
        let Some(grid) = played(&programme, problem) else { continue };
        let view = View::new(problem, &model.layout, &model.x, &grid);
        for (best, (layout, x)) in best.iter_mut().zip(&extended) {
            let left = view.left_of(&increments(problem, layout, std::slice::from_ref(x), &grid)[0]);
            if best.as_ref().is_none_or(|(most, _)| left > *most) {
                *best = Some((left, programme.clone()));
            }
        }
    }
    let shown = |best: Option<(f64, Programme)>| best.filter(|(left, _)| *left >= LEAST_SHOWN * noise);
    best.into_iter().map(|best| shown(best).map(|(_, programme)| programme)).collect()
}

/// `c` with the usual shape of what its last equation has beside the simpler ones: where its size came out as nothing, the shape
/// is anything.
fn in_usual_shape(c: &Fitted) -> Fitted {
    let mut usual = c.clone();
    let Some(spec) = c.kinds().last().map(|kind| kind.spec()) else { return usual };
    let first = c.layout.len() - spec.parameters.len();
    for (k, p) in spec.parameters.iter().enumerate() {
        if !p.strength && !spec.contains.iter().any(|(_, own)| *own == p.name) {
            usual.x[first + k] = 1.0;
        }
    }
    usual
}

impl Plan {
    /// Whether it would show anything: the best of all programmes may not.
    pub fn shows(&self) -> bool {
        self.separation >= LEAST_SHOWN
    }

    /// Why none of the programmes would show anything, where that is so.
    pub fn why_none(&self) -> Option<String> {
        (!self.shows()).then(|| self.why())
    }

    /// What it would show, or that none of the programmes would show anything, in a sentence.
    pub fn why(&self) -> String {
        let names: Vec<&str> = self.rivals.iter().map(|k| k.name()).collect();
        let (a, b) = self.closest;
        let name = &self.programme.name;
        match (nested(a, b), self.shows()) {
            (Some((simple, rich)), true) => format!(
                "{simple} suffices: {rich} contains it and gains nothing here; if there is a difference, {name} would show it \
                 best, by {} at its usual size",
                multiple(self.separation)
            ),
            (Some((simple, rich)), false) => format!(
                "{simple} suffices: {rich} contains it and gains nothing here; of the programmes known none would show a \
                 difference, the best of them, {name}, less than {}",
                multiple(LEAST_SHOWN)
            ),
            (None, true) => format!(
                "{name} plays what {} answer differently: even {a} and {b}, the most alike, would differ by {}{}",
                names.join(", "),
                multiple(self.separation),
                if self.separation < 1.0 {
                    ", which shows only where it is played several times"
                } else {
                    ""
                }
            ),
            (None, false) => format!(
                "of the programmes known none would tell {a} and {b} apart: in the best of them, {name}, they differ by less \
                 than {}",
                multiple(LEAST_SHOWN)
            ),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use crate::findings::NextExperiment;
    use crate::select::forward::forward;

    #[test]
    fn a_programme_that_stays_within_its_limits_separates_friction_from_a_dead_zone() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(11, &[motorlens_virtual_motor::Kind::Coulomb], ideal);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let library = [Kind::Coulomb, Kind::DeadZone];
        let found = forward(&evidence, &base, &library, 0.0, &mut |_| ());
        let rivals: Vec<&Fitted> = found.iter().collect();
        let limits = Limits { volts: 6.0, seconds: 5.0 };
        let plan = choose(&evidence.train, &rivals, limits).unwrap();
        assert!(plan.programme.peak_v() <= 6.0 && plan.programme.seconds() <= 5.01);
        assert!(plan.separation > 1.0, "{}", plan.why());
        assert!(choose(&evidence.train, &rivals[..1], limits).is_none());
    }

    #[test]
    fn of_a_law_and_one_that_contains_it_the_simpler_is_said_to_suffice() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(11, &[motorlens_virtual_motor::Kind::Coulomb], ideal);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let limits = Limits { volts: 6.0, seconds: 5.0 };
        let why = |library: &[Kind]| {
            let found = forward(&evidence, &base, library, 0.0, &mut |_| ());
            choose(&evidence.train, &found.iter().collect::<Vec<_>>(), limits).unwrap().why()
        };
        assert!(why(&[Kind::Stribeck, Kind::Coulomb]).starts_with("coulomb suffices: stribeck contains it"));
        let three = why(&[Kind::Stribeck, Kind::Coulomb, Kind::DeadZone]);
        assert!(three.contains("dead_zone") && !three.contains("suffices"), "{three}");
    }

    #[test]
    fn an_experiment_that_would_show_nothing_is_not_suggested() {
        let programme = menu(Limits { volts: 6.0, seconds: 5.0 }).remove(0);
        let plan = |closest, separation| Plan {
            programme: programme.clone(),
            rivals: vec![closest, Kind::DeadZone],
            separation,
            closest: (Kind::Coulomb, closest),
        };
        for (closest, separation, says) in [
            (Kind::DeadZone, 0.3, "would differ by 0.3 x the noise"),
            (Kind::DeadZone, 0.03, "none would tell coulomb and dead_zone apart"),
            (Kind::Stribeck, 0.3, "by 0.3 x the noise at its usual size"),
            (Kind::Stribeck, 0.03, "none would show a difference"),
        ] {
            let plan = plan(closest, separation);
            assert!(plan.why().contains(says), "{}", plan.why());
            assert_eq!(NextExperiment::of(Some(plan), &[]).is_some(), separation > 0.1, "{says}");
        }
    }

    #[test]
    fn where_only_nested_laws_are_left_the_programme_shows_what_the_richer_one_adds() {
        let ideal = Conditions { disturbed: 0.0, spoilt: 0.0 };
        let case = Case::new(11, &[motorlens_virtual_motor::Kind::Coulomb], ideal);
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let library = [Kind::Stribeck, Kind::Coulomb];
        let found = forward(&evidence, &base, &library, 0.0, &mut |_| ());
        let limits = Limits { volts: 6.0, seconds: 5.0 };
        let plan = choose(&evidence.train, &found.iter().collect::<Vec<_>>(), limits).unwrap();
        assert!(plan.separation > 0.3, "{}", plan.why());
    }
}
