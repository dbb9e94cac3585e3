//! Which controller drives a servo, tried out: the one whose voltage the motion explains best.
//!
//! A controller gives the voltage of every row, the motor's equation in its weak form ([`crate::log::weak`]) what of that the motion does not
//! explain: beside friction alone, or under a weight too, which an arm lifts. Where the target stands between two rows and how late it
//! arrives is not logged either, and is found alike. What the motion tells of a controller is judged by the simulated loop
//! ([`super::simulated`]): the trial that leaves least may still leave nearly all.

use super::simulated::{self, Followed};
use super::told::Told;
use super::{Controller, Servo, filtered_speed, volts};
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
/// Places between two rows at which the duty is worked out: full duty is reached between them.
const BETWEEN: usize = 8;

/// How a motor is driven: its controller, how many rows late the target arrives there, and whether that moves on straight from row to row or is held.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Loop {
    pub controller: Controller,
    pub late: usize,
    pub moves: bool,
}

impl Loop {
    /// The target as it arrives.
    pub fn target(self, servo: &Servo) -> Vec<f64> {
        (0..servo.target_rad.len()).map(|k| servo.target_rad[k.saturating_sub(self.late)]).collect()
    }

    /// The mean duty from each row of `record` to the next: the loop runs far more often than it is logged, and the shaft turns on meanwhile.
    pub fn mean_duty(self, record: &Record, servo: &Servo, speed: &[f64]) -> Vec<f64> {
        let (target, angle) = (self.target(servo), record.angle_rad.as_deref().unwrap_or_default());
        let last = angle.len().saturating_sub(1);
        let mean = |k: usize| {
            let next = (k + 1).min(last);
            let at = |values: &[f64], share: f64| values[k] + share * (values[next] - values[k]);
            let duty = |step: usize| {
                let share = (step as f64 + 0.5) / BETWEEN as f64;
                let target = if self.moves { at(&target, share) } else { target[k] };
                self.controller.duty(target - at(angle, share), at(speed, share))
            };
            (0..BETWEEN).map(duty).sum::<f64>() / BETWEEN as f64
        };
        (0..angle.len()).map(mean).collect()
    }
}

/// A loop that is not logged, and what tells its controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub run: Loop,
    pub told: Told,
}

/// A servo's record as every trial sees it.
pub(super) struct Seen<'a> {
    record: &'a Record,
    servo: &'a Servo,
    speed: Vec<f64>,
    weak: Option<Weak<'a>>,
}

