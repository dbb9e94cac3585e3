//! Users read the words of system identification, control and mechatronics, and none that were coined here.
//!
//! Looked through are the documents, the book, the help of every verb, what the registry and the glossary say, the page and the report,
//! the sentences that the program prints, and the comments of the sources.

mod repository;

use clap::Command;
use motorlens::{cli, glossary};
use motorlens_shared::effects::Kind;
use repository::{files_below, root, text_of};

/// A coined word, and the one to write.
const COINED: [(&str, &str); 50] = [
    ("teeth", "cogging torque, torque ripple; gear contact"),
    ("guided run", "prediction with measured angle"),
    ("guided runs", "prediction with measured angle"),
    ("free run", "simulation (open loop)"),
    ("free runs", "simulation (open loop)"),
    ("run free", "simulated open loop"),
    ("noise unit", "multiple of the noise"),
    ("noise units", "multiples of the noise"),
    ("calm", "without a disturbance torque"),
    ("unrest", "disturbance torque present"),
    ("merit", "selection criterion, score"),
    ("taken back", "rejected, removed"),
    ("takes back", "rejects, removes"),
    ("take back", "reject, remove"),
    ("withdrawn", "rejected, removed"),
    ("climb", "forward selection"),
    ("climbs", "forward selections"),
    ("rung", "model, step"),
    ("rungs", "models, steps"),
    ("detour", "exchange step"),
    ("detours", "exchange steps"),
    ("swapped in", "exchanged"),
    ("feeler", "pattern search"),
    ("felt for", "searched (pattern search)"),
    ("shaken", "restarted from perturbed parameters"),
    ("heats", "screening rounds"),
    ("race", "successive halving"),
    ("give way", "partialling out"),
    ("given way", "partialled out"),
    ("gives way", "is partialled out"),
    ("increments", "50 ms differences of the error"),
    ("straightened", "reset to the prior mean"),
    ("bent", "biased"),
    ("given back", "exchanged along a correlated direction"),
    ("disc off centre", "encoder eccentricity"),
    ("discs off centre", "encoder eccentricity"),
    ("starts in motion", "initial conditions"),
    ("straight values", "parameter transform"),
    ("quantum", "quantisation step"),
    ("crew", "thread pool"),
    ("law", "equation"),
    ("laws", "equations"),
    ("parabola's interval", "quadratic (Wald) interval"),
    ("record stands out", "is an outlier"),
    ("renewal", "update instant, update"),
    ("renewals", "update instants, updates"),
    ("a beat", "an interval, evenly spaced"),
    ("the beat", "the update rate"),
    ("odd", "data quality problem"),
    ("perfect model", "noise level (from a repeated record)"),
];

/// What is right all the same: laws with the name of a person, a path in the code, the value of an option.
const RIGHT: [&str; 8] = [
    "newton's drag law",
    "hooke's law",
    "diagnose::climb",
    "diagnose::detours",
    "diagnose::teeth",
    "compare::free_run",
    "default: increments",
    "- increments:",
];

/// Coined words in a text, each with the word to write.
fn coined(text: &str) -> Vec<String> {
    let mut lower = text.to_lowercase();
    for right in RIGHT {
        lower = lower.replace(right, " ");
    }
    let words: Vec<&str> =
        lower.split(|c: char| !(c.is_alphanumeric() || c == '\'')).filter(|w| !w.is_empty()).collect();
    let text = format!(" {} ", words.join(" "));
    let found = COINED.iter().filter(|(word, _)| text.contains(&format!(" {word} ")));
    found.map(|(word, instead)| format!("\"{word}\" (write: {instead})")).collect()
}

/// Panics with every coined word of these texts, each of which has a name.
fn free_of_coined_words(texts: impl IntoIterator<Item = (String, String)>) {
    let mut all = Vec::new();
    for (place, text) in texts {
        for (line, words) in text.lines().enumerate() {
            let found = coined(words);
            all.extend(found.iter().map(|word| format!("{place}:{}: {word}", line + 1)));
        }
    }
    assert!(all.is_empty(), "coined words:\n{}", all.join("\n"));
}

#[test]
fn the_documents_and_the_book() {
    let mut files = ["README.md", "CHANGELOG.md", "python/README.md"].map(|file| root().join(file)).to_vec();
    files.extend(files_below(root().join("docs"), &["md"]));
    free_of_coined_words(files.iter().map(|path| (path.display().to_string(), text_of(path))));
}

/// The help of a verb and of those below it.
fn help(command: &Command, texts: &mut Vec<(String, String)>) {
    texts.push((format!("{} --help", command.get_name()), command.clone().render_long_help().to_string()));
    command.get_subcommands().for_each(|verb| help(verb, texts));
}

#[test]
fn the_help_of_every_verb() {
    let mut texts = Vec::new();
    help(&cli::command(), &mut texts);
    assert!(texts.len() > 20, "{} helps", texts.len());
    free_of_coined_words(texts);
}

#[test]
fn the_registry_and_the_glossary() {
    let effects = Kind::ALL.iter().map(|kind| {
        let spec = kind.spec();
        let meanings: Vec<&str> = spec.parameters.iter().map(|p| p.meaning).collect();
        let lines = [spec.title, spec.equation, spec.source, spec.signature].into_iter().chain(meanings);
        (kind.to_string(), lines.collect::<Vec<_>>().join("\n"))
    });
    let words =
        glossary::WORDS.iter().map(|[word, meaning]| ("glossary".to_owned(), format!("{word}\n{meaning}")));
    free_of_coined_words(effects.chain(words));
}

