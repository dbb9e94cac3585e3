//! Everything can be reached and done without a mouse.

use motorlens_browser_tests::Server;

use super::{alone, opened};

/// Moves the focus on until it is on what `selector` names.
fn tab_to(browser: &mut motorlens_browser_tests::Browser, selector: &str) {
    for _ in 0..200 {
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
    browser.wait("document.querySelector('.card .add')");
    tab_to(&mut browser, ".card .add");
    browser.key("Enter", Some("\r"));
    browser.wait("document.querySelectorAll('.chip').length == 1");
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
