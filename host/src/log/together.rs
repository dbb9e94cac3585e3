//! Warnings of one kind are one warning with a count.

use super::Warning;

/// Places that are named.
const NAMED: usize = 3;

/// Joins warnings that say the same of several places: the first one's words, and where else.
pub fn together(warnings: impl IntoIterator<Item = Warning>) -> Vec<Warning> {
    let mut groups: Vec<(String, Vec<Warning>)> = Vec::new();
    for warning in warnings {
        let kind = kind(&warning);
        match groups.iter_mut().find(|(known, _)| *known == kind) {
            Some((_, group)) => group.push(warning),
            None => groups.push((kind, vec![warning])),
        }
    }
    groups.into_iter().map(|(_, group)| joined(group)).collect()
}

/// The name of the warning and its column, or its words without their figures.
fn kind(warning: &Warning) -> String {
    let words = |text: &str| text.chars().filter(|c| !c.is_ascii_digit()).collect::<String>();
    let column = warning.place.rsplit_once(", column ").map_or("", |(_, column)| column);
    match warning.what.split_once(": ") {
        Some((name, _)) if !name.contains(' ') => format!("{name} {column}"),
        _ => format!("{} {column}", words(&warning.what)),
    }
}

fn joined(mut group: Vec<Warning>) -> Warning {
    let more = group.len() - 1;
    let first = group.remove(0);
    if more == 0 {
        return first;
    }
    let mut fix = first.fix.clone();
    // What is to be done with each, where that differs in its figures.
    let others = group.iter().filter(|w| w.fix != first.fix).map(|w| w.fix.as_str());
    for other in others.take(NAMED) {
        if !fix.contains(other) {
            fix += &format!("; {other}");
        }
    }
    let mut places: Vec<&str> =
        group.iter().map(|w| w.place.split(", column").next().unwrap_or(&w.place)).collect();
    places.dedup();
    let shown = places.iter().take(NAMED).copied().collect::<Vec<_>>().join(", ");
    let rest = if places.len() > NAMED { ", ..." } else { "" };
    let times = if more == 1 { "1 more".to_owned() } else { format!("{more} more") };
    Warning {
        what: format!("{} (and {times} of this kind: {shown}{rest})", first.what),
        fix,
        place: first.place,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn warning(place: &str, what: &str, fix: &str) -> Warning {
        Warning { place: place.into(), what: what.into(), fix: fix.into() }
    }

    #[test]
    fn warnings_of_one_kind_are_one_with_a_count() {
        let mut all: Vec<Warning> = (0..6)
            .map(|k| {
                warning(&format!("run{k}.csv, column angle_rad"), &format!("hard_stop: {k} times"), "cut it")
            })
            .collect();
        all.insert(2, warning("run2.csv, column voltage_v", "stale_voltage: every 0.1 s", "log it"));
        let told = together(all);
        assert_eq!(told.len(), 2);
        assert_eq!(told[0].place, "run0.csv, column angle_rad");
        assert!(
            told[0].what.contains("and 5 more of this kind: run1.csv, run2.csv, run3.csv, ..."),
            "{}",
            told[0].what
        );
        assert_eq!((told[0].fix.as_str(), told[1].fix.as_str()), ("cut it", "log it"));
    }

    #[test]
    fn what_is_to_be_done_with_each_is_kept_where_it_differs() {
        let told = together([
            warning("a.csv", "12 rows were left out", "--skip a:1..2"),
            warning("b.csv", "7 rows were left out", "--skip b:3..4"),
        ]);
        assert_eq!(told.len(), 1);
        assert!(told[0].fix.contains("a:1..2") && told[0].fix.contains("b:3..4"), "{}", told[0].fix);
    }
}
