//! Step 1, Compare: measurement and model over time, one figure a record.

use serde_json::{Value, json};

use super::decimate::keep;
use super::figure::{Figure, line, numbers, with};
use super::story::Shown;
use crate::compare::residual_torque::ResidualTorque;
use crate::fit::grid::Quantity;

/// Points of a curve; a wide screen has about twice as many columns.
const POINTS: usize = 1200;

/// A window of time, s.
pub type Window = (f64, f64);

/// The figure of one record: measured and simulated, speeds, residual and voltage on one time axis.
///
/// `torques` hold the smoothed speeds of the base model's and of the model's comparison.
pub fn figure(
    id: &str,
    shown: &Shown,
    torques: [&ResidualTorque; 2],
    floor: f64,
    window: Option<Window>,
) -> Figure {
    let points = POINTS;
    let run = &shown.model;
    let unit = run.quantity.unit();
    let of_angle = run.quantity == Quantity::Angle;
    let residual = |r: &crate::compare::free_run::FreeRun| {
        r.measured.iter().zip(&r.simulated).map(|(y, p)| y - p).collect::<Vec<f64>>()
    };
    let (left, base_left) = (residual(run), residual(&shown.base));
    let (from, to) = places_within(&run.time_s, window);
    let kept = keep(&[&run.measured, &run.simulated, &left, &run.voltage_v], from, to, points);
    let pick = |column: &[f64], digits| numbers(kept.iter().map(|k| column[*k]), digits);
    let time = pick(&run.time_s, 7);
    let trace = |role: &str, name: &str, column: &[f64], row: usize| {
        let more = json!({ "yaxis": axis_name(row), "legendgroup": role, "showlegend": row == 0 });
        with(line(role, name, time.clone(), pick(column, 6)), more)
    };
    let rows = if of_angle { 4 } else { 3 };
    let residual_row = rows - 2;
    let mut data = vec![
        trace("measured", "measured", &run.measured, 0),
        trace("base", "base model", &shown.base.simulated, 0),
        slid("run", trace("model", "model", &run.simulated, 0)),
    ];
    if of_angle {
        data.extend(speeds(torques, window, points));
    }
    data.push(trace("base", "base model", &base_left, residual_row));
    data.push(slid("left", trace("model", "model", &left, residual_row)));
    let volts = trace("voltage", "voltage", &run.voltage_v, rows - 1);
    data.push(with(volts, json!({ "line": { "shape": "hv" }, "showlegend": false })));
    let main = if of_angle { "Angle" } else { "Speed" };
    let mut titles = vec![format!("{main} ({unit})")];
    if of_angle {
        titles.push("Speed (rad/s)".into());
    }
    titles.extend([format!("Residual ({unit})"), "Voltage (V)".into()]);
    let rmse = run.measures().rmse;
    let base_rmse = shown.base.measures().rmse;
    let reading = format!(
        "{}: error {} rms with the model, {} with the base model; the noise floor is {}.",
        if shown.unseen { "Unseen record" } else { "Training record" },
        super::figure::in_words(rmse, unit),
        super::figure::in_words(base_rmse, unit),
        super::figure::in_words(floor, unit),
    );
    let band = json!({ "type": "rect", "xref": "paper", "x0": 0, "x1": 1, "yref": axis_name(residual_row),
        "y0": -2.0 * floor, "y1": 2.0 * floor, "role": "floor" });
    let mut layout = stacked(&titles, &[3.0, 2.0, 2.0, 1.0][..rows]);
    layout["shapes"] = json!([band]);
    Figure {
        id: id.into(),
        title: format!("{} ({})", run.record, if shown.unseen { "unseen" } else { "training" }),
        reading,
        data,
        layout,
        height: 150 * rows as u32 + 60,
    }
}

/// Names a trace for the sliders of the live page, which replace its points.
fn slid(name: &str, mut trace: Value) -> Value {
    trace["meta"]["slide"] = name.into();
    trace
}

/// The smoothed speeds, on the second row.
fn speeds(torques: [&ResidualTorque; 2], window: Option<Window>, points: usize) -> Vec<Value> {
    let [base, model] = torques;
    let (from, to) = places_within(&model.time_s, window);
    let kept = keep(&[&model.speed_rad_s, &model.simulated_speed_rad_s], from, to, points);
    let pick = |column: &[f64], digits| numbers(kept.iter().filter_map(|k| column.get(*k).copied()), digits);
    let trace = |role: &str, name: &str, column: &[f64]| {
        let curve = line(role, name, pick(&model.time_s, 7), pick(column, 5));
        with(curve, json!({ "yaxis": axis_name(1), "legendgroup": role, "showlegend": false }))
    };
    vec![
        trace("measured", "measured", &model.speed_rad_s),
        trace("base", "base model", &base.simulated_speed_rad_s),
        slid("speed", trace("model", "model", &model.simulated_speed_rad_s)),
    ]
}

/// Places of the samples within `window`, and one beside each end.
fn places_within(time_s: &[f64], window: Option<Window>) -> (usize, usize) {
    let Some((low, high)) = window else { return (0, time_s.len()) };
    let from = time_s.partition_point(|t| *t < low).saturating_sub(1);
    let to = (time_s.partition_point(|t| *t <= high) + 1).min(time_s.len());
    (from.min(to), to)
}

fn axis_name(row: usize) -> String {
    if row == 0 { "y".into() } else { format!("y{}", row + 1) }
}

/// Rows over one time axis, with these titles and shares of the height.
fn stacked(titles: &[String], shares: &[f64]) -> Value {
    let whole: f64 = shares.iter().sum();
    let gap = 0.05;
    let mut layout = json!({
        "xaxis": { "title": { "text": "Time (s)" }, "anchor": axis_name(titles.len() - 1) },
        "hovermode": "x", "hoversubplots": "axis",
        "legend": { "orientation": "h", "y": 1.02, "yanchor": "bottom", "x": 0 },
    });
    let mut top = 1.0;
    for (row, (title, share)) in titles.iter().zip(shares).enumerate() {
        let height = (1.0 - gap * (titles.len() - 1) as f64) * share / whole;
        let name = if row == 0 { "yaxis".into() } else { format!("yaxis{}", row + 1) };
        let bottom: f64 = top - height;
        layout[name] = json!({ "title": { "text": title }, "domain": [bottom.max(0.0), top] });
        top = bottom - gap;
    }
    layout
}
