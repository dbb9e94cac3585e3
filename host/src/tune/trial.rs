//! The whole model under the gains: a move there and back, and a velocity that reverses.

use serde::Serialize;

use super::load::Loads;
use super::loops::Loop;
use super::profile::{Point, Profile};
use super::step::Step;
use super::{Feedforward, Options};
use crate::model_file::Model;
use crate::sentence::capital;

/// How well a profile was followed, in rad for the position's and rad/s for the velocity's.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub struct Tracking {
    /// rms error.
    pub rms: f64,
    /// Largest error.
    pub worst: f64,
    /// Error that is left in the last tenth of the profile, rms.
    pub at_the_end: f64,
}

/// A loop with some compensations.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Trial {
    /// What is added to the feedback.
    pub compensation: &'static str,
    /// On the base model alone: no effect costs anything.
    pub without_effects: bool,
    /// The position under PD.
    pub position: Tracking,
    /// The velocity under PI.
    pub velocity: Tracking,
    /// The position's course, for a plot.
    #[serde(skip)]
    pub course: Course,
    /// The trial to which it adds one compensation, by its place.
    #[serde(skip)]
    beside: Option<usize>,
}

/// What a loop controls, over time.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Course {
    /// s.
    pub time_s: Vec<f64>,
    /// rad, of a velocity rad/s.
    pub wanted: Vec<f64>,
    /// rad, of a velocity rad/s.
    pub reached: Vec<f64>,
}

impl Course {
    /// What it is until `end_s`.
    fn until(&self, end_s: f64) -> Self {
        // A sum of periods is not exact.
        let n = self.time_s.partition_point(|time_s| *time_s <= end_s * (1.0 + 1e-9));
        let first = |column: &[f64]| column[..n].to_vec();
        Self { time_s: first(&self.time_s), wanted: first(&self.wanted), reached: first(&self.reached) }
    }
}

/// What is commanded beside the feedback.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Compensation {
    motion: bool,
    load: Option<At>,
    friction: bool,
    dead_zone: bool,
}

/// Where a load's torque is looked up.
#[derive(Debug, Clone, Copy, PartialEq)]
enum At {
    Wanted,
    Measured,
}

/// Runs every trial, and the steps under feedback alone and with what came of the trials.
pub(super) fn all(
    model: &Model,
    options: &Options,
    gains: &[Loop; 2],
    feedforward: &Feedforward,
    loads: &Loads,
) -> (Vec<Trial>, Vec<Step>) {
    let plain = Model { effects: Vec::new(), ..model.clone() };
    let none = Compensation::default();
    let limit_v = options.limit_v.unwrap_or(model.rig.supply_v);
    let [profile, place, speed] = Profile::of(&model.base, limit_v);
    let [velocity, position] = gains;
    let run_of = |without_effects: bool, with, profile, gains, is_velocity| Run {
        model: if without_effects { &plain } else { model },
        options,
        feedforward,
        loads,
        with,
        limit_v,
        profile,
        gains,
        is_velocity,
    };
    let run = |compensation, without_effects: bool, with, beside| {
        let (of_position, course) = run_of(without_effects, with, profile, position, false).follow();
        let (of_velocity, _) = run_of(without_effects, with, profile, velocity, true).follow();
        Trial { compensation, without_effects, position: of_position, velocity: of_velocity, course, beside }
    };
    let mut best = Compensation { motion: true, ..none };
    let mut trials = vec![
        run("feedback alone, base model without effects", true, none, None),
        run("feedback alone", false, none, None),
        run("with kV, kA and kG", false, best, Some(1)),
    ];
    // The place of the trial that what follows adds to.
    let mut last = 2;
    // Friction first: it hides what a load's torque does where the shaft creeps.
    if feedforward.ks_v > 0.0 {
        best.friction = true;
        trials.push(run("with kS too", false, best, Some(last)));
        last = trials.len() - 1;
    }
    if !loads.told.is_empty() {
        let (before, with) = (last, best);
        for (name, at) in [
            ("with loads at the wanted angle too", At::Wanted),
            ("with loads at the measured angle too", At::Measured),
        ] {
            let load = Compensation { load: Some(at), ..with };
            trials.push(run(name, false, load, Some(before)));
            let this = trials.len() - 1;
            if trials[this].position.rms < trials[last].position.rms {
                (best, last) = (load, this);
            }
        }
    }
    if feedforward.dead_zone_v > 0.0 {
        best.dead_zone = true;
        trials.push(run("with the dead zone's inverse too", false, best, Some(last)));
    }
    let mut steps = Vec::new();
    for (of, profile, gains) in [("position", place, position), ("velocity", speed, velocity)] {
        for (compensation, without_effects, with) in [
            (trials[0].compensation, true, none),
            (trials[1].compensation, false, none),
            ("with all compensations", false, best),
        ] {
            let run = run_of(without_effects, with, profile, gains, of == "velocity");
            steps.push(Step::of(&run, of, compensation, without_effects));
        }
    }
    (trials, steps)
}

