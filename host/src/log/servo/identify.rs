//! Which loop a servo has, and what of its controller the motion tells.
//!
//! Of the trials ([`super::trials`]) the one that leaves least may still leave nearly all, so that what the motion tells is judged by the simulated
//! loop ([`super::simulated`]). What of the loop is late, and whether the target stands between two rows, is not logged either, and is found alike.

use super::Controller;
use super::busiest::{Stretch, busiest};
use super::driven::{Lateness, Loop, full_duty_v};
use super::late::{Judged, gain_of_late_voltage, judged};
use super::simulated::{self, Followed};
use super::told::Told;
use super::trials::{GAINS, Searched, Trial, between, carries, controllers, least, trials};
use crate::log::Record;
use crate::log::motion::peak;
use crate::log::weak::Regression;

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
/// Of the gains every so many suffice to find what is late.
const EVERY: usize = 2;

/// A loop that is not logged, and what tells its controller.
#[derive(Debug, Clone, Copy)]
pub(super) struct Found {
    pub run: Loop,
    pub told: Told,
    /// The gain, where the voltage may be late in the place of the target.
    pub or_gain: Option<f64>,
}

/// How a `controller` that is known drives the motor of `record`.
pub(super) fn known(record: &Record, controller: Controller) -> Loop {
    let stretches = busiest(std::slice::from_ref(record));
    of_known(&Searched::of(&stretches), controller)
}

/// How a `controller` that is known drives what is `searched`.
fn of_known(searched: &Searched, controller: Controller) -> Loop {
    let tried = |late: Lateness| trials(searched, &[controller], late);
    let at_once = least(&tried(Lateness::NONE), 1).map_or(f64::INFINITY, |trial| trial.left[1]);
    let late = judged(searched, &[controller], 1, at_once).late;
    least(&tried(late), 1).map_or(Loop { controller, late, moves: true }, |trial| trial.run)
}

/// The loop that explains the motion of `records` best, and what tells its controller.
pub(super) fn find(records: &[Record]) -> Found {
    let stretches = busiest(records);
    find_in(&stretches, &Searched::of(&stretches), assumed(records))
}

/// The same of the `stretches` that are `searched`; of a controller that they do not tell the `gain` is assumed.
fn find_in(stretches: &[Stretch], searched: &Searched, gain: f64) -> Found {
    let (Judged { either, .. }, tried) = with_lateness(searched);
    let kind = usize::from(carries(&tried));
    let unknown = |seconds: f64, told: Told| {
        let run = of_known(searched, Controller { gain, damping: gain * seconds });
        Found { run, told, or_gain: None }
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
    let Some(Followed { run, motor, left }) = followed else {
        return unknown(0.0, Told::Nothing);
    };
    let told = match run.controller.gain {
        _ if left >= FOLLOWED => Told::Nothing,
        gain if gain >= GAINS.1 => Told::Relay,
        _ => Told::Gain,
    };
    let supply_v = stretches.first().map(|one| full_duty_v(&one.record, 0));
    let or_gain = supply_v.filter(|_| either && told == Told::Gain);
    Found { run, told, or_gain: or_gain.map(|supply_v| gain_of_late_voltage(run, &motor, supply_v)) }
}

/// What of the loop is late, and the trials of all controllers so.
fn with_lateness(searched: &Searched) -> (Judged, Vec<Trial>) {
    let at_once = trials(searched, &controllers(1), Lateness::NONE);
    let kind = usize::from(carries(&at_once));
    let left = least(&at_once, kind).map_or(f64::INFINITY, |trial| trial.left[kind]);
    let judged = judged(searched, &controllers(EVERY), kind, left);
    let is_late = judged.late != Lateness::NONE;
    let tried = if is_late { trials(searched, &controllers(1), judged.late) } else { at_once };
    (judged, tried)
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
        assert!(part.run.moves == all.run.moves && part.run.late == all.run.late, "{part:?} {all:?}");
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
