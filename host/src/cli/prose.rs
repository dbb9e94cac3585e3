//! Tables and sentences for people, as wide as their terminal.

use motorlens_shared::effects::Kind;

use super::wrap::{filled, known_width, width};
use crate::compare::measures::Measures;
use crate::findings::{Findings, MANY, Standing, Verdict, multiple};
use crate::fit::uncertainty::Estimate;
use crate::log::Warning;
use crate::report::figure::in_words;
use crate::report::words;
use crate::select::DetectionLimit;
use crate::sentence::capital;

/// A line of errors; on a narrow terminal without the largest, on a phone's below its name.
pub fn measures(name: &str, m: &Measures, unit: &str) -> String {
    measures_within(name, m, unit, known_width().unwrap_or(usize::MAX))
}

fn measures_within(name: &str, m: &Measures, unit: &str, width: usize) -> String {
    let (rmse, fit) = (figure(m.rmse), m.nrmse_fit_percent);
    let row =
        |name: &str, largest: &str| format!("{name:<25} rmse {rmse:>9} {unit}{largest}   fit {fit:>7.2} %");
    let fits = |row: &str| row.chars().count() <= width;
    // Every row of a table has the same columns: which ones, a row without its name tells.
    let largest = format!("   largest {:>9} {unit}", figure(m.me));
    let largest = if fits(&row("", &largest)) { largest } else { String::new() };
    let (whole, below) = (row(name, &largest), row("", &largest));
    if fits(&whole) {
        whole
    } else if fits(&below) {
        format!("{name}\n{below}")
    } else {
        format!("{name}\n    rmse {rmse} {unit}, fit {fit:.2} %")
    }
}

/// Rows of a name and what is said of it, beside it where that fits, else below.
pub fn beside(rows: &[(&str, &str)]) -> String {
    beside_within(rows, known_width().unwrap_or(usize::MAX))
}

fn beside_within(rows: &[(&str, &str)], width: usize) -> String {
    let row = |(name, said): &(&str, &str)| {
        let whole = format!("  {name:<30} {said}\n");
        // The line's end takes no column.
        if whole.chars().count() <= width.saturating_add(1) {
            whole
        } else {
            format!("  {name}\n    {said}\n")
        }
    };
    rows.iter().map(row).collect()
}

/// What the usual model leaves, under the errors of a model; one that records do not determine runs away.
pub fn usual(m: &Measures, unit: &str) -> String {
    if m.missed() > RUN_AWAY {
        return "  kS-kV-kA is not determined by these records".to_owned();
    }
    measures("  kS-kV-kA for comparison", m, unit)
}

/// The same where the records give no usual model.
pub fn no_usual(why: &str) -> String {
    format!("  no kS-kV-kA for comparison: {why}")
}

/// Multiples of the motion that no usable model misses.
pub const RUN_AWAY: f64 = 2.0;

/// A fault of the data and what to do, by the name that docs/LOGS.md and `--json` know it by.
pub fn fault(fault: &Warning) -> String {
    format!("data: {}: {}\n  do: {}", fault.place, fault.what, fault.fix)
}

/// The faults that the fit has shown, each after an empty line: those of the logs are told before it.
pub fn shown_by_the_fit(findings: &Findings) -> String {
    findings.later_faults().iter().map(|later| format!("\n{}\n", fault(later))).collect()
}

/// A table of parameters with intervals; on a narrow terminal its columns are narrower, then each parameter takes two lines.
pub fn parameters(list: &[Estimate]) -> String {
    parameters_within(list, width())
}

fn parameters_within(list: &[Estimate], width: usize) -> String {
    let value = |e: &Estimate, [name, number]: [usize; 2]| {
        format!("{:<name$} {:>number$} {}", e.name, figure(e.value), words::unit(&e.unit))
    };
    let row = |e: &Estimate, [name, number, unit]: [usize; 3]| {
        let whole = name + number + unit + 2;
        format!("{:<whole$} {}", value(e, [name, number]), interval(e))
    };
    let name = list.iter().map(|e| e.name.chars().count()).max().unwrap_or(0);
    let number = list.iter().map(|e| figure(e.value).chars().count()).max().unwrap_or(0);
    let unit = list.iter().map(|e| words::unit(&e.unit).chars().count()).max().unwrap_or(0);
    let fits = |text: String| text.chars().count() <= width;
    let one_line = [[28, 11, 12], [name, number, unit]];
    if let Some(columns) = one_line.into_iter().find(|columns| list.iter().all(|e| fits(row(e, *columns)))) {
        return list.iter().map(|e| row(e, columns) + "\n").collect();
    }
    let columns = if list.iter().all(|e| fits(value(e, [name, number]))) { [name, number] } else { [0, 0] };
    list.iter().map(|e| format!("{}\n    {}\n", value(e, columns).trim_end(), interval(e))).collect()
}

