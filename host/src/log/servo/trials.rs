//! Which controller drives a servo, tried out: the one whose voltage the motion explains best.
//!
//! A controller gives the voltage of every row, the motor's equation in its weak form ([`crate::log::weak`]) what of that the motion does not
//! explain: beside friction alone, or under a weight too, which an arm lifts. Where the target stands between two rows and how late it
//! arrives is not logged either, and is found alike. What the motion tells of a controller is judged by the simulated loop
//! ([`super::simulated`]): the trial that leaves least may still leave nearly all.

use super::Controller;
use super::busiest::{Stretch, busiest};
use super::driven::{Loop, Seen, volts};
use super::simulated::{self, Followed};
use super::told::Told;
use crate::cores;
use crate::log::Record;
use crate::log::motion::peak;
use crate::log::weak::{Regression, Weak};
use crate::search::golden::lowest;

/// Gains that are tried, duty per rad: full duty at 1.5 rad to full duty at 0.01 rad.
const GAINS: (f64, f64, usize) = (0.7, 100.0, 40);
/// Damping that is tried, seconds of the gain.
const DAMPING_S: [f64; 5] = [0.0, 0.01, 0.02, 0.04, 0.08];
/// A gain is told where so many of the samples would be at full duty ...
const SATURATED: f64 = 0.02;
/// ... and a tenth of the gain leaves this much more.
const WORSE: f64 = 1.1;
/// The controller is told where the simulated loop leaves less than this share of the angle's variation; one that leaves more than the
/// second share is no better than any other.
const FOLLOWED: f64 = 0.1;
const HARDLY: f64 = 0.5;
/// A relay is tried where the loop leaves more than this share, and takes its place where it leaves less than this share of that.
const CLOSE: f64 = 1e-4;
const MUCH_LESS: f64 = 0.5;
/// The shaft carries a weight where its torque leaves less than this share of what is left without.
const CARRIES: f64 = 0.6;
/// A target arrives late by up to so many rows, where that leaves less than this share of what is left at once.
const MOST_LATE: usize = 6;
const LATE: f64 = 0.7;
/// Of the gains every so many suffice to find how late it is.
const EVERY: usize = 2;

/// A loop that is not logged, and what tells its controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub run: Loop,
    pub told: Told,
}

/// What every trial goes through.
pub(super) struct Searched<'a> {
    parts: Vec<(Seen<'a>, Option<Weak<'a>>)>,
    /// Rows that the trials went through so far.
    #[cfg(test)]
    pub steps: std::sync::atomic::AtomicUsize,
}

impl<'a> Searched<'a> {
    pub fn of(stretches: &'a [Stretch]) -> Self {
        let part = |stretch: &'a Stretch| Some((Seen::of(&stretch.record)?, Weak::new(&stretch.record)));
        Self {
            parts: stretches.iter().filter_map(part).collect(),
            #[cfg(test)]
            steps: std::sync::atomic::AtomicUsize::new(0),
        }
    }

    /// Time from row to row, s.
    fn interval_s(&self) -> f64 {
        self.parts.first().map_or(0.0, |(seen, _)| seen.interval_s)
    }
}

/// What a loop leaves unexplained of its own voltage, and how much of the time it is at full duty.
struct Trial {
    run: Loop,
    /// The motor as one of the records shows it, beside friction and a constant load, and under a weight too.
    motors: [Option<Regression>; 2],
    /// What is left so.
    left: [f64; 2],
    saturated: f64,
}

impl Trial {
    fn new(searched: &Searched, run: Loop) -> Self {
        let (mut sums, mut full, mut all) = ([(0.0, 0.0); 2], 0, 0);
        let mut motors = [None; 2];
        for (seen, weak) in &searched.parts {
            let duty = run.mean_duty(seen);
            full += duty.iter().filter(|duty| duty.abs() > 0.98).count();
            all += duty.len();
            let Some(weak) = weak else { continue };
            let volts = volts(seen.record, &duty);
            let found = weak.under(&volts).without_and_under_load(0.0);
            let found = found.map(|of| of.filter(|of| of.gain > 0.0));
            for ((of, motor), (left, weight)) in found.iter().zip(&mut motors).zip(&mut sums) {
                if let Some(of) = of {
                    *motor = motor.or(Some(*of));
                    *left += of.left * duty.len() as f64;
                    *weight += duty.len() as f64;
                }
            }
        }
        #[cfg(test)]
        searched.steps.fetch_add(all, std::sync::atomic::Ordering::Relaxed);
        let mean = |(left, weight): (f64, f64)| {
            if weight > 0.5 * all as f64 { left / weight } else { f64::INFINITY }
        };
        Self { run, motors, left: sums.map(mean), saturated: full as f64 / all.max(1) as f64 }
    }
}

