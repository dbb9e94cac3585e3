//! Whether a speed is that of the instant or the mean since the sample before.
//!
//! Both are half a sample apart, which a delay, a filter or the time constant make up for, so a motor without them decides wrongly
//! where there are such. Each reading is therefore given the usual friction, a load and what is late, and the likelihood of what it leaves decides
//! (white noise; the ratio of the likelihoods of the best fits).

use motorlens_shared::effects::{Kind, Rig};

use super::cost::Objective;
use super::grid::{Grid, Quantity};
use super::layout::{BaseValues, Prior, Values};
use super::search::Problem;
use super::setup::first_base;
use super::sketch::Sketch;

/// A reading is believed against what its column looks like where its likelihood is higher by so many natural logarithms.
const DECIDES: f64 = 5.0;
/// What a delay or a filter must gain, natural logarithms: a mean of the instants' speed is nearly half a sample's delay.
const LATE: f64 = 3.0;
/// What of the records is looked at.
const SKETCH: Sketch = Sketch { samples: 8e3, cell_s: 4.01e-3, interval_s: 0.0 };
/// Starts that are searched, and steps.
const SEARCHED: (usize, usize) = (2, 14);

/// The records read the other way, and a base for them, where that is what the motion says; none of records of an angle.
pub(super) fn read_otherwise(
    grids: &[Grid],
    base: BaseValues,
    rig: &Rig,
    prior: &Prior,
) -> Option<(Vec<Grid>, BaseValues)> {
    if grids.is_empty() || grids.iter().any(|g| g.quantity == Quantity::Angle) {
        return None;
    }
    let other = |quantity| match quantity {
        Quantity::Speed => Quantity::MeanSpeed,
        _ => Quantity::Speed,
    };
    let others: Vec<Grid> = grids.iter().map(|g| Grid { quantity: other(g.quantity), ..g.clone() }).collect();
    let base_so = first_base(&others, rig, prior);
    let gained = misfit(grids, base, rig, prior) - misfit(&others, base_so, rig, prior);
    (gained > DECIDES).then_some((others, base_so))
}

/// Laws on which others build that belong to the usual motor.
const BUILT_ON: usize = 2;

/// How many laws of the library build on `kind`: on the usual ones most.
pub fn built_on(kind: Kind) -> usize {
    Kind::ALL
        .iter()
        .filter(|other| other.spec().contains.iter().any(|(part, _)| *part == kind.name()))
        .count()
}

/// `laws`, that on which most others of the library build first: what a motor is rarely without.
pub fn usual_first(mut laws: Vec<Kind>) -> Vec<Kind> {
    laws.sort_by_key(|kind| std::cmp::Reverse(built_on(*kind)));
    laws
}

/// The negative log-likelihood of the best fit with the usual laws and any of what is only late, each of which costs [`LATE`].
fn misfit(grids: &[Grid], base: BaseValues, rig: &Rig, prior: &Prior) -> f64 {
    let rig = Rig { reference_speed: base.gain * rig.nominal_v, ..*rig };
    let mut problem = Problem::new(grids.to_vec(), rig, *prior).sketch(SKETCH);
    let plain = Values { base, effects: Vec::new() };
    problem.find_moving_starts(&plain);
    // A reading that is held tells nothing new.
    let renewed = |g: &Grid| 1 + g.measured.windows(2).filter(|pair| pair[0] != pair[1]).count();
    let count = problem.grids.iter().map(renewed).sum::<usize>() as f64;
    let mut usual = usual_first(Kind::ALL.to_vec());
    usual.truncate(BUILT_ON);
    let late: Vec<Kind> = Kind::ALL.iter().copied().filter(|kind| kind.spec().is_late()).collect();
    let sets = (0..1_usize << late.len()).map(|set| {
        let chosen = late.iter().enumerate().filter(|(k, _)| set >> k & 1 == 1).map(|(_, kind)| *kind);
        chosen.collect::<Vec<Kind>>()
    });
    let of = |set: Vec<Kind>| {
        let kinds: Vec<Kind> = usual.iter().chain(&set).copied().collect();
        0.5 * count * left(&problem, &plain, &kinds).ln() + LATE * set.len() as f64
    };
    sets.map(of).fold(f64::MAX, f64::min)
}

