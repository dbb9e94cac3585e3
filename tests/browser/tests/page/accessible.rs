//! The page and the report by the rules of axe-core: WCAG 2 levels A and AA, and its best practices.

use std::path::Path;

use motorlens_browser_tests::{Browser, Server, run};

use super::logs::asked_about;
use super::{FRESH, added, alone, diagnosed, opened};

/// The checker, as npm installs it.
fn checker() -> String {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/node_modules/axe-core/axe.min.js");
    std::fs::read_to_string(path).unwrap_or_else(|e| panic!("{path}: {e}; run npm ci in tests/browser"))
}

/// What breaks a rule: the rule, and the first places.
fn violations(browser: &mut Browser) -> serde_json::Value {
    if browser.value("typeof axe") != "object" {
        browser.value(&(checker() + ";null"));
    }
    browser.value(
        "axe.run(document, { resultTypes: ['violations'] }).then((r) => r.violations.map((v) => `${v.id}: ${v.nodes.slice(0, 3).map((n) => n.target.join(' ') + ' ' + (n.any[0]?.message || '')).join(' | ')}`))",
    )
}

/// The demo's report, written to `directory` and opened.
fn report(directory: &Path) -> Browser {
    let out = directory.to_str().unwrap();
    run(&["demo", "--quiet", "--out", out]);
    let mut browser = Browser::start(1280, 900);
    browser.open(&format!("file://{out}/report.html"));
    browser.wait("document.querySelector('.plot canvas')");
    browser
}

#[test]
fn the_page_breaks_no_rule_in_light_dark_and_on_a_phone() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    diagnosed(&mut browser);
    added(&mut browser);
    browser.value("document.querySelectorAll('details').forEach((d) => { d.open = true; })");
    for (scheme, width) in [("light", 1280), ("dark", 1280), ("light", 390)] {
        browser.prefer(scheme);
        browser.size(width, 900, width < 500);
        assert_eq!(violations(&mut browser), serde_json::json!([]), "{scheme}, {width} px");
    }
}

#[test]
fn the_page_breaks_no_rule_with_its_dialogue_open_and_after_a_wrong_effect() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("keys.csv");
    let row = |k: u32| {
        let t = 0.01 * f64::from(k);
        format!("{},{:.4},{:.5}\n", 10 * k, 6.0 * (2.0 * t).sin(), 5.0 * (2.0 * t - 0.1).sin())
    };
    std::fs::write(&log, "t,u,w\n".to_owned() + &(0..400).map(row).collect::<String>()).unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let none_in = |browser: &mut Browser, state: &str| {
        for (scheme, width) in [("light", 1280), ("dark", 1280), ("dark", 390)] {
            browser.prefer(scheme);
            browser.size(width, 900, width < 500);
            assert_eq!(violations(browser), serde_json::json!([]), "{state}, {scheme}, {width} px");
        }
        browser.prefer("light");
        browser.size(1280, 900, false);
    };
    asked_about(&mut browser, &log);
    none_in(&mut browser, "the dialogue of a new log");
    browser.value("$('log-more').open = true, $('log-servo-gain').value = '-1'");
    browser.click("#use");
    browser.wait("!$('log-fault').hidden");
    none_in(&mut browser, "the fields that are folded away, and a wrong one");
    browser.click("#cancel");

    browser.value("$('effect').value = 'lost_counts'");
    browser.click("#add-effect");
    browser.wait(&format!("document.querySelectorAll('.chip').length == 1 && {FRESH}"));
    assert_eq!(browser.text("#badge"), "Not confirmed");
    none_in(&mut browser, "a wrong effect added");
    browser.click("#reveal");
    browser.wait("!$('answer').hidden");
    none_in(&mut browser, "a wrong answer");

    diagnosed(&mut browser);
    browser.value("document.querySelectorAll('#cards details').forEach((d) => { d.open = true; })");
    none_in(&mut browser, "all candidates open");

    asked_about(&mut browser, &log);
    browser.click("#use");
    browser.wait(&format!("state.title == 'keys' && {FRESH}"));
    browser.click("#entries .columns");
    browser.wait("$('dialog').open");
    none_in(&mut browser, "the columns of a log that is there");
}

#[test]
fn the_report_breaks_no_rule() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let mut browser = report(directory.path());
    for scheme in ["light", "dark"] {
        browser.prefer(scheme);
        assert_eq!(violations(&mut browser), serde_json::json!([]), "{scheme}");
    }
}

#[test]
fn print_opens_and_draws_everything_and_cuts_nothing() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let mut browser = report(directory.path());
    browser.value(
        "addEventListener('beforeprint', () => setTimeout(() => {}, 0)); addEventListener('beforeprint', () => { globalThis.printed = [...document.querySelectorAll('.plot')].filter((p) => !p.closest('[hidden]') && p.clientWidth && !p.querySelector('canvas') && parseInt(p.style.minHeight) > 0).length; globalThis.shut = document.querySelectorAll('details:not([open]), .record[hidden]').length; \
         globalThis.drawn = [getComputedStyle(document.documentElement).getPropertyValue('--ink').trim(), Math.max(...[...document.querySelectorAll('.plot canvas')].filter((c) => c.clientWidth).map((c) => c.getBoundingClientRect().right)) <= 719]; })",
    );
    // Whoever works in the dark prints black on white.
    browser.prefer("dark");
    let paper = browser.call("Page.printToPDF", serde_json::json!({ "printBackground": true }));
    let bytes = paper["data"].as_str().map_or(0, str::len);
    assert!(bytes > 100_000, "{bytes}");
    assert_eq!((browser.value("printed"), browser.value("shut")), (0.into(), 0.into()));
    assert_eq!(browser.value("drawn"), serde_json::json!(["#1a1c1e", true]));
    assert_eq!(browser.value("document.documentElement.dataset.paper"), serde_json::Value::Null);
    assert_eq!(browser.number("document.querySelectorAll('.record:not([hidden])').length"), 1.0);
    // Nothing is wider than the paper: A4 less its margins at 96 dots an inch.
    browser.call("Emulation.setEmulatedMedia", serde_json::json!({ "media": "print" }));
    browser.size(718, 1000, false);
    std::thread::sleep(std::time::Duration::from_millis(500));
    let wide = "[...document.querySelectorAll('table, figure, .card, .verdict')].filter((e) => e.getBoundingClientRect().right > 719).map((e) => e.outerHTML.slice(0, 80))";
    assert_eq!(browser.value(wide), serde_json::json!([]));
}
