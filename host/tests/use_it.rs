//! From a model to where it is used, through the built program: export, same, completions, manual pages.

mod program;

use std::io::Write;
use std::process::Command;

use program::{DEAD, DRY, command, files, model, ran, run};

#[test]
fn an_export_that_would_lose_an_effect_is_refused_with_its_cost_and_allowed_on_request() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    model(here, "m.json", 0.9, &format!("{DRY},{DEAD}"));
    let refused = run(here, "export m.json -f urdf -o m.urdf --torque-per-volt 0.1").ends(2);
    assert!(
        refused.err.contains("no place for dead_zone") && refused.err.contains(" rad (rms"),
        "{}",
        refused.err
    );
    assert!(refused.err.contains("--allow-missing") && !here.join("m.urdf").exists(), "{}", refused.err);
    let allowed = run(here, "export m.json -f urdf -o m.urdf --torque-per-volt 0.1 --allow-missing --json")
        .ends(0)
        .json();
    assert_eq!(allowed["lost"][0]["effect"], "dead_zone");
    assert!(allowed["cost"]["all"]["rms"].as_f64().unwrap() > 0.05, "{allowed}");
    assert!(std::fs::read_to_string(here.join("m.urdf")).unwrap().contains("<dynamics damping="));
    let scale = run(here, "export m.json -f bam -o m1.json --allow-missing").ends(2);
    assert!(scale.err.contains("--torque-per-volt"), "{}", scale.err);
}

/// A weight that the robot must have, a delay in a comment, a program beside the file, steps that are too long.
#[test]
fn what_an_export_leaves_to_its_user_is_told_with_what_its_absence_costs() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let weight = r#"{"effect":"gravity","parameters":[{"name":"sine","value":0.8,"unit":"V"},
        {"name":"cosine","value":0.0,"unit":"V"}]}"#;
    let late = r#"{"effect":"delay","parameters":[{"name":"time","value":0.03,"unit":"s"}]}"#;
    for (effects, format, effect, word) in [
        (weight, "urdf", "gravity", "robot"),
        (late, "isaac", "delay", "comment"),
        (late, "bam", "delay", "rollout"),
        (late, "wpilib", "delay", "controller"),
        (DEAD, "mujoco", "dead_zone", "Python file"),
    ] {
        model(here, "m.json", 0.9, &format!("{DRY},{effects}"));
        let words = format!("export m.json -f {format} -o out --torque-per-volt 0.1 --json");
        let told = run(here, &words).ends(0).json();
        assert_eq!(told["left"][0]["effect"], effect, "{told}");
        let said = told["left_out"].to_string();
        assert!(
            said.contains(word) && said.contains("its absence costs") && said.contains(" rad (rms"),
            "{said}"
        );
        // Who pastes from the file is told there too.
        if format == "wpilib" {
            let text = std::fs::read_to_string(here.join("out")).unwrap();
            assert_eq!(text.matches("a command acts 30.000 ms late").count(), 3, "{text}");
        }
    }
    let slow = run(here, "export m.json -f c -o m.c --step 0.01 --json").ends(0).json();
    let said = slow["left_out"].to_string();
    assert!(said.contains("Steps of 0.01 s instead of 0.001 s cost"), "{said}");
    let shaft = r#"{"effect":"compliance","parameters":[{"name":"frequency","value":20.0,"unit":"Hz"},
        {"name":"load_share","value":0.4,"unit":"1"},{"name":"damping","value":0.1,"unit":"1"},
        {"name":"load_damping","value":0.3,"unit":"1"}]}"#;
    model(here, "m.json", 0.9, shaft);
    let unstable = run(here, "export m.json -f mujoco -o m.xml --step 0.01").ends(2);
    assert!(unstable.err.contains("shorter --step"), "{}", unstable.err);
}

