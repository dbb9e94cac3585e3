//! The report file, opened with no network.

use base64::Engine;
use motorlens_browser_tests::{Browser, Server, run};

use super::{added, alone, diagnosed, opened};

#[test]
fn the_report_draws_all_five_steps_from_its_one_file() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    run(&["demo", "--quiet", "--out", out]);
    let size = std::fs::metadata(directory.path().join("report.html")).unwrap().len();
    println!("the report of the default protocol has {size} bytes");
    assert!(size < 6_000_000, "{size} bytes");
    let mut browser = Browser::start(1280, 900);
    browser.call("Network.enable", serde_json::json!({}));
    browser.call(
        "Network.emulateNetworkConditions",
        serde_json::json!({ "offline": true, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0 }),
    );
    browser.open(&format!("file://{out}/report.html"));
    browser.wait("document.querySelector('.plot canvas')");
    for step in ["compare", "fails", "missing", "add", "falls"] {
        browser.screenshot(&format!("#{step}"), &format!("report-{step}"));
        let shown = if step == "add" { "table" } else { ".plot canvas" };
        browser.wait(&format!("document.querySelector('#{step} {shown}')"));
    }
    // Another record than the first is drawn once it is chosen.
    browser.value("(() => { const s = document.querySelector('#record'); s.selectedIndex = 2; s.dispatchEvent(new Event('change')); })()");
    browser.wait("document.querySelector('.record:not([hidden]) canvas') && document.querySelectorAll('.record:not([hidden])').length == 1");
    assert_eq!(browser.number("performance.getEntriesByType('resource').length"), 0.0);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);

    // A reader wants verdict, plots and tables of seven records on few pages, nothing drawn beyond an edge.
    let paper =
        browser.call("Page.printToPDF", serde_json::json!({ "paperWidth": 8.27, "paperHeight": 11.69 }));
    let paper = base64::engine::general_purpose::STANDARD.decode(paper["data"].as_str().unwrap()).unwrap();
    let pages = paper.windows(12).filter(|word| word == b"/Type /Page\n").count();
    println!("the report of the default protocol has {pages} pages");
    assert!((1..=10).contains(&pages), "{pages} pages");
}

/// Tables that are wider than their place, by their names.
const TOO_WIDE: &str = "[...document.querySelectorAll('main .table')].filter((t) => t.clientWidth && t.scrollWidth > t.clientWidth).map((t) => `${t.getAttribute('aria-label')}: ${t.scrollWidth} of ${t.clientWidth}`)";

#[test]
fn no_table_of_the_report_or_the_page_scrolls_sideways_on_a_phone() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    run(&["demo", "--quiet", "--out", out]);
    let mut browser = Browser::start(390, 844);
    browser.size(390, 844, true);
    browser.open(&format!("file://{out}/report.html"));
    browser.wait("document.querySelector('.plot canvas')");
    browser.value("document.querySelectorAll('details').forEach((d) => { d.open = true; })");
    assert!(browser.number("document.querySelectorAll('main .table').length") >= 6.0);
    for step in ["compare", "missing", "add", "falls", "glossary"] {
        browser.screenshot(&format!("#{step}"), &format!("small-report-{step}"));
    }
    assert_eq!(browser.value(TOO_WIDE), serde_json::json!([]), "the report");
    assert!(browser.number("document.documentElement.scrollWidth") <= 390.0);

    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    diagnosed(&mut browser);
    added(&mut browser);
    browser.size(390, 844, true);
    browser.value("document.querySelectorAll('details').forEach((d) => { d.open = true; })");
    assert_eq!(browser.value(TOO_WIDE), serde_json::json!([]), "the page");
    // A model with many effects has a long name.
    browser.value(
        "void $('against').add(new Option('dead_zone + lost_counts + coulomb + delay + quadratic_drag'))",
    );
    assert!(browser.number("document.documentElement.scrollWidth") <= 390.0);
}

#[test]
fn model_and_report_are_saved_from_the_page_which_asks_nobody_else() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let model = browser.value("fetch('/export/model.json').then((r) => r.json())");
    assert_eq!(model["schema"], 1, "{model}");
    let report = browser.value("fetch('/export/report.html').then((r) => r.text())");
    assert!(
        report.as_str().is_some_and(|page| page.starts_with("<!doctype html>") && page.contains("5 Error"))
    );
    let elsewhere = "performance.getEntriesByType('resource').filter((e) => !e.name.startsWith(location.origin) && !e.name.startsWith('data:')).length";
    assert_eq!(browser.number(elsewhere), 0.0);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
