//! The user's book: its generated parts are those of the present registry, its summary has every page, and its commands work.

use std::path::{Path, PathBuf};

use motorlens::{book, cli};
use motorlens_shared::effects::Kind;

mod program;

/// Where the book stands.
fn sources() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/book/src")
}

fn read(path: &Path) -> String {
    std::fs::read_to_string(path).unwrap_or_else(|error| panic!("{}: {error}", path.display()))
}

/// The numbers of a text, and what stands between them.
fn numbers(text: &str) -> (Vec<f64>, String) {
    let mut found = Vec::new();
    let mut between = String::new();
    let mut digits = String::new();
    for c in text.chars().chain(['\n']) {
        if c.is_ascii_digit() || c == '.' {
            digits.push(c);
            continue;
        }
        match digits.parse() {
            Ok(number) => found.push(number),
            Err(_) => between += &digits,
        }
        digits.clear();
        between.push(c);
    }
    (found, between)
}

#[test]
fn every_page_that_is_written_from_the_registry_is_up_to_date() {
    let again = "cargo xtask book writes it again";
    let glossary = read(&sources().join("glossary.md"));
    assert_eq!(book::glossary_page(&glossary), glossary, "glossary.md is out of date: {again}");
    for kind in Kind::ALL {
        let page = read(&sources().join(format!("effects/{kind}.md")));
        assert_eq!(book::effect_page(*kind, &page), page, "{kind}.md is out of date: {again}");
        for heading in ["## In the plots", "## A real example", "## What looks alike", "## How to show it"] {
            assert!(page.contains(heading), "{kind}.md has no section \"{heading}\"");
        }
    }
}

#[test]
fn every_plot_shows_what_the_effect_does_today() {
    for kind in [Kind::Coulomb, Kind::Backlash, Kind::SensorLag] {
        let written = read(&sources().join(format!("effects/{kind}.svg")));
        let now = book::plot(kind).expect("a plot");
        let ((old, words), (new, own)) = (numbers(&written), numbers(&now));
        assert_eq!(words, own, "{kind}.svg is out of date: cargo xtask book draws it again");
        // Another processor may round a point to the pixel beside.
        let off = old.iter().zip(&new).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(old.len() == new.len() && off <= 1.0, "{kind}.svg is off by {off} pixels");
    }
    for kind in Kind::ALL {
        let size = read(&sources().join(format!("effects/{kind}.svg"))).len();
        assert!((2_000..30_000).contains(&size), "{kind}.svg has {size} bytes");
    }
}

/// Pages named in SUMMARY.md.
fn pages() -> Vec<String> {
    let summary = read(&sources().join("SUMMARY.md"));
    let links = summary.lines().filter_map(|line| line.split_once("](")?.1.split_once(')'));
    links.map(|(path, _)| path.to_owned()).collect()
}

#[test]
fn the_summary_names_every_page_once_and_nothing_else() {
    let mut named = pages();
    let mut there: Vec<String> = program::files(&sources())
        .into_iter()
        .chain(program::files(&sources().join("effects")))
        .filter(|path| path.extension().is_some_and(|e| e == "md") && !path.ends_with("SUMMARY.md"))
        .map(|path| path.strip_prefix(sources()).expect("a page").to_string_lossy().replace('\\', "/"))
        .collect();
    named.sort();
    there.sort();
    assert_eq!(named, there);
}

/// The program's command lines on every page: in fenced blocks and in code within a line.
fn commands() -> Vec<(String, String)> {
    let mut all = Vec::new();
    for page in pages() {
        let text = read(&sources().join(&page));
        let mut fenced = false;
        for line in text.lines() {
            if line.starts_with("```") {
                fenced = !fenced;
            } else if fenced && line.starts_with("motorlens ") {
                all.push((page.clone(), line.to_owned()));
            } else {
                let spans = line.split('`').skip(1).step_by(2);
                let lines = spans.filter(|code| code.starts_with("motorlens ") && !code.contains("..."));
                all.extend(lines.map(|code| (page.clone(), code.to_owned())));
            }
        }
    }
    all
}

#[test]
fn every_command_of_the_book_is_one_that_the_program_takes() {
    let all = commands();
    assert!(all.len() > 40, "{} commands", all.len());
    for (page, line) in all {
        let parsed = cli::command().try_get_matches_from(line.split_whitespace());
        assert!(parsed.is_ok(), "{page}: {line}: {}", parsed.unwrap_err());
    }
}

/// What needs a board or a browser is run by the tests that have one.
fn can_run_here(line: &str) -> bool {
    let verb = line.split_whitespace().nth(1).unwrap_or_default();
    !["serve", "capture", "device"].contains(&verb)
}

/// The chapters one after the other, as a reader goes through them, and then each effect's page.
fn in_order() -> Vec<(String, String)> {
    let chapters = ["first-log.md", "experiment.md", "model.md", "effects.md"];
    let place = |page: &str| chapters.iter().position(|chapter| *chapter == page).unwrap_or(chapters.len());
    let mut all = commands();
    all.sort_by_key(|(page, _)| place(page));
    all.retain(|(_, line)| can_run_here(line));
    all
}

/// What readers have: an Arduino's table on the first page, a log with names later, logs of some days, and the effect that a page defines.
fn as_readers_have(directory: &Path, page: &str) {
    let logs = directory.join("s");
    let copy = |from: &str, to: &str| {
        std::fs::copy(logs.join(from), directory.join(to)).expect("a log can be copied");
    };
    match page {
        "first-log.md" if logs.exists() => {
            let text = read(&logs.join("prbs.csv"));
            let rows = text.lines().filter_map(|line| {
                let row: Vec<f64> = line.split(',').filter_map(|cell| cell.parse().ok()).collect();
                let [time, volts, angle] = row.try_into().ok()?;
                let counts = angle / std::f64::consts::TAU * 1320.0;
                Some(format!("{:.0},{:.0},{counts:.0}\n", time * 1e3, volts / 11.1 * 255.0))
            });
            let table: String = std::iter::once("millis,pwm,enc\n".to_owned()).chain(rows).collect();
            std::fs::write(directory.join("log.csv"), table).expect("a log can be written");
        }
        "model.md" => {
            for (from, to) in [
                ("prbs.csv", "monday-1.csv"),
                ("triangle.csv", "monday-2.csv"),
                ("multisine.csv", "friday.csv"),
            ] {
                copy(from, to);
            }
        }
        "effects.md" => {
            copy("prbs.csv", "log.csv");
            let text = read(&sources().join(page));
            let defined = text.split("```toml").nth(1).and_then(|rest| rest.split("```").next());
            std::fs::write(directory.join("cam.toml"), defined.expect("an effect in TOML"))
                .expect("it can be written");
        }
        _ => {}
    }
}

#[test]
fn every_command_of_the_book_that_needs_neither_board_nor_browser_runs() {
    let directory = tempfile::tempdir().expect("a directory");
    let mut pages = std::collections::BTreeSet::new();
    for (page, line) in in_order() {
        as_readers_have(directory.path(), &page);
        program::run(directory.path(), line.strip_prefix("motorlens ").expect("a command")).ends(0);
        pages.insert(page);
    }
    let effects = Kind::ALL.iter().filter(|kind| pages.contains(&format!("effects/{}.md", kind.name())));
    assert_eq!(effects.count(), Kind::ALL.len(), "an effect's page shows no command: {pages:?}");
    for file in ["model.json", "better.json", "motor.c", "tune.svg", "coulomb.svg", "backlash-logs/prbs.csv"]
    {
        assert!(directory.path().join(file).exists(), "{file} was not written");
    }
}
