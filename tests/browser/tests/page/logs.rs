//! Logs dropped on the page, and what the cards say of logs that leave a question open.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use motorlens_browser_tests::{Browser, Server, run};

use super::{FRESH, alone, diagnosed, opened};

/// Gives the page `log`, and waits until it asks about its columns.
pub fn asked_about(browser: &mut Browser, log: &Path) {
    browser.give_file("#file", log);
    browser.wait("document.querySelector('#dialog').open && document.querySelector('#preview select')");
}

/// Takes the columns as they are said to be, and waits for the record `title`.
pub fn taken(browser: &mut Browser, title: &str) {
    browser.click("#use");
    browser.wait(&format!(
        "!document.querySelector('#dialog').open && document.querySelector('#title').textContent == '{title}' && {FRESH}"
    ));
}

#[test]
fn a_binary_log_larger_than_a_beginning_is_shown_with_its_columns_and_taken() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    // A NumPy array of records. What the page sends of a text would not hold all of it.
    let mut w = 0.0;
    let row = |k: u32| {
        let t = f64::from(k) * 0.01;
        let v = 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin();
        let row = [f64::from(10 * k), v, w];
        w += 0.01 * (0.9 * v - w) / 0.06;
        row
    };
    let rows: Vec<[f64; 3]> = (0..800).map(row).collect();
    let filler = 300_000 / (8 * rows.len());
    let names: Vec<String> =
        ["t", "u", "w"].map(String::from).into_iter().chain((0..filler).map(|k| format!("x{k}"))).collect();
    let fields: Vec<String> = names.iter().map(|name| format!("('{name}', '<f8')")).collect();
    let shape = rows.len();
    let header =
        format!("{{'descr': [{}], 'fortran_order': False, 'shape': ({shape},), }}\n", fields.join(", "));
    let mut array = b"\x93NUMPY\x01\x00".to_vec();
    array.extend(u16::try_from(header.len()).unwrap().to_le_bytes());
    array.extend(header.as_bytes());
    for row in &rows {
        array.extend(row.iter().copied().chain((0..filler).map(|_| 0.0)).flat_map(f64::to_le_bytes));
    }
    assert!(array.len() > 200_000);
    let log = directory.path().join("array.npy");
    std::fs::write(&log, array).unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);

    asked_about(&mut browser, &log);
    let kinds =
        "[...document.querySelectorAll('#preview select')].slice(0, 4).map((select) => select.value).join()";
    assert_eq!(browser.value(kinds), "time:ms,voltage:V,speed:rad/s,");
    taken(&mut browser, "array");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn the_two_sides_of_a_bridge_are_taken_for_the_difference_that_drives_the_motor() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("bridge.csv");
    let mut text = "t_ms,RPWM,LPWM,rpm\n".to_owned();
    let mut w = 0.0;
    for k in 0..800 {
        let duty = (200.0 * (0.02 * f64::from(k)).sin()).round();
        writeln!(text, "{},{},{},{w:.3}", 10 * k, f64::max(duty, 0.0), f64::max(-duty, 0.0)).unwrap();
        w += 0.01 * (0.4 * duty - w) / 0.06;
    }
    std::fs::write(&log, text).unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);

    asked_about(&mut browser, &log);
    let kinds = "[...document.querySelectorAll('#preview select')].map((select) => select.value).join()";
    assert_eq!(browser.value(kinds), "time:ms,duty:255,duty-:,speed:rpm");
    let map = "mapOf(dropped.table, kindsChosen())";
    assert_eq!(browser.value(map), "time=0:ms,duty=1-2:255,speed=3:rpm");
    taken(&mut browser, "bridge");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

/// The message of the dialogue after it was asked to read the log with columns of these `kinds`.
fn refused(browser: &mut Browser, log: &Path, kinds: [&str; 3], counts: &str) -> String {
    asked_about(browser, log);
    let kinds = serde_json::json!(kinds);
    browser.value(&format!(
        "document.querySelectorAll('#preview select').forEach((s, k) => {{ s.value = {kinds}[k]; }}), $('log-supply-volts').value = '12', $('log-counts-per-rev').value = '{counts}'"
    ));
    browser.click("#use");
    browser.wait("!$('log-fault').hidden");
    let told = browser.text("#log-fault");
    browser.click("#cancel");
    told
}

