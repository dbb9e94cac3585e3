//! The data as their user edits them: several logs at once, roles, ranges brushed out, undo; and an effect that is wrong.

use std::io::Write;
use std::path::{Path, PathBuf};

use motorlens_browser_tests::{Browser, Server, run};
use serde_json::json;

use super::{FRESH, added, alone, diagnosed, effects, opened};

/// Published logs of a motor; none where they are not there: they are no part of the repository.
fn published(rig: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../shared/data");
    let data = std::env::var_os("MOTORLENS_DATA").map_or(beside, PathBuf::from);
    Some(data.join(rig)).filter(|rig| rig.is_dir())
}

/// Three logs of one motor to drop: published ones, or where they are not there those of a simulated motor, said past the test harness.
fn three_logs(directory: &Path) -> [PathBuf; 3] {
    if let Some(rig) = published("fra233-motor") {
        return ["ramp.csv", "sine_2.5hz.csv", "stair_1hz.csv"].map(|name| rig.join("train").join(name));
    }
    let message =
        "NO PUBLISHED LOGS (MOTORLENS_DATA names their directory): the whole loop runs on simulated ones\n";
    let _ = std::io::stderr().write_all(message.as_bytes());
    let out = directory.to_str().unwrap();
    run(&["simulate", "--quiet", "--rate", "100", "--effect", "coulomb=0.4", "--out", out]);
    ["triangle.csv", "multisine.csv", "staircase.csv"].map(|name| directory.join(name))
}

/// Drops files on the page, as a person does it.
fn dropped(browser: &mut Browser, files: &[PathBuf]) {
    let files: Vec<(String, String)> = files
        .iter()
        .map(|path| {
            let name = path.file_name().unwrap().to_str().unwrap().to_owned();
            (name, std::fs::read_to_string(path).unwrap())
        })
        .collect();
    browser.value(&format!(
        "(() => {{ const data = new DataTransfer(); for (const [name, text] of {}) data.items.add(new File([text], name)); \
         dispatchEvent(new DragEvent('drop', {{ dataTransfer: data, bubbles: true, cancelable: true }})); }})()",
        json!(files)
    ));
    browser.wait("document.querySelector('#dialog').open");
}