/// Friction that is rougher than the target's one level keeps its level there.
#[test]
fn a_urdf_keeps_the_level_of_friction_whose_break_away_it_loses() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let stribeck = r#"{"effect":"stribeck","parameters":[{"name":"level","value":0.5,"unit":"V"},
        {"name":"excess","value":0.3,"unit":"V"},{"name":"speed","value":0.2,"unit":"rad/s"},
        {"name":"tail","value":0.4,"unit":"1"}]}"#;
    model(here, "m.json", 0.9, stribeck);
    let refused = run(here, "export m.json -f urdf -o m.urdf --torque-per-volt 0.1").ends(2);
    assert!(refused.err.contains("its level stays"), "{}", refused.err);
    let words = "export m.json -f urdf -o m.urdf --torque-per-volt 0.1 --allow-missing --json";
    let written = run(here, words).ends(0).json();
    let text = std::fs::read_to_string(here.join("m.urdf")).unwrap();
    assert!(text.contains(r#"friction="0.05"#), "{text}");
    // What stays costs nothing: the one loss is all but the winding's time constant of what the target costs.
    let rms = |cost: &serde_json::Value| cost["rms"].as_f64().unwrap();
    let (one, all) = (rms(&written["cost"]["each"][0]), rms(&written["cost"]["all"]));
    assert!(one > 0.0 && (one / all - 1.0).abs() < 0.25, "{one} {all}");
    // Nor does it where a program beside the file applies the rest.
    let written = run(here, "export m.json -f mujoco -o m.xml --json").ends(0).json();
    let beside = rms(&written["cost"]["each"][0]);
    assert!((beside / one - 1.0).abs() < 1e-9, "{beside} {one}");
}

#[test]
fn the_cost_on_a_record_holds_the_errors_against_the_measurement_with_and_without() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    run(here, "simulate --effect coulomb=0.4 --rate 200 --seconds 4 --out s --quiet").ends(0);
    let fit =
        "fit s/multisine.csv s/prbs.csv s/triangle.csv --effects coulomb,dead_zone --motor s/motor.toml";
    run(here, &format!("{fit} --out m.json --quiet")).ends(0);
    let words = "export m.json -f urdf -o m.urdf --torque-per-volt 0.1 --allow-missing --on s/prbs.csv --motor s/motor.toml --json";
    let written = run(here, words).ends(0).json();
    let errors = written["cost"]["errors"].as_array().expect("errors on a record");
    assert!(errors.iter().all(|e| e.as_f64().is_some_and(|e| e > 0.0)), "{written}");
    assert_eq!(written["cost"]["on"], "prbs");
    // All effects are there, but steps that are too long lose something.
    for (format, long) in [("c", "0.01"), ("mujoco", "0.001")] {
        let words = format!("export m.json -f {format} -o out.{format} --on s/prbs.csv --motor s/motor.toml");
        let run = |words: &str| ran(command(here, words).env("PYTHON", "no-such-python"));
        let usual = run(&words).ends(0).err;
        // What MuJoCo did not run has not been measured there.
        let [kept, not_run] = match format {
            "c" => ["Nothing is lost: ", ""],
            _ => [
                "Every effect of the model is written.",
                "there is no Python \"no-such-python\" here. What its own steps cost",
            ],
        };
        assert!(usual.contains(kept) && usual.contains(not_run), "{usual}");
        assert_eq!(usual.contains("Nothing is lost"), format == "c", "{usual}");
        // A program is run in its own steps, and refused where it errs; what MuJoCo makes of its steps only MuJoCo can tell.
        let long = format!("{words} --step {long}");
        let refused = run(&long);
        let slow = if format == "c" {
            let said = refused.ends(2).err;
            let why = "more than a hundredth above it (give a step of 0.001 s";
            assert!(said.contains(why) && said.contains("or --step 0.001"), "{said}");
            run(&format!("{long} --allow-missing")).ends(0).err
        } else {
            let said = refused.ends(0).err;
            assert!(said.contains("With steps of 1e-3 s MuJoCo may err by more than a hundredth"), "{said}");
            said
        };
        assert!(!slow.contains("Nothing is lost"), "{slow}");
    }
}

/// Whatever the target: what it has of the model errs by at most a hundredth more than the model on a validation record, or it is
/// refused.
#[test]
fn every_target_is_as_good_as_the_model_on_a_validation_record_or_refused() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    run(here, "simulate --effect stribeck --rate 200 --seconds 4 --out s --quiet").ends(0);
    let fit = "fit s/multisine.csv s/prbs.csv s/triangle.csv --motor s/motor.toml --quiet";
    for (name, effects) in [("rough", "none"), ("dry", "coulomb"), ("full", "stribeck")] {
        run(here, &format!("{fit} --effects {effects} --out {name}.json")).ends(0);
    }
    let held_out = files(&here.join("s")).into_iter().find(|p| p.to_string_lossy().contains("holdout"));
    let held_out = held_out.expect("a record that no fit has seen").display().to_string();
    let (mut taken, mut refused) = (0, 0);
    for name in ["rough", "dry", "full"] {
        for format in ["c", "python", "modelica", "fmu", "mujoco", "wpilib", "bam", "isaac", "urdf"] {
            let words = format!(
                "export {name}.json -f {format} -o out.{format} --torque-per-volt 0.1 --on {held_out} --motor s/motor.toml --json"
            );
            let done = run(here, &words);
            if done.status == 0 {
                let written = done.ends(0).json();
                let [own, exported] = [0, 1].map(|k| written["cost"]["errors"][k].as_f64().unwrap());
                assert!(exported <= 1.01 * own, "{name} in {format}: {written}");
                taken += 1;
            } else {
                let said = done.ends(2).err;
                let why =
                    said.contains("more than a hundredth above it") || said.contains("has no place for");
                assert!(why && said.contains("--allow-missing"), "{name} in {format}: {said}");
                refused += 1;
            }
        }
    }
    // The exact ones take all; break-away has no place in a URDF, and costs in Isaac Lab.
    assert!(taken >= 3 * 5 && refused >= 2, "{taken} taken, {refused} refused");
}

