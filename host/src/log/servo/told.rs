//! What is said of a servo's loop that is not logged: what the motion tells of its controller, what is assumed, and how late its target arrives.

use super::Controller;
use crate::log::timing::median_interval;
use crate::log::{Record, Warning};

/// What of a controller the motion tells.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Told {
    Gain,
    /// A gain at the end of those that are tried, or beyond it.
    Relay,
    /// The product of its gain and the motor's.
    NeverFull,
    /// Nothing: no loop follows it.
    Nothing,
}

/// What is said of a `controller` that was not logged.
pub(super) fn told_or_assumed(
    record: &Record,
    Controller { gain, damping }: Controller,
    told: Told,
) -> Warning {
    let what = match told {
        Told::Gain => format!(
            "the motion tells a gain of {gain:.3} duty per rad and a damping of {damping:.3} duty per rad/s"
        ),
        Told::Relay => format!(
            "the motion tells a relay, full duty by the sign of the error (a gain of {gain:.0} duty per rad and a damping of {damping:.3} duty \
             per rad/s stand for it)"
        ),
        Told::NeverFull => format!(
            "it is never at full duty, so that its gain cannot be told from the motor's: {gain:.3} duty per rad is assumed, and only the \
             product of both gains is right"
        ),
        Told::Nothing => format!(
            "the motion does not tell it: no loop of a gain and a damping follows it, under a weight, with a late target or as a relay either; \
             {gain:.3} duty per rad and {damping:.3} duty per rad/s are assumed, and what is found of the motor may be wrong with them"
        ),
    };
    Warning {
        place: place(record),
        what: format!("servo_gain: the controller is not logged; {what}"),
        fix: "give what is known: --servo-gain DUTY_PER_RAD, --servo-damping DUTY_PER_RAD_S, and the supply (--supply-volts or --map supply=...); \
              or log the duty (--map duty=...); large steps of the target saturate the controller and tell its gain"
            .into(),
    }
}

/// What is said of a target that arrives so many seconds late.
pub(super) fn late_target(record: &Record, late_s: f64) -> Warning {
    // To a tenth of a row.
    let rows = (10.0 * late_s / median_interval(&record.time_s)).round() / 10.0;
    let ms = 1e3 * late_s;
    Warning {
        place: place(record),
        what: format!(
            "late_target: the shaft answers to its target {rows} rows ({ms:.0} ms) after the row that has it, and is taken to be driven so"
        ),
        fix: "nothing, if the way to the servo takes that long; otherwise log target and position of one instant in one row".into(),
    }
}

fn place(record: &Record) -> String {
    format!("{}, column target", record.path.display())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_gain_or_a_relay_is_told_and_all_else_is_assumed() {
        let controller = Controller { gain: 150.0, damping: 0.0 };
        for told in [Told::Gain, Told::Relay, Told::NeverFull, Told::Nothing] {
            let said = told_or_assumed(&Record::default(), controller, told);
            let tells = matches!(told, Told::Gain | Told::Relay);
            assert_eq!(said.what.contains("the motion tells"), tells, "{}", said.what);
            assert_eq!(said.what.contains("assumed"), !tells, "{}", said.what);
            assert_eq!(said.what.contains("a relay, full duty"), told == Told::Relay, "{}", said.what);
            assert!(
                said.fix.contains("--servo-gain") && said.fix.contains("--servo-damping"),
                "{}",
                said.fix
            );
        }
    }
}