/// The squared error that the best fit of `plain` with `kinds` leaves.
fn left(problem: &Problem, plain: &Values, kinds: &[Kind]) -> f64 {
    // Every size of one beside the smallest of the others.
    let sizes: Vec<Vec<Vec<f64>>> = kinds
        .iter()
        .map(|kind| kind.spec().probes_on(&problem.rig).map(Iterator::collect).collect())
        .collect();
    let with = |own: usize, size: usize| {
        kinds.iter().enumerate().fold(plain.clone(), |values, (k, kind)| {
            values.with(*kind, sizes[k][if k == own { size } else { 0 }].clone())
        })
    };
    let layout = problem.layout(kinds);
    let xs: Vec<Vec<f64>> = (0..kinds.len())
        .flat_map(|own| (0..sizes[own].len()).map(move |size| (own, size)))
        .map(|(own, size)| layout.pack(&with(own, size)))
        .collect();
    let starts = problem.costed(&layout, Objective::Position, xs);
    let searched = starts.iter().take(SEARCHED.0);
    let best = searched.map(|(_, x)| problem.race(&layout, Objective::Position, x, SEARCHED.1, 1e-5).0);
    best.fold(f64::MAX, f64::min)
}

#[cfg(test)]
mod tests {
    use crate::fit::grid::Quantity;
    use crate::fit::setup::problem;
    use crate::log::Record;
    use crate::motor_file::MotorFile;

    /// Speeds every 20 ms of a motor with friction behind a filter of `filter_s` (0: none), each of an instant or the `mean` since the
    /// one before.
    fn record(filter_s: f64, mean: bool) -> Record {
        const STEP_S: f64 = 1e-4;
        let (mut w, mut drive, mut filtered, mut sum, mut state) = (0.0_f64, 0.0_f64, 0.0, 0.0, 7_u32);
        let (mut volts, mut speeds) = (Vec::new(), Vec::new());
        for k in 0..600 {
            // Steps of uneven length.
            let v = 6.0 * (f64::from(k / 23) * 2.1).sin() + 2.0 * (f64::from(k / 11) * 1.3).cos();
            let read = if mean { sum / 200.0 } else { filtered };
            let noise: f64 = (0..4)
                .map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    f64::from(state >> 8) / f64::from(1 << 24) - 0.5
                })
                .sum();
            volts.push(v);
            speeds.push(read + 0.07 * noise);
            sum = 0.0;
            for _ in 0..200 {
                drive += STEP_S / 8e-4 * (v - drive);
                let held = w == 0.0 && drive.abs() < 0.3;
                let next = if held {
                    0.0
                } else {
                    w + STEP_S / 0.045
                        * (1.2 * (drive - 0.3 * (if w == 0.0 { drive } else { w }).signum()) - w)
                };
                w = if w * next < 0.0 { 0.0 } else { next };
                filtered = if filter_s > 0.0 { filtered + STEP_S / filter_s * (w - filtered) } else { w };
                sum += filtered;
            }
        }
        Record {
            name: "steps".into(),
            time_s: (0..600).map(|k| 0.02 * f64::from(k)).collect(),
            voltage_v: volts,
            speed_rad_s: Some(speeds),
            ..Record::default()
        }
    }

    #[test]
    fn a_filtered_speed_of_the_instant_is_no_mean_and_a_filtered_mean_is_none_of_the_instant() {
        for filter_s in [0.0, 0.02, 0.04] {
            for (mean, right) in [(false, Quantity::Speed), (true, Quantity::MeanSpeed)] {
                // A mean without a filter is a delay of half a sample all but exactly.
                if mean && filter_s == 0.0 {
                    continue;
                }
                let (problem, _) = problem(&[record(filter_s, mean)], &MotorFile::default());
                assert_eq!(problem.grids[0].quantity, right, "filter of {filter_s} s, mean: {mean}");
            }
        }
    }
}
