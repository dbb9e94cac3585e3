//! Step 2, Where it fails: the residual torque from every side, the one that accounts for most first.

use super::figure::{Axis, Curve, Draw, Figure, Numbers, Panel, in_words};
use super::story::{Shown, Torques};
use crate::compare::free_run::FreeRun;
use crate::compare::residual_torque::ResidualTorque;
use crate::compare::residual_views::{
    Binned, around_reversals, autocorrelation, by_angle, by_speed, by_voltage, orders,
};

/// Height of a figure of this step, CSS pixels.
const HEIGHT: u32 = 240;
/// What is said in the place of an empty figure.
const TOO_LITTLE: &str = "These records are too short, or stay too close to one value, to see anything here.";

/// A side from which the residual torque is seen.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// By speed and direction.
    Speed,
    /// By voltage.
    Voltage,
    /// By angle of the output shaft.
    OutputAngle,
    /// By angle of the motor shaft.
    MotorAngle,
    /// Around reversals.
    Reversal,
}

impl Side {
    /// Every side, in the order of the page.
    pub const ALL: [Self; 5] =
        [Self::Speed, Self::OutputAngle, Self::MotorAngle, Self::Reversal, Self::Voltage];

    fn id(self) -> &'static str {
        match self {
            Self::Speed => "by-speed",
            Self::Voltage => "by-voltage",
            Self::OutputAngle => "by-output-angle",
            Self::MotorAngle => "by-motor-angle",
            Self::Reversal => "around-reversals",
        }
    }

    fn title(self) -> &'static str {
        match self {
            Self::Speed => "By speed and direction",
            Self::Voltage => "By voltage",
            Self::OutputAngle => "By angle of the output shaft",
            Self::MotorAngle => "By angle of the motor shaft",
            Self::Reversal => "Around reversals",
        }
    }

    fn axis(self) -> &'static str {
        match self {
            Self::Speed => "Speed (rad/s)",
            Self::Voltage => "Voltage (V)",
            Self::OutputAngle => "Angle of the output shaft (deg)",
            Self::MotorAngle => "Angle of the motor (deg)",
            Self::Reversal => "Time since the reversal (s)",
        }
    }

    /// Residual torque in bins along this side.
    pub fn binned(self, torques: &Torques, gear_ratio: f64) -> Binned {
        let seen = match self {
            Self::Speed => by_speed(&torques.records),
            Self::Voltage => by_voltage(&torques.records),
            Self::OutputAngle => by_angle(&torques.records, 1.0),
            Self::MotorAngle => by_angle(&torques.records, gear_ratio),
            Self::Reversal => around_reversals(&torques.records),
        };
        // One bin depends on nothing.
        if seen.at.len() > 1 { seen } else { Binned::default() }
    }

    /// What the bins of the model say, in one line.
    fn reading(self, base: &Binned, seen: &Binned) -> String {
        if seen.at.is_empty() {
            return TOO_LITTLE.into();
        }
        let share = 100.0 * seen.explained;
        let (before, after) = (swing(base), swing(seen));
        let span = in_words(after, "V");
        let depends = match self {
            Self::Speed => "speed and direction",
            Self::Voltage => "the voltage",
            Self::OutputAngle => "the output's angle",
            Self::MotorAngle => "the motor's angle",
            Self::Reversal => "the time since a reversal",
        };
        let verdict = match share {
            _ if after < 0.1 * before => "the effects in the model explain it".to_owned(),
            s if s >= 30.0 => format!("{s:.0} % of its variance follows {depends}: it fails here"),
            s if s >= 8.0 => format!("{s:.0} % of its variance follows {depends}"),
            s => format!("hardly any of its variance ({s:.0} %) follows {depends}"),
        };
        let step = if self == Self::Speed { step_in_words(seen) } else { String::new() };
        format!(
            "The residual torque swings by {span} along this axis ({} with the base model); {verdict}.{step}",
            in_words(before, "V")
        )
    }
}

/// From the lowest to the highest mean, V.
fn swing(seen: &Binned) -> f64 {
    let high = seen.mean_v.iter().copied().fold(f64::MIN, f64::max);
    let low = seen.mean_v.iter().copied().fold(f64::MAX, f64::min);
    (high - low).max(0.0)
}

