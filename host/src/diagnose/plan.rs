//! The next experiment: which programme would tell the rivals apart.
//!
//! Every programme that the firmware can play is run through every rival model. What counts is the difference
//! that is left between two rivals after the first one's parameters are partialled out, to first
//! order: a programme is as good as the pair that it separates least.

use motorlens_shared::effects::Kind;
use motorlens_shared::excitation::{Player, Programme, Segment, Shape};
use nalgebra::{DMatrix, DVector};

use super::contained::extended;
use super::discover::reading_noise;
use super::evidence::Evidence;
use crate::findings::multiple;
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Layout;
use crate::fit::search::Problem;
use crate::fit::simulate::{LANES, predict_block};
use crate::log::Record;
use crate::select::fitted::Fitted;

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
/// Rate at which programmes are tried, Hz.
const RATE_HZ: u32 = 500;
/// A longer programme would show nothing new, s.
const LONGEST_S: f64 = 24.0;
/// Differences over 50 ms, every 4 ms.
const SPAN: usize = 25;
const STRIDE: usize = 2;

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

/// Those of `kinds` that contain no other of them: of nested equations that fit alike the simpler suffices.
pub fn simplest(kinds: &[Kind]) -> Vec<Kind> {
    let rich = |k: &Kind| kinds.iter().any(|other| nested(*k, *other).is_some_and(|(_, rich)| rich == *k));
    kinds.iter().copied().filter(|k| !rich(k)).collect()
}

/// The simpler and the richer of two equations of which one contains the other.
fn nested(a: Kind, b: Kind) -> Option<(Kind, Kind)> {
    let within = |(simple, rich): &(Kind, Kind)| simple != rich && rich.spec().holds(simple.name());
    [(a, b), (b, a)].into_iter().find(within)
}

/// Programmes within the limits.
fn menu(limits: Limits) -> Vec<Programme> {
    let volts = limits.volts as f32;
    let seconds = limits.seconds.min(LONGEST_S) as f32;
    let share = |part: f32| part * volts;
    let triangle =
        |part: f32| Shape::Triangle { amplitude_v: share(part), period_s: (seconds / 2.0).min(4.0) };
    let slow = [triangle(0.1), triangle(0.2)].map(|shape| Segment { shape, seconds: seconds / 2.0 });
    let mut menu: Vec<Programme> = Programme::sequence("slow-triangles", slow).into_iter().collect();
    let multisine = |part: f32| Shape::Multisine {
        amplitude_v: share(part),
        low_hz: 0.2,
        high_hz: 8.0,
        tones: 14,
        seed: 7,
    };
    let single = [
        ("pulse-and-coast", Shape::PulseAndCoast { amplitude_v: share(0.9) }),
        ("multisine", multisine(0.7)),
        ("small-multisine", multisine(0.25)),
        ("prbs", Shape::Prbs { amplitude_v: share(0.8), chip_s: 0.06, seed: 7 }),
        ("staircase", Shape::Staircase { amplitude_v: share(0.9), hold_s: 0.6, seed: 7 }),
        ("one-way-sine", Shape::Sine { amplitude_v: share(0.3), frequency_hz: 1.0, offset_v: share(0.5) }),
        ("sine", Shape::Sine { amplitude_v: share(0.6), frequency_hz: 0.5, offset_v: 0.0 }),
    ];
    menu.extend(single.map(|(name, shape)| Programme::single(name, shape, seconds)));
    menu.retain(|p| p.validate(volts).is_ok());
    menu
}

/// The programme laid on the model's grid, from rest; nothing is measured yet.
fn played(programme: &Programme, problem: &Problem) -> Option<Grid> {
    let voltage_v: Vec<f64> = Player::new(programme, RATE_HZ).ok()?.map(f64::from).collect();
    let n = voltage_v.len();
    let record = Record {
        name: programme.name.as_str().into(),
        time_s: (0..n).map(|k| k as f64 / f64::from(RATE_HZ)).collect(),
        angle_rad: Some(vec![0.0; n]),
        voltage_v,
        ..Record::default()
    };
    Some(Grid::new(&record, problem.rig.count_rad))
}

