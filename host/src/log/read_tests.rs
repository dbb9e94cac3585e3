//! The reader as a whole: what it accepts, what it refuses and how it says so.

use std::path::{Path, PathBuf};

use super::{Hold, ReadOptions, Record, read, write_canonical};
use crate::error::{Error, Result};

/// A file in a directory of its own.
pub(super) fn file(content: &[u8]) -> (tempfile::TempDir, PathBuf) {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    std::fs::write(&path, content).unwrap();
    (directory, path)
}

fn read_text(content: &[u8], options: &ReadOptions) -> Result<Record> {
    let (_directory, path) = file(content);
    read(&path, options).map(|mut records| records.remove(0))
}

fn mapped(map: &str) -> ReadOptions {
    ReadOptions { map: Some(map.parse().unwrap()), ..ReadOptions::default() }
}

/// A canonical log of `rows` samples at 100 Hz; `edit` may replace the line of a row.
pub(super) fn canonical(rows: usize, edit: impl Fn(usize) -> Option<String>) -> String {
    let mut text = "time_s,voltage_v,angle_rad\n".to_owned();
    for row in 0..rows {
        let t = row as f64 * 0.01;
        let line =
            edit(row).unwrap_or_else(|| format!("{t:.3},{:.3},{:.4}", (3.0 * t).sin(), (3.0 * t).cos()));
        text += &line;
        text.push('\n');
    }
    text
}

