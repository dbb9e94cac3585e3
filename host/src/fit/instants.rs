//! Whether a speed is that of the instant, the mean since the sample before, or the mean over a window of its own.
//!
//! They are half a sample and half a window apart, which a delay, a filter or the time constant make up for, so a motor without them decides
//! wrongly where there are such. Each reading is therefore given the usual friction, a load and what is late, and the likelihood of what it
//! leaves decides. What the model lacks and what disturbs the motor go on from reading to reading; how a reading is made shows in what is
//! new in each. So the errors are those of a first-order autoregression (Cochrane and Orcutt, J. Am. Stat. Assoc. 44, 1949): were they taken for white, a
//! load that is missing would have chosen the window.

use motorlens_shared::effects::{Kind, Rig};

use super::cost::Objective;
use super::grid::{Grid, Quantity};
use super::layout::{BaseValues, Layout, Prior, Values};
use super::search::Problem;
use super::setup::first_base;
use super::simulate::predict_one;
use super::sketch::Sketch;

/// A reading is believed against what its column looks like where its likelihood is higher by so many natural logarithms.
const DECIDES: f64 = 5.0;
/// Windows that are tried, samples, shortest first, and what all are shorter than, s (a motor controller's usual is 0.1 s) ...
const WINDOWS: [f64; 16] =
    [2.0, 3.0, 4.0, 5.0, 6.0, 8.0, 10.0, 14.0, 20.0, 28.0, 40.0, 56.0, 80.0, 100.0, 140.0, 200.0];
const LONGEST_WINDOW_S: f64 = 0.25;
/// ... and how many in a row may be no better than a shorter one.
const ENOUGH_WORSE: usize = 3;
/// What of the records is looked at.
const SKETCH: Sketch = Sketch { samples: 8e3, cell_s: 4.01e-3, interval_s: 0.0 };
/// Starts that are searched, and steps.
const SEARCHED: (usize, usize) = (2, 14);

impl Problem {
    /// What its speeds are, where a model of `values` says that they are not what they are taken for; none of a plain motor, of which that was
    /// asked when the records were laid out.
    pub fn read_otherwise(&self, values: &Values) -> Option<Quantity> {
        if values.effects.is_empty() {
            return None;
        }
        best_reading(&self.grids, |grids| misfit(grids, values, &self.rig, &self.prior))
    }
}

/// What the speeds of `grids` are, where a plain motor says that they are not what they are taken for. Each reading has a base of its own, that
/// at hand `base`.
pub(super) fn plainly_otherwise(
    grids: &[Grid],
    base: BaseValues,
    rig: &Rig,
    prior: &Prior,
) -> Option<Quantity> {
    let own = grids.first()?.quantity;
    best_reading(grids, |grids| {
        let base = if grids[0].quantity == own { base } else { first_base(grids, rig, prior) };
        misfit(grids, &Values { base, effects: Vec::new() }, rig, prior)
    })
}

/// The reading of the speeds of `grids` of which `misfit` is clearly less than of that at hand; none where angles are among them.
fn best_reading(grids: &[Grid], misfit: impl Fn(&[Grid]) -> f64) -> Option<Quantity> {
    let now = grids.first()?.quantity;
    if grids.iter().any(|g| g.quantity == Quantity::Angle) {
        return None;
    }
    let misfit_as = |reading| {
        let grids: Vec<Grid> = grids.iter().map(|g| g.clone().read_as(reading)).collect();
        misfit(&grids)
    };
    let own = misfit_as(now);
    let mut best = (own, now);
    let mut is_better = |reading: Quantity| {
        let misfit = if reading == now { own } else { misfit_as(reading) };
        let better = misfit < best.0;
        if better {
            best = (misfit, reading);
        }
        better
    };
    is_better(Quantity::Speed);
    is_better(Quantity::MeanSpeed);
    let lengths = WINDOWS.iter().map(|samples| samples * grids[0].interval_s);
    let mut worse = 0;
    for length in lengths.take_while(|length| *length < LONGEST_WINDOW_S) {
        worse = if is_better(Quantity::WindowSpeed(length)) { 0 } else { worse + 1 };
        if worse == ENOUGH_WORSE {
            break;
        }
    }
    // One that is better the longer it is makes up for something else.
    (best.0 + DECIDES < own && worse > 0).then_some(best.1)
}

/// Equations on which others build that belong to the usual motor.
const BUILT_ON: usize = 2;

/// How many equations of the library build on `kind`: on the usual ones most.
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

/// The one of `kinds` on which most others build.
pub fn usual(kinds: impl Iterator<Item = Kind>) -> Option<Kind> {
    usual_first(kinds.collect()).first().copied()
}

/// The negative log-likelihood of a fit whose errors are those of a first-order autoregression.
fn misfit_of(problem: &Problem, layout: &Layout, x: &[f64]) -> f64 {
    let plain = layout.all_plain(x);
    let (mut count, mut squares, mut products) = (0.0, 0.0, 0.0);
    for grid in &problem.grids {
        let run = predict_one(&layout.kinds, &plain, &problem.rig, grid);
        let errors: Vec<f64> = grid.measured.iter().zip(run).map(|(y, p)| y - p).collect();
        // A reading that is held tells nothing new.
        count += 1.0 + grid.measured.windows(2).filter(|pair| pair[0] != pair[1]).count() as f64;
        squares += errors.iter().map(|e| e * e).sum::<f64>();
        products += errors.windows(2).map(|pair| pair[0] * pair[1]).sum::<f64>();
    }
    // Each error is foreseen from the one before it.
    let new = squares - products * products / squares.max(f64::MIN_POSITIVE);
    0.5 * count * new.max(f64::MIN_POSITIVE).ln()
}

