//! Exported models run in the tools that they are for, beside motorlens' own simulation.
//!
//! The tools come from Python's registry: `MOTORLENS_EXPORT_PYTHON` names a Python that has MuJoCo, a Modelica compiler, FMPy, WPILib's
//! mathematics, a URDF reader and Isaac Lab's sources, and `cargo xtask test` sets one up, with compilers for the lines in C++ and in Java.
//! Where it is not set, each test says so and ends.

mod exported;
#[path = "exported/tools.rs"]
mod tools;

use std::io::Write;
use std::process::{Command, Stdio};

use exported::{OPTIONS, at_the_output, formulas, model, own, pairs, sets, truth};
use motorlens::export::{Format, Options, export};
use motorlens::model_file::Model;
use motorlens_shared::effects::Kind;
use tools::{AT_REST, FMU, MODELICA, MUJOCO, python, run, volts};

/// What the export makes of `volts`, and what the model makes of it.
fn both(python: &str, model: &Model, format: Format, volts: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let directory = tempfile::tempdir().unwrap();
    let (script, name) = match format {
        Format::Mujoco => (MUJOCO, "motor.xml"),
        Format::Fmu => (FMU, "motor.fmu"),
        _ => (MODELICA, "Motor.mo"),
    };
    let file = directory.path().join(name);
    // MuJoCo takes the step that its export has without being asked.
    let step_s = if format == Format::Mujoco { None } else { OPTIONS.step_s };
    let exported = export(model, format, &Options { step_s, ..OPTIONS }).unwrap();
    std::fs::write(&file, &exported.content).unwrap();
    if let Some((ending, text)) = &exported.beside {
        std::fs::write(file.with_extension(ending), text).unwrap();
    }
    let angles = run(python, script, &file, volts, AT_REST);
    let truth = truth(model, volts);
    assert_eq!(angles.len(), truth.len());
    (angles, truth)
}

/// For those who cannot run Python beside their simulator: in steady motion friction is nearly its level.
#[test]
fn an_mjcf_without_its_program_has_the_level_of_a_stribeck_curve() {
    let Some(python) = python() else { return };
    let stribeck = model(&[(Kind::Stribeck, &[0.5, 0.3, 0.2, 0.4])]);
    let directory = tempfile::tempdir().unwrap();
    let file = directory.path().join("motor.xml");
    let exported = export(&stribeck, Format::Mujoco, &Options { step_s: None, ..OPTIONS }).unwrap();
    assert!(exported.left[0].why.contains("its level stays"), "{:?}", exported.left);
    std::fs::write(&file, &exported.content).unwrap();
    let steady = vec![6.0; 1000];
    let (alone, whole) = (run(&python, MUJOCO, &file, &steady, AT_REST), truth(&stribeck, &steady));
    assert!((alone[999] / whole[999] - 1.0).abs() < 0.01, "{} {}", alone[999], whole[999]);
}

/// Largest difference as a share of how far the motor turned.
fn disagreement(python: &str, model: &Model, format: Format) -> f64 {
    let (angles, truth) = both(python, model, format, &volts());
    let range = truth.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = angles.iter().zip(&truth).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    println!("{format:?} {:?}: {:.2e} of {range:.3} rad", model.values().kinds(), worst / range);
    worst / range
}

