//! A dense record begins zoomed in, with all of it in a strip below; and every plot is drawn before anybody scrolls to it.

use std::path::{Path, PathBuf};

use motorlens_browser_tests::{Browser, Server, run};
use serde_json::json;

use super::{DRAWN, alone, opened};

/// A minute of random reversals, some 900 of them, and a quick one to judge by.
fn dense(directory: &Path) -> PathBuf {
    let out = directory.to_str().expect("UTF-8");
    let simulate = ["simulate", "--quiet", "--effect", "coulomb=0.4", "--excitation", "prbs"];
    run(&[&simulate[..], &["--seconds", "60", "--rate", "100", "--out", out]].concat());
    directory.join("prbs-9v.csv")
}

/// The part of the record that is looked at, and all of it, s.
fn looked_at(browser: &mut Browser) -> [f64; 2] {
    browser.wait("part && $('record-plot').dataset.detail == 'yes'");
    [0, 1].map(|k| browser.number(&format!("part[{k}]")))
}

#[test]
fn a_dense_record_begins_zoomed_in_and_its_window_is_dragged_over_all_of_it() {
    let _alone = alone();
    let directory = tempfile::tempdir().expect("a directory");
    let server = Server::start(&[dense(directory.path())]);
    let mut browser = opened(&server);
    let [low, high] = looked_at(&mut browser);
    assert!(low == 0.0 && high > 1.0 && high < 20.0, "{low} {high}");
    // What is drawn is that part with all its samples.
    assert!(
        browser.number("ask(`/api/record/0?from=${part[0]}&to=${part[1]}`).then((f) => f.columns[0].length)")
            > 100.0
    );
    browser.value("$('record-overview').scrollIntoView({ behavior: 'instant', block: 'center' })");
    browser.screenshot("#record-overview", "light-1-overview");
    let box_ = browser.value("(() => { const b = $('record-overview').getBoundingClientRect(); return [b.left, b.top + b.height / 2, b.width]; })()");
    let [left, y, width] = [0, 1, 2].map(|k| box_[k].as_f64().expect("a number"));
    let inside = left + 0.5 * high / 60.0 * width;
    browser.drag([inside, y], [inside + 0.5 * width, y]);
    browser.wait("part[0] > 25");
    let [from, to] = looked_at(&mut browser);
    assert!((from - 30.0).abs() < 1.5, "dragged by half of a minute: {from}");
    assert!((to - from - (high - low)).abs() < 0.1, "the window keeps its width: {from} {to}");
    // By keyboard: to the end, and back to the beginning.
    browser.value("$('overview-window').focus()");
    for (key, place) in [("End", "part[1] > 59.5"), ("Home", "part[0] < 0.01")] {
        browser.key(key, None);
        browser.wait(place);
    }
    // 0 shows all of it; the strip stays, for it leads back.
    browser
        .value("$('record-plot').dispatchEvent(new KeyboardEvent('keydown', { key: '0', bubbles: true }))");
    browser.wait("part === null && $('record-plot').dataset.detail == 'yes'");
    assert_eq!(browser.value("$('record-overview').hidden"), json!(false));
    // The report opens on the same part, with a strip of its own that leads to every other.
    let report = browser.value("fetch('/export/report.html').then((r) => r.text())");
    let file = directory.path().join("report.html");
    std::fs::write(&file, report.as_str().expect("a report")).expect("a file");
    browser.open(&format!("file://{}", file.display()));
    browser.wait("document.querySelector('.record .plot canvas')");
    browser.wait("!document.querySelector('.record .overview').hidden");
    let shown = "document.querySelector('.record .overview [role=slider]')";
    let said =
        |browser: &mut Browser| browser.value(&format!("{shown}.getAttribute('aria-valuetext')")).to_string();
    let told = said(&mut browser);
    assert!(
        told.starts_with("\"0.00 to ") && told.ends_with(" s of 59.99 s\"") && !told.contains(" to 59.99"),
        "{told}"
    );
    browser.value(&format!("{shown}.focus()"));
    browser.key("End", None);
    browser.wait(&format!("{shown}.getAttribute('aria-valuetext').includes(' to 59.99 s')"));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_record_that_is_seen_at_once_has_no_strip_until_one_zooms() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    assert_eq!(browser.value("[part, $('record-overview').hidden]"), json!([null, true]));
    browser
        .value("$('record-plot').dispatchEvent(new KeyboardEvent('keydown', { key: '+', bubbles: true }))");
    looked_at(&mut browser);
    assert_eq!(browser.value("$('record-overview').hidden"), json!(false));
}

#[test]
fn every_plot_is_drawn_without_scrolling() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.wait(DRAWN);
    let below = "[...document.querySelectorAll('#fails .plot, #falls .plot')].filter((p) => p.getBoundingClientRect().top > innerHeight + 300)";
    assert!(browser.number(&format!("{below}.length")) >= 3.0);
    assert_eq!(
        browser.number(&format!(
            "{below}.filter((p) => !p.querySelector('canvas') && parseInt(p.style.minHeight) > 40).length"
        )),
        0.0
    );
    assert_eq!(browser.number("scrollY"), 0.0);
}
