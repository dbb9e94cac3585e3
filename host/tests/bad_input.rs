//! Input that cannot be used: each is named with its place, cause and remedy, ends with 3, and leaves no file.

mod program;

use std::fmt::Write;
use std::path::Path;

use program::{Ran, files, run};

/// 4 s at 100 Hz; `angle` and `voltage` of the time.
fn table(header: &str, voltage: impl Fn(f64) -> f64, angle: impl Fn(f64) -> f64) -> String {
    let mut text = format!("{header}\n");
    for k in 0..400 {
        let t = f64::from(k) * 0.01;
        let _ = writeln!(text, "{t},{},{}", voltage(t), angle(t));
    }
    text
}

const HEADER: &str = "time_s,voltage_v,angle_rad";

fn square(t: f64) -> f64 {
    if (t * 2.0) as i64 % 2 == 0 { 6.0 } else { -6.0 }
}

/// What a motor without inertia does under [`square`].
fn follows(t: f64) -> f64 {
    let phase = (t * 2.0) % 2.0;
    1.5 * if phase < 1.0 { phase } else { 2.0 - phase }
}

fn refused(content: &[u8], wanted: &[&str]) {
    for verb in ["fit", "discover"] {
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("log.csv"), content).unwrap();
        let ran = run(directory.path(), &format!("{verb} log.csv --out model.json --json")).ends(3);
        for text in wanted {
            assert!(ran.err.contains(text), "{text:?} in {}", ran.err);
        }
        assert!(ran.err.contains("log.csv") && ran.err.contains("  do: "), "{}", ran.err);
        assert_document(&ran, verb);
        assert_eq!(files(directory.path()), [directory.path().join("log.csv")], "no half-written file");
    }
}

fn assert_document(ran: &Ran, verb: &str) {
    let document = ran.json();
    assert_eq!(document["error"]["exit"], 3, "{document}");
    if verb == "discover" {
        assert_eq!(document["verdict"], "bad_data");
        let fault = &document["data_faults"][0];
        for key in ["fault", "where", "fix"] {
            assert!(fault[key].as_str().is_some_and(|s| !s.is_empty()), "{key} in {document}");
        }
    }
}

#[test]
fn empty_files_headers_without_rows_and_single_rows_are_named() {
    refused(b"", &["empty"]);
    refused(format!("{HEADER}\n").as_bytes(), &["no sample"]);
    refused(format!("{HEADER}\n0,1,0\n").as_bytes(), &["line 2"]);
}

#[test]
fn fields_that_are_no_numbers_and_time_that_goes_backwards_are_named_with_line_and_column() {
    let good = table(HEADER, square, follows);
    refused(good.replace("1,6,", "1,ERR,").as_bytes(), &["line 3", "column voltage_v", "ERR"]);
    let backwards = good.replacen("\n0.2,", "\n0.05,", 1);
    refused(backwards.as_bytes(), &["line 22", "column time_s"]);
}

#[test]
fn one_bad_field_is_left_out_and_told() {
    let directory = tempfile::tempdir().unwrap();
    let text = table(HEADER, square, follows).replacen("0.1,6,", "0.1,ERR,", 1);
    std::fs::write(directory.path().join("log.csv"), text).unwrap();
    let ran = run(directory.path(), "fit log.csv").ends(0);
    assert!(ran.err.contains("line 12") && ran.err.contains("voltage_v"), "{}", ran.err);
    let found = run(directory.path(), "discover log.csv --most 0 --json").ends(0).json();
    assert!(found["data_faults"][0]["where"].as_str().unwrap().contains("line 12"), "{found}");
}

#[test]
fn motors_that_teach_nothing_are_named_with_the_column() {
    refused(table(HEADER, |_| 5.0, |t| 4.0 * t).as_bytes(), &["column voltage_v", "5.000 V"]);
    refused(table(HEADER, square, |_| 1.0).as_bytes(), &["column angle_rad", "never moves"]);
    refused(table(HEADER, square, |t| -follows(t)).as_bytes(), &["column angle_rad", "sign"]);
}

#[test]
fn wrong_units_are_recognised() {
    let milliseconds = table(HEADER, square, follows)
        .lines()
        .enumerate()
        .map(|(k, line)| match line.split_once(',') {
            Some((t, rest)) if k > 0 => format!("{},{rest}\n", t.parse::<f64>().unwrap() * 1000.0),
            _ => format!("{line}\n"),
        })
        .collect::<String>();
    refused(milliseconds.as_bytes(), &["time_s"]);
}

