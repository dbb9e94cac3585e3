//! Exported programs run like the model itself. Where there is no compiler or interpreter, the test says so.

mod exported;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use exported::{OPTIONS, formulas, model, sets, truth, volts};
use motorlens::export::{Format, Options, export};
use motorlens::model_file::Model;
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
    let exported = export(model, format, &OPTIONS);
    assert!(!exported.text.contains('@'), "a place was not filled: {}", exported.text);
    let path = directory.join(name);
    std::fs::write(&path, exported.text).expect("written");
    path
}

#[test]
fn c_compiles_without_warnings_and_runs_like_the_model() {
    if !there_is("cc") {
        return;
    }
    for model in sets().into_iter().chain(formulas()) {
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
    for model in sets().into_iter().chain(formulas()) {
        let directory = tempfile::tempdir().unwrap();
        let mut program = Command::new("python3");
        program.arg(write(directory.path(), "motor.py", &model, Format::Python));
        assert_same(&model, &angles(program));
    }
}

/// Two effects at their typical sizes, but for two transmissions, of which a model has one.
fn pairs() -> Vec<Model> {
    let typical = |kind: Kind| -> Vec<f64> {
        kind.spec().parameters.iter().map(|p| p.typical * p.scale.unit(&exported::rig())).collect()
    };
    let all = |a: Kind| Kind::ALL.iter().map(move |b| (a, *b));
    Kind::ALL
        .iter()
        .flat_map(|a| all(*a))
        .filter(|(a, b)| a < b && !(a.is_transmission() && b.is_transmission()))
        .map(|(a, b)| model(&[(a, &typical(a)), (b, &typical(b))]))
        .collect()
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
    assert!((way / (OPTIONS.step_s * speed) - 1.0).abs() < 0.01, "{way}");
}

#[test]
fn mujoco_gets_armature_damping_friction_and_gear_in_one_scale() {
    let model = model(&[(Kind::Coulomb, &[0.2]), (Kind::Backlash, &[0.01, 0.3, 0.3, 150.0, 0.3])]);
    let exported = export(&model, Format::Mujoco, &Options { torque_per_volt: 0.5, ..OPTIONS });
    let value = |name: &str| -> f64 {
        let (_, rest) = exported.text.split_once(&format!(" {name}=\"")).expect(name);
        rest.split('"').next().and_then(|x| x.parse().ok()).expect(name)
    };
    assert!((value("armature") - 0.5 * 0.05 / 0.9).abs() < 1e-12);
    assert!((value("damping") - 0.5 / 0.9).abs() < 1e-12);
    assert!((value("frictionloss") - 0.1).abs() < 1e-12 && (value("gear") - 0.5).abs() < 1e-12);
    assert!(exported.left_out.iter().any(|s| s.starts_with("backlash")), "{:?}", exported.left_out);
    assert!(!exported.text.contains("--\n") && exported.text.matches("--").count() == 2, "one XML comment");
}
