//! The loop of a position servo, simulated from its target to its angle: the controller, and a motor with a lag and dry friction, under a weight
//! where the shaft carries one.
//!
//! The weak-form regression tells a controller roughly, and too small a gain where the shaft often stands still: friction there has no
//! direction. The simulation has its friction right, and a loop does not drift, so its error over the whole record is minimised
//! ([`crate::search::least_squares`]). Whether the target moves on between two rows or is held is not logged: what
//! follows the angle better counts.

use std::collections::VecDeque;

use levenberg_marquardt::LevenbergMarquardt;

use super::Controller;
use super::busiest::Stretch;
use super::driven::{Lateness, Loop, full_duty_v, target_at};
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
    pub run: Loop,
    pub motor: Regression,
    /// Share of the angle's variation that the loop leaves.
    pub left: f64,
}

/// The loop that follows `stretches` best, from one that is about right and the motor seen with it, under the weight seen with that where the
/// shaft `carries` one; none where the angle does not change. What is late is refined with the rest.
pub(super) fn refined(
    stretches: &[Stretch],
    start: Loop,
    motor: Regression,
    carries: bool,
) -> Option<Followed> {
    let Controller { gain, damping } = start.controller;
    let mut begin =
        vec![gain, (damping / gain).max(DAMPING_S), motor.gain, motor.tau_s.max(5e-3), FRICTION_V];
    // The weight and the lateness as multiples of what was seen.
    let is_late = start.late != Lateness::NONE;
    begin.resize(begin.len() + usize::from(carries) + usize::from(is_late), 1.0);
    let solver = LevenbergMarquardt::new().with_ftol(ENDED).with_patience(PATIENCE);
    let solver = solver.with_scale_diag(false).with_stepbound(FIRST_STEP);
    let search = Search { start: &begin, bound: BOUND, difference: DIFFERENCE, solver };
    let both = cores::each(&[false, true], |moves| {
        let form = Form { seen: &motor, late: start.late, carries, moves: *moves };
        (*moves, search.minimise(|at| stretches.iter().flat_map(|one| errors(one, form, at)).collect()))
    });
    let best = both.into_iter().min_by(|a, b| a.1.squares.total_cmp(&b.1.squares));
    let (moves, Minimum { x, squares, .. }) = best?;
    let variation: f64 = stretches.iter().map(|one| variation(&one.record)).sum();
    let [gain, seconds] = [x[0].min(Controller::RELAY.gain), x[1]];
    // Of a damping that is as small as it began nothing is told.
    let damping = if seconds > 2.0 * DAMPING_S { gain * seconds } else { 0.0 };
    let mut moved = motor;
    (moved.gain, moved.tau_s) = (x[2], x[3]);
    let late = start.late.times(if is_late { x[x.len() - 1] } else { 1.0 });
    let run = Loop { controller: Controller { gain, damping }, late, moves };
    let found = Followed { run, motor: moved, left: squares / variation };
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
    late: Lateness,
    carries: bool,
    moves: bool,
}

