//! Exported models run in MuJoCo and by a Modelica compiler, beside motorlens' own simulation.
//!
//! Both come from Python's registry: `MOTORLENS_EXPORT_PYTHON` names a Python that has `mujoco` and `rumoca`, and
//! `cargo xtask test` sets one up. Where it is not set, each test says so and ends.

mod exported;

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use exported::{OPTIONS, formulas, model, own, sets, truth};
use motorlens::export::{Format, export};
use motorlens::model_file::Model;
use motorlens_shared::effects::Kind;

/// Reads volts, a line a millisecond; prints the angle after each.
const MUJOCO: &str = "
import sys, mujoco
m = mujoco.MjModel.from_xml_path(sys.argv[1])
d = mujoco.MjData(m)
for line in sys.stdin:
    d.ctrl[0] = float(line)
    mujoco.mj_step(m, d)
    print(repr(float(d.qpos[0])))
";

/// Drives the model by the sines of [`volts`]; prints the reading after every millisecond.
const MODELICA: &str = "
import sys, rumoca
source = open(sys.argv[1]).read() + '''
model Drive
  Motor motor;
equation
  motor.v = 6*sin(6.283185307179586*time) + 3*sin(17*time);
end Drive;
'''
model = rumoca.Session().loads(source, model='Drive')
config = rumoca.SimConfig(solver='bdf', rtol=1e-9, atol=1e-11)
result = model.simulate((0, 4), dt=1e-3, config=config)
# Events add points of their own: the last one up to each millisecond counts.
times, readings = list(result.time), list(result['motor.reading'])
at = 0
for k in range(1, 4001):
    while at + 1 < len(times) and times[at + 1] <= k * 1e-3 + 1e-9:
        at += 1
    print(repr(float(readings[at])))
";

fn python() -> Option<String> {
    let found = std::env::var("MOTORLENS_EXPORT_PYTHON").ok();
    if found.is_none() {
        let message = b"SKIPPED: MOTORLENS_EXPORT_PYTHON is not set (cargo xtask test sets it)\n";
        let _ = std::io::stderr().write_all(message);
    }
    found
}

/// 4 s of two sines, the mean of each millisecond.
fn volts() -> Vec<f64> {
    let tau = std::f64::consts::TAU;
    let integral = |t: f64| -6.0 / tau * (tau * t).cos() - 3.0 / 17.0 * (17.0 * t).cos();
    (0..4000).map(|k| (integral(f64::from(k + 1) * 1e-3) - integral(f64::from(k) * 1e-3)) * 1e3).collect()
}

fn run(python: &str, script: &str, file: &Path, volts: &[f64]) -> Vec<f64> {
    let mut command = Command::new(python);
    command.args(["-c", script]).arg(file).stdin(Stdio::piped()).stdout(Stdio::piped());
    let mut child = command.spawn().expect("Python starts");
    let mut input = child.stdin.take().expect("a pipe");
    let text: String = volts.iter().map(|v| format!("{v}\n")).collect();
    // A program that makes its own voltage does not read this one.
    let writer = std::thread::spawn(move || drop(input.write_all(text.as_bytes())));
    let output = child.wait_with_output().expect("Python ends");
    writer.join().expect("no panic");
    assert!(output.status.success(), "{}", std::fs::read_to_string(file).unwrap_or_default());
    String::from_utf8(output.stdout).expect("text").lines().map(|l| l.parse().expect("a number")).collect()
}

/// Largest difference as a share of how far the motor turned.
fn disagreement(python: &str, model: &Model, format: Format) -> f64 {
    let directory = tempfile::tempdir().unwrap();
    let (script, name) =
        if format == Format::Mujoco { (MUJOCO, "motor.xml") } else { (MODELICA, "Motor.mo") };
    let file = directory.path().join(name);
    std::fs::write(&file, export(model, format, &OPTIONS).text).unwrap();
    let volts = volts();
    let angles = run(python, script, &file, &volts);
    let truth = truth(model, &volts);
    assert_eq!(angles.len(), truth.len());
    let range = truth.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
    let worst = angles.iter().zip(&truth).fold(0.0_f64, |m, (a, b)| m.max((a - b).abs()));
    println!("{format:?} {:?}: {:.2e} of {range:.3} rad", model.values().kinds(), worst / range);
    worst / range
}

#[test]
fn mujoco_turns_as_far_as_the_model() {
    let Some(python) = python() else { return };
    let expressed = [
        model(&[]),
        model(&[(Kind::Coulomb, &[0.2])]),
        model(&[(Kind::ConstantLoad, &[-0.3])]),
        model(&[(Kind::Gravity, &[0.4, -0.2])]),
        model(&[(Kind::Spring, &[0.5, -0.1]), (Kind::Coulomb, &[0.2])]),
    ];
    for model in expressed {
        assert!(disagreement(&python, &model, Format::Mujoco) < 0.02, "{:?}", model.values().kinds());
    }
}

/// The same numbers, but for the solver's error in the integral of the voltage.
#[test]
fn modelica_compiles_and_runs_like_the_model() {
    let Some(python) = python() else { return };
    for model in sets().into_iter().chain(formulas()) {
        assert!(disagreement(&python, &model, Format::Modelica) < 1e-7, "{:?}", model.values().kinds());
    }
}

#[test]
fn every_effect_is_in_the_modelica_model_and_what_mujoco_lacks_is_named() {
    let plain = |format| export(&model(&[]), format, &OPTIONS).text;
    for kind in Kind::ALL.iter().copied().chain([own("y_torque", "torque", "-size * tanh(speed)")]) {
        let spec = kind.spec();
        let sizes: Vec<f64> = spec.parameters.iter().map(|p| p.typical).collect();
        let with = model(&[(kind, &sizes)]);
        assert_ne!(export(&with, Format::Modelica, &OPTIONS).text, plain(Format::Modelica), "{kind}");
        let mujoco = export(&with, Format::Mujoco, &OPTIONS);
        let named = mujoco.left_out.iter().any(|s| s.contains(kind.name()));
        assert!(named || mujoco.text != plain(Format::Mujoco), "{kind} is silently lost");
    }
}