#[test]
fn the_whole_loop_on_published_logs_that_are_dropped_on_the_page() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let logs = three_logs(directory.path());
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    dropped(&mut browser, &logs);
    assert!(
        browser.number("document.querySelectorAll('#raw canvas').length") >= 1.0,
        "raw columns are plotted"
    );
    browser.screenshot("#dialog", "light-0-mapping");
    browser.click("#use");
    browser.wait(&format!("!$('dialog').open && state.data.entries.length == 3 && {FRESH}"));
    // As the user named them.
    let names = logs.map(|path| path.file_stem().unwrap().to_str().unwrap().to_owned());
    assert_eq!(browser.value("state.data.entries.map((e) => e.name)"), json!(names));
    // One of them judges from now on.
    browser.click("#entries tr:nth-child(3) input[value=validation]");
    browser.wait(&format!("state.data.entries[2].role == 'validation' && {FRESH}"));
    assert!(browser.text("#headline").contains("x the noise"));
    diagnosed(&mut browser);
    let said = browser.text("#badge");
    if said == "An effect is missing" {
        added(&mut browser);
        assert!(browser.text("#status").contains("on validation records"), "{}", browser.text("#status"));
        diagnosed(&mut browser);
    }
    browser.screenshot("header", "light-0-real-log");
    let badges = [
        "Explained",
        "Explained but for a disturbance",
        "Partly explained",
        "Unexplained",
        "An effect is missing",
    ];
    assert!(badges.contains(&browser.text("#badge").as_str()), "{}", browser.text("#badge"));
    // kS-kV-kA stands beside the other models.
    assert_eq!(browser.text("#models tr:first-child th"), "kS-kV-kA");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_range_is_brushed_out_and_comes_back_with_undo() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    assert_eq!(browser.value("$('undo').disabled"), true);
    let records = browser.number("state.records.length");
    browser.value("$('brush').scrollIntoView({ behavior: 'instant' })");
    browser.click("#brush");
    browser.value("$('record-plot').scrollIntoView({ behavior: 'instant' })");
    let place = browser.value(
        "(() => { const b = document.querySelectorAll('#record-plot .u-over')[1].getBoundingClientRect(); return [b.left, b.top, b.width, b.height]; })()",
    );
    let [left, top, width, height] = [0, 1, 2, 3].map(|k| place[k].as_f64().unwrap());
    let middle = top + 0.5 * height;
    browser.drag([left + 0.25 * width, middle], [left + 0.5 * width, middle]);
    browser.wait(&format!("state.data.entries[0].cuts.length == 1 && {FRESH}"));
    // Two pieces in the place of one record, and the range is told.
    assert_eq!(browser.number("state.records.length"), records + 1.0);
    assert!(browser.text("#entries tr:nth-child(1) td:last-child").contains('…'));
    browser.screenshot("#data", "light-0-brushed");
    // A data problem of a piece is mended in that piece.
    browser.value("mendData({ mend: 'range', where: state.records[1].name + ', column angle_rad' })");
    assert_eq!(browser.number("chosen()"), 1.0);
    assert_eq!(browser.value("$('brush').getAttribute('aria-pressed')"), "true");
    browser.value("($('brush').click(), $('record').value = 0, part = null, showRecord())");
    browser.click("#undo");
    browser.wait(&format!("state.data.entries[0].cuts.length == 0 && {FRESH}"));
    assert_eq!(browser.number("state.records.length"), records);

    // The same by keyboard: a range that is typed, and Ctrl-Z.
    browser.value("$('cut-from').value = '1', $('cut-to').value = '2', $('cut').focus()");
    browser.key("Enter", Some("\r"));
    browser.wait(&format!("state.data.entries[0].cuts.length == 1 && {FRESH}"));
    browser.value("document.body.dispatchEvent(new KeyboardEvent('keydown', { key: 'z', ctrlKey: true, bubbles: true }))");
    browser.wait(&format!("state.data.entries[0].cuts.length == 0 && {FRESH}"));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_headline_tells_no_option_of_the_command_line() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let beside =
        "The size of coast supposes a supply of 6 V: give the supply with --supply-volts, or log it.";
    browser.value(&format!(
        "showStanding({{ verdict: null, badge: '', next: {{ action: 'look', label: '', command: '' }} }}, ['Nothing is left.', '{beside}'])"
    ));
    assert!(browser.text("#headline").starts_with("Nothing is left. The size of coast"));
    let told = browser.text("#headline span");
    assert!(told.contains("give the supply") && !told.contains("--"), "{told}");
}

#[test]
fn a_role_is_changed_by_clicking_and_the_last_record_to_fit_stays() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.click("#entries tr:nth-child(2) input[value=out]");
    browser.wait(&format!("state.data.entries[1].role == 'out' && {FRESH}"));
    assert_eq!(browser.value("state.records.some((r) => r.name == state.data.entries[1].name)"), false);
    for k in [0, 2, 3, 4] {
        browser.value(&format!("ask('/api/data', {{ change: 'role', entry: {k}, role: 'out' }})"));
        browser.wait(&format!("state.data.entries[{k}].role == 'out' && {FRESH}"));
    }
    browser.click("#entries tr:nth-child(6) input[value=out]");
    browser.wait("!$('alarm').hidden");
    assert!(browser.text("#alarm").contains("no record would be left to fit"));
    assert_eq!(
        browser.value("document.querySelector('#entries tr:nth-child(6) input[value=fit]').checked"),
        true
    );
}

