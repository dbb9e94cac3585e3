//! Marks by kind of bench, and their table.

use std::fmt::Write as _;

use motorlens_bench_motor::Bench;
use serde::Serialize;

use super::trial::Answer;
use crate::exam::Part;

/// Marks of one kind of bench, or of all.
#[derive(Debug, Clone, Serialize)]
pub struct Marks {
    /// The bench's name, or `all`.
    pub bench: &'static str,
    /// Cases.
    pub cases: usize,
    /// One effect on a motor without a disturbance torque: one that is there stands first; all that is asked and no other accepted.
    pub calm: [Part; 2],
    /// The same under a disturbance of 1-5 %.
    pub disturbed: [Part; 2],
    /// Two effects: all that is asked and no other.
    pub pairs: Part,
    /// Nothing hidden on purpose, and an effect accepted that is not there.
    pub false_alarms: Part,
    /// "explained" or "partly explained" by effects: every one is there.
    pub claims: Part,
    /// ... or a rival named with it is.
    pub claims_tenable: Part,
    /// Exact, with something found, and not called "explained".
    pub exact_unexplained: Part,
    /// Outside the library: "explained" by what is not there.
    pub outside_explained: Part,
    /// ... such accepted in part.
    pub outside_partial: Part,
    /// Answers that say what the records cannot show or what to run next.
    pub guides: Part,
    /// Records refused.
    pub refused: usize,
    /// Time, median and longest, s.
    pub seconds: [f64; 2],
}

fn part<'a>(answers: impl Iterator<Item = &'a Answer>, is: impl Fn(&Answer) -> bool) -> Part {
    let mut part = Part::default();
    for answer in answers {
        part.of += 1;
        part.number += usize::from(is(answer));
    }
    part
}

impl Marks {
    /// Marks of the `answers` of one bench.
    pub fn new(bench: &'static str, answers: &[&Answer]) -> Self {
        let of = |group: &'static str| answers.iter().copied().filter(move |a| a.group == group);
        let single =
            |calm: bool| of("single").filter(move |a| (a.disturbance == 0.0) == calm && !a.asked.is_empty());
        let explained = |a: &&Answer| a.verdict == "explained";
        let claims = || {
            let says = |a: &&Answer| matches!(a.verdict.as_str(), "explained" | "partly_explained");
            answers.iter().copied().filter(says).filter(|a| !a.found.is_empty())
        };
        let mut times: Vec<f64> = answers.iter().map(|a| a.seconds).collect();
        times.sort_by(f64::total_cmp);
        let time = |k: usize| times.get(k).copied().unwrap_or(f64::NAN);
        let exact = |calm| part(single(calm), Answer::exact);
        Self {
            bench,
            cases: answers.len(),
            calm: [part(single(true), Answer::first), exact(true)],
            disturbed: [part(single(false), Answer::first), exact(false)],
            pairs: part(of("pair").filter(|a| !a.asked.is_empty()), Answer::exact),
            false_alarms: part(of("nothing"), Answer::strange),
            claims: part(claims(), |a| !a.strange()),
            claims_tenable: part(claims(), Answer::tenable),
            exact_unexplained: part(
                answers.iter().copied().filter(|a| a.group != "outside" && a.exact() && !a.found.is_empty()),
                |a| a.verdict != "explained",
            ),
            outside_explained: part(of("outside"), |a| explained(&a) && a.strange()),
            outside_partial: part(of("outside"), |a| !explained(&a) && a.strange()),
            guides: part(answers.iter().copied(), |a| a.guides),
            refused: answers.iter().filter(|a| a.verdict == "refused").count(),
            seconds: [time(times.len() / 2), times.last().copied().unwrap_or(f64::NAN)],
        }
    }

    /// Marks of every bench that was asked, then of all together.
    pub fn all(answers: &[Answer]) -> Vec<Self> {
        let of = |name: &'static str| answers.iter().filter(|a| a.bench == name).collect::<Vec<_>>();
        let mut marks: Vec<Self> = Bench::ALL
            .into_iter()
            .map(|bench| Self::new(bench.name(), &of(bench.name())))
            .filter(|marks| marks.cases > 0)
            .collect();
        marks.push(Self::new("all", &answers.iter().collect::<Vec<_>>()));
        marks
    }
}

/// The marks as Markdown: a column for every bench, and what is asked; then every answer that is not exact.
pub fn table(answers: &[Answer]) -> String {
    let marks = Marks::all(answers);
    let mut text = String::from("| |");
    // A string takes everything.
    for m in &marks {
        let _ = write!(text, " {} |", m.bench);
    }
    text += " asked |\n|---|";
    text += &"---|".repeat(marks.len() + 1);
    text.push('\n');
    type Cell = fn(&Marks) -> String;
    let rows: [(&str, Cell, &str); 15] = [
        ("cases", |m| m.cases.to_string(), ""),
        ("one effect, calm: one that is there first", |m| share(m.calm[0]), "98 %"),
        ("... exactly what is asked", |m| share(m.calm[1]), "90 %"),
        ("one effect, disturbed by 1-5 %: first", |m| share(m.disturbed[0]), "90 %"),
        ("... exactly", |m| share(m.disturbed[1]), "80 %"),
        ("two effects, exactly", |m| share(m.pairs), "88 %"),
        ("nothing hidden, yet an effect that is not there", |m| share(m.false_alarms), "1 in 60"),
        ("explained, or partly, by effects that are all there", |m| share(m.claims), "98 %"),
        ("... or rivals of such", |m| share(m.claims_tenable), ""),
        ("exact, yet not \"explained\"", |m| share(m.exact_unexplained), "10 %"),
        ("outside the library: \"explained\" by what is not there", |m| share(m.outside_explained), "0"),
        ("... wrong in part", |m| share(m.outside_partial), "15 %"),
        ("says what these records cannot show, or what to run", |m| share(m.guides), "weak: all"),
        ("records refused", |m| m.refused.to_string(), "0"),
        ("time, median and longest", |m| format!("{:.1}, {:.1} s", m.seconds[0], m.seconds[1]), "0.5, 3 s"),
    ];
    for (what, cell, asked) in rows {
        let _ = write!(text, "| {what} |");
        for m in &marks {
            let _ = write!(text, " {} |", cell(m));
        }
        let _ = writeln!(text, " {asked} |");
    }
    text + "\n" + &misses(answers)
}

/// A row for every answer that is not exact.
fn misses(answers: &[Answer]) -> String {
    let mut text = String::from("| bench, seed | there | found | verdict |\n|---|---|---|---|\n");
    for a in answers.iter().filter(|a| !a.exact() || (a.group == "outside" && a.strange())) {
        let found = if a.found.is_empty() { "none".into() } else { a.found.join(" + ") };
        let there = if a.sizes.is_empty() { "nothing" } else { &a.sizes };
        let torque =
            if a.disturbance > 0.0 { format!(", {:.1} %", 100.0 * a.disturbance) } else { String::new() };
        let _ = writeln!(text, "| {}, {}{torque} | {there} | {found} | {} |", a.bench, a.seed, a.verdict);
    }
    text
}

fn share(part: Part) -> String {
    part.percent().map_or("-".into(), |p| format!("{} of {} ({p:.0} %)", part.number, part.of))
}