/// The jump at zero speed, where it is larger than what the residual torque does elsewhere.
fn step_in_words(seen: &Binned) -> String {
    // A bin far from rest says nothing of what happens there.
    let slow = 0.15 * seen.at.iter().fold(0.0, |most: f64, w| most.max(w.abs()));
    let beside = |sign: f64| {
        let near = seen.at.iter().zip(&seen.mean_v).filter(|(w, _)| **w * sign > 0.0 && w.abs() < slow);
        near.min_by(|a, b| a.0.abs().total_cmp(&b.0.abs())).map(|(_, f)| *f)
    };
    match (beside(1.0), beside(-1.0)) {
        (Some(forward), Some(backward))
            if (backward - forward).abs() > 0.4 * swing(seen) && seen.explained > 0.3 =>
        {
            format!(" It jumps by {} at zero speed, as dry friction does.", in_words(forward - backward, "V"))
        }
        _ => String::new(),
    }
}

/// A view of the residual torque: base model and model over one axis, with the spread of the model.
pub fn view(side: Side, id: &str, base: &Binned, model: &Binned, names: [&str; 2]) -> Figure {
    let x = match side {
        Side::OutputAngle | Side::MotorAngle => Axis::of_angles(side.axis(), &model.at),
        _ => Axis::titled(side.axis()),
    };
    let curve = |role, name: &str, on, seen: &Binned| Curve {
        draw: Draw::Dotted,
        ..Curve::line(role, name, on, Numbers::new(seen.mean_v.iter().copied(), 4))
    };
    let spread = Some(Numbers::new(model.spread_v.iter().copied(), 3));
    let curves =
        vec![curve("base", names[0], 0, base), Curve { spread, ..curve("model", names[1], 1, model) }];
    Figure {
        first: None,
        share_percent: (!model.at.is_empty()).then(|| (100.0 * model.explained).round()),
        id: id.into(),
        title: side.title().into(),
        reading: side.reading(base, model),
        x,
        columns: [base, model].map(|seen| Numbers::new(seen.at.iter().copied(), 5)).into(),
        panels: vec![panel("Residual torque (V)", curves)],
    }
}

fn panel(title: &str, curves: Vec<Curve>) -> Panel {
    Panel { y: Axis::titled(title), height: HEIGHT, curves, floor: None }
}

/// Why nothing is seen around reversals of `records`.
fn no_reversals(records: &[ResidualTorque]) -> &'static str {
    let turns_back = |r: &ResidualTorque| {
        let goes = |sign: f64| r.speed_rad_s.iter().any(|speed| speed * sign > 0.0);
        goes(1.0) && goes(-1.0)
    };
    if records.iter().any(turns_back) {
        "The shaft turns back too seldom in these records, or hardly moves then, so nothing is seen here."
    } else {
        "The shaft never turns back in these records, so nothing is seen here."
    }
}

/// Every figure of the step, of records with the residual torques of base model and model.
pub fn figures(records: &[&Shown], torques: [&Torques; 2], gear_ratio: f64) -> Vec<Figure> {
    let against = records.first().map_or("base model", |shown| shown.against.as_str());
    let geared = (gear_ratio - 1.0).abs() > 1e-6;
    let mut all: Vec<Figure> = Side::ALL
        .into_iter()
        .filter(|side| geared || *side != Side::MotorAngle)
        .map(|side| {
            let [base, model] = torques.map(|t| side.binned(t, gear_ratio));
            let figure = view(side, side.id(), &base, &model, [against, "model"]);
            if side == Side::Reversal && model.at.is_empty() {
                return Figure { reading: no_reversals(&torques[1].records).into(), ..figure };
            }
            figure
        })
        .collect();
    // The side that accounts for most comes first.
    let share = |figure: &Figure| figure.share_percent.unwrap_or(-1.0);
    all.sort_by(|a, b| share(b).total_cmp(&share(a)));
    all.push(memory(records, against));
    all.push(harmonics(torques, gear_ratio, against));
    // Words without a plot would leave a gap beside one.
    all.sort_by_key(Figure::is_empty);
    all
}

/// Curves of base model and model, each on its own column.
fn both(base: &[f64], model: &[f64], against: &str) -> Vec<Curve> {
    let curve =
        |role, name, on, seen: &[f64]| Curve::line(role, name, on, Numbers::new(seen.iter().copied(), 3));
    vec![curve("base", against, 0, base), curve("model", "model", 1, model)]
}

