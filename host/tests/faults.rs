//! Small logs with faults that people reported, each with its right answer. They are no part of this project:
//! `../shared/faults` beside the workspace is read in place, and where it is absent the test says so and ends.

use std::io::Write;
use std::path::{Path, PathBuf};

use motorlens::log::{Format, ReadOptions, Record, data_faults, read};

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
const TABLE: [(&str, bool, &str, &str); 17] = [
    ("02-changes-only-list/E_onlydyn.csv", true, "", "one_level"),
    ("03-wrapped-angle/A2_slowwrap.csv", false, "", "wrapped_angle"),
    ("03-wrapped-angle/R3_reset.csv", false, "", "jumps, which no motion explains"),
    ("03-wrapped-angle/SP_angle.csv", false, "", "garbled_readings"),
    ("03-wrapped-angle/A_unwrapped_a.csv", false, "", ""),
    ("04-sysid-sign-advice/E_neg.csv", true, "", "angle=position:rev*-1,speed=velocity:rev/s*-1"),
    ("06-one-level-only/E_onlydyn.csv", true, "", "one_level"),
    ("07-late-speed-beside-angle/AJ_both.csv", false, "", ""),
    ("10-duty-as-volts/S_duty.csv", false, "", "--map duty=voltage_v:1"),
    ("10-duty-as-volts/S_pct.csv", false, "", "--map duty=voltage_v:100"),
    ("11-gap-in-one-file/AI_state.csv", false, "", "read as 3 records"),
    ("12-spikes-in-speed/SP_spikes.csv", false, "", "garbled_readings: 3 readings"),
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
        if wanted.is_empty() && all.contains("lost_counts") || !all.contains(wanted) {
            wrong.push(format!("{file}: \"{wanted}\" in: {all}"));
        }
        if wanted.contains("rev*-1") && all.contains("without its sign") {
            wrong.push(format!("{file}: both signs are blamed: {all}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
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
