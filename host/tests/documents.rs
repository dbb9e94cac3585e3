//! The documents: short paragraphs, links that lead somewhere, and no file named that is not there.

mod repository;

use std::path::{Path, PathBuf};

use repository::{files_below, root, text_of};

/// Lines of a paragraph; its lines are no longer than `LONGEST_LINE` characters.
const MOST_LINES: usize = 8;
const LONGEST_LINE: usize = 150;
/// The examination fits on one page: lines, figures included.
const ONE_PAGE: usize = 90;

/// All documents with their text.
fn documents() -> Vec<(PathBuf, String)> {
    let single = [root().join("README.md"), root().join("python/README.md")];
    let files = single.into_iter().chain(files_below(root().join("docs"), &["md"]));
    files.map(|path| (path.clone(), text_of(&path))).collect()
}

/// The text without blocks of code.
fn prose(text: &str) -> Vec<&str> {
    let mut fenced = false;
    let keep = |line: &&str| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    };
    text.lines().filter(keep).collect()
}

/// Whether a line belongs to something else than a paragraph: a heading, a table, a list, code that is set in.
fn stands_alone(line: &str) -> bool {
    let words = line.trim_start();
    let numbered = words.split_once(". ").is_some_and(|(n, _)| n.chars().all(|c| c.is_ascii_digit()));
    line.starts_with("    ")
        || numbered
        || ["#", "|", "- ", "* ", "!", "<"].iter().any(|mark| words.starts_with(mark))
}

/// Paragraphs as their first line and how many lines they have. The lines of a list item that follow its first are no paragraph.
fn paragraphs(text: &str) -> Vec<(String, usize)> {
    let mut all: Vec<(String, usize)> = Vec::new();
    let mut open = false;
    let mut in_item = false;
    for line in prose(text) {
        if line.trim().is_empty() {
            (open, in_item) = (false, false);
        } else if stands_alone(line) {
            (open, in_item) = (false, true);
        } else if in_item {
        } else if open {
            all.last_mut().expect("a paragraph is open").1 += 1;
        } else {
            all.push((line.to_owned(), 1));
            open = true;
        }
    }
    all
}

#[test]
fn no_paragraph_is_longer_than_eight_lines() {
    let mut long = Vec::new();
    for (path, text) in documents() {
        let paragraphs = paragraphs(&text).into_iter().filter(|(_, lines)| *lines > MOST_LINES);
        long.extend(paragraphs.map(|(first, lines)| format!("{}: {lines} lines: {first}", path.display())));
        // What is generated has a paragraph on a line.
        if !text.contains("<!-- generated") {
            let wide = |line: &&str| line.chars().count() > LONGEST_LINE && !stands_alone(line);
            long.extend(
                prose(&text).into_iter().filter(wide).map(|line| format!("{}: {line}", path.display())),
            );
        }
    }
    assert!(long.is_empty(), "too long:\n{}", long.join("\n"));
}

#[test]
fn the_examination_is_one_page_and_the_architecture_has_a_diagram() {
    let docs = root().join("docs");
    let exam = std::fs::read_to_string(docs.join("EXAM.md")).expect("a document");
    assert!(exam.lines().count() <= ONE_PAGE, "{} lines", exam.lines().count());
    let architecture = std::fs::read_to_string(docs.join("ARCHITECTURE.md")).expect("a document");
    let diagram =
        architecture.split("```mermaid").nth(1).and_then(|rest| rest.split("```").next()).expect("a diagram");
    assert!(diagram.matches("-->").count() >= 10, "{diagram}");
}

#[test]
fn every_link_leads_to_a_file_that_is_there() {
    let mut links = 0;
    for (path, text) in documents() {
        let folder = path.parent().expect("a folder");
        for piece in prose(&text).join("\n").split("](").skip(1) {
            let target = piece.split([')', '#', ' ']).next().unwrap_or_default();
            if target.is_empty() || target.contains("://") || target.starts_with("mailto:") {
                continue;
            }
            links += 1;
            assert!(folder.join(target).exists(), "{}: the link {target} leads nowhere", path.display());
        }
    }
    assert!(links > 60, "{links} links");
}