#[test]
fn a_byte_that_is_no_text_costs_its_row_and_a_binary_file_is_named() {
    let text = table(HEADER, square, follows);
    let row = text.find("\n0.1,").unwrap() + 1;
    for stray in [0xff, 0x00] {
        let mut bytes = text.clone().into_bytes();
        bytes[row + 2] = stray;
        let directory = tempfile::tempdir().unwrap();
        std::fs::write(directory.path().join("log.csv"), &bytes).unwrap();
        let ran = run(directory.path(), "fit log.csv").ends(0);
        assert!(ran.err.contains("line 12, column time_s") && ran.err.contains("left out"), "{}", ran.err);
    }
    let binary: Vec<u8> = text.bytes().map(|b| if b.is_ascii_digit() { 1 } else { b }).collect();
    refused(&binary, &["line 2", "binary"]);
}

#[test]
fn a_directory_an_absent_file_and_models_of_another_schema_are_named() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    std::fs::create_dir(here.join("folder")).unwrap();
    std::fs::write(here.join("log.csv"), table(HEADER, square, follows)).unwrap();
    for (words, wanted) in [("fit folder", "directory"), ("fit absent.csv", "absent.csv")] {
        let ran = run(here, words).ends(3);
        assert!(ran.err.contains(wanted) && ran.err.contains("  do: "), "{}", ran.err);
    }
    model_refused(here, "{\"schema\": 99}", "schema 99");
    model_refused(here, "{\"schema\": 1}", "missing field");
    model_refused(here, "{", "line 1");
    model_refused(here, "{}", "no schema");
}

fn model_refused(directory: &Path, model: &str, wanted: &str) {
    std::fs::write(directory.join("m.json"), model).unwrap();
    for words in
        ["compare m.json log.csv", "diagnose m.json log.csv", "add m.json coulomb log.csv --out n.json"]
    {
        let ran = run(directory, words).ends(3);
        assert!(ran.err.contains("m.json") && ran.err.contains(wanted), "{}", ran.err);
    }
    assert!(!directory.join("n.json").exists());
}

#[test]
fn fixed_parameters_are_held_and_a_slip_in_their_name_is_answered() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let logs = program::logs(here);
    let logs = logs.replace("s/motor.toml", "m.toml");
    std::fs::write(here.join("m.toml"), "[fixed]\ntau_e = 0.0009\n").unwrap();
    let fit = run(here, &format!("fit {logs} --json")).ends(0).json();
    let tau_e = &fit["parameters"][2];
    assert_eq!((&tau_e["value"], &tau_e["low"]), (&tau_e["high"], &tau_e["value"]));
    assert!((tau_e["value"].as_f64().unwrap() - 0.0009).abs() < 1e-12);
    std::fs::write(here.join("m.toml"), "[fixed]\ntau_x = 0.0009\n").unwrap();
    let slip = run(here, &format!("fit {logs}")).ends(3);
    assert!(slip.err.contains("m.toml") && slip.err.contains("did you mean tau_"), "{}", slip.err);
}

#[test]
fn records_that_say_too_little_and_faults_of_the_data_are_told_beside_the_answer() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    // A steady speed, counted: no acceleration, no time constant.
    let slow = table(HEADER, |t| 2.0 + 0.002 * t, |t| (100.0 * (1.2 * t + 0.0006 * t * t)).floor() / 100.0);
    std::fs::write(here.join("log.csv"), slow).unwrap();
    let fit = run(here, "fit log.csv --json").ends(0).json();
    let told = |document: &serde_json::Value, wanted: &str| {
        let all = document["data_faults"].as_array().unwrap();
        all.iter().any(|f| {
            f["fault"].as_str().unwrap().starts_with(wanted) && !f["fix"].as_str().unwrap().is_empty()
        })
    };
    assert!(told(&fit, "too_little_excitation"), "{}", fit["data_faults"]);

    // The voltage eight rows late.
    run(here, "simulate --rate 100 --out s --quiet").ends(0);
    let text = std::fs::read_to_string(here.join("s/multisine.csv")).unwrap();
    let rows: Vec<Vec<&str>> = text.lines().map(|l| l.split(',').collect()).collect();
    let first = rows.iter().position(|r| r[0] == "time_s").unwrap() + 1;
    let mut late: String = text.lines().take(first).map(|l| format!("{l}\n")).collect();
    for k in first..rows.len() {
        let voltage = rows[k.max(first + 8) - 8][1];
        let _ = writeln!(late, "{},{voltage},{}", rows[k][0], rows[k][2]);
    }
    std::fs::write(here.join("late.csv"), late).unwrap();
    let fit = run(here, "fit late.csv --json").ends(0).json();
    assert!(told(&fit, "shifted_samples"), "{}", fit["data_faults"]);
    let said = run(here, "fit late.csv").ends(0);
    assert!(said.err.contains("before its voltage") && said.err.contains("  do: "), "{}", said.err);
    let good = run(here, "fit s/multisine.csv --json").ends(0).json();
    assert_eq!(good["data_faults"].as_array().map(Vec::len), Some(0), "{}", good["data_faults"]);
}
