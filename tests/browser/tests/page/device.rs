//! A motor at the other end of a line: run, watched, stopped, fitted.

use std::time::{Duration, Instant};

use motorlens_browser_tests::{Board, Browser, Server};

use super::logs::with_a_question;
use super::{FRESH, added, alone, diagnosed, effects, opened, over_floor};

fn connected(browser: &mut Browser, board: &Board) {
    browser.value("document.querySelector('#device').open = true");
    browser.value(&format!("document.querySelector('#port').value = '{}'", board.address));
    browser.click("#connect button");
    browser.wait("!document.querySelector('#play').hidden");
    assert!(browser.text("#board").contains("Firmware"));
}

/// Fills the form: a programme of so many seconds a run.
fn wished(browser: &mut Browser, programme: &str, seconds: f64) {
    browser.value(&format!(
        "$('programme').value = '{programme}', $('seconds').value = {seconds}, $('amplitude').value = 8, $('counts').value = 1000"
    ));
}

#[test]
fn a_programme_is_played_with_live_plots_and_its_records_are_fitted() {
    let _alone = alone();
    let board = Board::start(&["coulomb=0.4"]);
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    connected(&mut browser, &board);
    wished(&mut browser, "multisine", 4.0);
    browser.click("#run");
    browser.wait("Number(document.querySelector('#live').dataset.samples) > 1500 && document.querySelectorAll('#live canvas').length == 2");
    browser.screenshot("#device", "light-0-live");
    browser.wait(&format!(
        "/4 records of the motor are in/.test(document.querySelector('#status').textContent) && {FRESH}"
    ));
    let roles = browser.value("state.records.map((r) => r.unseen)");
    assert_eq!(roles, serde_json::json!([false, false, false, true]));
    diagnosed(&mut browser);
    assert!(browser.text(".card").contains("coulomb"), "{}", browser.text(".card"));
    added(&mut browser);
    assert_eq!(effects(&mut browser), 1.0);
    let left = over_floor(&mut browser);
    assert!(left < 3.0, "{left} noise floors are left");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn the_stop_button_takes_the_voltage_off_at_once() {
    let _alone = alone();
    let board = Board::start(&[]);
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    connected(&mut browser, &board);
    // Other work on the machine slows some stops; none makes one quicker than it can be.
    let (at_once, mut delays) = (Duration::from_millis(100), Vec::new());
    for round in 0..15 {
        if delays.len() >= 3 && delays.iter().any(|delay| *delay < at_once) {
            break;
        }
        let by_key = round % 2 == 1;
        wished(&mut browser, "sine", 20.0);
        browser.click("#run");
        browser.wait("Number(document.querySelector('#live').dataset.samples) > 300");
        assert_eq!(browser.value("$('running').hidden"), false);
        let asked = Instant::now();
        if by_key {
            browser.key("Escape", None)
        } else {
            browser.click("#stop")
        }
        browser.wait("/^The motor is stopped/.test(document.querySelector('#status').textContent)");
        // A board that had let go by itself, of a host too busy to be heard, says nothing of the button.
        delays.extend(board.released().and_then(|off| off.checked_duration_since(asked)));
        browser.value("$('status').textContent = ''; delete $('live').dataset.samples;");
    }
    println!("from the press to the bridge being off: {delays:.0?}");
    assert!(delays.iter().any(|d| *d < at_once), "{delays:?}");
    // Nothing of a stopped run is used.
    assert_eq!(browser.number("ask('/api/state').then((s) => s.records.length)"), 7.0);
}

#[test]
fn a_shaft_that_still_turns_is_waited_for_until_it_is_held_and_the_stop_button_ends_that() {
    let _alone = alone();
    let board = Board::turned();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    connected(&mut browser, &board);
    wished(&mut browser, "sine", 2.0);
    let waits = "/still turns: waiting/.test($('doing').textContent)";
    browser.click("#run");
    browser.wait(waits);
    browser.click("#stop");
    browser.wait("/^The motor is stopped/.test(document.querySelector('#status').textContent)");
    assert_eq!(browser.value(waits), false);
    browser.click("#run");
    browser.wait(waits);
    board.hold();
    browser.wait("Number(document.querySelector('#live').dataset.samples) > 300");
    assert_eq!(browser.value("/^Running /.test($('doing').textContent)"), true);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn the_next_experiment_runs_on_the_motor_and_its_record_joins_the_others() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start(&with_a_question(directory.path()));
    let board = Board::start(&["coulomb=0.4"]);
    let mut browser = opened(&server);
    let records = browser.number("state.records.length");
    diagnosed(&mut browser);
    browser.wait("document.querySelector('.card.next .run-next')");
    assert!(browser.text(".run-next").starts_with("Connect"));
    connected(&mut browser, &board);
    assert!(browser.text(".run-next").starts_with("Run it"));
    browser.click(".run-next");
    assert_eq!(browser.value("[$('programme').value, $('join').checked]"), serde_json::json!(["next", true]));
    // The records tell the counts of a turn; this board has its own.
    assert!(browser.number("Number($('counts').value)") > 0.0);
    browser.value("$('counts').value = 1000");
    browser.click("#run");
    browser.wait("Number(document.querySelector('#live').dataset.samples) > 300");
    browser.wait(&format!(
        "/1 record of the motor is in/.test(document.querySelector('#status').textContent) && {FRESH}"
    ));
    assert_eq!(browser.number("state.records.length"), records + 1.0);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_line_with_nobody_at_its_end_gets_a_message() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("document.querySelector('#device').open = true");
    browser.value("document.querySelector('#port').value = 'tcp://127.0.0.1:1'");
    browser.click("#connect button");
    browser.wait("!document.querySelector('#alarm').hidden");
    let message = browser.text("#alarm");
    assert!(message.contains("tcp://127.0.0.1:1") && message.contains("To do"), "{message}");
}

#[test]
fn a_current_limit_holds_once_the_page_is_told_what_amplifier_is_wired() {
    let _alone = alone();
    let board = Board::start(&[]);
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    connected(&mut browser, &board);
    wished(&mut browser, "multisine", 2.0);
    browser.value("$('current').value = 0.1");
    browser.click("#run");
    browser.wait("/no current is measured/.test($('alarm').textContent)");
    browser.value("$('amplifier').value = 165, $('divider').value = 11");
    browser.click("#run");
    browser.wait("/over-current/.test($('alarm').textContent)");
}
