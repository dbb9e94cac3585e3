//! What of a servo's loop is late: its target, on the way there, or its voltage, on the way to the motor.
//!
//! A late target shifts the whole motion. With a late voltage the loop answers to an angle that is as late, and swings the more. That is told where
//! hardly any damping hides it: to first order a damped loop with a late voltage moves the shaft as one with a late target, another gain and less
//! damping does ([`gain_of_late_voltage`]). Where no motion tells them apart the target is taken to be late, and both gains are said.

use super::Controller;
use super::driven::{Lateness, Loop};
use super::trials::{Searched, least, trials};
use crate::log::weak::Regression;

/// Latest that is looked for, half rows.
const MOST_LATE: usize = 12;
/// Something is late where that leaves less than this share of what is left at once ...
const LATE: f64 = 0.7;
/// ... and it is the voltage where that leaves less than this share of what is left at once, and of what any late target leaves.
const VOLTAGE: f64 = 0.6;

/// What is late.
pub(super) struct Judged {
    pub late: Lateness,
    /// Whether the voltage may be late in the place of the target.
    pub either: bool,
}

/// What is late in the loop of the best of `controllers`, which leaves so much `at_once`, beside friction (0) or under a weight (1).
pub(super) fn judged(searched: &Searched, controllers: &[Controller], kind: usize, at_once: f64) -> Judged {
    let best = |late: &dyn Fn(f64) -> Lateness| {
        least_late(|by_s| left(searched, controllers, kind, late(by_s)), searched)
    };
    let late_target = |target_s: f64| Lateness { target_s, ..Lateness::NONE };
    let late_voltage = |voltage_s: f64| Lateness { voltage_s, ..Lateness::NONE };
    let (target, voltage) = (best(&late_target), best(&late_voltage));
    if voltage.left < VOLTAGE * target.left.min(at_once) {
        Judged { late: late_voltage(voltage.by_s), either: false }
    } else if target.left < LATE * at_once {
        Judged { late: late_target(target.by_s), either: VOLTAGE * voltage.left < target.left }
    } else {
        Judged { late: Lateness::NONE, either: false }
    }
}

/// What the best of `controllers` leaves in a loop of which so much is late.
fn left(searched: &Searched, controllers: &[Controller], kind: usize, late: Lateness) -> f64 {
    least(&trials(searched, controllers, late), kind).map_or(f64::INFINITY, |trial| trial.left[kind])
}

/// By how much something is late, and what is left with it.
#[derive(Clone, Copy)]
struct By {
    halves: usize,
    by_s: f64,
    left: f64,
}

/// The lateness, s, for which `left` is least: of whole rows, and of half a row to either side of the best of these.
fn least_late(left: impl Fn(f64) -> f64, searched: &Searched) -> By {
    let by = |halves: usize| {
        let by_s = 0.5 * halves as f64 * searched.interval_s();
        By { halves, by_s, left: left(by_s) }
    };
    let less = |one: By, other: By| if other.left < one.left { other } else { one };
    let whole = (4..=MOST_LATE).step_by(2).map(&by).fold(by(2), less);
    [whole.halves - 1, whole.halves + 1].map(&by).into_iter().fold(whole, less)
}

/// The gain of a controller whose voltage is late by as much as the target of `run` is there, and that drives the `motor` alike to first order: it
/// answers to x(t - T) = x - T w + T^2 w' / 2, and of the motor's equation, tau w' = gain v - w, the part of v adds to its own.
pub(super) fn gain_of_late_voltage(run: Loop, motor: &Regression, supply_v: f64) -> f64 {
    let Controller { gain, damping } = run.controller;
    let (late_s, tau_s) = (run.late.target_s, motor.tau_s);
    let half = 0.5 * late_s * late_s;
    let seconds = (damping / gain + late_s + half / tau_s) / (1.0 + late_s / tau_s);
    gain / (1.0 + supply_v * motor.gain * gain * (seconds * late_s - half) / tau_s)
}

#[cfg(test)]
mod tests {
    use super::super::identify::{Found, find, known};
    use super::super::made::{Between, Made};
    use super::super::told::Told;
    use super::*;

    fn found(made: Made) -> Found {
        find(&[made.record()])
    }

    #[test]
    fn a_voltage_that_acts_late_is_told_with_its_gain_and_by_how_much() {
        for made in [
            Made { dead_s: 0.01, ..Made::default() },
            Made { dead_s: 0.02, ..Made::default() },
            Made { dead_s: 0.04, ..Made::default() },
            Made { dead_s: 0.02, weight_v: 2.0, ..Made::default() },
        ] {
            for noise in [0.0, 2e-3] {
                let found = found(Made { noise, ..made });
                let Loop { controller, late, .. } = found.run;
                assert!(found.told == Told::Gain && late.target_s == 0.0, "{found:?}");
                assert!((late.voltage_s - made.dead_s).abs() < 1e-3, "{found:?} of {} s", made.dead_s);
                assert!((controller.gain / made.gain - 1.0).abs() < 0.03, "{found:?} of {} s", made.dead_s);
            }
        }
    }

    #[test]
    fn a_target_that_arrives_late_is_no_late_voltage() {
        for (damping, rows) in [(0.0, 1), (0.0, 3), (0.1, 2), (0.1, 4)] {
            for noise in [0.0, 1e-3] {
                let made = Made { damping, between: Between::Stands(rows), noise, ..Made::default() };
                let found = found(made);
                let Loop { controller, late, .. } = found.run;
                assert!(found.told == Told::Gain && late.voltage_s == 0.0, "{found:?}");
                assert!((late.target_s - 0.01 * rows as f64).abs() < 1e-2, "{found:?} of {rows} rows");
                assert!((controller.gain / made.gain - 1.0).abs() < 0.1, "{found:?} of {rows} rows");
            }
        }
    }

    #[test]
    fn where_damping_hides_which_of_both_is_late_both_gains_are_said() {
        for noise in [0.0, 1e-3] {
            let made = Made { damping: 0.1, dead_s: 0.02, noise, ..Made::default() };
            let found = found(made);
            assert!(found.run.late.target_s > 0.01, "{found:?}");
            let gain = found.or_gain.unwrap();
            assert!(
                (gain / made.gain - 1.0).abs() < 0.05 && gain < 0.9 * found.run.controller.gain,
                "{found:?}"
            );
        }
        let prompt = found(Made { damping: 0.1, ..Made::default() });
        assert!(prompt.or_gain.is_none() && prompt.run.late == Lateness::NONE, "{prompt:?}");
    }

    #[test]
    fn of_a_known_gain_it_is_told_which_of_both_is_late() {
        for (made, late) in [
            (Made { dead_s: 0.01, ..Made::default() }, Lateness { voltage_s: 0.01, ..Lateness::NONE }),
            (Made { dead_s: 0.03, ..Made::default() }, Lateness { voltage_s: 0.03, ..Lateness::NONE }),
            (
                Made { between: Between::Stands(2), ..Made::default() },
                Lateness { target_s: 0.02, ..Lateness::NONE },
            ),
        ] {
            let controller = Controller { gain: made.gain, damping: made.damping };
            let seen = known(&made.record(), controller).late;
            let off = [seen.target_s - late.target_s, seen.voltage_s - late.voltage_s];
            assert!(off.iter().all(|off| off.abs() < 1e-9), "{seen:?} for {late:?}");
        }
    }
}
