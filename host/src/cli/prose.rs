//! Tables for people.

use crate::compare::measures::Measures;
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

/// A table of parameters with intervals.
pub fn parameters(list: &[Estimate]) -> String {
    let mut text = String::new();
    for e in list {
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
    use super::figure;

    #[test]
    fn figures_have_four_digits() {
        for (x, text) in
            [(0.0, "0.000000"), (1.23456, "1.235"), (0.05, "0.05000"), (12345.6, "12346"), (2e-6, "2.000e-6")]
        {
            assert_eq!(figure(x), text);
        }
    }
}
