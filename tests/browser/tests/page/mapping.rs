//! How the columns of a log are read: changed after it was loaded, said once for all files of its kind, mended before anything is added.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use motorlens_browser_tests::{Browser, Server};
use serde_json::json;

use super::logs::{asked_about, taken};
use super::{FRESH, alone, opened};

/// An Arduino's log of a motor of 2.1 rad/s per volt at a supply of 12 V: milliseconds, duty of 255, counts, 1320 a turn.
pub fn arduino(directory: &Path, name: &str, phase: f64) -> PathBuf {
    let mut text = "millis,pwm,enc\n".to_owned();
    let (mut w, mut x) = (0.0, 0.0);
    for k in 0..800 {
        let t = 0.01 * f64::from(k);
        let duty = (110.0 * (2.0 * t + phase).sin() + 40.0 * (7.0 * t).sin()).round();
        writeln!(text, "{},{duty},{x:.0}", 10 * k).unwrap();
        w += 0.01 * (0.1 * duty - w) / 0.06;
        x += 0.01 * w * 1320.0 / std::f64::consts::TAU;
    }
    let path = directory.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Loads such a log with what the dialogue does not know.
fn loaded(browser: &mut Browser, log: &Path, title: &str) {
    asked_about(browser, log);
    browser.value(
        "$('log-supply-volts').value = '12', $('log-counts-per-rev').value = '1320', $('log-gear-ratio').value = '50', $('log-encoder-shaft').value = 'output'",
    );
    taken(browser, title);
}

/// The gain of the base model, rad/s per volt.
fn gain(browser: &mut Browser) -> f64 {
    browser.number("state.parameters.find((p) => p.name == 'gain').value")
}

#[test]
fn gear_shaft_and_supply_are_taken_from_the_dialogue_and_changed_after_the_log_was_loaded() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    loaded(&mut browser, &arduino(directory.path(), "one.csv", 0.0), "one");
    assert_eq!(browser.value("ask('/api/state').then((s) => s.gear_ratio)"), 50.0);
    let at_12 = gain(&mut browser);

    // The same dialogue, filled with what is in use.
    browser.click("#entries .columns");
    browser.wait("$('dialog').open");
    assert_eq!(browser.text("#h-dialog").trim(), "Columns of one.csv");
    let kinds = "[...document.querySelectorAll('#preview select')].map((s) => s.value)";
    assert_eq!(browser.value(kinds), json!(["time:ms", "duty:255", "angle:counts"]));
    let fields = "['log-supply-volts', 'log-counts-per-rev', 'log-gear-ratio', 'log-encoder-shaft'].map((id) => $(id).value)";
    assert_eq!(browser.value(fields), json!(["12", "1320", "50", "output"]));
    assert_eq!(
        browser.value("$('log-role').hidden && $('log-records').hidden && $('log-alike').hidden"),
        true
    );
    browser.screenshot("#dialog", "light-0-columns-again");
    browser.value("$('log-supply-volts').value = '6'");
    browser.click("#use");
    browser.wait(&format!("/Undo reads them as before/.test($('status').textContent) && {FRESH}"));
    let at_6 = gain(&mut browser);
    assert!((at_6 / at_12 / 2.0 - 1.0).abs() < 0.02, "{at_12} at 12 V, {at_6} at 6 V");
    browser.click("#undo");
    browser.wait(&format!("/last change of the data is undone/.test($('status').textContent) && {FRESH}"));
    assert!((gain(&mut browser) / at_12 - 1.0).abs() < 1e-6);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn what_the_guess_leaves_open_is_asked_in_the_words_of_the_page_and_any_unit_can_be_given() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    asked_about(&mut browser, &arduino(directory.path(), "one.csv", 0.0));
    let asked = browser.text("#log-asked");
    assert!(asked.contains("Nothing tells the full duty of \"pwm\""), "{asked}");
    // What the command line writes as duty=pwm:1023 is chosen here.
    assert!(asked.contains("\"pwm\" as duty of 1023") && !asked.contains("duty="), "{asked}");
    browser.screenshot("#dialog", "light-0-questions");

    // A full duty that is not in the list.
    let other = "(() => { const pwm = document.querySelectorAll('#preview select')[1]; pwm.value = 'other'; \
                 pwm.dispatchEvent(new Event('change')); return pwm.value; })()";
    for (said, taken) in [("'duty:150'", "duty:150"), ("null", "duty:150"), ("'150'", "duty:150")] {
        browser.value(&format!("void (globalThis.prompt = () => {said})"));
        assert_eq!(browser.value(other), taken, "{said}");
    }
    assert_eq!(browser.value("mapOf(dropped.table, kindsChosen())"), "time=0:ms,duty=1:150,angle=2:counts");
    browser.value("$('log-supply-volts').value = '12', $('log-counts-per-rev').value = '1320'");
    taken(&mut browser, "one");
    browser.click("#entries .columns");
    browser.wait("$('dialog').open");
    assert_eq!(browser.value("kindsChosen()"), json!(["time:ms", "duty:150", "angle:counts"]));
    assert_eq!(browser.value("$('log-asked').hidden"), true, "another duty was given than that guessed");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_command_of_a_question_is_said_as_what_to_choose() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    for (question, said) in [
        (
            "\"u\" is taken for millivolts; where it is a duty, write duty=u:9000 --supply-volts 12",
            "\"u\" is taken for millivolts; where it is a duty, choose \"u\" as duty of 9000, with 12 in \"Supply (V), for a duty\".",
        ),
        (
            "where L is the other side of the same bridge, write duty=R-L:255",
            "Where L is the other side of the same bridge, choose \"R\" as duty of 255 and \"L\" as taken off the duty: the bridge's other side.",
        ),
        (
            "if it is that, say --map \"time=0:ms,voltage=left mode:V\" --rate 100 where it is volts",
            "If it is that, choose \"t\" as time in ms, \"left mode\" as voltage in V, with 100 in \"Samples per second\" where it is volts.",
        ),
        ("log it (direction=COLUMN)", "Log it (its column as direction in sign)."),
    ] {
        let names = json!(["t", "u", "R", "L", "left mode"]);
        assert_eq!(browser.value(&format!("askedOnPage({}, {names})", json!(question))), said);
    }
}

