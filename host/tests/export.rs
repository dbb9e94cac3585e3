//! Exported programs run like the model itself. Where there is no compiler or interpreter, the test says so.

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use motorlens::export::{Format, Options, export};
use motorlens::fit::layout::{BaseValues, Prior, Values};
use motorlens::model_file::{Model, Origin};
use motorlens_shared::effects::{Kind, Rig};
use motorlens_shared::simulator::Simulator;
use motorlens_shared::step::State;

const OPTIONS: Options = Options { step_s: 1e-3, torque_per_volt: 1.0 };

fn rig() -> Rig {
    Rig {
        step_s: 1e-3,
        gear_ratio: 30.0,
        encoder_on_motor: true,
        nominal_v: 12.0,
        supply_v: 12.0,
        reference_speed: 11.0,
        count_rad: 1e-3,
    }
}

fn model(effects: &[(Kind, &[f64])]) -> Model {
    let base = BaseValues { gain: 0.9, tau_m: 0.05, tau_e: 6e-4, viscous_share: 0.1 };
    let effects = effects.iter().map(|(kind, p)| (*kind, p.to_vec())).collect();
    let prior = Prior { tau_e: (5e-4, 0.4), viscous_share: (0.08, 0.05) };
    Model::new(&Values { base, effects }, &rig(), &prior, Origin::default())
}

/// Sets that together hold every effect of the library.
fn sets() -> Vec<Model> {
    let sets: Vec<Vec<(Kind, &[f64])>> = vec![
        vec![],
        vec![(Kind::DeadZone, &[0.3, 0.05]), (Kind::Coulomb, &[0.2]), (Kind::Gravity, &[0.4, -0.2])],
        vec![(Kind::SupplySag, &[0.3]), (Kind::Stribeck, &[0.2, 0.3, 0.2]), (Kind::Spring, &[0.05, -0.1])],
        vec![
            (Kind::VoltageDrop, &[0.4, 0.2]),
            (Kind::LoadFriction, &[0.1, 0.2]),
            (Kind::ConstantLoad, &[-0.3]),
        ],
        vec![
            (Kind::CoulombAsymmetric, &[0.3, 0.1]),
            (Kind::QuadraticDrag, &[0.01]),
            (Kind::Cogging, &[0.2, -0.1, 3.0]),
        ],
        vec![(Kind::Delay, &[0.0137]), (Kind::Coast, &[0.6]), (Kind::Saturation, &[0.5])],
        vec![(Kind::WindingHeating, &[0.2, 20.0]), (Kind::Eccentricity, &[0.004, -0.002])],
        vec![(Kind::LostCounts, &[0.05, 3.0]), (Kind::SensorLag, &[0.012])],
        vec![
            (Kind::Backlash, &[0.05, 0.4]),
            (Kind::Gravity, &[0.2, 0.1]),
            (Kind::WindingHeating, &[0.2, 20.0]),
            (Kind::Coulomb, &[0.2]),
            (Kind::SensorLag, &[0.012]),
            (Kind::Eccentricity, &[0.004, 0.002]),
        ],
        vec![
            (Kind::Compliance, &[8.0, 0.4, 0.05]),
            (Kind::Spring, &[0.05, 0.1]),
            (Kind::LostCounts, &[0.05, 3.0]),
        ],
    ];
    for kind in Kind::ALL {
        assert!(sets.iter().flatten().any(|(k, _)| k == kind), "{kind} is in no set");
    }
    sets.iter().map(|set| model(set)).collect()
}

/// 4 s of reversals and rest.
fn volts() -> Vec<f64> {
    (0..4000_u32)
        .map(|k| match k / 400 % 5 {
            0 => 8.0,
            1 => -5.0,
            2 => 0.0,
            3 => 0.5,
            _ => 9.0 * (f64::from(k) * 0.02).sin(),
        })
        .collect()
}

fn truth(model: &Model) -> Vec<f64> {
    let values = model.values();
    let effects = values.effects.iter().map(|(kind, p)| (*kind, p.as_slice()));
    let simulator = Simulator::new(&values.base.base(), effects, &rig());
    let mut motion = simulator.start(State::rest());
    let volts = volts();
    (0..volts.len())
        .map(|cell| {
            simulator.advance(&mut motion, &volts, cell);
            simulator.read(&motion)
        })
        .collect()
}

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
    let truth = truth(model);
    assert_eq!(angles.len(), truth.len());
    for (a, b) in angles.iter().zip(&truth) {
        // The model's sine is exact to 4e-9; with exact sines, steps of an unstable balance may grow from there.
        assert!((a - b).abs() < 1e-6, "{a} {b}: {:?}", model.values().kinds());
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
    for model in sets() {
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
    for model in sets() {
        let directory = tempfile::tempdir().unwrap();
        let mut program = Command::new("python3");
        program.arg(write(directory.path(), "motor.py", &model, Format::Python));
        assert_same(&model, &angles(program));
    }
}

#[test]
fn mujoco_gets_armature_damping_friction_and_gear_in_one_scale() {
    let model = model(&[(Kind::Coulomb, &[0.2]), (Kind::Backlash, &[0.01, 0.3])]);
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

#[test]
fn modelica_is_balanced_and_has_an_equation_for_every_unknown() {
    for model in sets() {
        let text = export(&model, Format::Modelica, &OPTIONS).text;
        assert_eq!(text.matches('(').count(), text.matches(')').count());
        let equations = text.split_once("equation\n").unwrap().1.split_once("end Motor;").unwrap().0;
        assert_eq!(equations.matches(" = ").count(), 5, "u, torque, friction, w, angle");
    }
}
