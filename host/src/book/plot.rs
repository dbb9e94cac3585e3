//! What an effect does, as SVG: the speed with and without it, the difference, and its equation as page and report draw it.

use motorlens_shared::effects::Kind;
use plotters::coord::Shift;
use plotters::prelude::*;

use super::motion::{Motion, motion};
use crate::compare::free_run::FreeRun;
use crate::error::{Error, Result};
use crate::report::evidence;
use crate::report::figure::Figure;

const SIZE: (u32, u32) = (720, 660);
const WITH: RGBColor = RGBColor(0, 114, 178);
const WITHOUT: RGBColor = RGBColor(213, 94, 0);
const MEASURED: RGBColor = RGBColor(110, 110, 110);
/// A point every so many seconds is as fine as the picture.
const EVERY_S: f64 = 0.03;

type Points = Vec<(f64, f64)>;
type Area<'a> = DrawingArea<SVGBackend<'a>, Shift>;
type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

/// The picture of `kind`.
///
/// # Errors
/// A drawing that the backend refuses.
pub fn plot(kind: Kind) -> Result<String> {
    let motion = motion(kind)?;
    let figures = evidence::figures(kind, &motion.values, &motion.rig, [&motion.with, &motion.without]);
    let mut text = String::new();
    draw(&mut text, kind, &motion, figures.first()).map_err(|error| Error::Io {
        doing: format!("cannot draw {kind}"),
        source: std::io::Error::other(error.to_string()),
    })?;
    Ok(text)
}

fn draw(text: &mut String, kind: Kind, motion: &Motion, figure: Option<&Figure>) -> Drawn {
    let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let panels = area.split_evenly((3, 1));
    let (with, without) = (speed(&motion.with), speed(&motion.without));
    let less: Points = with.iter().zip(&without).map(|(a, b)| (a.0, a.1 - b.1)).collect();
    let speeds = [(WITHOUT, without, false), (WITH, with, false)];
    panel(&panels[0], &format!("Speed (rad/s): with {kind} blue, without orange"), "Time (s)", &speeds)?;
    panel(&panels[1], "Difference of the speeds (rad/s)", "Time (s)", &[(WITH, less, false)])?;
    let Some((figure, lower)) = figure.and_then(|figure| Some((figure, figure.panels.first()?))) else {
        return Ok(area.present()?);
    };
    let curve = |k: usize| {
        let curve = &lower.curves[k];
        figure.columns[curve.on].values().iter().copied().zip(curve.y.values().iter().copied()).collect()
    };
    let title = format!("{}: dots measured, line {}", lower.y.title, lower.curves[1].name);
    panel(&panels[2], &title, &figure.x.title, &[(MEASURED, curve(0), true), (WITH, curve(1), false)])?;
    Ok(area.present()?)
}

/// Curves over one axis, as lines or as dots, with a margin around them.
fn panel(area: &Area, title: &str, x: &str, curves: &[(RGBColor, Points, bool)]) -> Drawn {
    let all = || curves.iter().flat_map(|curve| &curve.1);
    let mut chart = ChartBuilder::on(area)
        .caption(title, ("sans-serif", 15))
        .margin(6)
        .margin_right(20)
        .x_label_area_size(36)
        .y_label_area_size(52)
        .build_cartesian_2d(range(all().map(|p| p.0), 0.01), range(all().map(|p| p.1), 0.08))?;
    chart.configure_mesh().max_light_lines(1).x_desc(x).y_labels(5).x_labels(7).draw()?;
    for (colour, points, dots) in curves {
        if *dots {
            chart.draw_series(points.iter().map(|p| Circle::new(*p, 2, colour.filled())))?;
        } else {
            chart.draw_series(LineSeries::new(points.iter().copied(), colour.stroke_width(1)))?;
        }
    }
    Ok(())
}

/// The speed that the simulated reading shows, from its differences.
fn speed(runs: &[FreeRun]) -> Points {
    let Some(run) = runs.first() else { return Vec::new() };
    let (t, x) = (&run.time_s, &run.simulated);
    let every = (EVERY_S * (t.len() - 1) as f64 / (t[t.len() - 1] - t[0])).round().max(1.0) as usize;
    (every..t.len())
        .step_by(every)
        .map(|k| (0.5 * (t[k] + t[k - every]), (x[k] - x[k - every]) / (t[k] - t[k - every])))
        .collect()
}

/// From the smallest to the largest value, a `share` further on both sides.
fn range(values: impl Iterator<Item = f64>, share: f64) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    let margin = (share * (high - low)).max(1e-6);
    low - margin..high + margin
}