/// The trials of all `controllers` with a target that is so many seconds late, moving on and held.
fn trials(searched: &Searched, controllers: &[Controller], late_s: f64) -> Vec<Trial> {
    let runs: Vec<Loop> = controllers
        .iter()
        .flat_map(|controller| [true, false].map(|moves| Loop { controller: *controller, late_s, moves }))
        .collect();
    cores::each(&runs, |run| Trial::new(searched, *run))
}

/// The trial that leaves least beside friction (0) or under a weight (1); the first of equals.
fn least(trials: &[Trial], kind: usize) -> Option<&Trial> {
    trials.iter().min_by(|a, b| a.left[kind].total_cmp(&b.left[kind]))
}

/// How a `controller` that is known drives the motor of `record`.
pub(super) fn known(record: &Record, controller: Controller) -> Loop {
    let stretches = busiest(std::slice::from_ref(record));
    of_known(&Searched::of(&stretches), controller)
}

/// How a `controller` that is known drives what is `searched`.
fn of_known(searched: &Searched, controller: Controller) -> Loop {
    let tried = |late: usize| trials(searched, &[controller], late as f64 * searched.interval_s());
    let run = |trials: &[Trial]| least(trials, 1).map(|trial| (trial.run, trial.left[1]));
    let at_once = run(&tried(0));
    let late = (1..=MOST_LATE).filter_map(|late| run(&tried(late))).min_by(|a, b| a.1.total_cmp(&b.1));
    match (at_once, late) {
        (Some((_, left)), Some((run, less))) if less < LATE * left => run,
        (Some((run, _)), _) => run,
        (None, _) => Loop { controller, late_s: 0.0, moves: true },
    }
}

/// The controllers that are tried, of every so many gains.
fn controllers(every: usize) -> Vec<Controller> {
    let (low, high, count) = GAINS;
    let of_gain = |k: usize| {
        let gain = low * (high / low).powf(k as f64 / (count - 1) as f64);
        DAMPING_S.map(|seconds| Controller { gain, damping: gain * seconds })
    };
    (0..count).step_by(every).flat_map(of_gain).collect()
}

/// By how much the target arrives late, s, and the trials of all controllers so.
fn with_lateness(searched: &Searched) -> (f64, Vec<Trial>) {
    let at_once = trials(searched, &controllers(1), 0.0);
    let kind = usize::from(carries(&at_once));
    let less = least(&at_once, kind).map_or(f64::INFINITY, |trial| LATE * trial.left[kind]);
    let some = controllers(EVERY);
    let late = (1..=MOST_LATE).map(|late| late as f64 * searched.interval_s()).filter_map(|late_s| {
        let tried = trials(searched, &some, late_s);
        least(&tried, kind).map(|trial| (late_s, trial.left[kind]))
    });
    match late.filter(|(_, left)| *left < less).min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((late_s, _)) => (late_s, trials(searched, &controllers(1), late_s)),
        None => (0.0, at_once),
    }
}

/// The loop that explains the motion of `records` best, and what tells its controller.
pub(super) fn find(records: &[Record]) -> Found {
    let stretches = busiest(records);
    find_in(&stretches, &Searched::of(&stretches), assumed(records))
}

/// The same of the `stretches` that are `searched`; of a controller that they do not tell the `gain` is assumed.
fn find_in(stretches: &[Stretch], searched: &Searched, gain: f64) -> Found {
    let (late_s, tried) = with_lateness(searched);
    let kind = usize::from(carries(&tried));
    let unknown = |seconds: f64, told: Told| Found {
        run: of_known(searched, Controller { gain, damping: gain * seconds }),
        told,
    };
    let Some(best) = least(&tried, kind).filter(|best| best.left[kind].is_finite()) else {
        return unknown(0.0, Told::Nothing);
    };
    let linear = tried
        .iter()
        .filter(|trial| trial.saturated == 0.0)
        .map(|trial| trial.left[kind])
        .fold(f64::MAX, f64::min);
    if best.saturated <= SATURATED || linear <= WORSE * best.left[kind] {
        return unknown(best.run.controller.damping / best.run.controller.gain, Told::NeverFull);
    }
    let rough = between(searched, best.run, kind);
    let followed = followed(stretches, &rough, kind).filter(|followed| followed.left < HARDLY);
    let Some(Followed { controller, left, .. }) = followed else {
        return unknown(0.0, Told::Nothing);
    };
    let run = least(&trials(searched, &[controller], late_s), kind).map_or(rough.run, |trial| trial.run);
    let told = match controller.gain {
        _ if left >= FOLLOWED => Told::Nothing,
        gain if gain >= GAINS.1 => Told::Relay,
        _ => Told::Gain,
    };
    Found { run, told }
}

