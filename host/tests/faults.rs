//! Small logs with faults that people reported, each with its right answer. They are no part of this project:
//! `../shared/faults` beside the workspace is read in place, and where it is absent the test says so and ends.

mod program;

use std::io::Write;
use std::path::{Path, PathBuf};

use motorlens::error::Error;
use motorlens::estimate::{Method, Options, fit};
use motorlens::log::{Format, ReadArgs, ReadOptions, Record, check_usable, data_faults, load, read};
use motorlens::motor_file::MotorFile;

fn faults() -> Option<PathBuf> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared/faults");
    if root.is_dir() {
        return Some(root);
    }
    // Written past the test harness, which would swallow it.
    let _ = std::io::stderr().write_all(b"SKIPPED: no faulty logs at ../shared/faults\n");
    None
}

/// What is right for a file.
enum Right {
    /// It is read as it stands, into so many records, and these words are said of it.
    Read(usize, &'static [&'static str]),
    /// It is read so, and nothing in it is blamed.
    Clean(usize),
    /// It is answered with options that read it.
    Proposed(&'static str),
    /// It is read by itself; alone it tells nothing of the motor, and these words say so.
    Refused(&'static str),
}
use Right::{Clean, Proposed, Read, Refused};

/// A file, how it is read (empty: as it stands), and what is right.
type Row = (&'static str, &'static str, Right);

const SYSID: &str = "sysid";

/// Every file there is, at least once.
const TABLE: [Row; 62] = [
    ("01-speed-decimals/D3_2dec_5_a.csv", "", Clean(1)),
    ("01-speed-decimals/Q_noise_g12.csv", "", Clean(1)),
    ("01-speed-decimals/T_raw.csv", "", Clean(1)),
    ("02-changes-only-list/E_dynchg.csv", SYSID, Read(1, &["one_level"])),
    ("02-changes-only-list/E_onlydyn.csv", SYSID, Read(1, &["one_level"])),
    ("03-wrapped-angle/A2_slowwrap.csv", "", Read(1, &["wrapped_angle"])),
    ("03-wrapped-angle/R3_reset.csv", "", Read(4, &["jumps, which no motion explains"])),
    ("03-wrapped-angle/SP_angle.csv", "", Read(1, &["garbled_readings"])),
    ("03-wrapped-angle/A_unwrapped_a.csv", "", Clean(1)),
    ("04-sysid-sign-advice/E_neg.csv", SYSID, Read(4, &["angle=position:rev*-1,speed=velocity:rev/s*-1"])),
    ("05-feedforward-drops-short-tests/E_all.csv", SYSID, Clean(4)),
    ("05-feedforward-drops-short-tests/E_onlydyn.csv", SYSID, Read(1, &["one_level"])),
    ("06-one-level-only/E_onlydyn.csv", SYSID, Read(1, &["one_level"])),
    ("07-late-speed-beside-angle/AJ_both.csv", "", Read(1, &["late_speed: the speed is late by 80 ms"])),
    (
        "07-late-speed-beside-angle/AJ3_ma100.csv",
        "",
        Read(1, &["late_speed: the speed is a mean over 100 ms"]),
    ),
    ("08-hard-stop/H_wall.csv", "", Read(1, &["stands at 2.50 rad at up to 6.0 V", "--skip H_wall:0.8"])),
    ("09-stale-voltage/I2_ffill_sine.csv", "", Read(1, &["a new voltage comes only every 100 ms"])),
    ("09-stale-voltage/I_blank.csv", "", Read(1, &["blank fields hold the value before them"])),
    (
        "09-stale-voltage/I_merged.csv",
        "",
        Read(1, &["blank fields hold the value before them", "rows with a blank here were left out"]),
    ),
    ("10-duty-as-volts/S_duty.csv", "", Read(1, &["--map duty=voltage_v:1"])),
    ("10-duty-as-volts/S_pct.csv", "", Read(1, &["--map duty=voltage_v:100"])),
    ("11-gap-in-one-file/AI_state.csv", "", Read(3, &["read as 3 records"])),
    ("12-spikes-in-speed/SP_spikes.csv", "", Read(1, &["garbled_readings: 3 readings"])),
    ("12-spikes-in-speed/SP_clean.csv", "", Clean(1)),
    ("13-sysid-state-names/F_akit.csv", SYSID, Clean(1)),
    ("13-sysid-state-names/F_caps.csv", SYSID, Clean(1)),
    ("14-duplicate-header/N_dup.csv", "time=0:s,voltage=1:V,angle=3:rad", Clean(1)),
    ("15-small-messages/AH_boot.csv", "", Read(1, &["4 lines of text before the header"])),
    ("15-small-messages/L_ns.csv", "", Proposed("--map time=header.stamp:ns,voltage=u:V,angle=pos:rad")),
    ("15-small-messages/L_ns.csv", "time=header.stamp:ns,voltage=u,angle=pos", Clean(1)),
    ("15-small-messages/P_datetime.csv", "", Clean(1)),
    ("15-small-messages/W_comma.csv", "", Clean(1)),
    (
        "15-small-messages/Z_paren.csv",
        "",
        Proposed("--map \"time=Time (s):s,voltage=Voltage (V):V,angle=Position (rad):rad\""),
    ),
    (
        "15-small-messages/Z_sep.csv",
        "",
        Proposed("--map \"time=Zeit [s]:s,voltage=Spannung [V]:V,angle=Winkel [rad]:rad\""),
    ),
    ("15-small-messages/Z_sep.csv", "time=0:s,voltage=1:V,angle=2:rad", Clean(1)),
    ("16-still-records/f1_step_+3001.csv", "", Read(1, &["one_level"])),
    ("16-still-records/f1_step_+901.csv", "", Refused("breakaway")),
    ("16-still-records/f1_step_-899.csv", "", Refused("breakaway")),
    ("16-still-records/f1_zero.csv", "", Refused("never moves")),
    ("16-still-records/f2_move_angle.csv", "", Read(1, &[])),
    ("16-still-records/f2_still_angle.csv", "", Refused("breakaway")),
    ("17-step-from-first-row/f3_step_constant_pwm.csv", "", Proposed(PWM)),
    (
        "17-step-from-first-row/f3_step_constant_pwm.csv",
        "time=0:ms,duty=1:255,speed=2:rpm",
        Read(1, &["one_level"]),
    ),
    ("17-step-from-first-row/f3_with_rest_row.csv", "", Proposed(PWM)),
    ("18-foreign-tables/aligned.txt", "", Clean(1)),
    (
        "18-foreign-tables/arduino.csv",
        "",
        Proposed("--map time=t_ms:ms,duty=pwm:255,speed=rpm:rpm --supply-volts 12"),
    ),
    ("18-foreign-tables/base.csv", "", Clean(1)),
    ("18-foreign-tables/bom_crlf.csv", "", Clean(1)),
    ("18-foreign-tables/datetime.csv", "", Clean(1)),
    ("18-foreign-tables/epoch.csv", "", Clean(1)),
    ("18-foreign-tables/nan.csv", "", Read(1, &["line 80"])),
    ("18-foreign-tables/noise_lines.csv", "", Read(1, &["line 61"])),
    (
        "18-foreign-tables/notime.csv",
        "",
        Proposed("--map voltage=voltage_v:V,speed=speed_rad_s:rad/s --rate 100"),
    ),
    ("18-foreign-tables/preamble.csv", "", Read(1, &["2 lines of text before the header"])),
    (
        "18-foreign-tables/quoted_units.csv",
        "",
        Proposed("--map \"time=Time [s]:s,voltage=Voltage [V]:V,speed=Speed [rad/s]:rad/s\""),
    ),
    ("18-foreign-tables/semicolon.csv", "", Clean(1)),
    ("18-foreign-tables/semicolon_deccomma.csv", "", Clean(1)),
    ("18-foreign-tables/space.txt", "", Clean(1)),
    ("18-foreign-tables/tab.txt", "", Clean(1)),
    ("18-foreign-tables/timeofday.csv", "", Clean(1)),
    ("18-foreign-tables/trunc.csv", "", Clean(1)),
    ("18-foreign-tables/unitrow.csv", "", Clean(1)),
];

const PWM: &str = "--map time=time_ms:ms,duty=pwm:255,speed=rpm:rpm --supply-volts 12";

fn options(how: &str) -> ReadOptions {
    let format = if how == SYSID { Format::WpilibSysid } else { Format::Csv };
    let map = (!how.is_empty() && how != SYSID).then(|| how.parse().unwrap());
    ReadOptions { format, map, supply_volts: Some(12.0), ..ReadOptions::default() }
}

fn logs(path: &Path, sysid: bool, map: &str) -> Vec<Record> {
    read(path, &options(if sysid { SYSID } else { map })).unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn every_reported_log_is_answered_rightly() {
    let Some(root) = faults() else { return };
    let mut wrong = Vec::new();
    for (file, how, right) in TABLE {
        if let Err(why) = answered(&root.join(file), how, &right) {
            wrong.push(format!("{file}: {why}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

fn answered(path: &Path, how: &str, right: &Right) -> Result<(), String> {
    if let Proposed(options) = right {
        return proposed(path, options);
    }
    let records = read(path, &options(how)).map_err(|error| error.to_string())?;
    let wanted = if let Read(count, _) | Clean(count) = right { *count } else { 1 };
    if records.len() != wanted || records.iter().any(|record| record.len() < 40) {
        return Err(format!(
            "{:?} samples in {} records",
            records.iter().map(Record::len).collect::<Vec<_>>(),
            records.len()
        ));
    }
    let said: Vec<String> =
        data_faults(&records).iter().map(|w| format!("{}: {}. {}", w.place, w.what, w.fix)).collect();
    let all = said.join("\n");
    let lacks = |word: &&&str| !all.contains(**word);
    match right {
        Read(_, words) => {
            if let Some(word) = words.iter().find(lacks) {
                return Err(format!("\"{word}\" is not in: {all}"));
            }
        }
        Clean(_) => {
            let names = [
                "lost_counts",
                "late_speed",
                "hard_stop",
                "stale",
                "blind",
                "garbled",
                "shifted",
                "still",
                "perhaps",
            ];
            if let Some(name) = names.iter().find(|name| all.contains(**name)) {
                return Err(format!("{name} is said: {all}"));
            }
        }
        Refused(word) => {
            let refused = check_usable(&records[0]).err().map(|error| error.to_string()).unwrap_or_default();
            if !refused.contains(word) || !refused.contains("  do: ") {
                return Err(format!("\"{word}\" is not in: {refused}"));
            }
        }
        Proposed(_) => {}
    }
    Ok(())
}

/// The refusal proposes exactly `options`, and they read the file.
fn proposed(path: &Path, options: &str) -> Result<(), String> {
    let Err(Error::BadInput(fault)) = read(path, &ReadOptions::default()) else {
        return Err("it is read".into());
    };
    let proposal = fault.proposal.clone().ok_or_else(|| fault.to_string())?;
    if proposal.options() != options {
        return Err(proposal.options());
    }
    let number = |text: &Option<String>| text.as_ref().map(|text| text.parse().unwrap());
    let asked = ReadOptions {
        map: Some(proposal.map.parse().unwrap()),
        supply_volts: number(&proposal.supply_volts),
        rate_hz: number(&proposal.rate),
        ..ReadOptions::default()
    };
    let records = read(path, &asked).map_err(|error| error.to_string())?;
    check_usable(&records[0]).map_err(|error| error.to_string())
}

/// A file that somebody reports and nobody answers is no part of the table.
#[test]
fn every_file_has_a_row() {
    let Some(root) = faults() else { return };
    let mut files = Vec::new();
    for folder in
        std::fs::read_dir(&root).unwrap().map(|entry| entry.unwrap().path()).filter(|path| path.is_dir())
    {
        files.extend(std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()));
    }
    let without: Vec<String> = files
        .iter()
        .filter(|path| path.file_name().is_some_and(|name| name != "README.md"))
        .map(|path| path.strip_prefix(&root).unwrap().to_string_lossy().replace('\\', "/"))
        .filter(|file| !TABLE.iter().any(|(known, ..)| known == file))
        .collect();
    assert!(!files.is_empty() && without.is_empty(), "no right answer is known of {without:?}");
}

/// A right angle beside a late speed blames no counter; both signs turned are told as one.
#[test]
fn advice_names_what_is_wrong_and_nothing_else() {
    let Some(root) = faults() else { return };
    let said = |file: &str, sysid: bool| -> String {
        data_faults(&logs(&root.join(file), sysid, ""))
            .iter()
            .map(|w| format!("{}. {}", w.what, w.fix))
            .collect()
    };
    for file in ["AJ_both.csv", "AJ3_ma100.csv"] {
        let all = said(&format!("07-late-speed-beside-angle/{file}"), false);
        assert!(!all.contains("lost_counts") && !all.contains("counter"), "{all}");
    }
    assert!(!said("04-sysid-sign-advice/E_neg.csv", true).contains("without its sign"));
}

/// Friction is found whatever the decimals of the speed, and nothing else.
#[test]
fn decimals_of_a_speed_are_no_effect() {
    let Some(root) = faults() else { return };
    for (file, gain) in
        [("D3_2dec_5_a.csv", 1.0 / 0.15), ("T_raw.csv", 1.0 / 0.9), ("Q_noise_g12.csv", 1.0 / 0.9)]
    {
        let path = root.join("01-speed-decimals").join(file);
        let found = program::run(&root, &format!("discover {} --json", path.display())).ends(0).json();
        // Of a motor that turns one way only (T_raw) a load that never changes is no other thing than friction, and both are named.
        let rivals = found["rivals"].to_string();
        let coulomb = found["effects"] == serde_json::json!(["coulomb"]);
        let either =
            found["effects"] == serde_json::json!(["constant_load"]) && rivals.contains("\"coulomb\"");
        assert!(coulomb || file == "T_raw.csv" && either, "{file}: {found}");
        let found = value(&found, "gain");
        assert!((found / gain - 1.0).abs() < 0.03, "{file}: {found}");
    }
}

/// SysId's own regression takes tests of 2 s at 20 ms.
#[test]
fn short_tests_at_slow_sampling_take_part_in_the_feedforward_fit() {
    let Some(root) = faults() else { return };
    let path = root.join("05-feedforward-drops-short-tests/E_all.csv");
    let words = format!("fit {} --format wpilib-sysid --method feedforward --json", path.display());
    let fitted = program::run(&root, &words).ends(0).json();
    let gain = value(&fitted, "gain");
    assert!((gain * 0.9 - 1.0).abs() < 0.03, "{fitted}");
}

fn value(document: &serde_json::Value, name: &str) -> f64 {
    let all = document["parameters"].as_array().unwrap();
    all.iter().find(|p| p["name"] == name).and_then(|p| p["value"].as_f64()).unwrap()
}

/// Two still records beside one that moves: they tell where friction holds, and the fit is that of the moving one.
#[test]
fn a_still_record_tells_its_breakaway_voltage_and_never_outweighs_the_set() {
    let Some(root) = faults() else { return };
    let file = |name: &str| root.join("16-still-records").join(name);
    let gain = |files: &[&str]| -> (f64, String) {
        let args = ReadArgs::default();
        let paths: Vec<PathBuf> = files.iter().map(|name| file(name)).collect();
        let loaded = load(&paths, &args).unwrap();
        assert_eq!(loaded.records.len(), 1, "{files:?}");
        let options =
            Options { method: Method::Fast, effects: vec![], population: 80, generations: 1, seed: 1 };
        let fitted = fit(&loaded.records, &[], &MotorFile::default(), &options, &mut |_, _| ()).unwrap();
        let gain = fitted.parameters.iter().find(|p| p.name == "gain").unwrap().value;
        (gain, loaded.warnings.iter().map(|w| w.what.clone()).collect())
    };
    let (alone, said) = gain(&["f1_step_+3001.csv"]);
    assert!((alone - 11.2).abs() < 0.3 && said.is_empty(), "{alone} {said}");
    for (still, volts) in [
        ("f1_step_+901.csv", "up to 2.163 V"),
        ("f1_step_-899.csv", "down to -2.158 V"),
        ("f1_zero.csv", "up to 2.163 V"),
    ] {
        let (with, said) = gain(&["f1_step_+3001.csv", still]);
        assert_eq!(with, alone, "{still}");
        assert!(said.contains("still_record") && said.contains(volts), "{said}");
    }
    let (_, said) = gain(&["f2_move_angle.csv", "f2_still_angle.csv"]);
    assert!(said.contains("up to 2.163 V"), "{said}");
    let refused = check_usable(&logs(&file("f1_step_-899.csv"), false, "")[0]).unwrap_err().to_string();
    assert!(refused.contains("never moves") && refused.contains("breakaway"), "{refused}");
}

/// A step from the first row on is a step.
#[test]
fn a_step_that_begins_with_the_log_is_fitted_and_said_to_be_one_level() {
    let Some(root) = faults() else { return };
    let map = Some("time=0:ms,duty=1:255,speed=2:rpm".parse().unwrap());
    let options = ReadOptions { map, supply_volts: Some(12.0), ..ReadOptions::default() };
    let records = read(&root.join("17-step-from-first-row/f3_step_constant_pwm.csv"), &options).unwrap();
    check_usable(&records[0]).unwrap();
    assert!(data_faults(&records).iter().any(|w| w.what.starts_with("one_level")));
}

#[test]
fn a_voltage_logged_when_it_changes_holds_until_it_does() {
    let Some(root) = faults() else { return };
    let thin = logs(&root.join("02-changes-only-list/E_dynchg.csv"), true, "");
    let full = logs(&root.join("02-changes-only-list/E_onlydyn.csv"), true, "");
    assert_eq!((thin.len(), full.len()), (1, 1));
    let half = thin[0].len() - 2;
    assert!(thin[0].voltage_v[..half].iter().all(|v| *v == 7.0), "{:?}", thin[0].voltage_v);
}

#[test]
fn states_in_any_case_and_entries_of_advantagekit_are_the_same_tests() {
    let Some(root) = faults() else { return };
    let kit = logs(&root.join("13-sysid-state-names/F_akit.csv"), true, "");
    let caps = logs(&root.join("13-sysid-state-names/F_caps.csv"), true, "");
    assert!(!kit.is_empty() && kit.len() == caps.len());
    for (a, b) in kit.iter().zip(&caps) {
        assert_eq!(a.len(), b.len());
        assert_eq!(a.meta.programme(), b.meta.programme());
    }
}
