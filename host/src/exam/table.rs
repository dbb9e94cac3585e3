//! The marks as a table for people: Markdown.

use std::fmt::Write as _;

use super::mark::{Marks, Part};
use super::question::Group;
use super::trial::Answer;

/// Marks beside what is asked, then a row for every effect.
pub fn table(answers: &[Answer]) -> String {
    let m = Marks::new(answers);
    let mut text = String::from("| | reached | asked |\n|---|---|---|\n");
    let mut row = |what: &str, reached: String, asked: &str| {
        // A string takes everything.
        let _ = writeln!(text, "| {what} | {reached} | {asked} |");
    };
    row("single effect: right one first", share(m.first), "97 %");
    row("... where the plain motor leaves more than noise", share(m.shown_first), "");
    row("... of those that the data tell", share(m.told_first), "");
    row("... among the first two", share(m.first_two), "100 %");
    row("... exactly that one accepted", share(m.exact), "");
    row("single effect under a disturbance of 1-5 %: right one first", share(m.disturbed_first), "");
    row("... exactly that one accepted", share(m.disturbed_exact), "");
    row("nothing missing, yet something accepted", share(m.false_alarms), "at most 1 %");
    row("claims to explain, without a rival: every effect named is there", share(m.claims_right), "99 %");
    row("... where the library has what is hidden", share(m.claims_right_inside), "");
    row("... or the data do not tell what is hidden", share(m.claims_tenable), "");
    row(
        "... with rivals that the data cannot exclude: so, or one of these is",
        share(m.open_claims_right),
        "",
    );
    row("two effects, exactly both accepted", share(m.pairs), "90 %");
    row("... of those that the data tell", share(m.told_pairs), "");
    row("... under a disturbance of 1-5 %", share(m.disturbed_pairs), "");
    row("outside the library, yet \"explained\" by what is not there", share(m.outside_explained), "0");
    row("... although the data tell", share(m.outside_explained_told), "");
    row("... what is not there accepted in part", share(m.outside_partial), "at most 10 %");
    row("... nothing seen to be missing", share(m.outside_unseen), "");
    let quartiles = format!("{:.2}, {:.2}", m.median_over_floor, m.third_quartile_over_floor);
    row("unseen error over the floor: median, third quartile", quartiles, "1.0, 1.2");
    row(
        "time of one diagnosis (until the first effect is in), median",
        format!("{:.2} s", m.median_first_seconds),
        "0.5 s",
    );
    row("... of the whole loop, with up to four effects", format!("{:.2} s", m.median_seconds), "");
    text + "\n" + &by_effect(answers)
}

/// What became of every single effect.
fn by_effect(answers: &[Answer]) -> String {
    let mut text = String::from(
        "| hidden | cases | first | exact | error over floor before -> after | instead |\n|---|---|---|---|---|---|\n",
    );
    let singles = || answers.iter().filter(|a| a.group == Group::Single);
    let mut names: Vec<&str> = singles().map(|a| a.truth[0]).collect();
    names.sort_unstable();
    names.dedup();
    for name in names {
        let of: Vec<&Answer> = singles().filter(|a| a.truth[0] == name).collect();
        let number = |is: fn(&Answer) -> bool| of.iter().filter(|a| is(a)).count();
        let instead: Vec<String> =
            of.iter().filter(|a| !a.exact()).map(|a| format!("{} ({})", words(&a.found), a.seed)).collect();
        let middle = |value: fn(&Answer) -> f64| {
            let mut values: Vec<f64> = of.iter().map(|a| value(a)).collect();
            values.sort_by(f64::total_cmp);
            values[values.len() / 2]
        };
        let _ = writeln!(
            text,
            "| {name} | {} | {} | {} | {:.1} -> {:.2} | {} |",
            of.len(),
            number(|a| a.among_first(1)),
            number(Answer::exact),
            middle(|a| a.before),
            middle(|a| a.after),
            instead.join("; ")
        );
    }
    text
}

/// Effects in words.
pub fn words(names: &[&str]) -> String {
    if names.is_empty() { "none".into() } else { names.join(" + ") }
}

fn share(part: Part) -> String {
    part.percent().map_or("-".into(), |p| format!("{} of {} ({p:.0} %)", part.number, part.of))
}
