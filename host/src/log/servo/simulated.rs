//! The loop of a position servo, simulated from its target to its angle: the controller, and a motor with a lag and dry friction, under a weight
//! where the shaft carries one.
//!
//! The weak-form regression tells a controller roughly, and too small a gain where the shaft often stands still: friction there has no
//! direction. The simulation has its friction right, and a loop does not drift, so its error over the whole record is minimised
//! ([`crate::search::least_squares`]). Whether the target moves on between two rows or is held is not logged: what
//! follows the angle better counts.

use levenberg_marquardt::LevenbergMarquardt;

use super::Controller;
use super::busiest::Stretch;
use super::driven::{Loop, full_duty_v, target_at};
use crate::cores;
use crate::log::Record;
use crate::log::motion::mean;
use crate::log::timing::median_interval;
use crate::log::weak::Regression;
use crate::search::least_squares::{Minimum, Search};

/// Longest step of the simulation, s, and most steps from sample to sample.
const STEP_S: f64 = 2.5e-4;
const MOST_STEPS: usize = 40;
/// A search has ended where a step gains less than this share of the error, or after so many simulations a parameter.
const ENDED: f64 = 1e-5;
const PATIENCE: usize = 30;
/// Largest ratio between a parameter and its start.
const BOUND: f64 = 100.0;
/// Step of the difference, wide enough for a friction that sets in at samples; longest first step: what hardly shows may not run away.
const DIFFERENCE: f64 = 2e-4;
const FIRST_STEP: f64 = 0.15;
/// What the friction, V, and the damping, s of the gain, begin with: small, and not zero, whose logarithm has no slope.
const FRICTION_V: f64 = 0.2;
const DAMPING_S: f64 = 1e-3;

/// A simulated loop, and how well it follows the angle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Followed {
    pub controller: Controller,
    pub motor: Regression,
    /// Share of the angle's variation that the loop leaves.
    pub left: f64,
}

/// The loop that follows `stretches` best, from one that is about right and the motor seen with it, under the weight seen with that where the
/// shaft `carries` one; none where the angle does not change.
pub(super) fn refined(
    stretches: &[Stretch],
    start: Loop,
    motor: Regression,
    carries: bool,
) -> Option<Followed> {
    let Controller { gain, damping } = start.controller;
    let mut begin =
        vec![gain, (damping / gain).max(DAMPING_S), motor.gain, motor.tau_s.max(5e-3), FRICTION_V];
    if carries {
        begin.push(1.0);
    }
    let solver = LevenbergMarquardt::new().with_ftol(ENDED).with_patience(PATIENCE);
    let solver = solver.with_scale_diag(false).with_stepbound(FIRST_STEP);
    let search = Search { start: &begin, bound: BOUND, difference: DIFFERENCE, solver };
    let both = cores::each(&[false, true], |moves| {
        let form = Form { seen: &motor, late_s: start.late_s, moves: *moves };
        search.minimise(|at| stretches.iter().flat_map(|one| errors(one, form, at)).collect())
    });
    let Minimum { x, squares, .. } = both.into_iter().min_by(|a, b| a.squares.total_cmp(&b.squares))?;
    let variation: f64 = stretches.iter().map(|one| variation(&one.record)).sum();
    let [gain, seconds] = [x[0].min(Controller::RELAY.gain), x[1]];
    // Of a damping that is as small as it began nothing is told.
    let damping = if seconds > 2.0 * DAMPING_S { gain * seconds } else { 0.0 };
    let mut moved = motor;
    (moved.gain, moved.tau_s) = (x[2], x[3]);
    let controller = Controller { gain, damping };
    let found = Followed { controller, motor: moved, left: squares / variation };
    Some(found).filter(|found| found.left.is_finite())
}

/// Sum of squares of the angle about its mean, rad^2.
fn variation(record: &Record) -> f64 {
    let angle = record.angle_rad.as_deref().unwrap_or_default();
    let mean = mean(angle);
    angle.iter().map(|x| (x - mean).powi(2)).sum()
}

/// What of a loop no search changes.
#[derive(Clone, Copy)]
struct Form<'a> {
    /// With the weight as it was seen.
    seen: &'a Regression,
    late_s: f64,
    moves: bool,
}

/// What the simulated loop misses the measured angles by, rad, under gain, damping as seconds of the gain, gain and time constant of the motor,
/// friction, and where the shaft carries a weight the multiple of the one that was seen.
fn errors(Stretch { record, speed }: &Stretch, form: Form, parameters: &[f64]) -> Vec<f64> {
    let [gain, seconds, motor, tau_s, friction] = std::array::from_fn(|k| parameters[k]);
    let controller = Controller { gain, damping: gain * seconds };
    let weight = |x: f64| parameters.get(5).map_or(0.0, |times| times * form.seen.load_at(x));
    let (time, angle) = (&record.time_s, record.angle_rad.as_deref().unwrap_or_default());
    let (Some(servo), Some(&first)) = (&record.servo, angle.first()) else { return Vec::new() };
    let late = form.late_s / median_interval(time);
    let (mut x, mut w) = (first, *speed);
    let mut all = Vec::with_capacity(angle.len());
    for (k, measured) in angle.iter().enumerate() {
        all.push(x - measured);
        let Some(next) = time.get(k + 1) else { break };
        let steps = (((next - time[k]) / STEP_S).ceil() as usize).clamp(1, MOST_STEPS);
        let dt = (next - time[k]) / steps as f64;
        let supply = full_duty_v(record, k);
        let lag = dt / tau_s.max(2.0 * dt);
        for step in 0..steps {
            let rows = k as f64 + (step as f64 + 0.5) / steps as f64 - late;
            let target = target_at(&servo.target_rad, rows, form.moves);
            let push = supply * controller.duty(target - x, w) - weight(x);
            let holds = if w == 0.0 { push.clamp(-friction, friction) } else { friction * w.signum() };
            let turned = w + lag * (motor * (push - holds) - w);
            w = if turned * w < 0.0 { 0.0 } else { turned };
            x += dt * w;
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::super::busiest::whole;
    use super::super::made::Made;
    use super::*;
    use crate::log::weak::Weak;

    #[test]
    fn a_loop_that_carries_its_weight_follows_an_arm_better_than_one_that_carries_nothing() {
        let (record, means) = Made { weight_v: 2.0, ..Made::default() }.log();
        let seen = Weak::new(&record).unwrap().under(&means).under_load(0.0).unwrap();
        let controller = Controller { gain: 2.5, damping: 0.0 };
        let start = Loop { controller, late_s: 0.0, moves: false };
        let all = whole(&[record]);
        let left = |carries: bool| refined(&all, start, seen, carries).unwrap().left;
        assert!(left(true) < 0.3 * left(false), "{} {}", left(true), left(false));
    }
}
