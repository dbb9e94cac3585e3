//! `tune` through the built program: gains, what the effects cost under them, and where the position does not come to rest.

mod program;

use std::path::Path;

use program::{DEAD, DRY, model, run};
use serde_json::{Value, json};

/// An effect as a model file has it.
fn effect(name: &str, parameters: &[(&str, f64, &str)]) -> String {
    let parameters: Vec<Value> = parameters
        .iter()
        .map(|(name, value, unit)| json!({"name": name, "value": value, "unit": unit}))
        .collect();
    json!({"effect": name, "parameters": parameters}).to_string()
}

#[test]
fn tune_says_what_the_effects_cost_and_that_their_compensation_pays() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    model(here, "m.json", 0.9, &format!("{DRY},{DEAD}"));
    let tuned = run(here, "tune m.json --plot t.svg --json").ends(0).json();
    let trials = tuned["trials"].as_array().unwrap();
    assert_eq!(trials.len(), 5);
    let rms: Vec<f64> = trials.iter().map(|t| t["position"]["rms"].as_f64().unwrap()).collect();
    // Friction and dead zone cost; kS and the inverse win most of it back.
    assert!(rms[1] > rms[0], "{rms:?}");
    assert!(rms[2] < rms[1] && rms[3] < 0.7 * rms[2], "{rms:?}");
    for name in ["velocity", "position"] {
        let margins = &tuned[name]["margins"];
        assert!(
            margins["phase_deg"].as_f64().unwrap() > 59.0 && margins["gain"].as_f64().unwrap() > 1.5,
            "{margins}"
        );
    }
    // The velocity's PI cancels the pole: the base model settles on the step, and dry friction is what its integral has to find.
    let steps = tuned["steps"].as_array().unwrap();
    let of = |of: &str, place: usize| steps.iter().filter(|step| step["of"] == of).nth(place).unwrap();
    let number = |step: &serde_json::Value, name: &str| step[name].as_f64().unwrap();
    for name in ["velocity", "position"] {
        let ideal = of(name, 0);
        assert!(number(ideal, "left").abs() < 0.02 * number(ideal, "height"), "{ideal}");
        assert!(number(ideal, "rise_s") > 0.0 && number(ideal, "overshoot") < 0.3, "{ideal}");
        assert!(number(ideal, "settling_s") >= number(ideal, "rise_s"), "{ideal}");
    }
    // PD feedback alone stops where friction and dead zone hold it.
    let [ideal, real, helped] = [0, 1, 2].map(|place| number(of("position", place), "left").abs());
    assert!(real > 5.0 * ideal && helped < 0.7 * real, "{ideal} {real} {helped}");
    let drawn = std::fs::read_to_string(here.join("t.svg")).unwrap();
    assert!(drawn.contains("<svg") && drawn.contains("step of the velocity"));
    let said = run(here, "tune m.json").ends(0).err;
    assert!(said.contains("a step of the position by") && said.contains("rise / s"), "{said}");
    assert!(
        said.contains("phase margin 60") && said.contains("kS: ") && said.contains("which pays"),
        "{said}"
    );
    run(here, "tune m.json --period 2").ends(2);
}

/// A weight, a spring and cogging torque: the table has the torque looked up at both angles, and says that it pays.
#[test]
fn tune_compensates_torques_that_depend_on_the_angle_by_the_effects_own_law() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let loads = [
        ("gravity", effect("gravity", &[("sine", 1.5, "V"), ("cosine", -0.5, "V")])),
        ("spring", effect("spring", &[("stiffness", 0.8, "V/rad"), ("preload", 0.2, "V")])),
        (
            "cogging",
            effect(
                "cogging",
                &[
                    ("sine", 0.6, "V"),
                    ("cosine", 0.2, "V"),
                    ("sine2", 0.1, "V"),
                    ("cosine2", 0.0, "V"),
                    ("order", 3.0, "1"),
                ],
            ),
        ),
    ];
    for (name, load) in &loads {
        model(here, "m.json", 0.9, &format!("{DRY},{load}"));
        let tuned = run(here, "tune m.json --json").ends(0).json();
        assert_eq!(tuned["loads"][0]["effect"], *name, "{tuned}");
        let rms = |what: &str| {
            let trials = tuned["trials"].as_array().unwrap();
            let found = trials.iter().find(|t| t["compensation"].as_str().unwrap().contains(what));
            found.unwrap_or_else(|| panic!("{name}: no {what}"))["position"]["rms"].as_f64().unwrap()
        };
        let (before, wanted, measured) = (rms("kS"), rms("wanted angle"), rms("measured angle"));
        assert!(wanted.min(measured) < 0.75 * before, "{name}: {before} {wanted} {measured}");
        let said = run(here, "tune m.json").ends(0).err;
        assert!(said.contains(&format!("{name}: command -f, f = -")), "{said}");
        assert!(said.contains("Loads at the wanted angle: ") && !said.contains("angle: 0"), "{said}");
    }
    // A load that is the same everywhere is kG's.
    model(here, "m.json", 0.9, &effect("constant_load", &[("load", 0.4, "V")]));
    let tuned = run(here, "tune m.json --json").ends(0).json();
    assert!(
        tuned["loads"].as_array().unwrap().is_empty() && tuned["trials"].as_array().unwrap().len() == 3,
        "{tuned}"
    );
    assert_eq!(tuned["feedforward"]["kg_v"], 0.4);
}

