//! The live page and the report in a real browser.

mod accessible;
mod data;
mod device;
mod fields;
mod guard;
mod keyboard;
mod logs;
mod mapping;
mod overview;
mod plots;
mod report;
mod steps;
mod times;

use std::sync::{Mutex, MutexGuard, PoisonError};

use motorlens_browser_tests::{Browser, Server};

/// One browser at a time: each wants the whole machine.
fn alone() -> MutexGuard<'static, ()> {
    static ONE: Mutex<()> = Mutex::new(());
    ONE.lock().unwrap_or_else(PoisonError::into_inner)
}

/// The first step is drawn.
const PAINTED: &str = "document.body.dataset.painted && document.querySelector('#record-plot canvas')";
/// Every step has what belongs to the model as it is.
const FRESH: &str = "document.body.dataset.fresh && document.querySelector('#running').hidden";
/// Every plot that has a place on the page is drawn: what is out of sight is, when there is time.
const DRAWN: &str = "![...document.querySelectorAll('.plot[data-drawn=\"\"]')].some((p) => p.clientWidth && !p.closest('[hidden]'))";

fn opened(server: &Server) -> Browser {
    let mut browser = Browser::start(1280, 900);
    browser.open(&server.url);
    browser.wait(PAINTED);
    browser.wait(FRESH);
    browser.wait(DRAWN);
    browser
}

/// How many effects the page says are in the model.
fn effects(browser: &mut Browser) -> f64 {
    browser.number("document.querySelectorAll('.chip').length")
}

/// The error of the last model in multiples of the noise.
fn over_floor(browser: &mut Browser) -> f64 {
    browser.number("document.querySelector('#falls').dataset.lastOverFloor")
}

/// Finds what is missing and waits for the cards.
fn diagnosed(browser: &mut Browser) {
    browser.value("document.querySelector('#status').textContent = ''");
    browser.click("#diagnose");
    browser.wait(&format!(
        "/An effect is missing|No effect/.test(document.querySelector('#status').textContent) && {FRESH}"
    ));
}

/// Adds the first card's effect and waits for the ladder.
fn added(browser: &mut Browser) {
    let before = effects(browser);
    browser.click("#candidates .add");
    browser.wait(&format!("document.querySelectorAll('.chip').length == {} && {FRESH}", before + 1.0));
}
