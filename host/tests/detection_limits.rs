//! Detection limits are kept: what is told that these records would have shown, they show.

mod program;

use std::path::Path;

use program::run;
use serde_json::Value;

/// Findings on the records of the small motor under a disturbance of 3 % of stall, with `effect` or without any.
fn findings(directory: &Path, effect: &str) -> Value {
    let option = if effect.is_empty() { String::new() } else { format!("--effect {effect}") };
    let plant = format!("simulate --motor small --rate 100 --disturbance 0.03 {option} --out s --quiet");
    // Logs are written over no others.
    drop(std::fs::remove_dir_all(directory.join("s")));
    run(directory, &plant).ends(0);
    let logs =
        ["triangle", "pulse-and-coast", "multisine", "prbs", "staircase"].map(|name| format!("s/{name}.csv"));
    run(directory, &format!("discover {} --motor s/motor.toml --out m.json --json", logs.join(" ")))
        .ends(0)
        .json()
}

fn names(findings: &Value) -> Vec<&str> {
    findings["effects"].as_array().expect("effects").iter().filter_map(Value::as_str).collect()
}

#[test]
fn an_effect_of_twice_its_detection_limit_is_found_and_one_of_half_of_it_is_not() {
    let directory = tempfile::tempdir().unwrap();
    let plain = findings(directory.path(), "");
    assert!(names(&plain).is_empty(), "{}", plain["effects"]);
    for effect in ["coulomb", "gravity", "voltage_drop"] {
        let told =
            plain["detection_limits"].as_array().expect("limits").iter().find(|l| l["effect"] == effect);
        let limit = told.and_then(|l| l["smallest"].as_f64()).expect("a size");
        let at = |factor: f64| findings(directory.path(), &format!("{effect}={}", factor * limit));
        assert_eq!(names(&at(2.0)), [effect], "of {} V", 2.0 * limit);
        let half = at(0.5);
        assert!(names(&half).is_empty(), "{} of {} V", half["effects"], 0.5 * limit);
    }
}
