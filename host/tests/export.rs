//! Exported programs run like the model itself. Where there is no compiler or interpreter, the test says so.

mod exported;
mod program;

use std::io::Write;
use std::ops::ControlFlow;
use std::path::Path;
use std::process::{Command, Stdio};

use exported::{OPTIONS, at_the_output, formulas, model, pairs, sets, truth, volts};
use motorlens::export::cost::cost;
use motorlens::export::{Format, Options, export};
use motorlens::model_file::Model;
use motorlens::motor_file::MotorFile;
use motorlens_shared::effects::Kind;

fn angles(mut program: Command) -> Vec<f64> {
    let mut child = program.stdin(Stdio::piped()).stdout(Stdio::piped()).spawn().expect("the program starts");
    let mut input = child.stdin.take().expect("a pipe");
    let text: String = volts().iter().map(|v| format!("{v}\n")).collect();
    let writer = std::thread::spawn(move || input.write_all(text.as_bytes()));
    let output = child.wait_with_output().expect("the program ends");
    writer.join().expect("no panic").expect("the program reads");
    String::from_utf8(output.stdout).expect("text").lines().map(|l| l.parse().expect("a number")).collect()
}

fn assert_same(model: &Model, angles: &[f64]) {
    let truth = truth(model, &volts());
    assert_eq!(angles.len(), truth.len());
    for (a, b) in angles.iter().zip(&truth) {
        assert!((a - b).abs() <= 1e-9 * (1.0 + b.abs()), "{a} {b}: {:?}", model.values().kinds());
    }
}

fn there_is(program: &str) -> bool {
    let found = Command::new(program).arg("--version").output().is_ok();
    if !found {
        let _ = std::io::stderr().write_all(format!("SKIPPED: no {program} here\n").as_bytes());
    }
    found
}

fn write(directory: &Path, name: &str, model: &Model, format: Format) -> std::path::PathBuf {
    let exported = export(model, format, &OPTIONS).expect("whole");
    assert!(!exported.text().contains('@'), "a place was not filled: {}", exported.text());
    assert!(exported.lost.is_empty(), "{:?}", exported.lost);
    let path = directory.join(name);
    std::fs::write(&path, exported.content).expect("written");
    path
}

#[test]
fn c_compiles_without_warnings_and_runs_like_the_model() {
    if !there_is("cc") {
        return;
    }
    let output = sets().into_iter().map(at_the_output);
    for model in sets().into_iter().chain(formulas()).chain(output) {
        let directory = tempfile::tempdir().unwrap();
        let source = write(directory.path(), "motor.c", &model, Format::C);
        let binary = directory.path().join("motor");
        let built = Command::new("cc")
            .args(["-std=c99", "-Wall", "-Wextra", "-Werror", "-O1", "-DMOTOR_MAIN", "-o"])
            .arg(&binary)
            .arg(&source)
            .arg("-lm")
            .output()
            .unwrap();
        assert!(built.status.success(), "{}", String::from_utf8_lossy(&built.stderr));
        assert_same(&model, &angles(Command::new(&binary)));
    }
}

#[test]
fn python_runs_like_the_model() {
    if !there_is("python3") {
        return;
    }
    let output = sets().into_iter().map(at_the_output);
    for model in sets().into_iter().chain(formulas()).chain(output) {
        let directory = tempfile::tempdir().unwrap();
        let mut program = Command::new("python3");
        program.arg(write(directory.path(), "motor.py", &model, Format::Python));
        assert_same(&model, &angles(program));
    }
}

