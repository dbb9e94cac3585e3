//! The five steps of the work.

use motorlens_browser_tests::{Browser, Server};

use super::{FRESH, added, alone, diagnosed, effects, opened, over_floor};

const STEPS: [&str; 5] = ["compare", "fails", "missing", "add", "falls"];

/// Pictures of all five steps, named after the way in which they are looked at.
fn pictures(browser: &mut Browser, looked: &str) {
    for (k, step) in STEPS.iter().enumerate() {
        browser.screenshot(&format!("#{step}"), &format!("{looked}-{}-{step}", k + 1));
    }
}

#[test]
fn adding_what_is_suggested_brings_the_error_to_the_floor_and_removing_it_takes_it_away_again() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let before = over_floor(&mut browser);
    // Each step of a search: was it still running, and how many points had its curve?
    browser.value(
        "(() => { globalThis.drawn = []; const show = told.step; told.step = (e) => { show(e); \
         drawn.push([!$('running').hidden && document.querySelectorAll('#convergence canvas').length == 1, e.step.round]); }; })()",
    );
    for round in 0..3 {
        diagnosed(&mut browser);
        if browser.text("#status").starts_with("No effect") {
            break;
        }
        if round == 0 {
            assert!(
                browser.text("#headline").contains("the best candidate is"),
                "{}",
                browser.text("#headline")
            );
            assert!(browser.text("#next").starts_with("Add "));
            browser.screenshot("#missing", "light-3-missing-suspects");
            let first = "document.querySelector('#candidates meter').value";
            let others = "Math.max(...[...document.querySelectorAll('#candidates meter')].slice(1).map((m) => m.value))";
            assert!(browser.number(first) >= browser.number(others) - 5.0);
            browser.wait("document.querySelector('.card .plot canvas')");
        }
        added(&mut browser);
        if over_floor(&mut browser) <= 1.5 {
            break;
        }
    }
    let after = over_floor(&mut browser);
    assert!(before > 10.0 && after <= 1.5, "{before} {after}");
    // The search was drawn as it ran, and the old parameters with it.
    assert!(browser.number("drawn.length") >= 3.0 && browser.value("drawn.every((d) => d[0])") == true);
    assert!(browser.number("document.querySelectorAll('#giving .u-series').length") >= 3.0);
    assert!(browser.number("document.querySelectorAll('#moving tr.moved').length") >= 1.0);
    assert!(browser.number("document.querySelectorAll('#parameters tr').length") > 4.0);
    assert_eq!(browser.number("document.querySelectorAll('#combinations tr').length"), 4.0);
    let intervals = "[...document.querySelectorAll('#parameters tr')].every((row) => row.className === 'no' ? row.cells[2].textContent === 'not determined' : /^[-+.e\\d]+ … [-+.e\\d]+$/.test(row.cells[2].textContent))";
    assert_eq!(browser.value(intervals), true);
    // A dot for each model, and the line of the noise.
    let bars = "ask('/api/figures/falls').then((f) => f.figures[0].panels[0].curves[0].y.length)";
    assert_eq!(browser.number(bars), effects(&mut browser) + 1.0);
    browser.wait("(document.querySelector('#falls .plot').scrollIntoView(), document.querySelector('#falls .plot canvas'))");
    browser.screenshot("header", "light-0-header");
    pictures(&mut browser, "light");
    browser.wait("document.querySelector('#convergence canvas') && document.querySelector('#giving canvas')");
    browser.prefer("dark");
    pictures(&mut browser, "dark");
    browser.prefer("light");
    browser.size(390, 844, true);
    pictures(&mut browser, "small");
    let wide = browser.number("document.documentElement.scrollWidth");
    let beyond = browser.value(
        "[...document.querySelectorAll('body *')].filter((e) => e.getBoundingClientRect().right > 391 && !e.closest('.table'))\
         .map((e) => `${e.tagName}#${e.id}.${e.className} in ${e.parentElement.id}`).slice(0, 12).join(', ')",
    );
    assert!(wide <= 390.0, "the page is {wide} wide on a screen of 390; too wide: {beyond}");
    // What is to be pressed needs no scrolling to be seen.
    let buttons = "Math.max(0, ...[...document.querySelectorAll('#candidates .add, #entries input')].map((e) => e.getBoundingClientRect().right))";
    let rightmost = browser.number(buttons);
    assert!(rightmost <= 390.0, "a button ends at {rightmost} on a screen of 390");
    browser.size(1280, 900, false);
    let chips = effects(&mut browser);
    browser.click(".chip button");
    browser.wait(&format!("document.querySelectorAll('.chip').length == {} && {FRESH}", chips - 1.0));
    assert!(over_floor(&mut browser) > 1.5);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_diagnosis_stops_at_once_and_leaves_the_model_as_it_was() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.click("#diagnose");
    browser.wait("/^Trying/.test(document.querySelector('#doing').textContent)");
    browser.click("#stop");
    browser.wait("/^Stopped/.test(document.querySelector('#status').textContent)");
    assert_eq!(effects(&mut browser), 0.0);
    assert_eq!(browser.value("document.querySelector('#diagnose').disabled"), false);
}