#[test]
fn byte_order_marks_line_ends_separators_and_spaces_do_not_matter() {
    let plain = canonical(50, |_| None);
    let expected = read_text(plain.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(expected.len(), 50);
    for variant in [
        format!("\u{FEFF}{plain}"),
        plain.replace('\n', "\r\n"),
        plain.replace(',', ", "),
        plain.replace(',', ";"),
        plain.replace(',', "\t"),
        plain.replace(',', ";").replace('.', ","),
        plain.replace('\n', ",\n"),
        plain.replace("time_s", "# gear: x\n\n# operator: Ada\ntime_s").replace("\n0.100", "\n\n0.100"),
        plain.trim_end().to_owned(),
    ] {
        let record = read_text(variant.as_bytes(), &ReadOptions::default()).unwrap();
        assert_eq!(record.time_s, expected.time_s, "{variant}");
        assert_eq!(record.angle_rad, expected.angle_rad);
    }
}

#[test]
fn a_foreign_table_is_read_by_name_or_by_number_in_its_units() {
    let body: String = (0..40).map(|i| format!("{},{},180\n", i * 10, 1000 + i)).collect();
    let named = format!("t,u,y\n{body}");
    for (text, map) in [
        (named.as_str(), "time=t:ms,voltage=u:mV,speed=y:deg/s"),
        (named.as_str(), "time=0:ms,voltage=1:mV,speed=2:deg/s"),
        (body.as_str(), "time=0:ms,voltage=1:mV,speed=2:deg/s"),
    ] {
        let record = read_text(text.as_bytes(), &mapped(map)).unwrap();
        assert_eq!(record.len(), 40, "{map}");
        assert!((record.time_s[39] - 0.39).abs() < 1e-12);
        assert!((record.voltage_v[39] - 1.039).abs() < 1e-12);
        assert!((record.speed_rad_s.unwrap()[0] - std::f64::consts::PI).abs() < 1e-12);
        assert!(record.angle_rad.is_none());
    }
}

#[test]
fn duty_becomes_voltage_through_the_supply_column_or_option() {
    let body: String = (0..40).map(|i| format!("{},51,8000,1\n", i * 10)).collect();
    let text = format!("t,cmd,battery,y\n{body}");
    let with_column = mapped("time=t:ms,duty=cmd:255,supply=battery:mV,speed=y");
    assert!((read_text(text.as_bytes(), &with_column).unwrap().voltage_v[0] - 1.6).abs() < 1e-12);
    let mut with_option = mapped("time=t:ms,duty=cmd:255,speed=y");
    let error = read_text(text.as_bytes(), &with_option).unwrap_err();
    assert_eq!(error.exit_code(), 2);
    assert!(error.to_string().contains("--supply-volts"));
    with_option.supply_volts = Some(10.0);
    let record = read_text(text.as_bytes(), &with_option).unwrap();
    assert!((record.voltage_v[0] - 2.0).abs() < 1e-12);
    assert_eq!(record.mean_supply_v(), Some(10.0));
}

#[test]
fn a_supply_that_is_stated_beside_volts_is_kept_and_one_that_was_logged_goes_before_it() {
    let body: String = (0..40).map(|i| format!("{},1.5,8000,1\n", i * 10)).collect();
    let text = format!("t,u,battery,y\n{body}");
    let stated = |map: &str| {
        let options = ReadOptions { supply_volts: Some(12.0), ..mapped(map) };
        read_text(text.as_bytes(), &options).unwrap().mean_supply_v()
    };
    assert_eq!(stated("time=t:ms,voltage=u:V,speed=y"), Some(12.0));
    assert_eq!(stated("time=t:ms,voltage=u:V,supply=battery:mV,speed=y"), Some(8.0));
    let unknown = mapped("time=t:ms,voltage=u:V,speed=y");
    assert_eq!(read_text(text.as_bytes(), &unknown).unwrap().mean_supply_v(), None);
}

#[test]
fn the_motor_file_wins_over_the_log_and_gives_counts_their_meaning() {
    let body: String = (0..40).map(|i| format!("{},1,{i}\n", i * 10)).collect();
    let text = format!("# counts_per_rev: 100\n# hold: first\nt,u,n\n{body}");
    let mut options = mapped("time=t:ms,voltage=u,angle=n:counts");
    let by_log = read_text(text.as_bytes(), &options).unwrap();
    assert!((by_log.angle_rad.unwrap()[25] - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
    assert_eq!(by_log.hold, Hold::First);
    options.motor.counts_per_rev = Some(200.0);
    options.hold = Some(Hold::Zero);
    let by_motor_file = read_text(text.as_bytes(), &options).unwrap();
    assert!((by_motor_file.angle_rad.unwrap()[25] - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
    assert_eq!(by_motor_file.hold, Hold::Zero);
}

#[test]
fn a_few_bad_rows_are_left_out_with_a_warning_that_names_them() {
    let text = canonical(200, |row| match row {
        30 => Some("d".into()),
        31 => Some("0.310,NaN,0.5978".into()),
        60 => Some("0.590,1,1".into()),
        _ => None,
    });
    let record = read_text(text.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(record.len(), 198);
    let all: Vec<String> = record.warnings.iter().map(|w| format!("{}: {}", w.place, w.what)).collect();
    assert_eq!(all.len(), 3, "{all:?}");
    assert!(all[0].contains("line 32, column time_s") && all[0].contains("\"d\""), "{all:?}");
    assert!(all[1].contains("line 62, column time_s") && all[1].contains("repeat"), "{all:?}");
    assert!(all[2].contains("column voltage_v") && all[2].contains("first in line 33"), "{all:?}");
}

#[test]
fn closing_words_of_a_logger_are_left_out_and_words_between_rows_are_one_row_that_is_told() {
    let words = "\n\nAcceleration: 5.9\n".to_owned() + &"Acceleration: 6.1\n".repeat(9);
    let footer = canonical(40, |_| None) + &words;
    let record = read_text(footer.as_bytes(), &ReadOptions::default()).unwrap();
    assert_eq!(record.len(), 40);
    assert_eq!(record.warnings.len(), 1);
    assert!(record.warnings[0].place.contains("line 44"), "{}", record.warnings[0].place);
    assert!(record.warnings[0].what.contains("10 lines at the end"));
    let between = footer + "0.500,1,1\n";
    let warnings = read_text(between.as_bytes(), &ReadOptions::default()).unwrap().warnings;
    assert!(warnings[0].place.contains("line 44, column time_s"), "{}", warnings[0].place);
    assert!(warnings[0].what.contains("nor is what stands below it up to line 53"), "{}", warnings[0].what);
    let mostly_words = canonical(30, |_| None) + &words.repeat(9);
    assert!(read_text(mostly_words.as_bytes(), &ReadOptions::default()).is_err());
}

#[test]
fn a_pause_in_the_log_is_a_warning_with_its_sample_and_time_and_cuts_the_record() {
    let text = canonical(100, |row| (row >= 50).then(|| format!("{},1,{row}", 1.0 + row as f64 * 0.01)));
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    std::fs::write(&path, text).unwrap();
    let records = read(&path, &ReadOptions::default()).unwrap();
    assert_eq!(records.iter().map(|record| record.len()).collect::<Vec<_>>(), [50, 50]);
    let warnings = &records[0].warnings;
    assert!(
        warnings.iter().any(|warning| warning.what.contains("before sample 51 (1.500 s)")),
        "{warnings:?}"
    );
}

#[test]
fn a_written_record_comes_back_unchanged() {
    let text = canonical(64, |_| None);
    let mut record = read_text(text.as_bytes(), &ReadOptions::default()).unwrap();
    record.speed_rad_s = Some(record.time_s.iter().map(|t| t / 3.0).collect());
    record.supply_v = Some(vec![0.1 + 0.2; 64]);
    record.meta.insert("gear_ratio", "104").unwrap();
    record.meta.insert("programme", "{\"steps\": [1, 2]}").unwrap();
    record.hold = Hold::First;
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("run.csv");
    write_canonical(&record, &path).unwrap();
    let mut back = read(&path, &ReadOptions::default()).unwrap().remove(0);
    assert_eq!(back.meta.hold(), Some(Hold::First));
    back.meta = record.meta.clone();
    back.path = record.path.clone();
    assert_eq!(back, record);
}

/// Every message is a triple: place, cause, remedy.
pub(super) fn assert_bad(error: &Error, place: &str, cause: &str, remedy: &str) {
    let text = error.to_string();
    assert_eq!(error.exit_code(), 3, "{text}");
    let (fault, action) = text.split_once("\n  do: ").expect("a remedy");
    assert!(fault.contains(place), "no {place} in {text}");
    assert!(fault.contains(cause), "no {cause} in {text}");
    assert!(action.contains(remedy), "no {remedy} in {text}");
}

#[test]
fn every_unreadable_file_is_refused_with_place_cause_and_remedy() {
    let word = canonical(40, |row| matches!(row, 15 | 25).then(|| "0.150,ERR,1".into()));
    let infinite = canonical(40, |row| matches!(row, 15 | 25).then(|| "0.150,inf,1".into()));
    let empty_field = canonical(40, |row| matches!(row, 15 | 25).then(|| ",1,1".into()));
    let backwards = canonical(40, |row| (row == 15).then(|| "0.020,1,1".into()));
    let frozen = canonical(40, |row| (row >= 15).then(|| "0.140,1,1".into()));
    let one_row = canonical(1, |_| None);
    let wide = canonical(40, |row| matches!(row, 3 | 9).then(|| "0,030,1,5,0,7".into()));
    let latin: Vec<u8> = [canonical(40, |_| None).as_bytes(), b"0.40,\xB5,1\n0.41,\xB5,1\n"].concat();
    let no_voltage = canonical(40, |_| None).replace("voltage_v", "command");
    let no_angle = canonical(40, |_| None).replace("angle_rad", "y");
    let double = canonical(40, |_| None).replace("voltage_v", "time_s");
    let many_columns = vec!["x"; 2000].join(",");
    let cases: [(&[u8], &str, &str, &str); 17] = [
        (b"", "run.csv", "the file is empty", "logger"),
        (b"time_s,voltage_v,angle_rad\n", "line 1", "no sample below", "record"),
        (b"# gear_ratio: 3\n", "line 1", "no header", "time_s"),
        (one_row.as_bytes(), "line 2", "1 samples are too few", "at least 20"),
        (word.as_bytes(), "line 17, column voltage_v", "\"ERR\" is not a number", "remove"),
        (infinite.as_bytes(), "line 17, column voltage_v", "\"inf\" is not a number a fit can use", "remove"),
        (empty_field.as_bytes(), "line 17, column time_s", "field is empty", "remove"),
        (backwards.as_bytes(), "line 17, column time_s", "backwards, from 0.14 s to 0.02 s", "sort"),
        (frozen.as_bytes(), "line 17, column time_s", "repeat the time", "more digits"),
        (wide.as_bytes(), "line 5", "6 fields under 3 headers", "repair"),
        (&latin, "line 42, column voltage_v", "\"µ\" is not a number", "remove"),
        (b"\x89HDF\r\n\x1A\n", "run.csv", "HDF5", "copy"),
        (b"time_s,voltage_v\n0,\0\x01\x02\0\x03,1\n", "line 2", "binary", "export"),
        (
            no_voltage.as_bytes(),
            "line 1, column voltage_v",
            "time_s, command, angle_rad",
            "--map time=time_s:s,duty=command:1,angle=angle_rad:rad --supply-volts 12",
        ),
        (no_angle.as_bytes(), "line 1, column angle_rad", "time_s, voltage_v, y", "--map"),
        (double.as_bytes(), "line 1, column time_s", "two columns", "rename"),
        (many_columns.as_bytes(), "line 1", "2000 columns", "one quantity per column"),
    ];
    for (content, place, cause, remedy) in cases {
        let error = read_text(content, &ReadOptions::default()).unwrap_err();
        assert_bad(&error, place, cause, remedy);
    }
}

#[test]
fn absent_files_directories_and_wrong_columns_are_refused_too() {
    let options = ReadOptions::default();
    assert_bad(
        &read(Path::new("no/such.csv"), &options).unwrap_err(),
        "no/such.csv",
        "no such file",
        "check",
    );
    let (directory, path) = file(canonical(30, |_| None).as_bytes());
    assert_bad(&read(directory.path(), &options).unwrap_err(), "", "directory", "*.csv");
    let error = read(&path, &mapped("voltage=u,angle=9")).unwrap_err();
    assert_bad(&error, "line 1, column u", "no column \"u\" for voltage", "voltage_v");
    let error = read(&path, &mapped("angle=9")).unwrap_err();
    assert_bad(&error, "line 1, column 9", "no column \"9\" for angle", "angle_rad");
    let error = read(&path, &mapped("angle=2:counts")).unwrap_err();
    assert_bad(&error, "column angle_rad", "counts", "rev/1400");
}