/// The interval of `e`; one that the data leave open has no ends worth reading.
pub fn interval(e: &Estimate) -> String {
    if !words::has_interval(e) {
        return words::NOT_DETERMINED.to_owned();
    }
    format!("{} .. {}", figure(e.low), figure(e.high))
}

/// What the intervals of a model that leaves much suppose; empty where it leaves little.
pub fn supposed(findings: &Findings) -> String {
    let much = |n: &f64| findings.verdict != Verdict::Explained && *n > MANY;
    findings.left_over.filter(much).map_or_else(String::new, |n| {
        format!(
            "The intervals suppose that the model lacks nothing. It leaves {}: what it lacks may have moved the values further.\n",
            multiple(n)
        )
    })
}

/// The experiments that `findings` suggest, or why there is none, a line each.
pub fn experiments(findings: &Findings) -> String {
    let none = findings.no_experiment.as_ref().map(|why| format!("{}.\n", capital(why)));
    let next = findings.next_experiment.as_ref().map(|next| format!("Next experiment: {}\n", next.why));
    none.into_iter().chain(next).collect()
}

/// The smallest sizes of further effects that the records would have shown, and what they cannot show.
pub fn limits(limits: &[DetectionLimit]) -> String {
    limits_within(limits, width())
}

fn limits_within(limits: &[DetectionLimit], width: usize) -> String {
    let size =
        |limit: &DetectionLimit| limit.smallest.map(|size| of_size(limit.effect.name(), size, limit.unit));
    let mut shown: Vec<String> = limits.iter().filter_map(size).collect();
    shown.sort();
    let names = |kinds: Vec<Kind>| kinds.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(", ");
    let hidden = names(DetectionLimit::hidden(limits));
    let undecided = names(DetectionLimit::undecided(limits));
    let mut text = String::new();
    if !shown.is_empty() {
        text += "These records would have shown further effects from:\n";
        text += &filled(&shown, width);
    }
    if !hidden.is_empty() {
        let subject = if shown.is_empty() { "These records" } else { "They" };
        text += &format!("{subject} cannot confirm at any size: {hidden}.\n");
    }
    if !undecided.is_empty() {
        text += &format!(
            "Too much is left to confirm or to exclude: {undecided}. Alone they lower it too little, or the search gave them up before its end; \
             motorlens fit --effects A,B LOG... tries two together.\n"
        );
    }
    text
}

/// An effect with its size.
fn of_size(effect: &str, size: f64, unit: &str) -> String {
    // No prefix stands before 1/s.
    if unit.starts_with('1') {
        return format!("{effect} {} {}", in_words(size, "1"), words::unit(unit)).trim_end().to_owned();
    }
    format!("{effect} {}", in_words(size, unit))
}

/// The verdict, in front of the `story` that it sums up.
pub fn headed(standing: &Standing, story: &str) -> String {
    format!("\n{}: {}\n\n{story}", standing.badge, standing.headline)
}