/// What ends like a file of this repository.
const ENDINGS: [&str; 8] = [".rs", ".md", ".json", ".py", ".ino", ".toml", ".html", ".js"];

#[test]
fn no_document_names_a_source_file_that_is_not_there() {
    let parts = ["host/", "shared/", "docs/", "tests/", "firmware/", "model/", "python/", "xtask/"];
    let mut named = 0;
    for (path, text) in documents() {
        for code in text.split('`').skip(1).step_by(2) {
            let is_path =
                parts.iter().any(|part| code.starts_with(part)) && !code.contains(['*', ' ', '{', '<']);
            let is_file = ENDINGS.iter().any(|ending| code.ends_with(ending));
            if is_path && (is_file || !code.rsplit('/').next().unwrap_or_default().contains('.')) {
                named += 1;
                let there = root().join(code).exists() || root().join(format!("{code}.rs")).exists();
                assert!(there, "{} names {code}, which is not there", path.display());
            }
        }
    }
    assert!(named > 15, "{named} files are named");
}

/// Modules of the host that documents name, as `fit::grid`, are there under that name.
#[test]
fn no_document_names_a_module_that_is_not_there() {
    for (path, text) in documents() {
        for code in text.split('`').skip(1).step_by(2) {
            let parts: Vec<&str> = code.split("::").collect();
            let plain =
                |part: &&str| part.chars().all(|c| c.is_ascii_lowercase() || c == '_') && !part.is_empty();
            if parts.len() < 2 || !parts.iter().all(plain) {
                continue;
            }
            let module = parts.join("/");
            let inner = parts[..parts.len() - 1].join("/");
            let places = ["host/src", "shared/src", "host/kernel/src"].map(|source| root().join(source));
            let inside = |source: &Path| {
                let file = [source.join(format!("{inner}.rs")), source.join(&inner).join("mod.rs")];
                let named = parts[parts.len() - 1];
                file.iter().any(|f| std::fs::read_to_string(f).is_ok_and(|text| text.contains(named)))
            };
            let there = |source: &PathBuf| {
                source.join(format!("{module}.rs")).exists()
                    || source.join(&module).is_dir()
                    || inside(source)
            };
            let bare =
                parts[0] == "shared" && root().join("shared/src").join(format!("{}.rs", parts[1])).exists();
            assert!(bare || places.iter().any(there), "{} names {code}, which is not there", path.display());
        }
    }
}

#[test]
fn every_test_that_the_safety_page_names_is_there() {
    let folders = ["firmware", "host", "shared", "tests"].map(|folder| root().join(folder));
    let sources: Vec<String> = folders
        .into_iter()
        .flat_map(|folder| files_below(folder, &["rs"]))
        .map(|path| text_of(&path))
        .collect();
    let text = text_of(&root().join("docs/SAFETY.md"));
    let rows = text.lines().filter(|line| line.starts_with("| ") && line.contains("`"));
    let named: Vec<&str> = rows
        .filter_map(|row| row.trim_end_matches(" |").rsplit(" | ").next())
        .flat_map(|tests| tests.split('`').skip(1).step_by(2))
        .collect();
    assert!(named.len() > 30, "{} tests are named", named.len());
    let there = |name: &&str| sources.iter().any(|text| text.contains(&format!("fn {name}(")));
    let missing: Vec<&str> = named.into_iter().filter(|name| !there(name)).collect();
    assert!(missing.is_empty(), "docs/SAFETY.md names tests that are not there: {missing:?}");
}

#[test]
fn items_of_lists_tables_and_code_are_no_paragraphs() {
    let text = "one\ntwo\n\n- item\n  goes on\n  and on\n\n| a |\n| b |\n\n    code\n\n```sh\nx\n```\n1. first\n   goes on\n\nlast\n";
    let found: Vec<(String, usize)> =
        [("one", 2), ("last", 1)].map(|(line, n)| (line.to_owned(), n)).to_vec();
    assert_eq!(paragraphs(text), found);
}