/// Every effect alone at a size that shows, and sets of them.
#[test]
fn mujoco_turns_as_the_model_does_with_every_effect() {
    let Some(python) = python() else { return };
    let alone = [
        model(&[]),
        model(&[(Kind::Coulomb, &[0.2])]),
        model(&[(Kind::CoulombAsymmetric, &[0.3, 0.1])]),
        model(&[(Kind::Stribeck, &[0.2, 0.3, 0.2, 0.4])]),
        // Whose excess falls like a bell.
        model(&[(Kind::Stribeck, &[0.2, 0.3, 0.2, 0.0])]),
        model(&[(Kind::LoadFriction, &[0.2, 0.3])]),
        model(&[(Kind::QuadraticDrag, &[0.02])]),
        model(&[(Kind::Gravity, &[0.4, -0.2])]),
        model(&[(Kind::ConstantLoad, &[-0.3])]),
        model(&[(Kind::Cogging, &[0.2, -0.1, 0.05, -0.02, 3.0])]),
        model(&[(Kind::Spring, &[0.5, -0.1])]),
        model(&[(Kind::Saturation, &[1.5])]),
        model(&[(Kind::Delay, &[0.0061])]),
        model(&[(Kind::DeadZone, &[0.5, 0.05])]),
        model(&[(Kind::Coast, &[0.6, 500.0])]),
        model(&[(Kind::Freewheel, &[0.9, 500.0])]),
        model(&[(Kind::SupplySag, &[0.3, 0.003])]),
        model(&[(Kind::WindingHeating, &[0.4, 20.0])]),
        model(&[(Kind::VoltageDrop, &[0.4, 0.2])]),
        model(&[(Kind::Eccentricity, &[0.004, -0.002])]),
        model(&[(Kind::LostCounts, &[0.05, 3.0])]),
        model(&[(Kind::SensorLag, &[0.012, 0.0])]),
        model(&[(Kind::Compliance, &[8.0, 0.4, 0.05, 0.3])]),
        model(&[(Kind::Backlash, &[0.05, 0.4, 0.3, 120.0, 0.4])]),
    ];
    for kind in Kind::ALL {
        assert!(alone.iter().any(|m| m.values().kinds() == [*kind]), "{kind} is not tried");
    }
    let output = sets().into_iter().map(at_the_output);
    for model in alone.into_iter().chain(sets()).chain(formulas()).chain(output) {
        let apart = disagreement(&python, &model, Format::Mujoco);
        assert!(apart < 4e-3, "{:?}: {apart:.2e}", model.values().kinds());
    }
}

#[test]
fn a_unit_for_co_simulation_passes_fmpys_checks_and_runs_like_the_model() {
    let Some(python) = python() else { return };
    let output = sets().into_iter().map(at_the_output);
    for model in sets().into_iter().chain(formulas()).chain(output) {
        assert!(disagreement(&python, &model, Format::Fmu) < 1e-9, "{:?}", model.values().kinds());
    }
}

/// The same numbers, but for the solver's error in the integral of the voltage.
#[test]
fn modelica_compiles_and_runs_like_the_model() {
    let Some(python) = python() else { return };
    let output = sets().into_iter().map(at_the_output);
    for model in sets().into_iter().chain(formulas()).chain(output) {
        assert!(disagreement(&python, &model, Format::Modelica) < 1e-9, "{:?}", model.values().kinds());
    }
}

#[test]
fn every_pair_of_effects_runs_in_modelica_like_the_model() {
    let long = std::env::var_os("MOTORLENS_LONG_TESTS").is_some();
    let (true, Some(python)) = (long, python()) else { return };
    for model in pairs() {
        assert!(disagreement(&python, &model, Format::Modelica) < 1e-9, "{:?}", model.values().kinds());
    }
}

/// The volts that WPILib computes from the pasted lines turn the motor at the speed that was asked, and hold an arm still.
#[test]
fn wpilibs_feedforward_gives_the_voltage_for_a_speed() {
    let Some(python) = python() else { return };
    let script = "
import sys, wpimath.controller
text = open(sys.argv[1]).read().split('--- Python (radians)')[1]
scope = {'wpimath': wpimath}
exec(text, scope)
f = scope['feedforward']
for line in sys.stdin:
    a, b = map(float, line.split())
    print(f.calculate(a, b) if sys.argv[1].endswith('arm.txt') else f.calculate(a))
";
    let directory = tempfile::tempdir().unwrap();
    let ask = |name: &str, model: &Model, lines: &str| -> Vec<f64> {
        let file = directory.path().join(name);
        std::fs::write(&file, export(model, Format::Wpilib, &OPTIONS).unwrap().content).unwrap();
        let mut child = Command::new(&python)
            .args(["-c", script])
            .arg(&file)
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        child.stdin.take().unwrap().write_all(lines.as_bytes()).unwrap();
        let said = String::from_utf8(child.wait_with_output().unwrap().stdout).unwrap();
        said.lines().map(|line| line.parse().unwrap()).collect()
    };
    let turning = model(&[(Kind::Coulomb, &[0.3]), (Kind::DeadZone, &[0.4, 0.0])]);
    let speeds = [3.0, -5.0];
    for (speed, volts) in speeds.iter().zip(ask("motor.txt", &turning, "3 0\n-5 0\n")) {
        let angles = truth(&turning, &vec![volts; 2000]);
        let reached = (angles[1999] - angles[1899]) / 0.1;
        assert!((reached / speed - 1.0).abs() < 1e-3, "{reached} for {speed}");
    }
    // At the log's zero the weight pulls with its cosine part alone: the arm's angle is the log's less its zero.
    let (sine, cosine) = (0.8_f64, 0.5_f64);
    let arm = model(&[(Kind::Gravity, &[sine, cosine])]);
    let zero = sine.atan2(cosine);
    let volts = ask("arm.txt", &arm, &format!("{} 0\n", -zero))[0];
    assert!((volts - cosine).abs() < 1e-6, "{volts}");
}

