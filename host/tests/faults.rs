//! Small logs with faults that people reported, each with its right answer. They are no part of this project:
//! `../shared/faults` beside the workspace is read in place, and where it is absent the test says so and ends.

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

/// File, whether it is SysId's, mapping, and what must be said; nothing may be said where it is empty.
const TABLE: [(&str, bool, &str, &str); 22] = [
    ("02-changes-only-list/E_onlydyn.csv", true, "", "one_level"),
    ("03-wrapped-angle/A2_slowwrap.csv", false, "", "wrapped_angle"),
    ("03-wrapped-angle/R3_reset.csv", false, "", "jumps, which no motion explains"),
    ("03-wrapped-angle/SP_angle.csv", false, "", "garbled_readings"),
    ("03-wrapped-angle/A_unwrapped_a.csv", false, "", ""),
    ("04-sysid-sign-advice/E_neg.csv", true, "", "angle=position:rev*-1,speed=velocity:rev/s*-1"),
    ("06-one-level-only/E_onlydyn.csv", true, "", "one_level"),
    ("07-late-speed-beside-angle/AJ_both.csv", false, "", "late_speed: the speed is late by 80 ms"),
    ("07-late-speed-beside-angle/AJ3_ma100.csv", false, "", "late_speed: the speed is a mean over 100 ms"),
    ("08-hard-stop/H_wall.csv", false, "", "stands at 2.50 rad at up to 6.0 V"),
    ("08-hard-stop/H_wall.csv", false, "", "--skip H_wall:0.8"),
    ("09-stale-voltage/I2_ffill_sine.csv", false, "", "renewed only every 100 ms"),
    ("10-duty-as-volts/S_duty.csv", false, "", "--map duty=voltage_v:1"),
    ("10-duty-as-volts/S_pct.csv", false, "", "--map duty=voltage_v:100"),
    ("11-gap-in-one-file/AI_state.csv", false, "", "read as 3 records"),
    ("12-spikes-in-speed/SP_spikes.csv", false, "", "garbled_readings: 3 readings"),
    ("12-spikes-in-speed/SP_clean.csv", false, "", ""),
    ("14-duplicate-header/N_dup.csv", false, "time=0:s,voltage=1:V,angle=3:rad", ""),
    ("15-small-messages/AH_boot.csv", false, "", "lines of text before the header"),
    ("15-small-messages/L_ns.csv", false, "time=header.stamp:ns,voltage=u,angle=pos", ""),
    ("15-small-messages/Z_sep.csv", false, "time=0:s,voltage=1:V,angle=2:rad", ""),
    ("18-foreign-tables/preamble.csv", false, "", "lines of text before the header"),
];

fn logs(path: &Path, sysid: bool, map: &str) -> Vec<Record> {
    let format = if sysid { Format::WpilibSysid } else { Format::Csv };
    let map = (!map.is_empty()).then(|| map.parse().unwrap());
    read(path, &ReadOptions { format, map, ..ReadOptions::default() })
        .unwrap_or_else(|error| panic!("{error}"))
}

#[test]
fn each_reported_log_is_read_and_its_fault_said() {
    let Some(root) = faults() else { return };
    let mut wrong = Vec::new();
    for (file, sysid, map, wanted) in TABLE {
        let records = logs(&root.join(file), sysid, map);
        let said: Vec<String> =
            data_faults(&records).iter().map(|w| format!("{}. {}", w.what, w.fix)).collect();
        let all = said.join("\n");
        let blamed =
            ["lost_counts", "late_speed", "hard_stop", "stale", "blind", "garbled", "shifted", "still"];
        if wanted.is_empty() && blamed.iter().any(|name| all.contains(name)) || !all.contains(wanted) {
            wrong.push(format!("{file}: \"{wanted}\" in: {all}"));
        }
        if file.starts_with("07") && (all.contains("lost_counts") || all.contains("counter")) {
            wrong.push(format!("{file}: a counter is blamed: {all}"));
        }
        if wanted.contains("rev*-1") && all.contains("without its sign") {
            wrong.push(format!("{file}: both signs are blamed: {all}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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

/// The remedy is one complete `--map` that reads the file as pasted.
#[test]
fn a_foreign_table_is_answered_with_options_that_read_it() {
    let Some(root) = faults() else { return };
    for (file, options) in [
        (
            "15-small-messages/Z_paren.csv",
            "--map \"time=Time (s):s,voltage=Voltage (V):V,angle=Position (rad):rad\"",
        ),
        ("18-foreign-tables/arduino.csv", "--map time=t_ms:ms,duty=pwm:255,speed=rpm:rpm --supply-volts 12"),
        (
            "18-foreign-tables/quoted_units.csv",
            "--map \"time=Time [s]:s,voltage=Voltage [V]:V,speed=Speed [rad/s]:rad/s\"",
        ),
        (
            "17-step-from-first-row/f3_with_rest_row.csv",
            "--map time=time_ms:ms,duty=pwm:255,speed=rpm:rpm --supply-volts 12",
        ),
        (
            "15-small-messages/Z_sep.csv",
            "--map \"time=Zeit [s]:s,voltage=Spannung [V]:V,angle=Winkel [rad]:rad\"",
        ),
    ] {
        let path = root.join(file);
        let Err(Error::BadInput(fault)) = read(&path, &ReadOptions::default()) else {
            panic!("{file} is read")
        };
        let proposal = fault.proposal.clone().unwrap_or_else(|| panic!("{fault}"));
        assert_eq!(proposal.options(), options, "{fault}");
        assert_eq!(proposal.preview.len(), 3, "{fault}");
        let supply_volts = proposal.supply_volts.map(|volts| volts.parse().unwrap());
        let map = Some(proposal.map.parse().unwrap());
        let records = read(&path, &ReadOptions { map, supply_volts, ..ReadOptions::default() }).unwrap();
        assert!(records[0].len() > 20, "{file}");
    }
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

/// Rows as people's tools write them; those that are read today stay read.
#[test]
fn tables_as_peoples_tools_write_them_are_read() {
    let Some(root) = faults() else { return };
    for file in [
        "base.csv",
        "bom_crlf.csv",
        "epoch.csv",
        "nan.csv",
        "noise_lines.csv",
        "semicolon.csv",
        "semicolon_deccomma.csv",
        "tab.txt",
        "trunc.csv",
    ] {
        let records = logs(&root.join("18-foreign-tables").join(file), false, "");
        // One of them ends in the middle, in half a row.
        assert!(records.len() == 1 && records[0].len() > 95, "{file}: {}", records[0].len());
    }
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
