//! The confusion matrix as a picture: hidden effects by accepted ones.

use plotters::prelude::*;

use super::question::Group;
use super::trial::Answer;
use crate::error::{Error, Result};

const CELL: u32 = 26;
const MARGIN: (i32, i32) = (170, 150);

/// An SVG: a row for every hidden single effect (and nothing), a column for what was accepted first.
///
/// # Errors
/// The drawing library's refusal.
pub fn picture(answers: &[Answer]) -> Result<String> {
    let asked: Vec<&Answer> =
        answers.iter().filter(|a| matches!(a.group, Group::Single | Group::Nothing)).collect();
    let name = |list: &[&'static str]| list.first().copied().unwrap_or("none");
    let mut names: Vec<&str> = asked.iter().flat_map(|a| [name(&a.truth), name(&a.found)]).collect();
    names.sort_unstable();
    names.dedup();
    let n = names.len() as u32;
    let size = (MARGIN.0 as u32 + CELL * n + 20, MARGIN.1 as u32 + CELL * n + 20);
    let mut svg = String::new();
    let failed =
        |e: &dyn std::fmt::Display| Error::usage(format!("cannot draw the matrix: {e}"), "report this");
    {
        let root = SVGBackend::with_string(&mut svg, size).into_drawing_area();
        root.fill(&WHITE).map_err(|e| failed(&e))?;
        let label = |x: i32, y: i32, text: &str, turned: bool| {
            let font = ("sans-serif", 13).into_font();
            let font = if turned { font.transform(FontTransform::Rotate270) } else { font };
            root.draw(&Text::new(text.to_owned(), (x, y), font)).map_err(|e| failed(&e))
        };
        for (row, truth) in names.iter().enumerate() {
            let y = MARGIN.1 + (row as u32 * CELL) as i32;
            label(8, y + 6, truth, false)?;
            label(MARGIN.0 + (row as u32 * CELL) as i32 + 6, MARGIN.1 - 8, truth, true)?;
            let of: Vec<&&Answer> = asked.iter().filter(|a| name(&a.truth) == *truth).collect();
            for (column, found) in names.iter().enumerate() {
                let number = of.iter().filter(|a| name(&a.found) == *found).count();
                let share = number as f64 / of.len().max(1) as f64;
                let x = MARGIN.0 + (column as u32 * CELL) as i32;
                let hue = if row == column { 0.36 } else { 0.02 };
                let fill = HSLColor(hue, 0.7, 0.97 - 0.45 * share);
                let corners = [(x, y), (x + CELL as i32 - 2, y + CELL as i32 - 2)];
                root.draw(&Rectangle::new(corners, fill.filled())).map_err(|e| failed(&e))?;
                if number > 0 {
                    label(x + 5, y + 6, &number.to_string(), false)?;
                }
            }
        }
        label(8, MARGIN.1 - 24, "hidden, by row;", false)?;
        label(8, MARGIN.1 - 8, "accepted first, by column", false)?;
        root.present().map_err(|e| failed(&e))?;
    }
    Ok(svg)
}