#[test]
fn a_wrong_effect_is_not_praised_and_goes_with_one_click() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    browser.value("$('effect').value = 'lost_counts'");
    browser.click("#add-effect");
    browser.wait(&format!("document.querySelectorAll('.chip').length == 1 && {FRESH}"));
    assert_eq!(browser.text("#badge"), "Not confirmed");
    assert_eq!(browser.text("#next"), "Remove lost_counts");
    let (before, after) = (
        browser.number("state.ladder[0].validation.rmse"),
        browser.number("state.ladder[1].validation.rmse"),
    );
    let (way, said) = if after > before {
        ("rises", "With lost counts the error rises, most on ")
    } else {
        ("falls", "Held-out data do not confirm lost counts; ")
    };
    assert!(browser.text("#headline").starts_with(said), "{}", browser.text("#headline"));
    let status = browser.text("#status");
    assert!(status.contains(way) || status.contains("stays at"), "{status}");
    if after > before {
        assert!(browser.number("document.querySelectorAll('#models tr.rise').length") == 1.0);
    }
    browser.screenshot("header", "light-0-wrong-effect");
    browser.click("#next");
    browser.wait(&format!("document.querySelectorAll('.chip').length == 0 && {FRESH}"));
    assert_eq!(effects(&mut browser), 0.0);
    assert_eq!(browser.text("#next"), "Find what is missing");
    // The model is what it was, and who has seen the effect fail is not sent there again.
    let again = browser.number("state.ladder[2].validation.rmse");
    assert!((again / before - 1.0).abs() < 1e-3, "{before} before, {again} after");
    diagnosed(&mut browser);
    assert_eq!(browser.value("document.querySelector('#card-lost_counts')"), serde_json::Value::Null);
}

#[test]
fn an_effect_file_takes_part_and_a_wrong_one_is_refused_with_its_line() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    let directory = tempfile::tempdir().unwrap();
    let cam = "name = \"cam\"\nport = \"torque\"\nformula = \"-size * sin(3 * angle)\"\n[[parameter]]\nname = \"size\"\nunit = \"V\"\nlow = -6\ntypical = 0.3\nhigh = 6\n";
    let (good, bad) = (directory.path().join("cam.toml"), directory.path().join("bad.toml"));
    std::fs::write(&good, cam).unwrap();
    std::fs::write(&bad, cam.replace("sin(", "sine(").replace("cam", "bad")).unwrap();
    browser.give_file("#effect-file", &good);
    browser.wait("[...document.querySelectorAll('#effect option')].some((o) => o.value == 'cam')");
    assert_eq!(browser.value("meaningOf('cam.size') !== ''"), true);
    // It is added as any other: with its parameter, and the words of what held-out data say of it.
    browser.value("$('effect').value = 'cam'");
    browser.click("#add-effect");
    browser.wait(&format!("document.querySelectorAll('.chip').length == 1 && {FRESH}"));
    assert!(browser.text(".chip").starts_with("cam"));
    assert_eq!(browser.value("state.parameters.some((p) => p.name == 'cam.size' && p.unit == 'V')"), true);
    assert!(browser.text("#status").starts_with("cam is in the model: "), "{}", browser.text("#status"));
    assert!(browser.text("#models").contains("cam"));
    browser.give_file("#effect-file", &bad);
    browser.wait("!$('alarm').hidden");
    assert!(browser.text("#alarm").contains("bad.toml"), "{}", browser.text("#alarm"));
}

#[test]
fn two_models_are_drawn_side_by_side() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    assert!(browser.value("state.models.includes('kS-kV-kA')") == true);
    browser.value("$('against').value = state.models.indexOf('kS-kV-kA'), $('against').dispatchEvent(new Event('change'))");
    browser.wait("document.querySelector('#record-reading').textContent.includes('kS-kV-kA')");
    let names = "ask('/api/record/0').then((f) => f.panels[0].curves.map((c) => c.name))";
    assert_eq!(browser.value(names), json!(["measured", "kS-kV-kA", "model"]));
}
