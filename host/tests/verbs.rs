//! Every verb through the built program: exit status, the document, the files.

mod program;

use program::{command, files, logs, run};
use serde_json::Value;
use std::io::Read;
use std::path::Path;
use std::process::Stdio;

const MEASURES: [&str; 6] = ["rmse", "ae", "me", "iae", "nrmse_fit_percent", "samples"];

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is a number"))
}

fn assert_has(value: &Value, keys: &[&str]) {
    for key in keys {
        assert!(value.get(key).is_some(), "{key} in {value}");
    }
}

#[test]
fn fit_gives_the_published_document_and_a_model_that_compare_reads() {
    let directory = tempfile::tempdir().unwrap();
    let logs = logs(directory.path());
    let fit =
        run(directory.path(), &format!("fit {logs} --effects coulomb --out m.json --json")).ends(0).json();
    assert_has(
        &fit,
        &[
            "parameters",
            "combinations",
            "train",
            "validation",
            "objective_history",
            "seed",
            "evaluations",
            "seconds",
        ],
    );
    assert_has(&fit["train"], &MEASURES);
    assert_has(&fit["validation"], &MEASURES);
    let level = &fit["parameters"].as_array().unwrap()[4];
    assert_has(level, &["name", "value", "unit", "low", "high", "identifiable"]);
    assert_eq!(level["name"], "coulomb.level");
    assert!((number(&level["value"]) - 0.4).abs() < 0.02, "{level}");
    assert!(
        number(&level["low"]) < number(&level["value"]) && number(&level["value"]) < number(&level["high"])
    );
    assert_eq!(level["identifiable"], true);
    let open = &fit["identifiability"];
    assert_eq!((&open["determined"], &open["free"]), (&3.into(), &5.into()));
    for answer in open["eight_parameters"].as_array().unwrap() {
        assert!(number(&answer["difference"]) < 1e-9 && answer["parameters"].as_array().unwrap().len() == 8);
    }
    assert!(
        open["unlock"].as_array().unwrap().iter().any(|u| u["measure"].as_str().unwrap().contains("stall"))
    );
    for profile in fit["profiles"].as_array().unwrap() {
        assert_has(
            profile,
            &["name", "low", "high", "open_below", "open_above", "curvature", "curvature_misleads"],
        );
    }

    let compared =
        run(directory.path(), &format!("compare m.json {logs} --trace t.csv --json")).ends(0).json();
    assert_has(&compared["pooled"], &MEASURES);
    assert_eq!(compared["records"].as_array().unwrap().len(), 4);
    // A record that is cut begins in motion, here where the triangle turns the shaft fastest.
    let cut = run(directory.path(), "compare m.json s/triangle.csv -m s/motor.toml --skip 0..5 --json");
    let speed = cut.ends(0).json()["records"][0]["first_speed_rad_s"].as_f64().unwrap();
    assert!((speed - 0.87).abs() < 0.1, "{speed} rad/s");
    let by: Vec<&str> =
        compared["failures"].as_array().unwrap().iter().map(|s| s["by"].as_str().unwrap()).collect();
    for wanted in ["speed", "since_reversal", "standstill", "voltage", "time"] {
        assert!(by.contains(&wanted), "{by:?}");
    }
    let trace = std::fs::read_to_string(directory.path().join("t.csv")).unwrap();
    let mut lines = trace.lines();
    assert_eq!(lines.next(), Some("record,time_s,measured,simulated"));
    assert_eq!(lines.count() as u64, compared["pooled"]["samples"].as_u64().unwrap());
}

#[test]
fn the_same_seed_gives_the_same_genetic_fit_and_the_history_never_rises() {
    let directory = tempfile::tempdir().unwrap();
    let logs = logs(directory.path());
    let words =
        format!("fit {logs} --method ga --effects coulomb --population 24 --generations 30 --seed 7 --json");
    let (one, two) =
        (run(directory.path(), &words).ends(0).json(), run(directory.path(), &words).ends(0).json());
    assert_eq!(one["parameters"], two["parameters"]);
    let history: Vec<f64> = one["objective_history"].as_array().unwrap().iter().map(number).collect();
    assert_eq!(history.len(), 30);
    assert!(history.is_sorted_by(|a, b| a >= b));
    assert_eq!(one["seed"], 7);
    assert_eq!(one["evaluations"], 24 + 29 * 23);
}

#[test]
fn all_methods_agree_on_a_motor_without_effects() {
    let directory = tempfile::tempdir().unwrap();
    run(directory.path(), "simulate --motor paper --rate 100 --out s --quiet").ends(0);
    let gain = |method: &str| {
        let words =
            format!("fit s/multisine.csv s/staircase.csv --motor s/motor.toml --method {method} --json");
        let fit = run(directory.path(), &words).ends(0).json();
        assert_eq!(fit["parameters"][0]["name"], "gain");
        number(&fit["parameters"][0]["value"])
    };
    let fast = gain("fast");
    for method in ["ga", "conventional", "paper"] {
        let other = gain(method);
        assert!((other / fast - 1.0).abs() < 0.02, "{method}: {other} {fast}");
    }
    let usual = gain("feedforward");
    assert!((usual / fast - 1.0).abs() < 0.05, "kS-kV-kA: {usual} {fast}");
    let refused = "fit s/prbs.csv --method paper --effects coulomb";
    assert!(run(directory.path(), refused).ends(2).err.contains("linear"));
}