#[test]
fn mujocos_second_file_stands_beside_the_first() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    model(here, "m.json", 0.9, DEAD);
    let written = run(here, "export m.json --format mujoco --out motor.xml --json").ends(0).json();
    assert_eq!(written["beside"], "motor.py");
    let [xml, program] = ["motor.xml", "motor.py"].map(|f| std::fs::read_to_string(here.join(f)).unwrap());
    assert!(xml.contains("<dcmotor") && program.contains("dead_zone"), "{xml}{program}");
}

#[test]
fn records_of_one_motor_are_the_same_and_of_another_are_not() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for (out, effect, seed) in [("a", "coulomb=0.4", 1), ("b", "coulomb=0.4", 2), ("c", "coulomb=0.7", 3)] {
        run(
            here,
            &format!("simulate --effect {effect} --rate 100 --seconds 6 --seed {seed} --out {out} --quiet"),
        )
        .ends(0);
    }
    let set = |d: &str| format!("{d}/multisine.csv {d}/prbs.csv {d}/triangle.csv");
    let ask = |other: &str| {
        let words =
            format!("same --effects coulomb --motor a/motor.toml --json {} -- {}", set("a"), set(other));
        run(here, &words).ends(0).json()
    };
    let one = ask("b");
    assert_eq!(one["verdict"], "same", "{one}");
    let two = ask("c");
    assert_eq!(two["verdict"], "different", "{two}");
    assert_eq!(two["parameters"][0]["name"], "coulomb.level", "{two}");
    // What it proposes reads the logs as it did.
    let told =
        run(here, &format!("same --effects coulomb -m a/motor.toml {} -- {}", set("a"), set("b"))).ends(0);
    let all = format!("{}{}", told.out, told.err);
    assert!(all.contains("-m a/motor.toml") && all.contains("\u{b1}"), "{all}");
    // Two wheels of one robot are alike, and no one motor.
    assert!(all.contains("No difference shows: one model") && !all.contains("One motor"), "{all}");
    run(here, &format!("same {}", set("a"))).ends(2);
    let misplaced = run(here, &format!("same {} -- {} --motor a/motor.toml", set("a"), set("b"))).ends(2);
    assert!(misplaced.err.contains("before --"), "{}", misplaced.err);
}

/// On a single record each two effects that do alike trade: both fits are as good, at other values.
#[test]
fn other_values_that_fit_no_better_are_no_other_motor() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    // Heating and a delay trade in records that are short and alike.
    run(here, "simulate --motor random --seed 5 --effect winding_heating=0.2254,time=27.44 --effect delay=6.477 --out s --quiet").ends(0);
    let words = "same s/prbs.csv --effects delay,winding_heating -m s/motor.toml --json -- s/triangle.csv";
    let told = run(here, words).ends(0).json();
    let deviations = told["parameters"][0]["deviations"].as_f64().unwrap();
    assert!(deviations > told["bar"].as_f64().unwrap(), "no values trade here any more: {told}");
    assert_eq!(told["verdict"], "same", "{told}");
    assert_eq!(told["parameters"][0]["differs"], false, "{told}");
    assert!(told["why"].as_str().unwrap().contains("fit no better"), "{told}");
}

/// Friction that rises towards rest is more Coulomb friction to a slow triangle than to fast steps.
#[test]
fn a_model_that_lacks_something_makes_no_second_motor_of_another_programme() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    run(here, "simulate --motor random --seed 3 --effect stribeck --rate 200 --seconds 4 --out s --quiet")
        .ends(0);
    let told =
        run(here, "same s/prbs.csv -e coulomb -m s/motor.toml --json -- s/triangle.csv").ends(0).json();
    assert_eq!(told["parameters"][0]["differs"], true, "{told}");
    assert_eq!(told["verdict"], "open", "{told}");
    assert!(told["why"].as_str().unwrap().contains("give each set a second record"), "{told}");
}