/// Four significant digits, in plain or scientific notation, whichever is shorter to read.
pub fn figure(x: f64) -> String {
    let size = x.abs();
    if x == 0.0 {
        return "0".into();
    }
    if (1e-3..1e5).contains(&size) {
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
    use super::super::wrap::wrapped;
    use super::*;

    #[test]
    fn a_narrow_terminal_gets_narrow_tables() {
        let one = Estimate {
            name: "coulomb.level".into(),
            value: 0.4,
            unit: "V".into(),
            low: 0.3,
            high: 0.5,
            identifiable: true,
        };
        let far = Estimate { name: "coulomb_asymmetric.backward".into(), identifiable: false, ..one.clone() };
        for (width, lines) in [(80, 2), (60, 2), (40, 4)] {
            let told = parameters_within(&[one.clone(), far.clone()], width);
            assert!(told.lines().all(|line| line.len() <= width), "{told}");
            assert!(told.contains("0.4000 V") && told.contains("0.3000 .. 0.5000"), "{told}");
            assert!(told.lines().count() == lines && told.contains("not determined"), "{told}");
        }
    }

    #[test]
    fn a_row_of_errors_fits_the_terminal() {
        let m = Measures { rmse: 6.1e-5, me: 1.2e-4, nrmse_fit_percent: 28.71, ..Measures::default() };
        for (unit, at_60) in [("rad", 1), ("rad/s", 2)] {
            for (width, lines) in [(90, 1), (80, 1), (60, at_60), (40, 2)] {
                let told = measures_within("  kS-kV-kA for comparison", &m, unit, width);
                assert!(told.lines().all(|line| line.len() <= width), "{told}");
                assert!(told.lines().count() == lines && told.contains("28.71 %"), "{told}");
                assert_eq!(told.contains("largest"), width == 90, "{told}");
            }
        }
        let long = measures_within("a-record-with-a-name-that-is-as-long-as-some-are", &m, "rad", 80);
        assert_eq!(long.lines().count(), 2, "{long}");
    }

    #[test]
    fn what_is_said_of_a_name_stands_below_it_where_it_would_be_cut() {
        let rows = [("voltage", "-6 .. -4 V: 45 % of the error is made here, in 12 % of the time")];
        for (width, lines) in [(120, 1), (80, 2), (60, 3), (40, 3)] {
            let told = wrapped(&beside_within(&rows, width), width);
            assert_eq!(told.lines().count(), lines, "{told}");
            assert!(told.lines().all(|line| line.len() <= width), "{told}");
            assert!(told.contains("-6 .. -4 V:") && told.contains("45 %") && told.contains("12 %"), "{told}");
        }
    }

    #[test]
    fn an_interval_that_the_data_leave_open_is_not_printed_with_its_ends() {
        let open = Estimate {
            name: "b/a1".into(),
            value: 6036.0,
            unit: "1".into(),
            low: 1e-32,
            high: 1e38,
            identifiable: false,
        };
        for width in [60, 80] {
            let told = parameters_within(std::slice::from_ref(&open), width);
            assert!(told.contains("6036") && told.contains("not determined"), "{told}");
            assert!(!told.contains("e38") && !told.contains("e-32"), "{told}");
        }
        let endless = Estimate { high: f64::INFINITY, identifiable: true, ..open };
        assert_eq!(interval(&endless), "not determined");
    }

    #[test]
    fn the_detection_limits_are_a_short_list_in_which_no_size_is_parted() {
        let limit = |effect: Kind| {
            let strength = effect.spec().parameters.iter().find(|p| p.strength);
            let (parameter, unit) = strength.map_or(("", "1"), |p| (p.name, p.unit));
            let smallest = Some(0.012_34);
            DetectionLimit { effect, parameter, smallest, undecided: false, unit, programme: None }
        };
        let all: Vec<DetectionLimit> = Kind::ALL.iter().map(|kind| limit(*kind)).collect();
        for width in [40, 60, 80] {
            let told = limits_within(&all, width);
            assert!(told.lines().skip(1).all(|line| line.len() <= width), "{told}");
            for whole in ["coulomb 12.3 mV,", "  backlash 12.3 mrad,"] {
                assert!(told.contains(whole), "{told}");
            }
            assert!(width < 80 || told.lines().count() <= 8, "{told}");
        }
        let unseen = |undecided| DetectionLimit { smallest: None, undecided, ..limit(Kind::Coast) };
        let told = limits_within(&[unseen(false)], 80);
        assert_eq!(told, "These records cannot confirm at any size: coast.\n");
        let told = limits_within(&[unseen(true)], 80);
        assert!(told.starts_with("Too much is left to confirm or to exclude: coast."), "{told}");
        assert_eq!(of_size("winding_heating", 0.023_44, "1/s"), "winding_heating 0.0234 1/s");
        assert_eq!(of_size("coast", 0.1, "1"), "coast 0.1");
    }

    #[test]
    fn figures_have_four_digits() {
        for (x, text) in
            [(0.0, "0"), (1.23456, "1.235"), (0.05, "0.05000"), (12345.6, "12346"), (2e-6, "2.000e-6")]
        {
            assert_eq!(figure(x), text);
        }
    }
}