/// Units that do not fit, such as radians where a class takes metres, do not compile; what does gives the volts of a steady speed, at an angle
/// at which the weight pulls with its cosine part alone.
#[test]
fn the_lines_for_cpp_run_with_wpilibs_own_library() {
    let Some(python) = python() else { return };
    let script = r#"
import pathlib, subprocess, sys, native.wpimath, native.wpiutil
lines = pathlib.Path(sys.argv[1]).read_text().split('--- C++ (radians)')[1].split('--- Python')[0]
source, program = pathlib.Path(sys.argv[1] + '.cpp'), sys.argv[1] + '.bin'
source.write_text(f'{lines}\n#include <cstdio>\nint main() {{ std::printf("%.9f", ({sys.argv[2]}).value()); }}\n')
homes = [path for package in (native.wpimath, native.wpiutil) for path in package.__path__]
flags = [flag for home in homes for flag in (f'-I{home}/include', f'-L{home}/lib', f'-Wl,-rpath,{home}/lib')]
subprocess.check_call(['c++', '-std=c++20', '-o', program, str(source), *flags, '-lwpimath', '-lwpiutil'])
sys.exit(subprocess.call([program]))
"#;
    let directory = tempfile::tempdir().unwrap();
    let weight = [0.8_f64, 0.5];
    let simple = "feedforward.Calculate(2_rad_per_s)";
    let lift = format!("{simple} + kG");
    let arm = format!("feedforward.Calculate({:?}_rad, 2_rad_per_s)", -weight[0].atan2(weight[1]));
    let back_emf = 2.0 / 0.9;
    for (name, effects, call, volts) in [
        ("simple", vec![(Kind::Coulomb, &[0.3][..])], simple, 0.3 + back_emf),
        ("lift", vec![(Kind::ConstantLoad, &[0.4][..])], lift.as_str(), 0.4 + back_emf),
        (
            "arm",
            vec![(Kind::Coulomb, &[0.3][..]), (Kind::Gravity, &weight[..])],
            arm.as_str(),
            0.3 + weight[1] + back_emf,
        ),
        ("late", vec![(Kind::Delay, &[0.0061][..])], simple, back_emf),
    ] {
        let file = directory.path().join(name);
        std::fs::write(&file, export(&model(&effects), Format::Wpilib, &OPTIONS).unwrap().content).unwrap();
        let ran = Command::new(&python).args(["-c", script]).arg(&file).arg(call).output().unwrap();
        assert!(ran.status.success(), "{name}: {}", String::from_utf8_lossy(&ran.stderr));
        let said: f64 = String::from_utf8(ran.stdout).unwrap().parse().unwrap();
        assert!((said - volts).abs() < 1e-6, "{name}: {said} V, not {volts} V");
    }
}

/// In a class that imports what their comment says, beside classes with the constructors of WPILib's documentation.
#[test]
fn the_lines_for_java_compile() {
    if python().is_none() {
        return;
    }
    for (class, arguments, effects) in [
        ("SimpleMotorFeedforward", 3, vec![(Kind::Coulomb, &[0.3][..])]),
        ("ElevatorFeedforward", 4, vec![(Kind::ConstantLoad, &[0.4][..])]),
        ("ArmFeedforward", 4, vec![(Kind::Gravity, &[0.8, 0.5][..])]),
        ("SimpleMotorFeedforward", 3, vec![(Kind::Delay, &[0.0061][..])]),
    ] {
        let directory = tempfile::tempdir().unwrap();
        let package = directory.path().join("edu/wpi/first/math/controller");
        std::fs::create_dir_all(&package).unwrap();
        let parameters: Vec<String> = (0..arguments).map(|k| format!("double k{k}")).collect();
        let stub = format!(
            "package edu.wpi.first.math.controller;\npublic class {class} {{\n  public {class}({}) {{ }}\n}}\n",
            parameters.join(", ")
        );
        std::fs::write(package.join(format!("{class}.java")), stub).unwrap();
        let text = export(&model(&effects), Format::Wpilib, &OPTIONS).unwrap().text();
        let lines = text.split("--- Java (radians)\n").nth(1).and_then(|rest| rest.split("--- C++").next());
        let (imports, lines): (Vec<&str>, Vec<&str>) =
            lines.expect("lines for Java").lines().partition(|line| line.contains("// import "));
        let imports = imports.join("\n").replace("// ", "");
        let robot = directory.path().join("Robot.java");
        std::fs::write(&robot, format!("{imports}\nclass Robot {{\n{}\n}}\n", lines.join("\n"))).unwrap();
        let mut javac = Command::new("javac");
        javac.arg("-sourcepath").arg(directory.path()).arg("-d").arg(directory.path()).arg(&robot);
        let done = javac.output().unwrap();
        assert!(done.status.success(), "{class}: {}", String::from_utf8_lossy(&done.stderr));
    }
}

