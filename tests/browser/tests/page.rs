//! The live page in a real browser.

use std::fmt::Write;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Instant;

use motorlens_browser_tests::{Browser, Server, run};

/// One browser at a time: each wants the whole machine.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

const PAINTED: &str = "document.body.dataset.painted && document.querySelector('#record-plot .main-svg')";
const IDLE: &str =
    "document.querySelector('#running').hidden && !document.querySelector('#diagnose').disabled";

fn opened(server: &Server) -> Browser {
    let mut browser = Browser::start(1280, 900);
    browser.open(&server.url);
    browser.wait(PAINTED);
    browser.wait("document.querySelector('#falls').dataset.lastOverFloor");
    browser
}

fn number(browser: &mut Browser, expression: &str) -> f64 {
    let value = browser.value(&format!("Number({expression})"));
    value.as_f64().unwrap_or_else(|| panic!("{expression} is {value}"))
}

#[test]
fn adding_what_is_suggested_brings_the_error_to_the_floor() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.screenshot("header", "1-compare");
    browser.screenshot("#fails", "2-where-it-fails");
    let before = number(&mut browser, "document.querySelector('#falls').dataset.lastOverFloor");
    for round in 0..3 {
        browser.value("document.querySelector('#status').textContent = ''");
        browser.click("#diagnose");
        browser.wait("document.querySelector('.card .add') && /best suspect|worth adding/.test(document.querySelector('#status').textContent)");
        browser.wait("document.querySelector('.card .plot svg') || document.querySelector('#missing').scrollIntoView()");
        if round == 0 {
            browser.screenshot("#missing", "3-what-is-missing");
        }
        if browser
            .value("document.querySelector('#status').textContent")
            .as_str()
            .is_some_and(|s| s.starts_with("Nothing"))
        {
            break;
        }
        browser.click(".card .add");
        browser.wait("/in the model/.test(document.querySelector('#status').textContent)");
        browser.wait(&format!("{IDLE} && Number(document.querySelector('#falls').dataset.lastOverFloor) > 0 && document.querySelectorAll('.chip').length == {}", round + 1));
        if round == 0 {
            browser.screenshot("#add", "4-add");
        }
        if number(&mut browser, "document.querySelector('#falls').dataset.lastOverFloor") <= 1.5 {
            break;
        }
    }
    browser.wait("document.querySelectorAll('#parameters tr').length > 4");
    browser.screenshot("#falls", "5-falls");
    let after = number(&mut browser, "document.querySelector('#falls').dataset.lastOverFloor");
    assert!(before > 10.0 && after <= 1.5, "{before} {after}");
    browser.prefer("dark");
    browser.screenshot("header", "6-dark");
    browser.size(390, 844, true);
    browser.screenshot("#compare", "7-small");
    let wide = number(&mut browser, "document.documentElement.scrollWidth");
    assert!(wide <= 392.0, "the page is {wide} wide on a screen of 390");
    browser.size(1280, 900, false);
    let chips = number(&mut browser, "document.querySelectorAll('.chip').length");
    browser.click(".chip button");
    browser.wait(&format!("document.querySelectorAll('.chip').length == {}", chips - 1.0));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_good_log_is_taken_and_a_bad_one_gets_a_clear_message() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let (good, bad) = (directory.path().join("good.csv"), directory.path().join("bad.csv"));
    let mut text = "t,u,w\n".to_owned();
    let mut w = 0.0;
    for k in 0..800 {
        let t = f64::from(k) * 0.01;
        let v = 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin();
        writeln!(text, "{},{v:.4},{w:.5}", 10 * k).unwrap();
        w += 0.01 * (0.9 * v - w) / 0.06;
    }
    std::fs::write(&good, text).unwrap();
    std::fs::write(&bad, "time_s,voltage_v,angle_rad\n0.00,1,0\n0.01,1,zero\n0.02,1,0\n").unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);

    browser.give_file("#file", &bad);
    browser.wait("document.querySelector('#dialog').open");
    browser.click("#use");
    browser.wait("!document.querySelector('#log-fault').hidden");
    browser.screenshot("#dialog", "8-bad-log");
    let message = browser.value("document.querySelector('#log-fault').textContent").to_string();
    assert!(
        message.contains("bad.csv") && message.contains("line 3") && message.contains("To do"),
        "{message}"
    );
    browser.click("#cancel");

    browser.give_file("#file", &good);
    browser.wait(
        "document.querySelector('#dialog').open && document.querySelectorAll('#preview select').length == 3",
    );
    for (column, kind) in ["time:ms", "voltage:V", "speed:rad/s"].iter().enumerate() {
        browser.value(&format!("document.querySelectorAll('#preview select')[{column}].value = '{kind}'"));
    }
    browser.screenshot("#dialog", "9-good-log");
    browser.click("#use");
    browser.wait(
        "!document.querySelector('#dialog').open && document.querySelector('#title').textContent == 'good'",
    );
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_running_search_stops_and_leaves_the_model_as_it_was() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.click("#diagnose");
    browser.wait("/^Trying/.test(document.querySelector('#doing').textContent)");
    browser.click("#stop");
    browser.wait("/^Stopped/.test(document.querySelector('#status').textContent)");
    assert_eq!(number(&mut browser, "document.querySelectorAll('.chip').length"), 0.0);
    // And the next one may start.
    browser.value("document.querySelector('#effect').value = 'coulomb'");
    browser.click("#add-effect");
    browser.wait("document.querySelectorAll('#moving tr').length > 4");
    browser.wait("document.querySelectorAll('.chip').length == 1");
}

