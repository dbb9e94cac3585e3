//! The fields of the dialogue beside the columns: what advice names is done there, what cannot stand there is told, and what was typed is kept.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use motorlens_browser_tests::{Browser, Server};
use serde_json::json;

use super::logs::{asked_about, taken};
use super::mapping::arduino;
use super::{FRESH, PAINTED, alone, opened};

/// A log that is read every 20 ms and in which each voltage was written 12 ms before its row, of a motor of 20 rad/s a volt and 50 ms.
fn late(directory: &Path, name: &str) -> PathBuf {
    const LEVELS: [f64; 12] = [0.0, 6.0, -4.0, 3.0, -6.0, 5.0, -2.0, 4.0, 0.0, -5.0, 6.0, -3.0];
    let volts = |t: f64| LEVELS[((t + 1e-6) / 0.6) as usize % LEVELS.len()];
    let mut text = "time_s,voltage_v,speed_rad_s\n".to_owned();
    let mut w = 0.0;
    for k in 0..361_i32 {
        let t = 0.02 * f64::from(k);
        // What a meter scatters by.
        writeln!(text, "{t:.2},{:.1},{:.4}", volts(t), w + 0.3 * f64::from(k * k).sin()).unwrap();
        for part in 0..200 {
            let drive = volts(t + 0.012 + 1e-4 * (f64::from(part) + 0.5));
            w += 1e-4 / 0.05 * (20.0 * drive - w);
        }
    }
    let path = directory.join(name);
    std::fs::write(&path, text).unwrap();
    path
}

/// Opens the dialogue of the first record again.
fn columns_of_the_first(browser: &mut Browser) {
    browser.click("#entries .columns");
    browser.wait("$('dialog').open");
}

const LEAD: &str = "\"Voltage acts before its row by (s)\"";

