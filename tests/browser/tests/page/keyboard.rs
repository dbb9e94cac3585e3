//! Everything can be reached and done without a mouse.

use motorlens_browser_tests::Server;

use super::{FRESH, alone, opened};

/// Moves the focus on until it is on what `selector` names.
fn tab_to(browser: &mut motorlens_browser_tests::Browser, selector: &str) {
    for _ in 0..400 {
        browser.key("Tab", None);
        if browser.value(&format!("document.activeElement.matches('{selector}')")) == true {
            return;
        }
    }
    panic!("the Tab key does not lead to {selector}");
}

#[test]
fn plots_sliders_and_buttons_obey_the_keyboard() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    tab_to(&mut browser, "#file");
    tab_to(&mut browser, "summary");
    tab_to(&mut browser, "#record");
    tab_to(&mut browser, "#record-plot");
    browser.key("+", Some("+"));
    browser.wait("part && part[1] - part[0] < 5 && document.querySelector('#record-plot').dataset.detail");
    browser.key("0", Some("0"));
    browser.wait("part === null && document.querySelector('#record-plot').dataset.detail");
    tab_to(&mut browser, "#slider-0");
    let before = browser.text("#slid");
    browser.key("ArrowRight", None);
    browser.wait("document.querySelector('#record-plot').dataset.slideMs");
    assert_ne!(browser.text("#slid"), before);
    tab_to(&mut browser, "#diagnose");
    browser.key("Enter", Some("\r"));
    browser.wait("document.querySelector('#candidates .add')");
    tab_to(&mut browser, "#candidates .add");
    browser.key("Enter", Some("\r"));
    browser.wait(&format!("document.querySelectorAll('.chip').length == 1 && {FRESH}"));
    // The button is gone with its effect; who works by keys goes on at the verdict, not at the top.
    assert_eq!(browser.value("document.activeElement.id"), "headline");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

/// What one can see and use, each with the place of its kind in the order of the Tab key.
const USABLE: &str = "[...document.querySelectorAll('a[href], button, input:not([type=radio]:not(:checked)), select, summary, .plot:has(canvas), .u-series:not(.silent) th')].filter((e) => e.checkVisibility({ visibilityProperty: true }) && !e.disabled && !e.matches('.skip'))";

#[test]
fn nothing_that_one_can_see_and_use_is_beyond_the_tab_key() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("document.querySelector('#device').open = true");
    // All plots are drawn, so that their legends are there.
    browser.value("document.querySelectorAll('.plot').forEach(Plots.draw)");
    let all = browser.number(&format!("(globalThis.usable = {USABLE}).length"));
    assert!(all > 40.0, "{all}");
    browser.value("document.activeElement.blur(), scrollTo(0, 0)");
    for _ in 0..(2.0 * all) as usize {
        browser.key("Tab", None);
        browser.value("(usable = usable.filter((e) => e !== document.activeElement)).length");
    }
    let beyond = browser.value("usable.map((e) => e.outerHTML.slice(0, 80))");
    assert_eq!(beyond, serde_json::json!([]));
}

#[test]
fn a_log_is_mapped_and_a_puzzle_set_and_revealed_by_keyboard() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    tab_to(&mut browser, "#puzzle");
    browser.key("Enter", Some("\r"));
    browser.wait(&format!("/^Puzzle/.test(document.querySelector('#status').textContent) && {FRESH}"));
    tab_to(&mut browser, "#reveal");
    browser.key("Enter", Some("\r"));
    browser.wait("/Hidden: /.test(document.querySelector('#answer').textContent)");

    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("keys.csv");
    let rows = (0..400).map(|k| {
        format!(
            "{},{:.4},{:.5}\n",
            10 * k,
            6.0 * (0.02 * f64::from(k)).sin(),
            5.0 * (0.02 * f64::from(k) - 0.1).sin()
        )
    });
    std::fs::write(&log, "t,u,w\n".to_owned() + &rows.collect::<String>()).unwrap();
    browser.give_file("#file", &log);
    browser.wait("document.querySelector('#dialog').open");
    browser.wait("document.querySelectorAll('#preview select').length == 3");
    // The arrow keys choose among what a column can be, from what was guessed.
    for (column, kind) in ["time:ms", "voltage:V", "speed:rad/s"].iter().enumerate() {
        tab_to(&mut browser, &format!("#preview td:nth-child({}) select", column + 1));
        let place = format!("[...document.activeElement.options].findIndex((o) => o.value == '{kind}')");
        let steps =
            browser.value(&format!("{place} - document.activeElement.selectedIndex")).as_i64().unwrap();
        let key = if steps < 0 { "ArrowUp" } else { "ArrowDown" };
        for _ in 0..steps.abs() {
            browser.key(key, None);
        }
        assert_eq!(browser.value("document.activeElement.value"), *kind);
    }
    tab_to(&mut browser, "#use");
    browser.key("Enter", Some("\r"));
    browser.wait(&format!(
        "!document.querySelector('#dialog').open && document.querySelector('#title').textContent == 'keys' && {FRESH}"
    ));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_drag_over_one_plot_zooms_all_of_the_record_and_a_double_click_goes_back() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("document.querySelector('#record-plot').scrollIntoView({ behavior: 'instant' })");
    let place = browser.value(
        "(() => { const b = document.querySelectorAll('#record-plot .u-over')[1].getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()",
    );
    let [left, top, width, height] = [0, 1, 2, 3].map(|k| place[k].as_f64().unwrap());
    let middle = top + 0.5 * height;
    browser.drag([left + 0.25 * width, middle], [left + 0.5 * width, middle]);
    browser.wait("part && document.querySelector('#record-plot').dataset.detail");
    let part = browser.value("part");
    let (from, to) = (part[0].as_f64().unwrap(), part[1].as_f64().unwrap());
    assert!((from - 2.0).abs() < 0.2 && (to - 4.0).abs() < 0.2, "{from} {to}");
    browser.screenshot("#record-plot", "light-1-zoomed");
    let double = "document.querySelectorAll('#record-plot .u-over')[0].dispatchEvent(new MouseEvent('dblclick', { bubbles: true }))";
    browser.value(double);
    browser.wait("part === null && document.querySelector('#record-plot').dataset.detail");
}