/// What the simulated loop misses the measured angles by, rad, under gain, damping as seconds of the gain, gain and time constant of the motor,
/// friction, and the multiples of the weight, where the shaft carries one, and of the lateness.
fn errors(Stretch { record, speed }: &Stretch, form: Form, parameters: &[f64]) -> Vec<f64> {
    let [gain, seconds, motor, tau_s, friction] = std::array::from_fn(|k| parameters[k]);
    let mut multiples = parameters[5..].iter().copied();
    let times = if form.carries { multiples.next().unwrap_or(1.0) } else { 0.0 };
    let late = form.late.times(multiples.next().unwrap_or(1.0));
    let controller = Controller { gain, damping: gain * seconds };
    let weight = |x: f64| if form.carries { times * form.seen.load_at(x) } else { 0.0 };
    let (time, angle) = (&record.time_s, record.angle_rad.as_deref().unwrap_or_default());
    let (Some(servo), Some(&first)) = (&record.servo, angle.first()) else { return Vec::new() };
    let (mut x, mut w) = (first, *speed);
    // Until it has an answer to the first row the servo lets its shaft turn as it does there.
    let against = if w == 0.0 { 0.0 } else { friction * w.signum() };
    let before = ((w / motor + against + weight(x)) / full_duty_v(record, 0)).clamp(-1.0, 1.0);
    let mut voltage = Delayed { late_s: late.voltage_s, before, asked: VecDeque::new() };
    let late = late.target_s / median_interval(time);
    let mut all = Vec::with_capacity(angle.len());
    for (k, measured) in angle.iter().enumerate() {
        all.push(x - measured);
        let Some(next) = time.get(k + 1) else { break };
        let steps = (((next - time[k]) / STEP_S).ceil() as usize).clamp(1, MOST_STEPS);
        let (dt, width) = ((next - time[k]) / steps as f64, 1.0 / steps as f64);
        let supply = full_duty_v(record, k);
        let lag = dt / tau_s.max(2.0 * dt);
        for step in 0..steps {
            let rows = k as f64 + step as f64 * width - late;
            let target = target_over(&servo.target_rad, rows, width, form.moves);
            let asked = if rows < 0.0 { before } else { controller.duty(target - x, w) };
            let push = supply * voltage.after(time[k] + step as f64 * dt, asked) - weight(x);
            let holds = if w == 0.0 { push.clamp(-friction, friction) } else { friction * w.signum() };
            let turned = w + lag * (motor * (push - holds) - w);
            w = if turned * w < 0.0 { 0.0 } else { turned };
            x += dt * w;
        }
    }
    all
}

/// The mean target from so many rows behind the first on over a part of a row: one that is held may step within, which a search sees.
fn target_over(target: &[f64], rows: f64, width: f64, moves: bool) -> f64 {
    if moves {
        return target_at(target, rows + 0.5 * width, true);
    }
    let end = rows + width;
    let [from, to] = [rows, end].map(|rows| target_at(target, rows, false));
    from + ((end - end.floor()) / width).min(1.0) * (to - from)
}

/// A duty that acts later than it is asked for.
struct Delayed {
    late_s: f64,
    /// What acts until then.
    before: f64,
    /// When what was asked for, from the last one that acts on.
    asked: VecDeque<(f64, f64)>,
}

impl Delayed {
    /// The duty that acts at a `time`, s, at which this `duty` is asked for.
    fn after(&mut self, time: f64, duty: f64) -> f64 {
        if self.late_s == 0.0 {
            return duty;
        }
        self.asked.push_back((time, duty));
        let then = time - self.late_s;
        while self.asked.get(1).is_some_and(|next| next.0 <= then) {
            let _ = self.asked.pop_front();
        }
        let from = self.asked[0];
        match self.asked.get(1) {
            _ if then < from.0 => self.before,
            Some(to) => from.1 + (then - from.0) / (to.0 - from.0) * (to.1 - from.1),
            None => from.1,
        }
    }
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
        let start = Loop { controller, late: Lateness::NONE, moves: false };
        let all = whole(&[record]);
        let left = |carries: bool| refined(&all, start, seen, carries).unwrap().left;
        assert!(left(true) < 0.3 * left(false), "{} {}", left(true), left(false));
    }

    #[test]
    fn a_late_duty_is_what_was_asked_for_so_long_ago_and_before_the_first_what_was() {
        let mut late = Delayed { late_s: 0.025, before: 0.3, asked: VecDeque::new() };
        let seen: Vec<f64> = (0..6).map(|k| late.after(0.01 * f64::from(k), f64::from(k))).collect();
        let right = [0.3, 0.3, 0.3, 0.5, 1.5, 2.5];
        assert!(seen.iter().zip(right).all(|(one, other)| (one - other).abs() < 1e-9), "{seen:?}");
        let mut prompt = Delayed { late_s: 0.0, before: 0.3, asked: VecDeque::new() };
        assert_eq!([prompt.after(0.0, 0.1), prompt.after(0.1, 0.2)], [0.1, 0.2]);
    }

    #[test]
    fn a_step_within_a_part_of_a_row_counts_by_its_share() {
        let target = [0.0, 1.0];
        let over = |rows: f64, moves: bool| target_over(&target, rows, 0.5, moves);
        assert_eq!([0.25, 0.5, 0.75, 1.0].map(|rows| over(rows, false)), [0.0, 0.0, 0.5, 1.0]);
        assert_eq!(over(0.25, true), 0.5);
    }
}