#[test]
fn every_pair_of_effects_runs_in_c_like_the_model() {
    if std::env::var_os("MOTORLENS_LONG_TESTS").is_none() || !there_is("cc") {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    for model in pairs() {
        let source = write(directory.path(), "motor.c", &model, Format::C);
        let binary = directory.path().join("motor");
        let mut cc = Command::new("cc");
        cc.args(["-std=c99", "-O0", "-DMOTOR_MAIN", "-o"]).arg(&binary).arg(&source).arg("-lm");
        assert!(cc.status().unwrap().success(), "{:?}", model.values().kinds());
        assert_same(&model, &angles(Command::new(&binary)));
    }
}

/// What holds of the C for every pair holds of the unit, whose archive stores its source as it is. No compiler is asked for its binary.
#[test]
fn the_source_of_a_unit_for_co_simulation_is_the_exported_c_for_every_pair_of_effects() {
    if std::env::var_os("MOTORLENS_LONG_TESTS").is_none() {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let [file, unit] = ["m.json", "motor.fmu"].map(|name| directory.path().join(name));
    for model in pairs() {
        model.write(&file).unwrap();
        let words = "export m.json --format fmu --out motor.fmu --quiet";
        let mut command = program::command(directory.path(), words);
        program::ran(command.env("CC", "no-such-compiler")).ends(0);
        let archive = String::from_utf8_lossy(&std::fs::read(&unit).unwrap()).into_owned();
        let c = export(&Model::read(&file).unwrap(), Format::C, &OPTIONS).unwrap().text();
        assert!(archive.contains(&c), "{:?}", model.values().kinds());
    }
}

/// Without the trail a filtered reading would run ahead of the model for a few of its time constants.
#[test]
fn a_program_that_begins_in_motion_begins_with_the_trail_of_its_reading() {
    if !there_is("python3") {
        return;
    }
    let model = model(&[(Kind::SensorLag, &[0.02, 0.0])]);
    let values = model.values();
    let (speed, volts) = (3.0, 3.0 * values.base.base().back_emf());
    let directory = tempfile::tempdir().unwrap();
    write(directory.path(), "motor.py", &model, Format::Python);
    let says = format!(
        "import motor; m = motor.Motor(0.5, {speed}); first = m.reading; print(first, m.step({volts}) - first)"
    );
    let ran = Command::new("python3").current_dir(directory.path()).args(["-c", &says]).output().unwrap();
    let said = String::from_utf8(ran.stdout).unwrap();
    let [first, way] = said.split_whitespace().map(|x| x.parse::<f64>().unwrap()).collect::<Vec<_>>()[..]
    else {
        panic!("{said}{}", String::from_utf8_lossy(&ran.stderr))
    };
    assert!((first - (0.5 - 0.02 * speed)).abs() < 1e-12, "{first}");
    // What friction takes in the first step is little.
    assert!((way / (1e-3 * speed) - 1.0).abs() < 0.01, "{way}");
}

#[test]
fn every_pair_of_effects_runs_in_python_like_the_model() {
    if std::env::var_os("MOTORLENS_LONG_TESTS").is_none() || !there_is("python3") {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    for model in pairs() {
        let mut program = Command::new("python3");
        program.arg(write(directory.path(), "motor.py", &model, Format::Python));
        assert_same(&model, &angles(program));
    }
}

#[test]
fn mujoco_gets_the_motors_constants_in_one_scale_shared_between_rotor_and_load() {
    let gap: (Kind, &[f64]) = (Kind::Backlash, &[0.01, 0.3, 0.3, 150.0, 0.3]);
    let model = model(&[(Kind::Coulomb, &[0.2]), (Kind::Stribeck, &[0.1, 0.2, 0.2, 0.4]), gap]);
    let exported =
        export(&model, Format::Mujoco, &Options { torque_per_volt: Some(0.5), step_s: None, ..OPTIONS })
            .unwrap();
    let text = exported.text();
    let value = |name: &str| -> f64 {
        let (_, rest) = text.split_once(&format!(" {name}=\"")).expect(name);
        rest.split(['"', ' ']).next().and_then(|x| x.parse().ok()).expect(name)
    };
    let constant = 0.9 / 0.9;
    // The rotor stands first; the load has three tenths of inertia and of viscous friction.
    assert!((value("armature") - 0.7 * 0.5 * 0.05 / 0.9).abs() < 1e-12);
    assert!((value("damping") - 0.7 * 0.5 * 0.1 / 0.9).abs() < 1e-12);
    assert!(
        (value("motorconst") - constant).abs() < 1e-12
            && (value("resistance") - constant / 0.5).abs() < 1e-12
    );
    // The levels of both, for those who have no program beside it, which sets the friction anew at each step from its own.
    assert!((value("frictionloss") - 0.5 * (0.2 + 0.1)).abs() < 1e-12);
    assert!(exported.lost.is_empty() && exported.carried == model.values(), "{:?}", exported.lost);
    let (_, program) = exported.beside.as_ref().expect("a program for stribeck and the gear contact");
    assert!(program.contains("FRICTION = 0.1\n"), "{program}");
    assert!(program.contains("stribeck") && program.contains("backlash"), "{program}");
    assert!(program.contains("rotor=\"rotor\"") && !program.contains('@'), "{program}");
    assert!(!text.contains("--\n") && text.matches("--").count() == 2, "one XML comment");
}

/// The cost is what the two simulations part by: a dead zone of half a volt under a standard programme.
#[test]
fn what_a_target_lacks_is_priced_by_simulating_with_and_without() {
    let model = model(&[(Kind::DeadZone, &[0.5, 0.0]), (Kind::Coulomb, &[0.2])]);
    let options = Options { torque_per_volt: Some(0.1), ..OPTIONS };
    let exported = export(&model, Format::Bam, &options).unwrap();
    let price = cost(&model, &exported, &[], &MotorFile::default(), None, &mut |_| ControlFlow::Continue(()))
        .unwrap();
    assert_eq!(price.each.len(), 1);
    assert_eq!(price.each[0].effect, Kind::DeadZone);
    // Half a volt at 0.9 rad/(s V) for most of 8 s, forwards and backwards.
    assert!(price.all.worst > 0.3 && price.all.worst < 0.5 * 0.9 * 8.0, "{price:?}");
    // BAM has no inductance either, which costs next to nothing beside it.
    assert!((price.all.rms / price.each[0].apart.rms - 1.0).abs() < 0.01, "{price:?}");
    assert!(price.clause().contains("rad (rms"), "{}", price.clause());
}

#[test]
fn bam_takes_the_smallest_model_that_holds_the_effects() {
    let file = |model: &Model, bam_model| -> motorlens::Result<serde_json::Value> {
        let options = Options { torque_per_volt: Some(0.1), bam_model, ..OPTIONS };
        Ok(serde_json::from_slice(&export(model, Format::Bam, &options)?.content).expect("JSON"))
    };
    let stribeck = model(&[(Kind::Stribeck, &[0.2, 0.3, 0.4, 0.25])]);
    let [m1, m2, m5] = [
        file(&model(&[(Kind::Coulomb, &[0.3])]), None).unwrap(),
        file(&stribeck, None).unwrap(),
        file(&model(&[(Kind::LoadFriction, &[0.2, 0.3])]), None).unwrap(),
    ];
    assert_eq!((&m1["model"], &m2["model"], &m5["model"]), (&"m1".into(), &"m2".into(), &"m5".into()));
    let near = |value: &serde_json::Value, wanted: f64| (value.as_f64().unwrap() - wanted).abs() < 1e-12;
    assert!(near(&m1["friction_base"], 0.03) && near(&m1["kt"], 1.0) && near(&m1["R"], 10.0), "{m1}");
    assert!(near(&m2["friction_stribeck"], 0.03) && near(&m2["alpha"], 1.75), "{m2}");
    assert!(near(&m5["load_friction_motor"], 0.2) && near(&m5["load_friction_external"], 0.0), "{m5}");
    let m6 = file(&stribeck, Some(6)).unwrap();
    assert!(near(&m6["load_friction_motor_quad"], 0.0) && near(&m6["friction_stribeck"], 0.03), "{m6}");
    let refused = file(&stribeck, Some(1)).unwrap_err().to_string();
    assert!(refused.contains("m1 cannot hold") && refused.contains("m2 is the smallest"), "{refused}");
    let unknown = export(&stribeck, Format::Bam, &OPTIONS).unwrap_err().to_string();
    assert!(unknown.contains("--torque-per-volt"), "{unknown}");
}