impl<'a> Seen<'a> {
    pub fn of(record: &'a Record) -> Option<Self> {
        let servo = record.servo.as_ref()?;
        Some(Self { record, servo, speed: filtered_speed(record), weak: Weak::new(record) })
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
    fn new(seen: &[Seen], run: Loop) -> Self {
        let (mut sums, mut full, mut all) = ([(0.0, 0.0); 2], 0, 0);
        let mut motors = [None; 2];
        for one in seen {
            let duty = run.mean_duty(one.record, one.servo, &one.speed);
            full += duty.iter().filter(|duty| duty.abs() > 0.98).count();
            all += duty.len();
            let volts = volts(one.record, &duty);
            let Some(weak) = one.weak.as_ref().map(|weak| weak.under(&volts)) else { continue };
            let found = [weak.regress(0.0, |v| v), weak.under_load(0.0)];
            let found = found.map(|of| of.filter(|of| of.gain > 0.0));
            for ((of, motor), (left, weight)) in found.iter().zip(&mut motors).zip(&mut sums) {
                if let Some(of) = of {
                    *motor = motor.or(Some(*of));
                    *left += of.left * duty.len() as f64;
                    *weight += duty.len() as f64;
                }
            }
        }
        let mean = |(left, weight): (f64, f64)| {
            if weight > 0.5 * all as f64 { left / weight } else { f64::INFINITY }
        };
        Self { run, motors, left: sums.map(mean), saturated: full as f64 / all.max(1) as f64 }
    }
}

/// The trials of all `controllers` with a target that is so many rows late, moving on and held.
fn trials(seen: &[Seen], controllers: &[Controller], late: usize) -> Vec<Trial> {
    let runs = controllers
        .iter()
        .flat_map(|controller| [true, false].map(|moves| Loop { controller: *controller, late, moves }));
    runs.map(|run| Trial::new(seen, run)).collect()
}

/// The trial that leaves least beside friction (0) or under a weight (1); the first of equals.
fn least(trials: &[Trial], kind: usize) -> Option<&Trial> {
    trials.iter().min_by(|a, b| a.left[kind].total_cmp(&b.left[kind]))
}

/// How a `controller` that is known drives what was `seen`.
pub(super) fn of_known(seen: &[Seen], controller: Controller) -> Loop {
    let tried = |late: usize| trials(seen, &[controller], late);
    let run = |trials: &[Trial]| least(trials, 1).map(|trial| (trial.run, trial.left[1]));
    let at_once = run(&tried(0));
    let late = (1..=MOST_LATE).filter_map(|late| run(&tried(late))).min_by(|a, b| a.1.total_cmp(&b.1));
    match (at_once, late) {
        (Some((_, left)), Some((run, less))) if less < LATE * left => run,
        (Some((run, _)), _) => run,
        (None, _) => Loop { controller, late: 0, moves: true },
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

/// How many rows late the target arrives, and the trials of all controllers so.
fn with_lateness(seen: &[Seen]) -> (usize, Vec<Trial>) {
    let at_once = trials(seen, &controllers(1), 0);
    let kind = usize::from(carries(&at_once));
    let less = least(&at_once, kind).map_or(f64::INFINITY, |trial| LATE * trial.left[kind]);
    let some = controllers(EVERY);
    let late = (1..=MOST_LATE).filter_map(|late| {
        let tried = trials(seen, &some, late);
        least(&tried, kind).map(|trial| (late, trial.left[kind]))
    });
    match late.filter(|(_, left)| *left < less).min_by(|a, b| a.1.total_cmp(&b.1)) {
        Some((late, _)) => (late, trials(seen, &controllers(1), late)),
        None => (0, at_once),
    }
}

/// The loop that explains the motion of `records` best, and what tells its controller.
pub(super) fn find(records: &[Record]) -> Found {
    let seen: Vec<Seen> = records.iter().filter_map(Seen::of).collect();
    let (late, tried) = with_lateness(&seen);
    let kind = usize::from(carries(&tried));
    let unknown = |seconds: f64, told: Told| {
        let gain = assumed(records);
        Found { run: of_known(&seen, Controller { gain, damping: gain * seconds }), told }
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
    let rough = between(&seen, best.run, kind);
    let followed = followed(records, &rough, kind).filter(|followed| followed.left < HARDLY);
    let Some(Followed { controller, left, .. }) = followed else {
        return unknown(0.0, Told::Nothing);
    };
    let run = least(&trials(&seen, &[controller], late), kind).map_or(rough.run, |trial| trial.run);
    let told = match controller.gain {
        _ if left >= FOLLOWED => Told::Nothing,
        gain if gain >= GAINS.1 => Told::Relay,
        _ => Told::Gain,
    };
    Found { run, told }
}

/// The trial of the gain that leaves least between those tried beside that of `run`.
fn between(seen: &[Seen], run: Loop, kind: usize) -> Trial {
    let (low, high, count) = GAINS;
    let step = (high / low).powf(1.0 / (count - 1) as f64);
    let Controller { gain: centre, damping } = run.controller;
    let times = |times: f64| {
        let controller = Controller { gain: centre * times, damping: damping * times };
        Trial::new(seen, Loop { controller, ..run })
    };
    let ends = [-step.ln(), step.ln()];
    let (_, at) = lowest(ends, |at| times(at.exp()).left[kind]);
    times(at.exp())
}

/// The simulated loop that follows `records` best from where a `rough` one is, or from a relay.
fn followed(records: &[Record], rough: &Trial, kind: usize) -> Option<Followed> {
    let arrived: Vec<Record> = records.iter().map(|record| arrived(record, rough.run)).collect();
    let from = |controller: Controller, motor: Regression| {
        simulated::refined(&arrived, controller, motor, kind == 1)
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

/// `record` with its target as `run` gets it.
fn arrived(record: &Record, run: Loop) -> Record {
    let servo = record.servo.as_ref().map(|servo| Servo { target_rad: run.target(servo), ..servo.clone() });
    Record { servo, ..record.clone() }
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