#[test]
fn a_voltage_that_is_logged_late_is_mended_in_the_field_that_the_advice_names_and_stays_mended() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    asked_about(&mut browser, &late(directory.path(), "late.csv"));
    assert_eq!(browser.value("$('log-more').open"), false, "few logs need what is folded there");
    taken(&mut browser, "late");
    let told = browser.text("#data-faults .card.fault");
    assert!(told.contains("shifted samples") && told.contains(LEAD) && !told.contains("--"), "{told}");
    assert!(told.contains("(\"columns\" beside the record, under \"More\")"), "{told}");
    browser.screenshot("#data-faults", "light-0-late-voltage");

    // The button leads to the field, and the advice stands beside it.
    browser.click("#next");
    browser.wait("$('dialog').open");
    let asked = browser.text("#log-asked");
    assert!(asked.contains("with 0.01") && asked.contains(LEAD), "{asked}");
    assert_eq!(browser.value("$('log-more').open"), true);
    let help = "$($('log-voltage-lead').getAttribute('aria-describedby')).textContent";
    let help = browser.value(help);
    assert!(help.as_str().unwrap().starts_with("How many seconds before its row a voltage acts"), "{help}");
    browser.screenshot("#log-more", "light-0-more-fields");
    browser.value("$('log-voltage-lead').value = '0.012'");
    browser.click("#use");
    browser.wait(&format!("/Undo reads them as before/.test($('status').textContent) && {FRESH}"));
    assert_eq!(browser.value("state.faults.some((f) => f.fault.startsWith('shifted_samples'))"), false);
    let gain = browser.number("state.parameters.find((p) => p.name == 'gain').value");
    assert!((gain / 20.0 - 1.0).abs() < 0.005, "{gain}");

    // A page that is loaded again shows it again, and Undo empties it.
    browser.open(&server.url);
    browser.wait(PAINTED);
    browser.wait(FRESH);
    columns_of_the_first(&mut browser);
    assert_eq!(browser.value("$('log-voltage-lead').value"), "0.012");
    assert_eq!(browser.value("$('log-more').open"), true);
    assert_eq!(browser.value("rigChosen()"), json!({ "voltage_lead": "0.012" }));
    browser.click("#cancel");
    browser.click("#undo");
    browser.wait(&format!("/last change of the data is undone/.test($('status').textContent) && {FRESH}"));
    columns_of_the_first(&mut browser);
    assert_eq!(browser.value("rigChosen()"), json!({}));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn what_cannot_stand_in_a_field_is_told_with_its_label_where_it_is_folded_away_too() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    asked_about(&mut browser, &late(directory.path(), "late.csv"));
    let refused = |browser: &mut Browser| {
        browser.value("$('log-fault').hidden = true, $('log-more').open = false");
        browser.click("#use");
        browser.wait("!$('log-fault').hidden");
        assert_eq!(browser.value("$('dialog').open"), true);
        browser.text("#log-fault")
    };
    browser.value("$('log-voltage-lead').value = '-0.012'");
    let told = refused(&mut browser);
    assert!(told.starts_with(&format!("{LEAD} is \"-0.012\"")), "{told}");
    assert!(told.contains("give a positive number, or leave it empty"), "{told}");
    assert_eq!(browser.value("$('log-more').open"), true);
    assert_eq!(browser.value("document.activeElement.id"), "log-voltage-lead");
    browser.screenshot("#log-fault", "light-0-wrong-field");

    // A letter that is typed.
    browser.value("$('log-voltage-lead').value = '', $('log-voltage-lead').focus()");
    browser.key("e", Some("e"));
    let told = refused(&mut browser);
    assert!(told.starts_with(&format!("{LEAD} is no number")), "{told}");
    browser.value("$('log-voltage-lead').value = '', $('log-gear-ratio').value = '-3'");
    let told = refused(&mut browser);
    assert!(told.starts_with("\"Gear ratio\" is \"-3\""), "{told}");
    // 0 is none of a gain, and one of a damping.
    browser.value(
        "$('log-gear-ratio').value = '', $('log-servo-damping').value = '0', $('log-servo-gain').value = '0'",
    );
    let told = refused(&mut browser);
    assert!(told.starts_with("\"Servo gain (duty per rad)\" is \"0\""), "{told}");

    // What only the server can judge.
    browser.value("$('log-servo-gain').value = '', $('log-only').value = 'id'");
    let told = refused(&mut browser);
    assert!(told.starts_with("\"Only the rows of\" is \"id\"") && told.contains("such as id:3"), "{told}");
    assert_eq!(browser.value("$('log-more').open"), true);
    browser.value("$('log-only').value = ''");
    taken(&mut browser, "late");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn a_second_file_of_the_same_columns_is_read_with_the_folded_fields_too_and_another_log_without() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    asked_about(&mut browser, &late(directory.path(), "one.csv"));
    browser.value("$('log-hold').value = 'first'");
    taken(&mut browser, "one");
    browser.give_file("#file", &late(directory.path(), "two.csv"));
    browser.wait(&format!("state.data.entries.length == 2 && {FRESH}"));
    let told = browser.text("#read-as-words");
    assert!(told.contains("Voltage between two rows \"runs straight to the next row\""), "{told}");
    browser.click("#read-as-change");
    browser.wait("$('dialog').open");
    assert_eq!(
        browser.value("[$('log-name').textContent, $('log-hold').value]"),
        json!(["two.csv", "first"])
    );
    browser.click("#cancel");
    asked_about(&mut browser, &arduino(directory.path(), "other.csv", 0.0));
    assert_eq!(browser.value("[$('log-hold').value, $('log-more').open]"), json!(["", false]));
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn the_rows_of_one_motor_are_chosen_in_the_field_that_the_refusal_names() {
    let _alone = alone();
    let directory = tempfile::tempdir().unwrap();
    let log = directory.path().join("both.csv");
    let mut text = "time_s,id,voltage_v,speed_rad_s\n".to_owned();
    let mut w = [0.0, 0.0];
    for k in 0..1600 {
        let (t, id) = (0.01 * f64::from(k / 2), (k % 2) as usize);
        let v = 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin();
        writeln!(text, "{t:.2},{},{v:.4},{:.5}", id + 1, w[id]).unwrap();
        w[id] += 0.01 * ([0.9, 1.8][id] * v - w[id]) / 0.06;
    }
    std::fs::write(&log, text).unwrap();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    asked_about(&mut browser, &log);
    browser.click("#use");
    browser.wait("!$('log-fault').hidden");
    let told = browser.text("#log-fault");
    assert!(told.contains("id:1 in \"Only the rows of\"") && !told.contains("--"), "{told}");
    assert_eq!(browser.value("$('log-more').open"), true);
    browser.value("$('log-only').value = 'id:2'");
    taken(&mut browser, "both");
    let gain = browser.number("state.parameters.find((p) => p.name == 'gain').value");
    assert!((gain / 1.8 - 1.0).abs() < 0.1, "{gain}");
    columns_of_the_first(&mut browser);
    assert_eq!(browser.value("$('log-only').value"), "id:2");
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}