/// A loop that follows a profile.
pub(super) struct Run<'a> {
    model: &'a Model,
    options: &'a Options,
    feedforward: &'a Feedforward,
    loads: &'a Loads,
    with: Compensation,
    limit_v: f64,
    profile: Profile,
    gains: &'a Loop,
    /// Of the velocity, or of the position.
    is_velocity: bool,
}

impl Run<'_> {
    /// A count of the encoder, rad.
    pub(super) fn count_rad(&self) -> f64 {
        self.model.rig.count_rad
    }

    /// The answer to a step, and the same while it is held on.
    pub(super) fn answer(&self) -> [Course; 2] {
        let (_, held) = self.follow();
        [held.until(self.profile.answered_s()), held]
    }

    /// Feedback by what the encoder shows, updated once a period, and the profile's own command.
    fn follow(&self) -> (Tracking, Course) {
        let (gains, velocity) = (self.gains, self.is_velocity);
        let period = self.options.period_s;
        let parts = (period / 1e-3).ceil().max(1.0);
        let mut motor = self.model.start(period / parts, 0.0);
        let count = self.model.rig.count_rad.max(1e-9);
        let shown = |angle: f64| (angle / count).round() * count;
        let (mut last, mut sum, mut kept) = (shown(motor.angle_rad()), 0.0, Vec::new());
        let mut course = Course::default();
        for k in 0..(self.profile.seconds() / period) as usize {
            let time = k as f64 * period;
            let point @ [place, speed, _] = self.profile.at(time);
            let seen = shown(motor.angle_rad());
            let moving = (seen - last) / period;
            last = seen;
            let feedback = if velocity {
                let error = speed - moving;
                sum += error * period;
                gains.kp * error + gains.ki * sum
            } else {
                gains.kp * (place - seen) + gains.kd * (if self.with.motion { speed } else { 0.0 } - moving)
            };
            let moved = self.profile.at(time + period)[0] - place;
            let asked = self.command(feedback, point, seen, moved);
            let limited = asked.clamp(-self.limit_v, self.limit_v);
            if velocity && limited != asked {
                // No winding up at the limit.
                sum -= (speed - moving) * period;
            }
            for _ in 0..parts as usize {
                motor.step(limited);
            }
            let [place, speed, _] = self.profile.at(time + period);
            let (wanted, reached) =
                if velocity { (speed, motor.speed_rad_s()) } else { (place, motor.angle_rad()) };
            kept.push(wanted - reached);
            course.time_s.push(time + period);
            course.wanted.push(wanted);
            course.reached.push(reached);
        }
        (tracking(&kept), course)
    }

    /// Feedback and what is added to it, of which a load asks how far the shaft is to move in the period, rad.
    fn command(&self, feedback: f64, [place, speed, acceleration]: Point, seen: f64, moved: f64) -> f64 {
        let f = self.feedforward;
        let mut volts = feedback;
        if self.with.motion {
            volts += f.kv_v_s_per_rad * speed + f.ka_v_s2_per_rad * acceleration + f.kg_v;
        }
        if let Some(at) = self.with.load {
            let from = if at == At::Wanted { place } else { seen };
            volts += self.loads.volts(from, from + moved);
        }
        if self.with.friction && speed != 0.0 {
            volts += f.ks_v * speed.signum();
        }
        // Round zero the inverse would jump at every count: it begins where the command is worth a tenth of the dead zone.
        if self.with.dead_zone {
            volts += f.dead_zone_v * (volts / (0.1 * f.dead_zone_v)).clamp(-1.0, 1.0);
        }
        volts
    }
}

fn tracking(errors: &[f64]) -> Tracking {
    let rms = |e: &[f64]| (e.iter().map(|x| x * x).sum::<f64>() / e.len().max(1) as f64).sqrt();
    Tracking {
        rms: rms(errors),
        worst: errors.iter().fold(0.0, |worst, x| worst.max(x.abs())),
        at_the_end: rms(&errors[errors.len() * 9 / 10..]),
    }
}

/// Which compensation pays.
pub(super) fn advice(trials: &[Trial]) -> Vec<String> {
    let mut said = Vec::new();
    if let [ideal, real, ..] = trials {
        said.push(format!(
            "Under feedback alone the effects cost {:.2e} rad rms beside the {:.2e} rad of the base model.",
            (real.position.rms.powi(2) - ideal.position.rms.powi(2)).max(0.0).sqrt(),
            ideal.position.rms
        ));
    }
    for trial in trials {
        let Some(before) = trial.beside.and_then(|place| trials.get(place)) else { continue };
        let (before, after) = (before.position.rms, trial.position.rms);
        let verdict = if after < 0.9 * before { "which pays" } else { "which does not pay" };
        said.push(format!("{}: {before:.2e} to {after:.2e} rad rms, {verdict}.", named(trial.compensation)));
    }
    said
}

/// A compensation as a sentence begins with it.
fn named(text: &str) -> String {
    let text = text.strip_suffix(" too").unwrap_or(text).strip_prefix("with ").unwrap_or(text);
    // kS and its like keep their letters.
    if text.starts_with('k') { text.to_owned() } else { capital(text) }
}