#[test]
fn a_running_fit_stops_at_a_step_and_the_next_one_may_start() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    // The button is pressed as soon as the page has shown a step: no test is as quick from outside.
    browser.value(
        "(() => { const show = told.step; told.step = (e) => { show(e); told.step = show; $('stop').click(); }; })()",
    );
    browser.value("document.querySelector('#effect').value = 'coulomb'");
    browser.click("#add-effect");
    browser.wait("/^Stopped/.test(document.querySelector('#status').textContent)");
    assert!(browser.number("history_.length") >= 1.0);
    assert_eq!(effects(&mut browser), 0.0);
    assert_eq!(browser.number("ask('/api/state').then((s) => s.ladder.length)"), 1.0);
    browser.click("#add-effect");
    browser.wait(&format!("document.querySelectorAll('.chip').length == 1 && {FRESH}"));
}

/// The same motor, by the page's button and by `demo`: what the page did not know of it had a second effect make up for.
#[test]
fn the_button_leads_to_the_answer_of_the_loop_by_itself() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    diagnosed(&mut browser);
    added(&mut browser);
    diagnosed(&mut browser);
    assert_eq!(browser.text("#badge"), "Explained");
    browser.click("#reveal");
    browser.wait("!$('answer').hidden");
    assert!(browser.text("#answer").starts_with("Right."), "{}", browser.text("#answer"));
}

#[test]
fn a_puzzle_is_set_found_and_revealed() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.click("#puzzle");
    browser.wait(&format!("/^Puzzle/.test(document.querySelector('#status').textContent) && {FRESH}"));
    // Any puzzle may come; to be found every time it has to be the same one.
    browser.value("document.querySelector('#status').textContent = ''");
    browser.value("ask('/api/puzzle', { seed: 3 })");
    browser.wait(&format!("/^Puzzle 3/.test(document.querySelector('#status').textContent) && {FRESH}"));
    assert_eq!(browser.value("document.querySelector('#answer').hidden"), true);
    for _ in 0..3 {
        diagnosed(&mut browser);
        if browser.text("#status").starts_with("No effect") {
            break;
        }
        added(&mut browser);
    }
    browser.click("#reveal");
    browser.wait("/Hidden: /.test(document.querySelector('#answer').textContent)");
    browser.screenshot("header", "light-0-puzzle");
    let answer = browser.text("#answer");
    assert!(!answer.contains('='), "{answer}");
    assert!(answer.starts_with("Right."), "{answer}");
}

#[test]
fn a_wrong_answer_to_a_puzzle_is_told_as_wrong_with_what_it_misses() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("document.querySelector('#status').textContent = ''");
    browser.value("ask('/api/puzzle', { seed: 3 })");
    browser.wait(&format!("/^Puzzle 3/.test(document.querySelector('#status').textContent) && {FRESH}"));
    browser.value("$('effect').value = 'lost_counts'");
    browser.click("#add-effect");
    browser.wait(&format!("document.querySelectorAll('.chip').length == 1 && {FRESH}"));
    browser.click("#reveal");
    browser.wait("!$('answer').hidden");
    let answer = browser.text("#answer");
    assert!(answer.starts_with("Wrong. Hidden: "), "{answer}");
    assert!(answer.contains("it misses ") && answer.contains("lost_counts is not in the motor"), "{answer}");
    assert_eq!(browser.value("$('answer').className"), "answer wrong");
    browser.screenshot("header", "light-0-wrong-answer");
}