#[test]
fn what_the_dialogue_refuses_it_tells_how_to_mend_on_the_page() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("turned.csv");
    let mut text = "millis,pwm,enc\n".to_owned();
    let (mut w, mut x) = (0.0, 0.0);
    for k in 0..800 {
        let duty = (150.0 * (0.02 * f64::from(k)).sin()).round();
        writeln!(text, "{},{duty},{x:.0}", 10 * k).unwrap();
        w += 0.01 * (0.1 * duty - w) / 0.06;
        x -= 0.01 * w * 1320.0 / std::f64::consts::TAU;
    }
    std::fs::write(&log, text).unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);

    let told = refused(&mut browser, &log, ["time:ms", "duty:255", "angle:counts"], "");
    assert!(told.contains("fill in \"Counts per output turn\"") && !told.contains("--"), "{told}");
    let told = refused(&mut browser, &log, ["time:ms", "", "angle:counts"], "1320");
    assert!(told.contains("in the row below the names") && !told.contains("--"), "{told}");
    // An encoder that counts the other way is found when the records are taken in, and turned round in the dialogue.
    let read = |browser: &mut Browser, turned: bool| {
        asked_about(browser, &log);
        browser.value(&format!("$('log-counts-per-rev').value = '1320', $('log-turned').checked = {turned}"));
        browser.click("#use");
    };
    read(&mut browser, false);
    browser.wait("!$('alarm').hidden && $('running').hidden");
    let told = browser.text("#alarm");
    assert!(told.contains("open the log again and tick \"turn angle and speed round"), "{told}");
    read(&mut browser, true);
    browser.wait(&format!("state.title == 'turned' && {FRESH}"));
    assert_eq!(
        browser.value("document.querySelector('#ranges small').textContent"),
        "steady speed of the output shaft per volt"
    );
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_good_log_is_taken_and_a_bad_one_gets_a_clear_message() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let bad = directory.path().join("bad.csv");
    let mut text = "t,u,w\n".to_owned();
    let mut w = 0.0;
    // The time of one row stands twice in the log: a data quality problem, but no reason to refuse it.
    for k in (0..800).flat_map(|k| if k == 300 { vec![k, k] } else { vec![k] }) {
        let t = f64::from(k) * 0.01;
        let v = 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin();
        writeln!(text, "{},{v:.4},{w:.5}", 10 * k).unwrap();
        w += 0.01 * (0.9 * v - w) / 0.06;
    }
    std::fs::write(&bad, "time_s,voltage_v,angle_rad\n0.00,1,0\n0.01,1,zero\n0.02,1,0\n").unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);

    browser.give_file("#file", &bad);
    browser.wait("document.querySelector('#dialog').open");
    browser.click("#use");
    browser.wait("!document.querySelector('#log-fault').hidden");
    browser.screenshot("#dialog", "light-0-bad-log");
    let message = browser.text("#log-fault");
    assert!(
        message.contains("bad.csv") && message.contains("line 3") && message.contains("To do"),
        "{message}"
    );
    browser.click("#cancel");

    // Dropped, as a person does it.
    let content = serde_json::json!(text);
    browser.value(&format!(
        "(() => {{ const data = new DataTransfer(); data.items.add(new File([{content}], 'good.csv')); \
         dispatchEvent(new DragEvent('drop', {{ dataTransfer: data, bubbles: true, cancelable: true }})); }})()"
    ));
    browser.wait(
        "document.querySelector('#dialog').open && document.querySelectorAll('#preview select').length == 3",
    );
    // The guess of the command line.
    let kinds = "[...document.querySelectorAll('#preview select')].map((select) => select.value).join()";
    assert_eq!(browser.value(kinds), "time:ms,voltage:V,speed:rad/s");
    browser.screenshot("#dialog", "light-0-good-log");
    taken(&mut browser, "good");
    let fault = browser.text("#data-faults .card.fault");
    assert!(fault.contains("repeat the time") && fault.contains("To do"), "{fault}");
    // A record of speed: speed, residual, voltage.
    assert_eq!(browser.number("document.querySelectorAll('#record-plot canvas').length"), 3.0);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

/// Logs, written to `directory`, that cannot tell dry friction from its rivals.
pub fn with_a_question(directory: &Path) -> Vec<PathBuf> {
    let out = directory.to_str().unwrap();
    run(&["simulate", "--quiet", "--excitation", "paper", "--effect", "coulomb=0.4", "--out", out]);
    let found = std::fs::read_dir(directory).unwrap().map(|entry| entry.unwrap().path());
    found.filter(|path| path.extension().is_some_and(|e| e == "csv")).collect()
}

#[test]
fn rivals_and_the_next_experiment_are_among_the_cards_where_the_data_leave_a_question() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start(&with_a_question(directory.path()));
    let mut browser = opened(&server);
    diagnosed(&mut browser);
    browser.wait("document.querySelector('.card.rivals') && document.querySelector('.card.next')");
    assert!(browser.text(".card.rivals").contains("coulomb"));
    let first = browser.text(".card figcaption");
    assert!(first.contains("taken out") && first.contains("the dots follow it"), "{first}");
    browser.screenshot(".card.rivals", "light-3-rivals-and-next-experiment");
    let programme = browser.value("fetch('/export/programme.json').then((r) => r.json())");
    assert!(programme["segments"].as_array().is_some_and(|s| !s.is_empty()), "{programme}");
    assert!(browser.text("#missing-words").starts_with("Gain"));
}