/// Autocorrelation of the error with its bounds.
fn memory(records: &[&Shown], against: &str) -> Figure {
    let of =
        |pick: fn(&Shown) -> &FreeRun| autocorrelation(&records.iter().map(|r| pick(r)).collect::<Vec<_>>());
    let (base, model) = (of(|r| &r.base), of(|r| &r.model));
    let outside = model.correlation.iter().filter(|c| c.abs() > model.bound).count();
    let share = 100 * outside / model.correlation.len().max(1);
    let reading = if model.correlation.is_empty() {
        TOO_LITTLE.to_owned()
    } else if share > 5 {
        format!(
            "{share} % of the lags leave the 99 % bounds: the error is correlated in time, so it is not only noise."
        )
    } else {
        format!("{share} % of the lags leave the 99 % bounds: what is left looks like noise.")
    };
    let curves = both(&base.correlation, &model.correlation, against);
    let plain = panel("Autocorrelation (1)", curves);
    let y = Axis { range: Some([-1.05, 1.05]), ..plain.y };
    Figure {
        share_percent: None,
        first: None,
        id: "autocorrelation".into(),
        title: "Autocorrelation of the error".into(),
        reading,
        x: Axis::titled("Lag (s)"),
        columns: [&base, &model].map(|a| Numbers::new(a.lag_s.iter().copied(), 4)).into(),
        panels: vec![Panel { y, floor: Some([-model.bound, model.bound]), ..plain }],
    }
}

/// Amplitudes by order of the motor's turn.
fn harmonics(torques: [&Torques; 2], gear_ratio: f64, against: &str) -> Figure {
    let [base, model] = torques.map(|t| orders(&t.records, gear_ratio));
    let best = (0..model.order.len()).max_by(|a, b| model.amplitude_v[*a].total_cmp(&model.amplitude_v[*b]));
    let reading = best.map_or_else(
        || "The motor turns too little in these records for it.".into(),
        |k| {
            let mut sorted = model.amplitude_v.clone();
            sorted.sort_by(f64::total_cmp);
            let (top, usual) = (model.amplitude_v[k], sorted[sorted.len() / 2].max(1e-12));
            let place = format!("{} cycles per motor turn ({})", model.order[k], in_words(top, "V"));
            if top > 6.0 * usual {
                format!("It repeats at {place}, {:.0} times the usual amplitude.", top / usual)
            } else {
                format!("No order is much larger than the others; the largest is {place}.")
            }
        },
    );
    let curves = both(&base.amplitude_v, &model.amplitude_v, against);
    Figure {
        share_percent: None,
        first: None,
        id: "harmonics".into(),
        title: "Harmonics of the motor's turn".into(),
        reading,
        x: Axis::titled("Order (cycles per turn of the motor)"),
        columns: [&base, &model].map(|s| Numbers::new(s.order.iter().copied(), 5)).into(),
        panels: vec![panel("Amplitude (V)", curves)],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn binned(at: &[f64], mean_v: &[f64], explained: f64) -> Binned {
        Binned { at: at.into(), mean_v: mean_v.into(), spread_v: vec![0.01; at.len()], explained }
    }

    #[test]
    fn the_share_of_a_side_is_that_of_its_bins() {
        let seen = binned(&[-1.0, 1.0], &[0.3, -0.3], 0.634);
        assert_eq!(view(Side::Speed, "s", &seen, &seen, ["base model", "model"]).share_percent, Some(63.0));
        let nothing = binned(&[], &[], 0.0);
        assert!(Side::Voltage.reading(&nothing, &nothing).contains("too short"));
        assert_eq!(view(Side::Speed, "s", &seen, &nothing, ["base model", "model"]).share_percent, None);
    }

    #[test]
    fn only_records_whose_speed_keeps_its_sign_are_said_never_to_turn_back() {
        let of = |speeds: &[f64]| ResidualTorque { speed_rad_s: speeds.into(), ..ResidualTorque::default() };
        assert!(no_reversals(&[of(&[0.0, 3.0, 2.0])]).contains("never turns back"));
        assert!(no_reversals(&[of(&[0.0, 3.0, -0.01])]).contains("too seldom"));
        // Two records of opposite directions have no reversal either.
        assert!(no_reversals(&[of(&[3.0]), of(&[-3.0])]).contains("never turns back"));
    }

    #[test]
    fn a_jump_is_read_between_bins_beside_rest_only() {
        let near = binned(&[-9.0, -1.0, 1.0, 9.0], &[0.4, 0.4, -0.4, -0.4], 0.9);
        assert!(Side::Speed.reading(&near, &near).contains("jumps by"));
        let far = binned(&[-0.5, 6.0, 9.0], &[0.4, -0.4, -0.4], 0.9);
        assert!(!Side::Speed.reading(&far, &far).contains("jumps by"));
    }
}
