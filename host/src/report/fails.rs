//! Step 2, Where it fails: the residual torque from every side, before and after.

use serde_json::{Value, json};

use super::figure::{Figure, axes, in_words, line, numbers, with};
use super::story::{Shown, Story, Torques};
use crate::compare::residual_views::{
    Binned, around_reversals, autocorrelation, by_angle, by_speed, by_voltage, orders,
};

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
            Self::OutputAngle => "Angle within a turn of the output shaft (deg)",
            Self::MotorAngle => "Angle within a turn of the motor (deg)",
            Self::Reversal => "Time since the reversal (s)",
        }
    }

    /// Residual torque in bins along this side.
    pub fn binned(self, torques: &Torques, gear_ratio: f64) -> Binned {
        match self {
            Self::Speed => by_speed(&torques.records),
            Self::Voltage => by_voltage(&torques.records),
            Self::OutputAngle => by_angle(&torques.records, 1.0),
            Self::MotorAngle => by_angle(&torques.records, gear_ratio),
            Self::Reversal => around_reversals(&torques.records),
        }
    }

    /// What the bins of the model say, in one line.
    fn reading(self, base: &Binned, seen: &Binned) -> String {
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
            _ if after < 0.1 * before => "the effects in the model have taken it away".to_owned(),
            s if s >= 30.0 => format!("this is where it fails: {depends} accounts for {s:.0} % of it"),
            s if s >= 8.0 => format!("{depends} accounts for {s:.0} % of it"),
            s => format!("hardly any of it ({s:.0} %) follows {depends}"),
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

/// The jump at zero speed, where it stands out.
fn step_in_words(seen: &Binned) -> String {
    let beside = |sign: f64| {
        let near = seen.at.iter().zip(&seen.mean_v).filter(|(w, _)| **w * sign > 0.0);
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
    let mut layout = axes(side.axis(), "Residual torque (V)");
    if matches!(side, Side::OutputAngle | Side::MotorAngle) {
        layout["xaxis"]["range"] = json!([0, 360]);
        layout["xaxis"]["dtick"] = json!(60);
    }
    let curve = |role: &str, name: &str, seen: &Binned| {
        let trace =
            line(role, name, numbers(seen.at.iter().copied(), 5), numbers(seen.mean_v.iter().copied(), 4));
        with(trace, json!({ "mode": "lines+markers" }))
    };
    let edge = |sign: f64| {
        let y = model.mean_v.iter().zip(&model.spread_v).map(|(m, s)| m + sign * s);
        let more = json!({ "line": { "width": 0 }, "showlegend": false, "hoverinfo": "skip" });
        with(line("model", "spread", numbers(model.at.iter().copied(), 5), numbers(y, 4)), more)
    };
    let upper = with(edge(1.0), json!({ "fill": "tonexty" }));
    Figure {
        id: id.into(),
        title: side.title().into(),
        reading: side.reading(base, model),
        data: vec![edge(-1.0), upper, curve("base", names[0], base), curve("model", names[1], model)],
        layout,
        height: 320,
    }
}

/// Every figure of the step.
pub fn figures(story: &Story) -> Vec<Figure> {
    let gear = story.model.rig.gear_ratio;
    let geared = (gear - 1.0).abs() > 1e-6;
    let mut all: Vec<Figure> = Side::ALL
        .into_iter()
        .filter(|side| geared || *side != Side::MotorAngle)
        .map(|side| {
            let (base, model) =
                (side.binned(&story.base_torques, gear), side.binned(&story.model_torques, gear));
            view(side, side.id(), &base, &model, ["base model", "model"])
        })
        .collect();
    all.push(memory(&story.records));
    all.push(harmonics(story));
    all
}

/// Autocorrelation of the error with its bounds.
fn memory(records: &[Shown]) -> Figure {
    let of = |pick: fn(&Shown) -> &crate::compare::free_run::FreeRun| {
        autocorrelation(&records.iter().map(pick).collect::<Vec<_>>())
    };
    let (base, model) = (of(|r| &r.base), of(|r| &r.model));
    let curve = |role: &str, name: &str, a: &crate::compare::residual_views::Autocorrelation| {
        line(role, name, numbers(a.lag_s.iter().copied(), 4), numbers(a.correlation.iter().copied(), 3))
    };
    let outside = model.correlation.iter().filter(|c| c.abs() > model.bound).count();
    let share = 100 * outside / model.correlation.len().max(1);
    let reading = if share > 5 {
        format!(
            "{share} % of the lags leave the 99 % bounds: the error has a memory, so it is not only noise."
        )
    } else {
        format!("{share} % of the lags leave the 99 % bounds: what is left looks like noise.")
    };
    let mut layout = axes("Lag (s)", "Autocorrelation of the error (1)");
    layout["yaxis"]["range"] = json!([-1.05, 1.05]);
    layout["shapes"] = json!([{ "type": "rect", "xref": "paper", "x0": 0, "x1": 1, "y0": -model.bound,
        "y1": model.bound, "role": "floor" }]);
    Figure {
        id: "autocorrelation".into(),
        title: "Memory of the error".into(),
        reading,
        data: vec![curve("base", "base model", &base), curve("model", "model", &model)],
        layout,
        height: 320,
    }
}

/// Amplitudes by order of the motor's turn.
fn harmonics(story: &Story) -> Figure {
    let gear = story.model.rig.gear_ratio;
    let (base, model) =
        (orders(&story.base_torques.records, gear), orders(&story.model_torques.records, gear));
    let best = (0..model.order.len()).max_by(|a, b| model.amplitude_v[*a].total_cmp(&model.amplitude_v[*b]));
    let reading = best.map_or_else(String::new, |k| {
        let mut sorted = model.amplitude_v.clone();
        sorted.sort_by(f64::total_cmp);
        let (top, usual) = (model.amplitude_v[k], sorted[sorted.len() / 2].max(1e-12));
        let place = format!("{} cycles per motor turn ({})", model.order[k], in_words(top, "V"));
        if top > 6.0 * usual {
            format!("It repeats at {place}, {:.0} times the usual amplitude.", top / usual)
        } else {
            format!("No order stands out; the largest is {place}.")
        }
    });
    let bars = |role: &str, name: &str, s: &crate::compare::residual_views::Spectrum| -> Value {
        line(role, name, numbers(s.order.iter().copied(), 5), numbers(s.amplitude_v.iter().copied(), 3))
    };
    let mut layout = axes("Order (cycles per turn of the motor)", "Amplitude (V)");
    layout["yaxis"]["rangemode"] = json!("tozero");
    Figure {
        id: "harmonics".into(),
        title: "Harmonics of the motor's turn".into(),
        reading,
        data: vec![bars("base", "base model", &base), bars("model", "model", &model)],
        layout,
        height: 320,
    }
}