/// What is written between double quotes, a line each, where it is a sentence and no name; one that a backslash continues goes on in the next
/// line.
fn sentences(code: &str) -> String {
    let code = code.split("#[cfg(test)]").next().unwrap_or_default();
    let mut within = false;
    let mut spoken = |line: &str| {
        if !within && line.trim_start().starts_with("//") {
            return String::new();
        }
        let line = line.replace("\\\"", " ");
        let parts: Vec<&str> = line.split('"').collect();
        let texts = parts.iter().enumerate().filter(|(k, _)| (k % 2 == 1) != within).map(|(_, text)| *text);
        let texts = texts.filter(|text| text.trim().contains(' ')).collect::<Vec<_>>().join(" | ");
        within = parts.len().is_multiple_of(2) != within && line.trim_end().ends_with('\\');
        texts
    };
    code.lines().map(&mut spoken).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_sentence_that_goes_on_in_the_next_line_is_read_to_its_end() {
    let code = "say(\"one line \\\n    and a second\"); // a remark\nsay(\"a third\")";
    assert_eq!(sentences(code), "one line \\\n    and a second\na third");
}

/// What a reader of the page sees of its source: no tags, no placeholders.
fn seen(html: &str) -> String {
    let mut text = String::new();
    let mut depth = 0_u32;
    for c in html.chars() {
        match c {
            '<' | '{' => depth += 1,
            '>' | '}' => depth = depth.saturating_sub(1),
            '\n' => text.push('\n'),
            c if depth == 0 => text.push(c),
            _ => {}
        }
    }
    text
}

#[test]
fn the_page_and_the_report() {
    let source = |file: &str| text_of(&root().join("host/src").join(file));
    let pages = ["report/assets/report.html", "serve/assets/page.html"].map(|file| {
        let whole = source(file);
        let text = whole.split("<script>").next().unwrap_or_default().to_owned();
        (file.to_owned(), seen(&text))
    });
    let mut scripts = Vec::new();
    for directory in ["host/src/report/assets", "host/src/serve/assets"] {
        scripts.extend(files_below(root().join(directory), &["js"]));
    }
    let own = scripts.into_iter().filter(|path| !path.display().to_string().contains("uplot"));
    let own = own.map(|path| (path.display().to_string(), sentences(&text_of(&path))));
    free_of_coined_words(pages.into_iter().chain(own));
}

#[test]
fn the_sentences_that_the_program_prints() {
    let mut files = Vec::new();
    for part in ["cli", "findings", "report", "serve", "tune", "export", "paper"] {
        files.extend(files_below(root().join("host/src").join(part), &["rs"]));
    }
    files.push(root().join("host/src/same.rs"));
    free_of_coined_words(files.iter().map(|path| (path.display().to_string(), sentences(&text_of(path)))));
}

/// What has another meaning in a comment: numbers, teeth of gears and of sawtooths, and a beat of two rates.
const ELSEWHERE: [&str; 5] = ["odd", "teeth", "heats", "a beat", "the beat"];

/// The comments of a source, a line each, without the code in them.
fn comments(code: &str) -> String {
    let comment = |line: &str| {
        let line = line.trim_start();
        let parts = line.split('`').step_by(2).collect::<Vec<_>>();
        if line.starts_with("//") { parts.join(" ") } else { String::new() }
    };
    code.lines().map(comment).collect::<Vec<_>>().join("\n")
}

#[test]
fn what_python_says_of_its_functions() {
    let files = files_below(root().join("python/python"), &["py", "pyi"]);
    assert!(!files.is_empty());
    // Sentences stand in documentation strings and behind #.
    let said = |text: &str| {
        let spoken = |line: &str| line.contains("\"\"\"") || line.trim_start().starts_with('#');
        text.lines().map(|line| if spoken(line) { line } else { "" }).collect::<Vec<_>>().join("\n")
    };
    free_of_coined_words(files.iter().map(|path| (path.display().to_string(), said(&text_of(path)))));
}

#[test]
fn the_comments_of_the_page_and_its_style() {
    let mut files = Vec::new();
    for part in ["report/assets", "serve/assets"] {
        files.extend(files_below(root().join("host/src").join(part), &["js", "css"]));
    }
    let own = files.iter().filter(|path| !path.display().to_string().contains("uplot"));
    // Of the script the lines that are comments; a style has nothing else that could be a sentence.
    free_of_coined_words(own.map(|path| {
        let text = text_of(path);
        let is_style = path.extension().is_some_and(|ending| ending == "css");
        (path.display().to_string(), if is_style { text } else { comments(&text) })
    }));
}

#[test]
fn the_comments_of_the_sources() {
    let crates =
        ["host", "host/kernel", "host/virtual-motor", "host/bench-motor", "shared", "firmware", "python"];
    let mut all = Vec::new();
    for path in crates.iter().flat_map(|one| files_below(root().join(one).join("src"), &["rs"])) {
        for (line, words) in comments(&text_of(&path)).lines().enumerate() {
            let found = coined(words).into_iter();
            let found =
                found.filter(|word| !ELSEWHERE.iter().any(|other| word.starts_with(&format!("\"{other}\""))));
            all.extend(found.map(|word| format!("{}:{}: {word}", path.display(), line + 1)));
        }
    }
    assert!(all.is_empty(), "coined words:\n{}", all.join("\n"));
}

#[test]
fn a_coined_word_is_found_and_a_right_one_is_not() {
    assert_eq!(coined("Taken back: the TEETH, by a climb.").len(), 3);
    assert!(coined("Hooke's law; `diagnose::climb`; climbing stairs; programme").is_empty());
    assert_eq!(sentences("let x = \"a b\"; // \"c d\"\n//! \"e f\""), "a b | c d\n");
    assert_eq!(comments("let law = 1;\n    /// A `law` of [`Laws`], odd."), "\n/// A   of [ ], odd.");
    assert_eq!(seen("<p title=\"law\">a {{ law }} b</p>"), "a  b");
}
