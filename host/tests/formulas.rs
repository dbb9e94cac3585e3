//! Effects that a user writes as formulas, through the built program: they take part in every verb.

mod program;

use std::path::Path;

use program::{logs, run};
use serde_json::Value;

/// A cam with three lobes on the output shaft: nothing of the library.
const CAM: &str = "name = \"cam\"\nport = \"torque\"\ntitle = \"a cam with three lobes\"\n\
    formula = \"-(sine * sin(3 * angle) + cosine * cos(3 * angle))\"\n\
    [[parameter]]\nname = \"sine\"\nunit = \"V\"\nlow = -6\ntypical = 0.3\nhigh = 6\n\
    [[parameter]]\nname = \"cosine\"\nunit = \"V\"\nlow = -6\ntypical = 0.3\nhigh = 6\n";

const DRY: &str = "name = \"dry\"\nport = \"friction\"\nformula = \"level\"\n\
    [[parameter]]\nname = \"level\"\nunit = \"V\"\nlow = 0\ntypical = 0.2\nhigh = 5\n";

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap_or_else(|| panic!("{value} is a number"))
}

fn write(directory: &Path, name: &str, text: &str) {
    std::fs::write(directory.join(name), text).unwrap();
}

#[test]
fn two_files_that_give_different_effects_one_name_are_refused_with_the_place() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write(here, "dry.toml", DRY);
    write(here, "drier.toml", &DRY.replace("typical = 0.2", "typical = 0.4"));
    run(here, "effects --effect-file dry.toml --effect-file dry.toml dry").ends(0);
    let refused = run(here, "effects --effect-file dry.toml --effect-file drier.toml dry").ends(3);
    let wanted = ["drier.toml, line 1, column 8", "two different effects are called dry", "another name"];
    assert!(wanted.iter().all(|words| refused.err.contains(words)), "{}", refused.err);
}

#[test]
fn a_formula_is_simulated_discovered_compared_and_exported() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write(here, "cam.toml", CAM);
    let own = "--effect-file cam.toml";
    run(here, &format!("simulate {own} --effect cam=0.8,cosine=-0.4 --rate 100 --out s --quiet")).ends(0);
    let revealed = run(here, "reveal s --json").ends(0).json();
    assert_eq!(revealed["effects"][0], "cam");

    let logs = "s/triangle.csv s/multisine.csv s/staircase.csv --validate s/holdout-multisine-2.csv --motor s/motor.toml";
    let found = run(here, &format!("discover {own} {logs} --most 2 --out m.json --json")).ends(0).json();
    assert_eq!(found["effects"][0], "cam", "{}", found["candidates"]);
    let parameter = |name: &str| {
        let all = found["parameters"].as_array().unwrap();
        number(&all.iter().find(|p| p["name"] == name).unwrap_or_else(|| panic!("{name}"))["value"])
    };
    assert!((parameter("cam.sine") - 0.8).abs() < 0.04, "{}", parameter("cam.sine"));
    assert!((parameter("cam.cosine") + 0.4).abs() < 0.04, "{}", parameter("cam.cosine"));

    // The model file carries the formula, so nothing else is needed any more.
    let compared = run(here, &format!("compare m.json {logs} --json")).ends(0).json();
    assert_eq!(compared["effects"][0], "cam");
    assert!(number(&compared["pooled"]["nrmse_fit_percent"]) > 95.0, "{}", compared["pooled"]);
    let wanted = "cam: torque = -(sine * sin(3 * angle) + cosine * cos(3 * angle))";
    for format in ["c", "python", "modelica"] {
        run(here, &format!("export m.json --format {format} --out x --quiet")).ends(0);
        assert!(std::fs::read_to_string(here.join("x")).unwrap().contains(wanted), "{format}");
    }
    let listed = run(here, &format!("effects {own} cam")).ends(0);
    assert!(listed.out.contains("three lobes"), "{}", listed.out);
}

#[test]
fn a_formula_equal_to_a_library_effect_gives_the_same_answer() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    write(here, "dry.toml", DRY);
    let logs = logs(here);
    let fit = |effect: &str| {
        let words =
            format!("fit --effect-file dry.toml {logs} --effects {effect} --out {effect}.json --json");
        run(here, &words).ends(0).json()
    };
    let (library, own) = (fit("coulomb"), fit("dry"));
    for (a, b) in library["parameters"].as_array().unwrap().iter().zip(own["parameters"].as_array().unwrap())
    {
        let (a, b) = (number(&a["value"]), number(&b["value"]));
        // What the data hardly determine may differ where the search stopped.
        assert!((a / b - 1.0).abs() < 1e-2, "{a} {b}");
    }
    let rmse = |fit: &Value| number(&fit["validation"]["rmse"]);
    assert!((rmse(&library) / rmse(&own) - 1.0).abs() < 1e-2, "{} {}", rmse(&library), rmse(&own));

    run(here, &format!("fit {logs} --out base.json --quiet")).ends(0);
    let added = run(here, &format!("add --effect-file dry.toml base.json dry {logs} --json")).ends(0).json();
    assert_eq!(added["worth_adding"], true);
    // What a user fixes has the name that results print.
    write(here, "m.toml", "[fixed]\n\"dry.level\" = 0.3\n");
    let held =
        format!("fit --effect-file dry.toml {} --effects dry --json", logs.replace("s/motor.toml", "m.toml"));
    assert_eq!(run(here, &held).ends(0).json()["parameters"][4]["value"], 0.3);
}

#[test]
fn what_is_wrong_with_a_formula_is_named_with_file_line_and_column() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for (text, place, cause, remedy) in [
        (
            CAM.replace("3 * angle) + ", "3 * angel) + "),
            "line 4, column 29",
            "angel is neither",
            "did you mean angle?",
        ),
        (CAM.replace("torque", "lever"), "line 2, column 8", "no port", "sensor"),
        (
            DRY.replace("\"level\"\n[[", "\"level * sign(speed)\"\n[[").replace("friction", "torque"),
            "line 3",
            "chatter",
            "friction",
        ),
        ("name = 3".into(), "line 1, column 8", "string", "correct"),
        (String::new(), "line 1", "name is missing", "add name"),
    ] {
        write(here, "wrong.toml", &text);
        let ran = run(here, "effects --effect-file wrong.toml --json").ends(3);
        for wanted in [format!("wrong.toml, {place}").as_str(), cause, remedy] {
            assert!(ran.err.contains(wanted), "{wanted} in {}", ran.err);
        }
        assert_eq!(ran.json()["error"]["kind"], "bad_input");
    }
    let absent = run(here, "effects --effect-file absent.toml").ends(3);
    assert!(absent.err.contains("absent.toml"), "{}", absent.err);
    write(here, "cam.toml", CAM);
    for (effect, wanted) in
        [("cam=9", "outside"), ("cam=1,width=2", "no parameter width"), ("cam=x", "not a number")]
    {
        let ran = run(here, &format!("simulate --effect-file cam.toml --effect {effect}")).ends(2);
        assert!(ran.err.contains(wanted), "{}", ran.err);
    }
}
