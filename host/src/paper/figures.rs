//! Figures 5 and 7 as SVG and as the numbers in them, the run as JSON, and the model with the missing effect.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use plotters::prelude::*;

use super::data::Data;
use super::{PaperRun, tables};
use crate::atomic_file;
use crate::error::{Error, Result};
use crate::search::{LinearRecord, Records};

const SIZE: (u32, u32) = (900, 420);

/// A curve by name.
type Curve<'a> = (&'a str, Vec<(f64, f64)>);

/// Writes everything into `out` and returns the files.
///
/// # Errors
/// The machine's refusal to write.
pub fn write(
    run: &PaperRun,
    data: &Data,
    even: &[LinearRecord],
    prepared: &Records,
    out: &Path,
) -> Result<Vec<PathBuf>> {
    std::fs::create_dir_all(out).map_err(|source| Error::Io {
        doing: format!("cannot make the directory {}", out.display()),
        source,
    })?;
    let mut files = Vec::new();
    let mut save = |name: &str, text: String| -> Result<()> {
        let path = out.join(name);
        atomic_file::write(&path, text)?;
        files.push(path);
        Ok(())
    };
    let generations = run.ga.history.iter().enumerate();
    let history: Vec<(f64, f64)> = generations.map(|(k, iae)| (k as f64 + 1.0, *iae)).collect();
    save("figure-5.csv", csv("generation,best_iae", &history))?;
    let curve = [("best IAE", history)];
    save("figure-5.svg", plot("Figure 5: best objective per generation", "generation", "IAE", &curve)?)?;

    let ga = tables::predictions(prepared, even, &run.ga.combinations);
    let conventional = tables::predictions(prepared, even, &run.conventional.combinations);
    for (k, record) in data.records.iter().enumerate() {
        let times: Vec<f64> = (0..even[k].measured.len()).map(|n| n as f64 * even[k].dt).collect();
        let curve = |values: &[f64]| times.iter().copied().zip(values.iter().copied()).collect();
        let first = record.time_s.first().copied().unwrap_or(0.0);
        let own_times = record.time_s.iter().map(|t| t - first);
        let curves: [Curve; 4] = [
            ("measured", curve(&even[k].measured)),
            ("GA", curve(&ga[k])),
            ("conventional", curve(&conventional[k])),
            ("with the missing effect", own_times.zip(run.missing.predictions[k].iter().copied()).collect()),
        ];
        let mut text = String::from("curve,time_s,value\n");
        for (name, points) in &curves {
            for (t, y) in points {
                let _ = writeln!(text, "{name},{t:.6},{y:.7}");
            }
        }
        let name = format!("figure-7-{}", k + 1);
        let title = format!("Figure 7: {}", record.name);
        save(&format!("{name}.svg"), plot(&title, "time, s", "angle, rad", &curves)?)?;
        save(&format!("{name}.csv"), text)?;
    }
    save("paper.json", json(run)?)?;
    save("model.json", json(&run.missing.model)?)?;
    save("paper.txt", run.to_string())?;
    Ok(files)
}

fn json(value: &impl serde::Serialize) -> Result<String> {
    serde_json::to_string_pretty(value)
        .map_err(|error| Error::Io { doing: "cannot write JSON".into(), source: error.into() })
}

fn csv(header: &str, points: &[(f64, f64)]) -> String {
    let mut text = format!("{header}\n");
    for (x, y) in points {
        let _ = writeln!(text, "{x},{y:.9}");
    }
    text
}

/// Smallest and largest of the finite values, a little apart.
fn range(values: impl Iterator<Item = f64>) -> std::ops::Range<f64> {
    let (low, high) = values
        .filter(|v| v.is_finite())
        .fold((f64::MAX, f64::MIN), |(low, high), v| (low.min(v), high.max(v)));
    let margin = (0.05 * (high - low)).max(1e-9);
    low - margin..high + margin
}

fn plot(title: &str, x: &str, y: &str, curves: &[Curve]) -> Result<String> {
    let mut text = String::new();
    draw(&mut text, title, x, y, curves).map_err(|error| Error::Io {
        doing: format!("cannot draw \"{title}\""),
        source: std::io::Error::other(error.to_string()),
    })?;
    Ok(text)
}

type Drawn = std::result::Result<(), Box<dyn std::error::Error>>;

fn draw(text: &mut String, title: &str, x: &str, y: &str, curves: &[Curve]) -> Drawn {
    const COLOURS: [RGBColor; 4] =
        [RGBColor(90, 90, 90), RGBColor(213, 94, 0), RGBColor(0, 114, 178), RGBColor(0, 158, 115)];
    let area = SVGBackend::with_string(text, SIZE).into_drawing_area();
    area.fill(&WHITE)?;
    let points = || curves.iter().flat_map(|(_, points)| points);
    let mut chart = ChartBuilder::on(&area)
        .caption(title, ("sans-serif", 18))
        .margin(12)
        .x_label_area_size(40)
        .y_label_area_size(64)
        .build_cartesian_2d(range(points().map(|p| p.0)), range(points().map(|p| p.1)))?;
    chart.configure_mesh().x_desc(x).y_desc(y).draw()?;
    for ((name, points), colour) in curves.iter().zip(COLOURS) {
        let line = LineSeries::new(points.iter().copied(), colour.stroke_width(2));
        chart
            .draw_series(line)?
            .label(*name)
            .legend(move |(x, y)| PathElement::new([(x, y), (x + 18, y)], colour.stroke_width(2)));
    }
    chart.configure_series_labels().background_style(WHITE.mix(0.8)).border_style(BLACK).draw()?;
    area.present()?;
    Ok(())
}