/// The trial of the gain that leaves least between those tried beside that of `run`.
fn between(searched: &Searched, run: Loop, kind: usize) -> Trial {
    let (low, high, count) = GAINS;
    let step = (high / low).powf(1.0 / (count - 1) as f64);
    let Controller { gain: centre, damping } = run.controller;
    let times = |times: f64| {
        let controller = Controller { gain: centre * times, damping: damping * times };
        Trial::new(searched, Loop { controller, ..run })
    };
    let ends = [-step.ln(), step.ln()];
    let (_, at) = lowest(ends, |at| times(at.exp()).left[kind]);
    times(at.exp())
}

/// The simulated loop that follows `stretches` best from where a `rough` one is, or from a relay.
fn followed(stretches: &[Stretch], rough: &Trial, kind: usize) -> Option<Followed> {
    let from = |controller: Controller, motor: Regression| {
        simulated::refined(stretches, Loop { controller, ..rough.run }, motor, kind == 1)
    };
    let graded = from(rough.run.controller, rough.motors[kind]?)?;
    if graded.left <= CLOSE {
        return Some(graded);
    }
    // Full duty either way within a row hides the motor from the regression, and not from the loop.
    let relay = from(Controller::RELAY, graded.motor).filter(|relay| relay.left < MUCH_LESS * graded.left);
    relay.or(Some(graded))
}

/// Whether the shaft carries a weight, by what the best of `trials` leave.
fn carries(trials: &[Trial]) -> bool {
    let left = |kind: usize| least(trials, kind).map_or(f64::INFINITY, |trial| trial.left[kind]);
    left(1) < CARRIES * left(0)
}

/// A gain that just does not saturate: nothing is known, and nothing is lost.
fn assumed(records: &[Record]) -> f64 {
    let errors = records.iter().flat_map(|record| {
        let target = record.servo.iter().flat_map(|servo| &servo.target_rad);
        target.zip(record.angle_rad.iter().flatten()).map(|(target, angle)| target - angle)
    });
    let largest = peak(&errors.collect::<Vec<f64>>());
    if largest > 0.0 { 1.0 / largest } else { 1.0 }
}

#[cfg(test)]
mod tests {
    use std::sync::atomic::Ordering;

    use super::super::busiest::whole;
    use super::super::made::Made;
    use super::*;

    fn found_in(stretches: &[Stretch]) -> (Found, usize) {
        let searched = Searched::of(stretches);
        (find_in(stretches, &searched, 1.0), searched.steps.load(Ordering::Relaxed))
    }

    #[test]
    fn the_trials_of_a_long_log_go_through_no_more_rows_than_those_of_a_shorter_one() {
        let steps = |rows: usize| {
            let stretches = busiest(&[Made { rows, ..Made::default() }.record()]);
            let (found, steps) = found_in(&stretches);
            let gain = found.run.controller.gain;
            assert!(found.told == Told::Gain && (gain / 2.5 - 1.0).abs() < 0.02, "{found:?}");
            steps
        };
        // On all rows of it they would be some hundred million.
        let (long, shorter) = (steps(100_000), steps(12_000));
        assert!(long < 20_000_000 && long < shorter + shorter / 10, "{long} {shorter}");
    }

    #[test]
    fn what_the_busiest_parts_of_a_log_tell_is_what_all_of_it_tells() {
        let record = Made { damping: 0.1, noise: 1e-3, rows: 10_000, ..Made::default() }.record();
        let records = std::slice::from_ref(&record);
        let [part, all] = [busiest(records), whole(records)].map(|stretches| found_in(&stretches));
        assert!(2 * part.1 < all.1, "{} {}", part.1, all.1);
        let [part, all] = [part.0, all.0];
        assert!(part.told == Told::Gain && all.told == Told::Gain, "{part:?} {all:?}");
        assert!(part.run.moves == all.run.moves && part.run.late_s == all.run.late_s, "{part:?} {all:?}");
        let [part, all] = [part.run.controller, all.run.controller];
        assert!((part.gain / all.gain - 1.0).abs() < 0.01, "{part:?} {all:?}");
        assert!((part.damping / all.damping - 1.0).abs() < 0.03, "{part:?} {all:?}");
    }

    #[test]
    fn a_log_that_waits_most_of_the_time_tells_its_controller() {
        // It rests for five minutes, and then moves every half a minute.
        let target = |t: f64| if t < 300.0 { 0.0 } else { (2.4 * (t / 30.0).floor()).sin() };
        let found = find(&[Made { target, rows: 60_000, ..Made::default() }.record()]);
        let gain = found.run.controller.gain;
        assert!(found.told == Told::Gain && (gain / 2.5 - 1.0).abs() < 0.05, "{found:?}");
    }
}