/// The negative log-likelihood of the best fit with the effects of `values`, the usual equations and all that is only late.
fn misfit(grids: &[Grid], values: &Values, rig: &Rig, prior: &Prior) -> f64 {
    let rig = Rig { reference_speed: values.base.gain * rig.nominal_v, ..*rig };
    let mut problem = Problem::new(grids.to_vec(), rig, *prior).sketch(SKETCH);
    let late: Vec<Kind> = Kind::ALL.iter().copied().filter(|kind| kind.spec().is_late()).collect();
    let plain = late.iter().fold(values.clone(), |values, kind| values.without(*kind));
    problem.find_moving_starts(&plain);
    let mut usual = usual_first(Kind::ALL.to_vec());
    usual.truncate(BUILT_ON);
    usual.retain(|kind| !plain.kinds().iter().any(|own| own.spec().holds(kind.name())));
    let kinds: Vec<Kind> = usual.into_iter().chain(late).collect();
    left(&problem, &plain, &kinds)
}

/// That of the best fit of `plain` with `kinds`.
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
    let layout = problem.layout(&with(0, 0).kinds());
    let xs: Vec<Vec<f64>> = (0..kinds.len())
        .flat_map(|own| (0..sizes[own].len()).map(move |size| (own, size)))
        .map(|(own, size)| layout.pack(&with(own, size)))
        .collect();
    let starts = problem.costed(&layout, Objective::Position, xs);
    let searched = starts.iter().take(SEARCHED.0);
    let end = |(_, x): &(f64, Vec<f64>)| {
        let (_, x) = problem.race(&layout, Objective::Position, x, SEARCHED.1, 1e-5);
        misfit_of(problem, &layout, &x)
    };
    searched.map(end).fold(f64::MAX, f64::min)
}

#[cfg(test)]
mod tests {
    use crate::fit::grid::Quantity::{self, MeanSpeed, Speed, WindowSpeed};
    use crate::fit::setup::problem;
    use crate::log::Record;
    use crate::motor_file::MotorFile;

    /// Speeds every 20 ms of a motor with friction behind a filter of `filter_s` (0: none), each the mean over so many samples, or that of an
    /// instant (0). A torque that holds from sample to sample comes to `disturbance`, V.
    fn record(filter_s: f64, samples: usize, disturbance: f64) -> Record {
        const STEP_S: f64 = 1e-4;
        let (mut w, mut drive, mut filtered, mut state) = (0.0_f64, 0.0_f64, 0.0, 7_u32);
        let (mut means, mut torque) = (vec![0.0; samples], 0.0);
        let (mut volts, mut speeds) = (Vec::new(), Vec::new());
        for k in 0..600 {
            // Steps of uneven length.
            let v = 6.0 * (f64::from(k / 23) * 2.1).sin() + 2.0 * (f64::from(k / 11) * 1.3).cos();
            let lately = means.iter().rev().take(samples).sum::<f64>();
            let read = if samples > 0 { lately / samples as f64 } else { filtered };
            let mut noise = || -> f64 {
                let even = (0..4).map(|_| {
                    state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
                    f64::from(state >> 8) / f64::from(1 << 24) - 0.5
                });
                even.sum()
            };
            torque = 0.9 * torque + 0.75 * disturbance * noise();
            volts.push(v);
            speeds.push(read + 0.07 * noise());
            let mut sum = 0.0;
            for _ in 0..200 {
                drive += STEP_S / 8e-4 * (v - drive);
                let held = w == 0.0 && drive.abs() < 0.3;
                let next = if held {
                    0.0
                } else {
                    w + STEP_S / 0.045
                        * (1.2 * (drive + torque - 0.3 * (if w == 0.0 { drive } else { w }).signum()) - w)
                };
                w = if w * next < 0.0 { 0.0 } else { next };
                filtered = if filter_s > 0.0 { filtered + STEP_S / filter_s * (w - filtered) } else { w };
                sum += filtered;
            }
            means.push(sum / 200.0);
        }
        Record {
            name: "steps".into(),
            time_s: (0..600).map(|k| 0.02 * f64::from(k)).collect(),
            voltage_v: volts,
            speed_rad_s: Some(speeds),
            ..Record::default()
        }
    }

    fn found(record: Record) -> Option<Quantity> {
        problem(&[record], &MotorFile::default()).0.speeds()
    }

    #[test]
    fn a_filtered_speed_of_the_instant_is_no_mean_and_a_filtered_mean_is_none_of_the_instant() {
        for filter_s in [0.0, 0.02, 0.04] {
            for (samples, right) in [(0, Speed), (1, MeanSpeed)] {
                // A mean without a filter is a delay of half a sample all but exactly.
                if samples == 1 && filter_s == 0.0 {
                    continue;
                }
                let told = format!("filter of {filter_s} s, mean over {samples}");
                assert_eq!(found(record(filter_s, samples, 0.0)), Some(right), "{told}");
            }
        }
    }

    /// What a disturbance does goes on from reading to reading: taken for white errors it would have chosen other windows.
    #[test]
    fn the_window_of_a_speed_is_found_behind_a_filter_and_under_a_disturbance() {
        for filter_s in [0.0, 0.02] {
            for (samples, disturbance) in [(2, 0.0), (5, 0.0), (2, 0.1), (5, 0.1)] {
                let reading = found(record(filter_s, samples, disturbance));
                let Some(WindowSpeed(length)) = reading else { panic!("{samples} samples: {reading:?}") };
                let told = format!("filter of {filter_s} s, disturbance of {disturbance} V");
                assert!((length / (0.02 * samples as f64) - 1.0).abs() < 1e-6, "{told}: {length} s");
            }
        }
    }
}