/// A log of counts and duty, as `discover` reads it with its options.
#[test]
fn what_an_export_costs_is_told_on_a_log_that_needs_options_to_be_read() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    model(here, "m.json", 0.9, DRY);
    let mut log = String::from("pwm,enc\n");
    for k in 0..400 {
        let duty = [127, -60, 0, 200][k / 100];
        log += &format!("{duty},{}\n", k * k % 97 + 3 * k);
    }
    std::fs::write(here.join("duty.csv"), log).unwrap();
    let words = "export m.json -f wpilib -o m.txt --allow-missing --json --on duty.csv --map duty=pwm:255,angle=enc:counts \
                 --rate 100 --supply-volts 12 --counts-per-rev 1320 --skip 3.5..";
    let told = run(here, words).ends(0).json();
    assert_eq!(told["cost"]["unit"], "rad", "{told}");
    assert!(told["cost"]["errors"][0].as_f64().unwrap() > 0.0, "{told}");
}

/// Characters that XML keeps for itself, and a name that the target takes.
#[test]
fn an_exported_joint_has_the_name_that_was_asked_for() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    model(here, "m.json", 0.9, DRY);
    for (format, named) in [
        ("urdf", "name=\"left&amp;right\""),
        ("mujoco", "joint=\"left&amp;right\""),
        ("isaac", "[\"left&right\"]"),
        ("bam", "\"left&right\""),
    ] {
        let words = format!("export m.json -f {format} -o out --torque-per-volt 0.1 --name left&right");
        run(here, &words).ends(0);
        let text = std::fs::read_to_string(here.join("out")).unwrap();
        assert!(text.contains(named), "{format}: {text}");
        assert!(!text.contains("\"output\""), "{format}: {text}");
        // ros2_control loads no component without a plugin.
        assert!(
            format != "urdf" || text.contains("<plugin>mock_components/GenericSystem</plugin>"),
            "{text}"
        );
    }
    // The program beside an MJCF knows the name too.
    model(here, "m.json", 0.9, DEAD);
    run(here, "export m.json -f mujoco -o m.xml --name wheel").ends(0);
    let program = std::fs::read_to_string(here.join("m.py")).unwrap();
    assert!(program.contains("joint=\"wheel\", rotor=\"wheel\""), "{program}");
}

#[test]
fn every_shell_gets_its_completions_and_every_verb_its_page() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    for shell in ["bash", "zsh", "fish", "powershell", "elvish"] {
        let script = run(here, &format!("completions {shell}")).ends(0).out;
        assert!(script.contains("discover") && script.contains("torque-per-volt"), "{shell}");
        std::fs::write(here.join(shell), script).unwrap();
    }
    if let Ok(read) = Command::new("bash").args(["-n", "bash"]).current_dir(here).output() {
        let said = String::from_utf8_lossy(&read.stderr);
        assert!(read.status.success() && said.is_empty(), "{said}");
    } else {
        let _ = std::io::stderr().write_all(b"SKIPPED: no bash here to read its completions\n");
    }
    run(here, "man pages").ends(0);
    let pages = files(&here.join("pages"));
    let help = run(here, "--help").ends(0).out;
    // A description that goes on in the next line is indented further.
    let begins = |line: &&str| line.starts_with("  ") && !line.starts_with("   ");
    let list =
        help.lines().skip_while(|line| *line != "Commands:").skip(1).take_while(|line| !line.is_empty());
    for verb in
        list.filter(begins).filter_map(|line| line.split_whitespace().next()).filter(|verb| *verb != "help")
    {
        let own = run(here, &format!("{verb} --help")).ends(0).out;
        let heads = ["Example:\n  motorlens ", "Examples:\n  motorlens "];
        assert!(heads.iter().any(|head| own.contains(head)), "{verb} --help has no example");
    }
    for verb in ["discover", "tune", "same", "export", "completions"] {
        assert!(help.contains(verb), "{verb}");
        let page = pages.iter().find(|p| p.ends_with(format!("motorlens-{verb}.1"))).expect(verb);
        let text = std::fs::read_to_string(page).unwrap();
        assert!(text.starts_with(".ie") && text.contains(".SH NAME"), "{text}");
    }
    // Whatever page a page refers to is there.
    for page in &pages {
        let text = std::fs::read_to_string(page).unwrap();
        for word in text.split(|c: char| c.is_whitespace()).filter(|word| word.ends_with("(1)")) {
            let name = word.trim_end_matches("(1)").replace('\\', "");
            assert!(here.join(format!("pages/{name}.1")).is_file(), "{} refers to {name}", page.display());
        }
    }
    assert!(
        std::fs::read_to_string(here.join("pages/motorlens-export.1")).unwrap().contains("allow\\-missing")
    );
}
