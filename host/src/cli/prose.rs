//! Tables for people.

use std::path::{Path, PathBuf};

use crate::compare::measures::Measures;
use crate::findings::{NextStep, Standing};
use crate::fit::uncertainty::Estimate;
use crate::log::Warning;

/// A line of errors.
pub fn measures(name: &str, m: &Measures, unit: &str) -> String {
    format!(
        "{name:<24} rmse {:>10} {unit}   largest {:>10} {unit}   fit {:>7.2} %",
        figure(m.rmse),
        figure(m.me),
        m.nrmse_fit_percent
    )
}

/// A fault of the data and what to do.
pub fn fault(fault: &Warning) -> String {
    format!("data: {}: {}\n  do: {}", fault.place, fault.what, fault.fix)
}

/// A table of parameters with intervals; on a narrow terminal each takes two lines.
pub fn parameters(list: &[Estimate]) -> String {
    parameters_within(list, width())
}

fn parameters_within(list: &[Estimate], width: usize) -> String {
    let mut text = String::new();
    for e in list {
        if width < 80 {
            let doubt = if e.identifiable { "" } else { "; not determined" };
            text += &format!(
                "{} {} {}\n    {} .. {}{doubt}\n",
                e.name,
                figure(e.value),
                e.unit,
                figure(e.low),
                figure(e.high)
            );
            continue;
        }
        let doubt = if e.identifiable { "" } else { "   these data do not determine it" };
        text += &format!(
            "{:<28} {:>11} {:<12} {:>11} .. {:<11}{doubt}\n",
            e.name,
            figure(e.value),
            e.unit,
            figure(e.low),
            figure(e.high)
        );
    }
    text
}

/// Columns of the terminal that shows the prose; 80 where it is none.
pub fn width() -> usize {
    console::Term::stderr().size_checked().map_or(80, |(_, columns)| usize::from(columns))
}

/// The verdict, what to do next, and the command that does it.
pub fn standing(standing: &Standing, model: Option<&Path>, logs: &[PathBuf]) -> String {
    format!("{}: {}\n{}", standing.badge, standing.headline, next(&standing.next, model, logs))
}

/// What to do next, as a command that can be pasted where the files are few.
pub fn next(step: &NextStep, model: Option<&Path>, logs: &[PathBuf]) -> String {
    let all: Vec<String> = logs.iter().map(|log| log.display().to_string()).collect();
    let all = all.join(" ");
    let logs = if all.is_empty() || all.len() > LONGEST { "LOG...".to_owned() } else { all };
    let model = model.map_or_else(|| "model.json".to_owned(), |path| path.display().to_string());
    let command = step.command.replace("LOG...", &logs).replace("MODEL", &model);
    format!("next: {} with\n  {command}\n", step.label.to_lowercase())
}

/// More characters of file names than these are not repeated.
const LONGEST: usize = 120;

/// Four significant digits, in plain or scientific notation, whichever is shorter to read.
pub fn figure(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 || (1e-3..1e5).contains(&size) {
        let digits = (3 - size.max(1e-3).log10().floor() as i32).clamp(0, 6) as usize;
        format!("{x:.digits$}")
    } else {
        format!("{x:.3e}")
    }
}

/// Effects in a row, or what their absence is called.
pub fn effects<T: std::fmt::Display>(list: &[T]) -> String {
    if list.is_empty() {
        return "base model".into();
    }
    list.iter().map(ToString::to_string).collect::<Vec<_>>().join(" + ")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::findings::Action;

    #[test]
    fn the_next_command_can_be_pasted() {
        let step = NextStep::new(Action::Diagnose, None);
        let told = next(&step, Some(Path::new("base.json")), &["a.csv".into(), "b.csv".into()]);
        assert_eq!(told, "next: find what is missing with\n  motorlens diagnose base.json a.csv b.csv\n");
    }

    #[test]
    fn a_narrow_terminal_gets_narrow_tables() {
        let one = Estimate {
            name: "coulomb.level".into(),
            value: 0.4,
            unit: "V".into(),
            low: 0.3,
            high: 0.5,
            identifiable: false,
        };
        let told = parameters_within(&[one], 60);
        assert!(told.lines().all(|line| line.len() <= 60) && told.contains("not determined"), "{told}");
    }

    #[test]
    fn figures_have_four_digits() {
        for (x, text) in
            [(0.0, "0.000000"), (1.23456, "1.235"), (0.05, "0.05000"), (12345.6, "12346"), (2e-6, "2.000e-6")]
        {
            assert_eq!(figure(x), text);
        }
    }
}
