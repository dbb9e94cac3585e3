//! The position's profile and how each trial followed it, and the steps, as SVG.

use std::ops::Range;

use plotters::coord::Shift;
use plotters::coord::types::RangedCoordf64;
use plotters::prelude::*;

use super::{Step, Tuned};

type Failed = Box<dyn std::error::Error>;
type Panel<'svg> = DrawingArea<SVGBackend<'svg>, Shift>;
type Chart<'chart, 'svg> =
    ChartContext<'chart, SVGBackend<'svg>, Cartesian2d<RangedCoordf64, RangedCoordf64>>;

/// Four panels: the profile with each trial, the errors of all, and a step of the position and of the velocity.
///
/// # Errors
/// A drawing that the backend refuses.
pub fn plot(tuned: &Tuned) -> Result<String, Failed> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (900, 960)).into_drawing_area();
        area.fill(&WHITE)?;
        let panels = area.split_evenly((3, 1));
        let Some(first) = tuned.trials.first() else { return Ok(String::new()) };
        let end = first.course.time_s.last().copied().unwrap_or(1.0);
        let wanted: Vec<(f64, f64)> =
            first.course.time_s.iter().copied().zip(first.course.wanted.iter().copied()).collect();
        let top = wanted.iter().fold(0.0_f64, |m, p| m.max(p.1.abs())) * 1.1 + 1e-9;

        let mut upper = chart(&panels[0], "position / rad", end, -0.1 * top..top)?;
        upper
            .draw_series(LineSeries::new(wanted, BLACK))?
            .label("wanted")
            .legend(|(x, y)| PathElement::new([(x, y), (x + 18, y)], BLACK));
        let errors: Vec<Vec<(f64, f64)>> = tuned
            .trials
            .iter()
            .map(|trial| {
                let c = &trial.course;
                c.time_s.iter().zip(c.wanted.iter().zip(&c.reached)).map(|(t, (w, r))| (*t, w - r)).collect()
            })
            .collect();
        for (k, trial) in tuned.trials.iter().enumerate() {
            let colour = Palette99::pick(k).to_rgba();
            let course = trial.course.time_s.iter().copied().zip(trial.course.reached.iter().copied());
            upper
                .draw_series(LineSeries::new(course, colour))?
                .label(trial.compensation)
                .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
        }
        upper
            .configure_series_labels()
            .background_style(WHITE.mix(0.8))
            .border_style(BLACK.mix(0.3))
            .draw()?;

        let most = errors.iter().flatten().fold(1e-9_f64, |m, p| m.max(p.1.abs())) * 1.05;
        let mut lower = chart(&panels[1], "error / rad, over time / s", end, -most..most)?;
        for (k, error) in errors.into_iter().enumerate() {
            lower.draw_series(LineSeries::new(error, Palette99::pick(k).to_rgba()))?;
        }
        for (steps, panel) in Step::by_loop(&tuned.steps).iter().zip(panels[2].split_evenly((1, 2))) {
            draw_steps(steps, &panel)?;
        }
        area.present()?;
    }
    Ok(text)
}

/// An empty chart over the time from nought to `end`, with its mesh.
fn chart<'chart, 'svg>(
    panel: &Panel<'svg>,
    caption: &str,
    end: f64,
    range: Range<f64>,
) -> Result<Chart<'chart, 'svg>, Failed> {
    let mut chart = ChartBuilder::on(panel)
        .margin(10)
        .caption(caption, ("sans-serif", 16))
        .x_label_area_size(24)
        .y_label_area_size(56)
        .build_cartesian_2d(0.0..end, range)?;
    chart.configure_mesh().light_line_style(WHITE).draw()?;
    Ok(chart)
}

/// What the steps of one loop reach.
fn draw_steps(steps: &[&Step], panel: &Panel<'_>) -> Result<(), Failed> {
    let Some(first) = steps.first() else { return Ok(()) };
    let end = first.course.time_s.last().copied().unwrap_or(1.0);
    let reached = steps.iter().flat_map(|step| &step.course.reached);
    let (low, high) = reached.fold((0.0_f64, first.height), |(low, high), x| (low.min(*x), high.max(*x)));
    let room = 0.05 * (high - low) + 1e-9;
    let caption = format!("step of the {} / {}, over time / s", first.of, first.unit());
    let mut chart = chart(panel, &caption, end, low - room..high + room)?;
    chart.draw_series(LineSeries::new([(0.0, 0.0), (0.0, first.height), (end, first.height)], BLACK))?;
    for (k, step) in steps.iter().enumerate() {
        let colour = Palette99::pick(k).to_rgba();
        let course = step.course.time_s.iter().copied().zip(step.course.reached.iter().copied());
        let begun = std::iter::once((0.0, 0.0)).chain(course);
        chart
            .draw_series(LineSeries::new(begun, colour))?
            .label(step.compensation)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour));
    }
    chart
        .configure_series_labels()
        .position(SeriesLabelPosition::LowerRight)
        .background_style(WHITE.mix(0.8))
        .border_style(BLACK.mix(0.3))
        .draw()?;
    Ok(())
}