/// What each of `points` expects to see on `grid`, as differences over 50 ms in the unit that `problem` has measured: of the angle, or the mean
/// speed in that time.
fn increments(problem: &Problem, layout: &Layout, points: &[Vec<f64>], grid: &Grid) -> Vec<DVector<f64>> {
    let speed = problem.grids.iter().any(|grid| grid.quantity != Quantity::Angle);
    let unit = if speed { f64::from(RATE_HZ) / SPAN as f64 } else { 1.0 };
    let mut seen: Vec<DVector<f64>> = Vec::new();
    let mut series = Vec::new();
    for chunk in points.chunks(LANES) {
        predict_block(layout, chunk, &problem.rig, grid, &mut series);
        for l in 0..chunk.len() {
            let n = series.len().saturating_sub(SPAN) / STRIDE;
            let step = |k: usize| unit * (series[k * STRIDE + SPAN].0[l] - series[k * STRIDE].0[l]);
            seen.push(DVector::from_fn(n, |k, _| step(k)));
        }
    }
    seen
}

/// What one rival expects to see, and how its parameters could bend that.
struct View {
    centre: DVector<f64>,
    tangent: DMatrix<f64>,
}

impl View {
    fn new(problem: &Problem, layout: &Layout, x: &[f64], grid: &Grid) -> Self {
        let mut points = vec![x.to_vec()];
        let mut deltas = Vec::new();
        for k in 0..layout.len() {
            let d = layout.step(k, x[k]);
            let mut moved = x.to_vec();
            moved[k] += d;
            points.push(moved);
            deltas.push(d);
        }
        let mut seen = increments(problem, layout, &points, grid);
        let centre = seen.remove(0);
        let columns: Vec<DVector<f64>> = seen.iter().zip(&deltas).map(|(p, d)| (p - &centre) / *d).collect();
        Self { tangent: DMatrix::from_columns(&columns), centre }
    }

    /// rms of what this rival could not imitate of `other`.
    fn left_of(&self, other: &DVector<f64>) -> f64 {
        left(&self.tangent, other - &self.centre)
    }

    /// rms of what the most visible parameter of this rival `c` that `simple` lacks would show at its usual size, and
    /// no other parameter could imitate.
    fn added(&self, c: &Fitted, simple: Kind) -> f64 {
        let common = simple.spec().parameters;
        let own = c.kinds().last().map_or(&[][..], |kind| kind.spec().parameters);
        let first = c.layout.len() - own.len();
        let news = (0..own.len()).filter(|k| !common.iter().any(|p| p.name == own[*k].name));
        news.map(|k| {
            let others = self.tangent.clone().remove_column(first + k);
            left(&others, self.tangent.column(first + k).into_owned())
        })
        .fold(0.0, f64::max)
    }
}

/// rms of what is left of `difference` beside the columns of `tangent`.
fn left(tangent: &DMatrix<f64>, difference: DVector<f64>) -> f64 {
    let mut h = tangent.tr_mul(tangent);
    for k in 0..h.nrows() {
        h[(k, k)] += 1e-9 * h[(k, k)] + 1e-15;
    }
    let g = tangent.tr_mul(&difference);
    let bend = h.cholesky().map_or_else(|| DVector::zeros(g.len()), |f| f.solve(&g));
    let left = difference - tangent * bend;
    (left.norm_squared() / left.len().max(1) as f64).sqrt()
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
    fn records_of_speed_are_compared_with_speeds_and_records_of_angle_with_angles() {
        let case = Case::new(11, &[], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let slow = Shape::Sine { amplitude_v: 6.0, frequency_hz: 0.1, offset_v: 0.0 };
        let programme = Programme::single("slow", slow, 10.0);
        let highest = |problem: &Problem| {
            let grid = played(&programme, problem).unwrap();
            let seen = increments(problem, &base.layout, std::slice::from_ref(&base.x), &grid);
            seen[0].max()
        };
        let steady = 6.0 * base.values().base.gain;
        let angle = evidence.train.clone();
        let mut speed = angle.clone();
        let means = |mut grid: Grid| {
            grid.quantity = Quantity::Speed;
            grid.read_as(Quantity::MeanSpeed)
        };
        speed.grids = speed.grids.into_iter().map(means).collect();
        assert!((highest(&angle) / (0.05 * steady) - 1.0).abs() < 0.02, "{} rad", highest(&angle));
        assert!((highest(&speed) / steady - 1.0).abs() < 0.02, "{} rad/s", highest(&speed));
    }

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
    fn laws_that_contain_another_one_are_no_rivals_of_it() {
        let all = [Kind::Stribeck, Kind::Coulomb, Kind::DeadZone, Kind::CoulombAsymmetric];
        assert_eq!(simplest(&all), [Kind::Coulomb, Kind::DeadZone]);
        assert_eq!(simplest(&[Kind::Stribeck, Kind::CoulombAsymmetric]).len(), 2);
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
