//! Which controller drives a servo, tried out: what of its own voltage each leaves unexplained by the motion.
//!
//! A controller gives the voltage of every row, the motor's equation in its weak form ([`crate::log::weak`]) what of that the motion does not
//! explain: beside friction alone, or under a weight too, which an arm lifts.

use super::Controller;
use super::busiest::Stretch;
use super::driven::{Lateness, Loop, Seen, volts};
use crate::cores;
use crate::log::weak::{Regression, Weak};
use crate::search::golden::lowest;

/// Gains that are tried, duty per rad: full duty at 1.5 rad to full duty at 0.01 rad.
pub(super) const GAINS: (f64, f64, usize) = (0.7, 100.0, 40);
/// Damping that is tried, seconds of the gain.
const DAMPING_S: [f64; 5] = [0.0, 0.01, 0.02, 0.04, 0.08];
/// The shaft carries a weight where its torque leaves less than this share of what is left without.
const CARRIES: f64 = 0.6;

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
    pub fn interval_s(&self) -> f64 {
        self.parts.first().map_or(0.0, |(seen, _)| seen.interval_s)
    }
}

/// What a loop leaves unexplained of its own voltage, and how much of the time it is at full duty.
pub(super) struct Trial {
    pub run: Loop,
    /// The motor as one of the records shows it, beside friction and a constant load, and under a weight too.
    pub motors: [Option<Regression>; 2],
    /// What is left so.
    pub left: [f64; 2],
    pub saturated: f64,
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
            let found = weak.under(&volts).without_and_under_load(run.late.voltage_s);
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

/// The trials of all `controllers` in a loop of which so much is late, its target moving on and held.
pub(super) fn trials(searched: &Searched, controllers: &[Controller], late: Lateness) -> Vec<Trial> {
    let runs: Vec<Loop> = controllers
        .iter()
        .flat_map(|controller| [true, false].map(|moves| Loop { controller: *controller, late, moves }))
        .collect();
    cores::each(&runs, |run| Trial::new(searched, *run))
}

/// The trial that leaves least beside friction (0) or under a weight (1); the first of equals.
pub(super) fn least(trials: &[Trial], kind: usize) -> Option<&Trial> {
    trials.iter().min_by(|a, b| a.left[kind].total_cmp(&b.left[kind]))
}

/// Whether the shaft carries a weight, by what the best of `trials` leave.
pub(super) fn carries(trials: &[Trial]) -> bool {
    let left = |kind: usize| least(trials, kind).map_or(f64::INFINITY, |trial| trial.left[kind]);
    left(1) < CARRIES * left(0)
}

/// The controllers that are tried, of every so many gains.
pub(super) fn controllers(every: usize) -> Vec<Controller> {
    let (low, high, count) = GAINS;
    let of_gain = |k: usize| {
        let gain = low * (high / low).powf(k as f64 / (count - 1) as f64);
        DAMPING_S.map(|seconds| Controller { gain, damping: gain * seconds })
    };
    (0..count).step_by(every).flat_map(of_gain).collect()
}

/// The trial of the gain that leaves least between those tried beside that of `run`.
pub(super) fn between(searched: &Searched, run: Loop, kind: usize) -> Trial {
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