#[test]
fn advice_that_names_an_option_names_on_the_page_the_field_or_the_place_that_does_the_same() {
    let _alone = alone();
    let server = Server::start::<&str>(&[]);
    let mut browser = opened(&server);
    for (advice, said) in [
        (
            "read this log with --voltage-lead 0.008, by which",
            "with 0.008 in \"Voltage acts before its row by (s)\"",
        ),
        (
            "read this log with --hold first",
            "with \"runs straight to the next row\" in \"Voltage between two rows\"",
        ),
        (
            "give what is known: --servo-gain DUTY_PER_RAD, --servo-damping DUTY_PER_RAD_S, and the supply (--supply-volts or --map supply=...)",
            "\"Servo damping (duty per rad/s)\", and the supply (\"Supply (V), for a duty\" or its column as supply)",
        ),
        ("say which is right: --rate 50 or --rate 25", "or 25 in \"Samples per second\""),
        ("convert it to CSV, or name its layout with --format", "in \"Layout of the file\""),
        (
            "give inductance_h and resistance_ohm in motor.toml if yours is",
            "fill in \"Winding inductance (H)\" (where the log is opened, under \"More\") and \"Winding resistance (Ohm)\"",
        ),
        ("say --map angle=a:rad/104, or correct gear_ratio and counts_per_rev", "correct \"Gear ratio\""),
        (
            "say --map \"time=t:s,duty=my u:4095\" --supply-volts 12 for duty, or --map time=t:s,voltage=u:mV",
            "choose \"t\" as time in s, \"my u\" as duty of 4095, with 12 in \"Supply (V), for a duty\" for duty, or \"t\" as",
        ),
        ("read each alone: --map time=t:s,only=servo:1", "servo:1 in \"Only the rows of\""),
        (
            "leave that out with --skip run:1.000..2.500 --skip run:3.000..4.000, and log a duty of 0",
            "leave that out under 1 Compare (Brush out, or From and To: 1.000 to 2.500 s and 3.000 to 4.000 s of run), and",
        ),
        ("else fit to records of one direction (--skip)", "direction (Brush out)"),
        ("say with --map which columns are to be read", "say under \"columns\" beside the record which"),
        ("use that model (fit --effects coulomb,delay), or", "(4 Add: coulomb and delay and nothing else)"),
    ] {
        let told = browser.value(&format!("onPage({})", json!(advice)));
        let told = told.as_str().unwrap();
        assert!(told.contains(said) && !told.contains("--") && !told.contains(".toml"), "{told}");
    }
    // Options of another program are its own.
    let foreign = "convert it: mavlogdump.py --format csv --types RCOU OLD > NEW.csv";
    assert_eq!(browser.value(&format!("onPage({})", json!(foreign))), foreign);
    assert!(browser.complaints.is_empty(), "{:?}", browser.complaints);
}
