//! What a person at a terminal reads: the next command at the end of a verb, and lines that fit a narrow terminal.

use std::path::Path;

use motorlens::fit::layout::{BaseValues, Prior, Values};
use motorlens::model_file::Origin;
use motorlens::{Model, cli};
use motorlens_shared::effects::{Kind, Rig};

mod program;

/// Columns of the narrow terminal.
const NARROW: usize = 60;

/// A model file with dry friction in `directory`.
fn model(directory: &Path) {
    let base = BaseValues { gain: 1.0, tau_m: 0.06, tau_e: 8e-4, viscous_share: 0.1 };
    let values = Values { base, effects: Vec::new() }.with(Kind::Coulomb, vec![0.4]);
    let rig = Rig {
        step_s: 1e-3,
        gear_ratio: 30.0,
        encoder_on_motor: true,
        nominal_v: 12.0,
        supply_v: 12.0,
        reference_speed: 12.0,
        count_rad: 3.3e-3,
    };
    let prior = Prior { tau_e: (8e-4, 0.4), viscous_share: (0.1, 0.05) };
    let model = Model::new(&values, &rig, &prior, Origin::default());
    model.write(&directory.join("model.json")).expect("a model file");
}

/// What a verb says on a terminal of `columns`.
fn said(directory: &Path, words: &str, columns: usize) -> (String, String) {
    let mut command = program::command(directory, words);
    let output = command.env("COLUMNS", columns.to_string()).output().expect("the program starts");
    assert!(output.status.success(), "{words}: {}", String::from_utf8_lossy(&output.stderr));
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).expect("UTF-8");
    (text(output.stdout), text(output.stderr))
}

/// Quick verbs, each with the verb that it names as the next one.
const VERBS: [(&str, &str); 18] = [
    ("simulate --hidden 5 --rate 100 --out s", "discover"),
    ("reveal s", "report"),
    ("compare model.json s/prbs.csv --motor s/motor.toml", "diagnose"),
    ("tune model.json --period 0.005", "export"),
    ("export model.json --format c --out motor.c", "tune"),
    ("exam --singles 0 --nothing 1 --pairs 0 --outside 0 --only coulomb", "exam"),
    ("exam --singles 0 --nothing 1 --pairs 0 --outside 0 --only coulomb --out kept", "simulate"),
    ("exam --benches --cases 1 --bench protocol --write cases", "discover"),
    ("same s/triangle.csv --effects none -- s/prbs.csv", ""),
    ("fit s/triangle.csv --effects coulomb --motor s/motor.toml --out base.json", "diagnose base.json"),
    ("fit s/triangle.csv --motor s/motor.toml", "diagnose model.json"),
    ("diagnose base.json s/triangle.csv --motor s/motor.toml", ""),
    ("add base.json delay s/triangle.csv --motor s/motor.toml --out better.json", "diagnose"),
    ("discover s/triangle.csv --motor s/motor.toml --out found.json", ""),
    ("discover s/triangle.csv --motor s/motor.toml", ""),
    ("plan s/triangle.csv --motor s/motor.toml --out next.json", ""),
    ("plan base.json s/triangle.csv --motor s/motor.toml", ""),
    ("report s/triangle.csv --motor s/motor.toml --out r.html", ""),
];

/// Panics unless `told` ends with the command that begins with `next`, the program takes it, and no line is too wide.
fn ends_with_a_command(words: &str, told: &str, next: &str) {
    let lines: Vec<&str> = told.trim_end().lines().collect();
    let [.., what, command] = lines.as_slice() else { panic!("{words}: {told}") };
    assert!(told.contains("next: "), "{words}: {what}");
    assert!(command.starts_with(&format!("  motorlens {next}")), "{words}: {command}");
    for line in lines.iter().filter(|line| line.starts_with("  motorlens ")) {
        // What only the user knows is a number.
        let line = line.replace("COUNTS", "1200");
        let parsed = cli::command().try_get_matches_from(line.split_whitespace());
        assert!(parsed.is_ok(), "{words}: {line}: {}", parsed.unwrap_err());
    }
    let wide = lines
        .iter()
        .find(|line| line.chars().count() > NARROW && !line.trim_start().starts_with("motorlens "));
    assert!(wide.is_none(), "{words}: wider than {NARROW} columns: {wide:?}");
}

#[test]
fn every_verb_ends_with_the_next_command_and_its_lines_fit() {
    let directory = tempfile::tempdir().expect("a directory");
    model(directory.path());
    for (words, next) in VERBS {
        let (_, told) = said(directory.path(), words, NARROW);
        ends_with_a_command(words, &told, next);
    }
}

#[test]
fn the_manual_ends_with_the_command_that_shows_its_first_page() {
    let directory = tempfile::tempdir().expect("a directory");
    let told = said(directory.path(), "man pages", NARROW).1;
    assert!(told.trim_end().ends_with("next: read the first with\n  man pages/motorlens.1"), "{told}");
    assert!(directory.path().join("pages/motorlens.1").is_file());
}

#[test]
fn the_demo_ends_with_the_next_command_too() {
    let directory = tempfile::tempdir().expect("a directory");
    let words = "demo --hidden 3 --out d";
    ends_with_a_command(words, &said(directory.path(), words, NARROW).1, "");
}

#[test]
fn an_effect_is_explained_within_a_narrow_terminal() {
    for columns in [40, NARROW, 80] {
        let (told, _) = said(Path::new("."), "effects stribeck", columns);
        let wide = told.lines().find(|line| line.chars().count() > columns);
        assert!(wide.is_none() && told.contains("in data: "), "wider than {columns} columns: {wide:?}");
    }
}

#[test]
fn a_program_that_listens_gets_the_same_document_on_any_terminal() {
    let directory = tempfile::tempdir().expect("a directory");
    model(directory.path());
    for words in ["tune model.json --json", "effects stribeck --json"] {
        let (wide, _) = said(directory.path(), words, 200);
        let (narrow, told) = said(directory.path(), words, NARROW);
        assert_eq!(wide, narrow, "{words}");
        assert!(!told.contains("next: "), "{words}: {told}");
        serde_json::from_str::<serde_json::Value>(&narrow).expect("JSON");
    }
}

#[test]
fn the_data_problems_that_the_fit_shows_stand_on_the_terminal_too_when_a_report_is_written() {
    let directory = tempfile::tempdir().expect("a directory");
    // A fifth of a second in which the motor only gathers speed.
    let row = |k: u32| {
        let (t, noise) = (0.01 * f64::from(k), if k.is_multiple_of(3) { 2e-3 } else { 0.0 });
        let volts = 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin();
        format!("{t:.2},{volts:.4},{:.6}\n", 60.0 * t.powi(3) + noise)
    };
    let log = "time_s,voltage_v,angle_rad\n".to_owned() + &(0..20).map(row).collect::<String>();
    std::fs::write(directory.path().join("short.csv"), log).expect("a log");
    let (_, told) = said(directory.path(), "report short.csv --out r.html", 80);
    let problem = told.find("data: all records together: too_little_excitation: these records do not");
    assert!(problem.is_some() && problem < told.find("next: "), "{told}");
}
