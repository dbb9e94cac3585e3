//! The position's profile and how each trial followed it, as SVG.

use plotters::prelude::*;

use super::Tuned;

type Failed = Box<dyn std::error::Error>;

/// Two panels: the profile with the first and the best trial, and the errors of all.
///
/// # Errors
/// A drawing that the backend refuses.
pub fn plot(tuned: &Tuned) -> Result<String, Failed> {
    let mut text = String::new();
    {
        let area = SVGBackend::with_string(&mut text, (900, 640)).into_drawing_area();
        area.fill(&WHITE)?;
        let panels = area.split_evenly((2, 1));
        let Some(first) = tuned.trials.first() else { return Ok(String::new()) };
        let end = first.course.time_s.last().copied().unwrap_or(1.0);
        let wanted: Vec<(f64, f64)> =
            first.course.time_s.iter().copied().zip(first.course.wanted.iter().copied()).collect();
        let top = wanted.iter().fold(0.0_f64, |m, p| m.max(p.1.abs())) * 1.1 + 1e-9;

        let mut upper = ChartBuilder::on(&panels[0])
            .margin(10)
            .caption("position / rad", ("sans-serif", 16))
            .x_label_area_size(24)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..end, -0.1 * top..top)?;
        upper.configure_mesh().light_line_style(WHITE).draw()?;
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
        let mut lower = ChartBuilder::on(&panels[1])
            .margin(10)
            .caption("error / rad, over time / s", ("sans-serif", 16))
            .x_label_area_size(24)
            .y_label_area_size(56)
            .build_cartesian_2d(0.0..end, -most..most)?;
        lower.configure_mesh().light_line_style(WHITE).draw()?;
        for (k, error) in errors.into_iter().enumerate() {
            lower.draw_series(LineSeries::new(error, Palette99::pick(k).to_rgba()))?;
        }
        area.present()?;
    }
    Ok(text)
}
