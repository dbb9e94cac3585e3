//! What is said of a servo's loop that is not logged: what the motion tells of its controller, what is assumed, and how late its target arrives.

use super::Controller;
use super::driven::Lateness;
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
            "the motion does not tell it: no loop of a gain and a damping follows it, under a weight, with a late target or voltage, or as a relay \
             either; {gain:.3} duty per rad and {damping:.3} duty per rad/s are assumed, and what is found of the motor may be wrong with them"
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

/// What is said of a loop of which something is late, whose gain may be another with a voltage that is; none where nothing is.
pub(super) fn late(record: &Record, late: Lateness, or_gain: Option<f64>) -> Option<Warning> {
    // To a tenth of a row.
    let rows = |late_s: f64| (10.0 * late_s / median_interval(&record.time_s)).round() / 10.0;
    let Lateness { target_s, voltage_s } = late;
    let (what, fix) = if target_s > 0.0 {
        let or = or_gain.map_or_else(String::new, |gain| {
            format!("; a gain of {gain:.3} duty per rad with a voltage that acts as late would turn it alike")
        });
        let (rows, ms) = (rows(target_s), 1e3 * target_s);
        let what = format!(
            "late_target: the shaft answers to its target {rows} rows ({ms:.0} ms) after the row that has it, and is taken to be driven so{or}"
        );
        let otherwise = "otherwise log target and position of one instant in one row";
        let known = if or_gain.is_some() {
            "; --servo-gain, where it is known, tells which of both is late"
        } else {
            ""
        };
        (what, format!("nothing, if the way to the servo takes that long; {otherwise}{known}"))
    } else if voltage_s > 0.0 {
        let (rows, ms) = (rows(voltage_s), 1e3 * voltage_s);
        let what = format!(
            "late_voltage: the voltage of the servo's loop acts {rows} rows ({ms:.0} ms) after target and angle ask for it; what is fitted is the \
             voltage that they ask for"
        );
        (what, "see whether a delay or a lag explains it: motorlens discover, or add the effect delay".into())
    } else {
        return None;
    };
    Some(Warning { place: place(record), what, fix })
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

    #[test]
    fn what_is_late_is_told_with_the_gain_that_explains_it_as_well() {
        let record = Record { time_s: (0..10).map(|k| 0.01 * f64::from(k)).collect(), ..Record::default() };
        let said = |target_s: f64, voltage_s: f64, or_gain: Option<f64>| {
            late(&record, Lateness { target_s, voltage_s }, or_gain)
        };
        assert_eq!(said(0.0, 0.0, None), None);
        let target = said(0.0301, 0.0, None).unwrap();
        assert!(
            target.what.starts_with("late_target") && target.what.contains("3 rows (30 ms)"),
            "{target:?}"
        );
        assert!(!target.what.contains("gain") && !target.fix.contains("--servo-gain"), "{target:?}");
        let either = said(0.0149, 0.0, Some(2.07)).unwrap();
        assert!(either.what.contains("1.5 rows (15 ms)") && either.what.contains("2.070 duty"), "{either:?}");
        assert!(either.fix.contains("--servo-gain"), "{either:?}");
        let voltage = said(0.0, 0.02, None).unwrap();
        assert!(
            voltage.what.starts_with("late_voltage") && voltage.what.contains("2 rows (20 ms)"),
            "{voltage:?}"
        );
        assert!(voltage.fix.contains("delay"), "{voltage:?}");
    }
}