/// The same model with the encoder on the load.
fn seen_from_the_load(here: &Path) {
    let text = std::fs::read_to_string(here.join("m.json")).unwrap();
    std::fs::write(
        here.join("m.json"),
        text.replace(r#""encoder_on_motor":true"#, r#""encoder_on_motor":false"#),
    )
    .unwrap();
}

/// The limit cycles of the three steps of the position.
fn limit_cycles(tuned: &Value) -> Vec<Value> {
    let steps = tuned["steps"].as_array().unwrap();
    assert!(steps.iter().all(|step| step["of"] == "position" || step["limit_cycle"].is_null()), "{tuned}");
    steps.iter().filter(|step| step["of"] == "position").map(|step| step["limit_cycle"].clone()).collect()
}

/// From behind the gap nothing is seen of the rotor, so the load is thrown from side to side; in front of it the rotor is held.
#[test]
fn a_gap_that_is_seen_from_the_load_keeps_it_moving_by_about_the_gap() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let gap = effect(
        "backlash",
        &[
            ("gap", 0.05, "rad"),
            ("load_share", 0.4, "1"),
            ("load_damping", 0.3, "1"),
            ("contact", 120.0, "Hz"),
            ("contact_damping", 0.4, "1"),
        ],
    );
    model(here, "m.json", 0.9, &gap);
    let tuned = run(here, "tune m.json --json").ends(0).json();
    assert!(limit_cycles(&tuned).iter().all(Value::is_null), "{tuned}");
    seen_from_the_load(here);
    let tuned = run(here, "tune m.json --json").ends(0).json();
    let cycles = limit_cycles(&tuned);
    assert!(cycles[0].is_null(), "the base model comes to rest: {tuned}");
    for cycle in &cycles[1..] {
        let number = |name: &str| cycle[name].as_f64().unwrap_or_else(|| panic!("no {name}: {tuned}"));
        let (gaps, crossover) =
            (number("amplitude_rad") / 0.05, tuned["position"]["margins"]["crossover_hz"].as_f64());
        assert!((0.25..1.0).contains(&gaps), "{cycle}");
        let share = number("frequency_hz") / crossover.unwrap();
        assert!((0.3..2.0).contains(&share), "{cycle}");
    }
    let said = run(here, "tune m.json").ends(0).err;
    let rows =
        said.lines().filter(|line| line.contains("  keeps moving by \u{b1}0.0") && line.ends_with(" Hz"));
    assert_eq!(rows.count(), 2, "{said}");
    assert!(said.contains("The position does not come to rest (feedback alone)"), "{said}");
}

/// A springy shaft is designed for as two masses: the loop is slower where the load is seen, holds its margins, and comes to rest.
#[test]
fn a_springy_shaft_slows_the_loops_down_to_where_it_comes_to_rest() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let spring = effect(
        "compliance",
        &[
            ("frequency", 8.0, "Hz"),
            ("load_share", 0.4, "1"),
            ("damping", 0.05, "1"),
            ("load_damping", 0.3, "1"),
        ],
    );
    let tuned = || run(here, "tune m.json --json").ends(0).json();
    let kp = |tuned: &Value, of: &str| tuned[of]["kp"].as_f64().unwrap();
    model(here, "m.json", 0.9, "");
    let rigid = tuned();
    model(here, "m.json", 0.9, &spring);
    seen_from_the_load(here);
    let springy = tuned();
    for of in ["velocity", "position"] {
        let margins = &springy[of]["margins"];
        assert!(kp(&springy, of) < 0.3 * kp(&rigid, of), "{of}: {springy}");
        assert!(margins["phase_deg"].as_f64().unwrap() > 59.0, "{of}: {margins}");
        assert!(margins["gain"].as_f64().unwrap() > 1.99, "{of}: {margins}");
    }
    for tuned in [&rigid, &springy] {
        assert!(limit_cycles(tuned).iter().all(Value::is_null), "{tuned}");
    }
    let real =
        springy["steps"].as_array().unwrap().iter().find(|step| step["without_effects"] == false).unwrap();
    assert!(real["settling_s"].as_f64().is_some() && real["overshoot"].as_f64().unwrap() < 0.3, "{real}");
    let said = run(here, "tune m.json").ends(0).err;
    assert!(
        said.contains("rotor and load with the springy shaft between them") && !said.contains("keeps moving"),
        "{said}"
    );
}