#[test]
fn discover_finds_what_simulate_put_in_and_diagnose_and_add_agree() {
    let directory = tempfile::tempdir().unwrap();
    let logs = logs(directory.path());
    let found = run(directory.path(), &format!("discover {logs} --out d.json --json")).ends(0).json();
    assert_has(
        &found,
        &[
            "schema",
            "effects",
            "verdict",
            "noise_floor_rad",
            "ladder",
            "candidates",
            "rivals",
            "next_experiment",
            "data_faults",
            "parameters",
            "combinations",
            "seconds",
            "simulations",
        ],
    );
    assert_eq!(found["effects"][0], "coulomb");
    let ladder = found["ladder"].as_array().unwrap();
    assert_eq!(ladder[0]["effects"], Value::Array(vec![]));
    let unseen = |rung: &Value| number(&rung["validation"]["rmse"]);
    assert!(unseen(&ladder[ladder.len() - 1]) < 0.1 * unseen(&ladder[0]));

    run(directory.path(), &format!("fit {logs} --out base.json")).ends(0);
    let diagnosed = run(directory.path(), &format!("diagnose base.json {logs} --json")).ends(0).json();
    assert_eq!(diagnosed["candidates"][0]["effect"], "coulomb");
    let added =
        run(directory.path(), &format!("add base.json coulomb {logs} --out c.json --json")).ends(0).json();
    assert_eq!(added["worth_adding"], true);
    assert!(number(&added["after"]["train"]["rmse"]) < 0.1 * number(&added["before"]["train"]["rmse"]));
    let idle = run(directory.path(), &format!("add c.json eccentricity {logs} --json")).ends(0).json();
    assert_eq!(idle["worth_adding"], false);
    assert_eq!(run(directory.path(), &format!("add c.json coulomb {logs}")).status, 2);
}

#[test]
fn fit_and_add_tell_what_the_size_of_an_effect_rests_on() {
    let directory = tempfile::tempdir().unwrap();
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let row = |k: u32| {
        let t = 0.01 * f64::from(k);
        let u = 6.0 * (1.3 * t).sin() + 2.0 * (7.0 * t).sin();
        let row = format!("{t:.2},{u:.4},{:.2}\n", angle.to_degrees());
        speed += 0.01 * (0.9 * u - 0.5 * angle.sin() - speed) / 0.06;
        angle += 0.01 * speed;
        row
    };
    let rows: String = (0..800).map(row).collect();
    std::fs::write(directory.path().join("log.csv"), format!("t,u,position\n{rows}")).unwrap();
    let done = |verb: &str| {
        let how = "log.csv --map time=t:s,voltage=u:V,angle=position:deg --json";
        run(directory.path(), &format!("{verb} {how}")).ends(0).json()
    };
    let said = "gravity supposes that \"position\" is in degrees";
    let fitted = done("fit --effects gravity");
    for place in ["headline", "supposes"] {
        assert!(fitted[place].as_str().unwrap().contains(said), "{fitted}");
    }
    assert_eq!(done("fit --out base.json")["supposes"], Value::Null);
    let added = done("add base.json gravity");
    assert!(added["supposes"].as_str().unwrap().contains(said), "{added}");
}

/// The first seconds are cut off, so that the shaft turns when the record begins.
fn begun_in_motion(folder: &Path, from: &str, to: &str) {
    let text = std::fs::read_to_string(folder.join(from)).unwrap();
    let (head, rows): (Vec<&str>, Vec<&str>) =
        text.lines().partition(|l| !l.starts_with(|c: char| c.is_ascii_digit()));
    let kept = head.into_iter().chain(rows.into_iter().skip(137));
    std::fs::write(folder.join(to), kept.collect::<Vec<_>>().join("\n")).unwrap();
}