#[test]
fn a_mapping_is_remembered_and_a_second_file_of_the_same_columns_is_read_as_the_first() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let one = arduino(directory.path(), "one.csv", 0.0);
    loaded(&mut browser, &one, "one");
    // The second one is not asked about, told in one line, and can be changed.
    browser.give_file("#file", &arduino(directory.path(), "two.csv", 1.0));
    browser.wait(&format!("state.data.entries.length == 2 && {FRESH}"));
    assert_eq!(browser.value("$('dialog').open"), false);
    let told = browser.text("#read-as-words");
    assert!(told.starts_with("two.csv is read as one.csv: millis is time in ms"), "{told}");
    assert!(told.contains("Supply (V) 12"), "{told}");
    browser.screenshot("header", "light-0-read-as");
    browser.click("#read-as-change");
    browser.wait("$('dialog').open");
    assert_eq!(browser.text("#log-name"), "two.csv");
    assert_eq!(browser.value("!$('log-alike').hidden && $('log-all').checked"), true);
    let before = gain(&mut browser);
    browser.value("$('log-supply-volts').value = '6'");
    browser.click("#use");
    browser.wait(&format!("/Undo reads them as before/.test($('status').textContent) && {FRESH}"));
    assert!((gain(&mut browser) / before / 2.0 - 1.0).abs() < 0.02, "both files are read anew");

    // Another day the dialogue is filled with what was said of such columns.
    browser.click("#puzzle");
    browser.wait(&format!("/^Puzzle/.test($('status').textContent) && {FRESH}"));
    asked_about(&mut browser, &one);
    assert!(browser.text("#log-words").contains("mapped columns of these names before"));
    let fields = "['log-supply-volts', 'log-counts-per-rev'].map((id) => $(id).value)";
    assert_eq!(browser.value(fields), json!(["6", "1320"]));
    browser.click("#cancel");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn whether_the_columns_mean_what_was_read_is_asked_before_anything_else() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("small.csv");
    let mut text = "time_s,voltage_v,speed_rad_s\n".to_owned();
    let mut w = 0.0;
    for k in 0..800 {
        let t = f64::from(k) * 0.01;
        let v = 0.6 * (1.3 * t).sin() + 0.3 * (7.0 * t).sin();
        writeln!(text, "{t:.2},{v:.4},{w:.5}").unwrap();
        w += 0.01 * (9.0 * v - w) / 0.06;
    }
    std::fs::write(&log, text).unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    asked_about(&mut browser, &log);
    taken(&mut browser, "small");
    assert_eq!(browser.text("#badge"), "Not diagnosed yet");
    assert_eq!(browser.text("#next"), "Check the columns");
    assert_eq!(browser.text("#also"), "Find what is missing");
    assert_eq!(browser.number("document.querySelectorAll('.verdict button.main:not([hidden])').length"), 1.0);
    browser.screenshot("header", "light-0-data-problem");
    browser.click("#next");
    browser.wait("$('dialog').open");
    assert_eq!(browser.text("#log-name"), "small.csv");
    // They are volts: who has looked is not sent there again.
    browser.click("#use");
    browser.wait(&format!("/Undo reads them as before/.test($('status').textContent) && {FRESH}"));
    assert_eq!(browser.text("#next"), "Find what is missing");
    assert_eq!(browser.value("$('also').hidden"), true);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn records_that_the_command_line_divided_are_read_anew_and_stay_divided() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let log = arduino(directory.path(), "one.csv", 0.0);
    let map = "time=millis:ms,duty=pwm:255,angle=enc:counts";
    let options = ["--skip", "3..3.5", "--map", map, "--supply-volts", "12", "--counts-per-rev", "1320"];
    let server = Server::start(&[&[log.to_str().unwrap()][..], &options[..]].concat());
    let mut browser = opened(&server);
    let names = "state.data.entries.map((e) => e.name)";
    assert_eq!(browser.value(names), json!(["one part 1", "one part 2"]));
    let at_12 = gain(&mut browser);
    browser.click("#entries .columns");
    browser.wait("$('dialog').open");
    browser.value("$('log-supply-volts').value = '6'");
    browser.click("#use");
    browser.wait(&format!("/Undo reads them as before/.test($('status').textContent) && {FRESH}"));
    assert_eq!(browser.value(names), json!(["one part 1", "one part 2"]));
    let at_6 = gain(&mut browser);
    assert!((at_6 / at_12 - 2.0).abs() < 0.02, "{at_12} {at_6}");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