/// Isaac Lab makes an actuator of its own of the configuration: a field that it does not know is refused.
#[test]
fn isaac_labs_configuration_and_the_urdf_hold_the_motors_numbers() {
    let Some(python) = python() else { return };
    let script = concat!(
        include_str!("exported/isaac_lab.py"),
        "
import yourdfpy
scope = {}
exec(open(sys.argv[1] + '.py').read(), scope)
motor = scope['MOTOR']
motor.validate()
assert isinstance(actuator(motor, 'output'), isaaclab.actuators.DCMotor)
joint = yourdfpy.URDF.load(sys.argv[1] + '.urdf', load_meshes=False).joint_map['output']
print(motor.saturation_effort, motor.velocity_limit, motor.armature, motor.friction)
print(joint.limit.effort, joint.limit.velocity, joint.dynamics.damping, joint.dynamics.friction)
"
    );
    let directory = tempfile::tempdir().unwrap();
    let stem = directory.path().join("motor");
    let options = Options { torque_per_volt: Some(0.1), ..OPTIONS };
    let model = model(&[(Kind::Coulomb, &[0.3])]);
    for (format, ending) in [(Format::Isaac, "py"), (Format::Urdf, "urdf")] {
        std::fs::write(stem.with_extension(ending), export(&model, format, &options).unwrap().content)
            .unwrap();
    }
    let ran = Command::new(&python).args(["-c", script]).arg(&stem).output().unwrap();
    let said = String::from_utf8(ran.stdout).unwrap();
    let numbers: Vec<f64> = said.split_whitespace().map(|x| x.parse().unwrap()).collect();
    // A tenth of friction at the no-load speed: the motor's own torque ends a ninth above it.
    let (stall, no_load) = (0.1 * 12.0, 0.9 * 12.0);
    let wanted = [stall, no_load / 0.9, 0.1 * 0.05 / 0.9, 0.03, stall, no_load, 0.1 * 0.1 / 0.9, 0.03];
    assert_eq!(numbers.len(), wanted.len(), "{}", String::from_utf8_lossy(&ran.stderr));
    for (a, b) in numbers.iter().zip(wanted) {
        assert!((a / b - 1.0).abs() < 1e-6, "{numbers:?}");
    }
}

/// Whatever the target: an effect changes the file, or is named as lost.
#[test]
fn no_target_loses_an_effect_in_silence() {
    let options = Options { torque_per_volt: Some(0.1), ..OPTIONS };
    let all = [
        Format::Mujoco,
        Format::Modelica,
        Format::Python,
        Format::C,
        Format::Wpilib,
        Format::Bam,
        Format::Isaac,
        Format::Urdf,
    ];
    for format in all {
        // MuJoCo's bodies want shorter steps than the model's.
        let step_s = options.step_s.filter(|_| format != Format::Mujoco);
        let options = Options { step_s, ..options.clone() };
        let plain = export(&model(&[]), format, &options).unwrap();
        for kind in Kind::ALL.iter().copied().chain([own("y_torque", "torque", "-size * tanh(speed)")]) {
            let spec = kind.spec();
            let sizes: Vec<f64> = spec.parameters.iter().map(|p| p.typical).collect();
            let exported = export(&model(&[(kind, &sizes)]), format, &options).unwrap();
            let named = exported.lost.iter().any(|lost| lost.effect == kind);
            let there = exported.content != plain.content || exported.beside != plain.beside;
            let left = exported.left.iter().any(|left| left.effect == kind);
            assert!(named || there || left, "{format:?} loses {kind} in silence");
            assert!(
                !named || !exported.carried.kinds().contains(&kind),
                "{format:?} says that it loses {kind}, and has it"
            );
        }
    }
}
