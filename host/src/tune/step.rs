//! How the loops answer a step: the usual figures of a step response, with all effects.

use serde::Serialize;

use super::limit_cycle::LimitCycle;
use super::trial::{Course, Run};

/// Between these shares of a step it rises.
const RISES: [f64; 2] = [0.1, 0.9];
/// It has settled where it stays within this share of it.
const SETTLED: f64 = 0.05;
/// Of this last part of the run what is left is the mean.
const LAST: f64 = 0.1;

/// What the loops control, in the order in which their steps are shown.
const LOOPS: [&str; 2] = ["position", "velocity"];

/// A loop's answer to a step of what is wanted; lengths are rad of the position's loop and rad/s of the velocity's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Step {
    /// `position` or `velocity`.
    pub of: &'static str,
    /// What is added to the feedback.
    pub compensation: &'static str,
    /// On the base model alone.
    pub without_effects: bool,
    /// How high the step is.
    pub height: f64,
    /// Time from a tenth to nine tenths of it, s; none where it does not come so far.
    pub rise_s: Option<f64>,
    /// How far beyond it, as a share of it.
    pub overshoot: f64,
    /// Time until it stays within a twentieth of it, s; none where it does not.
    pub settling_s: Option<f64>,
    /// What is left at the end: wanted less reached.
    pub left: f64,
    /// How the position keeps moving where the step is held for longer; none of one that comes to rest, and of the velocity.
    pub limit_cycle: Option<LimitCycle>,
    /// For a plot; of the velocity's loop in rad/s.
    #[serde(skip)]
    pub course: Course,
}

impl Step {
    /// The answer of a `run` whose profile is a step.
    pub(super) fn of(run: &Run, of: &'static str, compensation: &'static str, without_effects: bool) -> Self {
        let [course, held] = run.answer();
        let is_held_on = held.time_s.len() > course.time_s.len();
        let height = course.wanted.last().copied().unwrap_or_default();
        let share: Vec<f64> = course.reached.iter().map(|reached| reached / height).collect();
        let first = |least: f64| share.iter().position(|x| *x >= least).map(|k| course.time_s[k]);
        let [low, high] = RISES.map(first);
        let astray = share.iter().rposition(|x| (x - 1.0).abs() > SETTLED);
        let settled = astray.map_or(Some(0), |k| (k + 1 < share.len()).then_some(k + 1));
        let last = &share[share.len() - ((LAST * share.len() as f64) as usize).clamp(1, share.len())..];
        Self {
            of,
            compensation,
            without_effects,
            height,
            rise_s: low.zip(high).map(|(low, high)| high - low),
            overshoot: share.iter().fold(0.0, |most: f64, x| most.max(x - 1.0)),
            settling_s: settled.map(|k| course.time_s[k]),
            limit_cycle: is_held_on.then(|| LimitCycle::of(&held, run.count_rad())).flatten(),
            left: height * (1.0 - last.iter().sum::<f64>() / last.len() as f64),
            course,
        }
    }

    /// The unit of its height and of what is left of it.
    pub fn unit(&self) -> &'static str {
        if self.of == "velocity" { "rad/s" } else { "rad" }
    }

    /// Those of the position's loop, then those of the velocity's.
    pub(crate) fn by_loop(steps: &[Self]) -> [Vec<&Self>; 2] {
        LOOPS.map(|of| steps.iter().filter(|step| step.of == of).collect())
    }
}