#[test]
fn discover_diagnose_and_compare_say_one_thing_of_one_model_and_its_records() {
    let directory = tempfile::tempdir().unwrap();
    run(directory.path(), "simulate --effect coulomb=0.4 --rate 100 --out s --quiet").ends(0);
    begun_in_motion(directory.path(), "s/multisine.csv", "s/moving.csv");
    let logs = "s/moving.csv s/staircase.csv --motor s/motor.toml";
    let found = run(directory.path(), &format!("discover {logs} --out d.json --json")).ends(0).json();
    let compared = run(directory.path(), &format!("compare d.json {logs} --json")).ends(0).json();
    let last = found["ladder"].as_array().unwrap().last().unwrap();
    let [by_discover, by_compare] = [&last["train"], &compared["pooled"]].map(|m| number(&m["rmse"]));
    assert!((by_discover / by_compare - 1.0).abs() < 1e-9, "{by_discover} {by_compare}");
    let again = run(directory.path(), &format!("diagnose d.json {logs} --json")).ends(0).json();
    assert_eq!(again["effects"], Value::Array(vec![]), "nothing further");
    assert_eq!((&again["verdict"], &again["headline"]), (&found["verdict"], &found["headline"]));
    let fit = run(directory.path(), &format!("fit {logs} --out base.json --json")).ends(0).json();
    let compared = run(directory.path(), &format!("compare base.json {logs} --json")).ends(0).json();
    let [by_fit, by_compare] = [&fit["train"], &compared["pooled"]].map(|m| number(&m["rmse"]));
    assert!((by_fit / by_compare - 1.0).abs() < 1e-9, "{by_fit} {by_compare}");
    let first = run(directory.path(), &format!("diagnose base.json {logs} --json")).ends(0).json();
    assert_eq!((&first["effects"][0], &first["verdict"]), (&"coulomb".into(), &"unexplained".into()));
    assert_eq!(first["next_step"]["action"], "add");
}

#[test]
fn plan_and_discover_propose_one_experiment_for_weak_records() {
    let directory = tempfile::tempdir().unwrap();
    // Smooth sines leave dry friction and its rival open; slow triangles do not heat the winding.
    run(directory.path(), "simulate --excitation paper --effect coulomb=0.4 --out paper --quiet").ends(0);
    run(directory.path(), "simulate --rate 100 --out s --quiet").ends(0);
    let paper = std::fs::read_dir(directory.path().join("paper")).unwrap();
    let paper = paper.map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let mut paper: Vec<String> =
        paper.filter(|name| name.ends_with(".csv")).map(|name| format!("paper/{name}")).collect();
    paper.sort();
    for logs in [paper.join(" "), "s/triangle.csv".to_owned()] {
        let json = |verb: &str| run(directory.path(), &format!("{verb} {logs} --json")).ends(0).json();
        let (found, planned) = (json("discover"), json("plan"));
        assert!(found["next_experiment"].is_object(), "{logs}: {}", found["verdict"]);
        for key in ["next_experiment", "no_experiment", "rivals"] {
            assert_eq!(found[key], planned[key], "{logs}: {key}");
        }
        // Whoever allows less gets no longer one and no more volts.
        let small = json("plan --seconds 5 --volts 4");
        let segments =
            small["next_experiment"]["programme"]["segments"].as_array().cloned().unwrap_or_default();
        let seconds: f64 = segments.iter().map(|segment| number(&segment["seconds"])).sum();
        assert!(seconds < 5.01, "{logs}: {seconds} s");
    }
}

#[test]
fn effects_lists_the_registry_and_explains_one() {
    let directory = tempfile::tempdir().unwrap();
    let all = run(directory.path(), "effects --json").ends(0).json();
    assert_eq!(all["effects"].as_array().unwrap().len(), motorlens_shared::effects::Kind::ALL.len());
    let one = run(directory.path(), "effects backlash").ends(0);
    assert!(one.out.contains("width") || one.out.contains("gap"), "{}", one.out);
    let slip = run(directory.path(), "effects backlsh").ends(2);
    assert!(slip.err.contains("did you mean backlash?"), "{}", slip.err);
}

#[test]
fn simulate_hides_and_reveal_tells() {
    let directory = tempfile::tempdir().unwrap();
    let made = run(directory.path(), "simulate --hidden 5 --rate 100 --seconds 2 --json").ends(0).json();
    assert!(made.get("effects").is_none());
    assert_has(&run(directory.path(), "reveal --json").ends(0).json(), &["effects", "sizes"]);
    assert_eq!(run(directory.path(), "reveal nowhere").status, 3);
}

#[test]
fn quiet_says_nothing_and_prose_never_goes_to_standard_output() {
    let directory = tempfile::tempdir().unwrap();
    let logs = logs(directory.path());
    let quiet = run(directory.path(), &format!("fit {logs} --quiet")).ends(0);
    assert_eq!((quiet.out.as_str(), quiet.err.as_str()), ("", ""));
    let loud = run(directory.path(), &format!("fit {logs}")).ends(0);
    assert!(loud.out.is_empty() && loud.err.contains("gain"), "{}", loud.out);
}

#[test]
fn wrong_usage_ends_with_2_and_a_document_for_programs() {
    let directory = tempfile::tempdir().unwrap();
    for words in
        ["fit", "fit --generations 0 a.csv", "levitate", "fit a.csv --method magic", "add m.json coulomb"]
    {
        assert!(!run(directory.path(), words).ends(2).err.is_empty(), "{words}");
        let document = run(directory.path(), &format!("{words} --json")).ends(2).json();
        assert_eq!(document["error"]["kind"], "usage", "{words}");
    }
    assert!(files(directory.path()).is_empty());
}

#[test]
fn a_reader_that_goes_away_is_no_failure() {
    let directory = tempfile::tempdir().unwrap();
    let mut child = command(directory.path(), "effects --json")
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    assert_eq!((child.wait().unwrap().code(), err.as_str()), (Some(0), ""));
}