#[test]
fn a_puzzle_is_set_and_revealed() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.click("#puzzle");
    browser.wait("/^Puzzle/.test(document.querySelector('#status').textContent)");
    assert_eq!(browser.value("document.querySelector('#answer').hidden"), true);
    browser.click("#reveal");
    browser.wait("/^Hidden: /.test(document.querySelector('#answer').textContent)");
    browser.screenshot("header", "10-puzzle");
}

#[test]
fn ten_records_of_100_000_samples_are_on_the_screen_soon() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let mut logs = Vec::new();
    for seed in 0..5 {
        let out = directory.path().join(seed.to_string());
        let seed = seed.to_string();
        run(&[
            "simulate",
            "--quiet",
            "--seconds",
            "100",
            "--excitation",
            "multisine",
            "--seed",
            &seed,
            "--out",
            out.to_str().unwrap(),
        ]);
        let mut found: Vec<_> = std::fs::read_dir(&out).unwrap().map(|e| e.unwrap().path()).collect();
        found.retain(|p| p.extension().is_some_and(|e| e == "csv"));
        logs.extend(found);
    }
    logs.truncate(10);
    let server = Server::start(&logs);
    let (mut paints, mut zooms) = (Vec::new(), Vec::new());
    for _ in 0..3 {
        let mut browser = Browser::start(1280, 900);
        browser.open(&server.url);
        browser.wait(PAINTED);
        paints.push(number(&mut browser, "document.body.dataset.painted"));
        browser.wait(
            "document.querySelector('#fails-figures figure') && document.querySelector('#parameters tr')",
        );
        let zoom = browser.value("(async () => { const begun = performance.now(); window_ = [40, 42]; await showRecord(); return performance.now() - begun; })()");
        zooms.push(zoom.as_f64().expect("a time"));
    }
    println!("ten records of 100,000 samples: first paint {paints:.0?} ms, zoom {zooms:.0?} ms");
    // Other work on the machine slows some; it cannot make one faster than the page is.
    let fastest = |times: &[f64]| times.iter().copied().fold(f64::MAX, f64::min);
    // The goals are 1500 and 100 ms on a quiet machine: the gate leaves room for a busy one.
    assert!(fastest(&paints) < 6000.0 && fastest(&zooms) < 600.0);
}

#[test]
fn a_slider_moves_the_curve_and_the_error_at_once() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.wait("document.querySelector('#cards')");
    let mut times = Vec::new();
    for k in 0..9 {
        let before = browser.value("document.querySelector('#slid').textContent");
        let set = format!(
            "(() => {{ const s = document.querySelector('#slider-0'); delete document.querySelector('#record-plot').dataset.slideMs; s.value = {}; s.dispatchEvent(new Event('input')); }})()",
            0.3 + 0.05 * f64::from(k)
        );
        let begun = Instant::now();
        browser.value(&set);
        browser.wait("document.querySelector('#record-plot').dataset.slideMs");
        assert!(begun.elapsed().as_secs() < 5);
        assert_ne!(browser.value("document.querySelector('#slid').textContent"), before);
        times.push(number(&mut browser, "document.querySelector('#record-plot').dataset.slideMs"));
    }
    let asked = number(
        &mut browser,
        "performance.getEntriesByType('resource').filter((e) => e.name.endsWith('/api/slide')).at(-1).duration",
    );
    times.sort_by(f64::total_cmp);
    println!(
        "a slider's move on 48 s at 1 kHz: {:.0} ms (fastest), {:.0} ms (median), {:.0} ms (slowest), the server's part {asked:.0} ms",
        times[0], times[4], times[8]
    );
    // Other work on the machine slows some moves; it cannot make one faster than the page is.
    // The goal is 50 ms on a quiet machine: the gate leaves room for a busy one.
    assert!(times[0] < 200.0, "{times:?}");
}

#[test]
fn the_report_draws_everything_from_its_one_file() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let out = directory.path().to_str().unwrap();
    run(&["demo", "--quiet", "--out", out]);
    let mut browser = Browser::start(1280, 900);
    browser.call("Network.enable", serde_json::json!({}));
    browser.call(
        "Network.emulateNetworkConditions",
        serde_json::json!({ "offline": true, "latency": 0, "downloadThroughput": 0, "uploadThroughput": 0 }),
    );
    browser.open(&format!("file://{out}/report.html"));
    browser.wait("document.querySelector('.plot .main-svg')");
    browser.screenshot("header", "11-report");
    for step in ["fails", "missing", "falls"] {
        browser.screenshot(&format!("#{step}"), &format!("11-report-{step}"));
        browser.wait(&format!("document.querySelector('#{step} .plot .main-svg')"));
    }
    assert_eq!(number(&mut browser, "performance.getEntriesByType('resource').length"), 0.0);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
