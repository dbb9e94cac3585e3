//! The commands for a board that README, docs and book print, word for word, so that tests can run what people copy.

use std::path::{Path, PathBuf};

/// A printed command.
pub struct Line {
    words: Vec<String>,
}

/// What stands for a user's own word in [`Line::shape`], by the option before it.
const OWN: [(&str, &str); 3] = [("--port", "PORT"), ("--out", "DIR"), ("--counts-per-rev", "COUNTS")];

impl Line {
    /// The words behind `motorlens`, with this port and this directory in the place of those that are printed.
    pub fn as_run(&self, port: &str, out: &Path) -> Vec<String> {
        let out = out.display().to_string();
        self.with(|option| match option {
            "--port" => Some(port),
            "--out" => Some(out.as_str()),
            _ => None,
        })
    }

    /// The command without what is a user's own.
    pub fn shape(&self) -> String {
        let own = |option: &str| OWN.iter().find(|(name, _)| *name == option).map(|(_, word)| *word);
        self.with(own).join(" ")
    }

    /// The words, and behind an option what `word` has for it.
    fn with<'a>(&self, word: impl Fn(&str) -> Option<&'a str>) -> Vec<String> {
        let before = std::iter::once("").chain(self.words.iter().map(String::as_str));
        let pairs = before.zip(&self.words);
        pairs.map(|(option, printed)| word(option).map_or_else(|| printed.clone(), str::to_owned)).collect()
    }
}

/// All lines of the project at `root` that begin with `motorlens capture` or `motorlens device`, README's first.
pub fn lines(root: &Path) -> Vec<Line> {
    let mut files = vec![root.join("README.md")];
    for directory in ["docs", "docs/book/src"] {
        let entries = std::fs::read_dir(root.join(directory)).into_iter().flatten().flatten();
        let mut pages: Vec<PathBuf> = entries.map(|entry| entry.path()).collect();
        pages.retain(|page| page.extension().is_some_and(|end| end == "md"));
        pages.sort();
        files.extend(pages);
    }
    let texts = files.iter().map(|file| std::fs::read_to_string(file).unwrap_or_default());
    texts.flat_map(|text| text.lines().filter_map(printed).collect::<Vec<_>>()).collect()
}

/// The command that a line of a document is, if it is one; what stands behind it as a comment is none of it.
fn printed(line: &str) -> Option<Line> {
    let command = line.trim().strip_prefix("motorlens ")?;
    let command = command.split(" #").next().unwrap_or_default();
    let for_a_board = command.starts_with("capture ") || command.starts_with("device ");
    // Prose that happens to begin so has its words in code.
    (for_a_board && !command.contains('`'))
        .then(|| Line { words: command.split_whitespace().map(str::to_owned).collect() })
}

/// The first line of this shape.
pub fn line(root: &Path, shape: &str) -> Option<Line> {
    lines(root).into_iter().find(|line| line.shape() == shape)
}
