//! The tools that exports are for: a Python that has them, and a program for each.
#![allow(dead_code)] // each test file is a crate of its own and uses what it needs

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use motorlens::export::Format;

/// Reads volts, a line a millisecond; prints the reading after each. With the program beside the MJCF where there is one.
pub const MUJOCO: &str = "
import sys, pathlib, runpy, mujoco
m = mujoco.MjModel.from_xml_path(sys.argv[1])
d = mujoco.MjData(m)
beside = pathlib.Path(sys.argv[1]).with_suffix('.py')
motor = runpy.run_path(str(beside))['Motor'](m, d) if beside.exists() else None
parts = round(1e-3 / m.opt.timestep)
for line in sys.stdin:
    for _ in range(parts):
        if motor:
            reading = motor.step(d, float(line))
        else:
            d.ctrl[0] = float(line)
            mujoco.mj_step(m, d)
            reading = d.qpos[0]
    print(repr(float(reading)))
";

/// The same by FMPy, after it has checked the unit.
pub const FMU: &str = "
import sys, numpy, fmpy, fmpy.validation
problems = fmpy.validation.validate_fmu(sys.argv[1])
assert not problems, problems
volts = [float(line) for line in sys.stdin]
signals = numpy.array([(k * 1e-3, v) for k, v in enumerate(volts)], dtype=[('time', float), ('volts', float)])
result = fmpy.simulate_fmu(sys.argv[1], input=signals, output=['reading'], stop_time=len(volts) * 1e-3, step_size=1e-3,
                           output_interval=1e-3)
for row in result[1:]:
    print(repr(float(row['reading'])))
";

/// Drives the model by the sines of [`volts`]; prints the reading after every millisecond.
pub const MODELICA: &str = "
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

/// The same with volts that are held: a line a millisecond, of which few differ from the line before. Under a step of the voltage rumoca's
/// own check of its interpolation stops it at finer tolerances.
pub const HELD_MODELICA: &str = "
import sys, rumoca
volts = [float(line) for line in sys.stdin]
changes = [k for k in range(1, len(volts)) if volts[k] != volts[k - 1]]
pieces = ' '.join(f'if time < {k * 1e-3!r} then {volts[k - 1]!r} else' for k in changes)
source = open(sys.argv[1]).read() + f'''
model Drive
  Motor motor;
equation
  motor.v = {pieces} {volts[-1]!r};
end Drive;
'''
model = rumoca.Session().loads(source, model='Drive')
config = rumoca.SimConfig(solver='bdf', rtol=1e-6, atol=1e-8)
result = model.simulate((0, len(volts) * 1e-3), dt=1e-3, config=config)
times, readings = list(result.time), list(result['motor.reading'])
at = 0
for k in range(1, len(volts) + 1):
    while at + 1 < len(times) and times[at + 1] <= k * 1e-3 + 1e-9:
        at += 1
    print(repr(float(readings[at])))
";

pub fn python() -> Option<String> {
    let found = std::env::var("MOTORLENS_EXPORT_PYTHON").ok();
    if found.is_none() {
        let message = b"SKIPPED: MOTORLENS_EXPORT_PYTHON is not set (cargo xtask test sets it)\n";
        let _ = std::io::stderr().write_all(message);
    }
    found
}

/// 4 s of two sines, the mean of each millisecond.
pub fn volts() -> Vec<f64> {
    let tau = std::f64::consts::TAU;
    let integral = |t: f64| -6.0 / tau * (tau * t).cos() - 3.0 / 17.0 * (17.0 * t).cos();
    (0..4000).map(|k| (integral(f64::from(k + 1) * 1e-3) - integral(f64::from(k) * 1e-3)) * 1e3).collect()
}

pub fn run(python: &str, script: &str, file: &Path, volts: &[f64]) -> Vec<f64> {
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

/// A format, the file that it is written to, the program that runs it, and the tool in which.
pub type Target = (Format, &'static str, &'static str, &'static str);

/// What each target is run by, in the order of the table below: the tool itself, or for Isaac Lab, whose simulator needs a graphics
/// card, the equations of its documentation. Volts a line a millisecond in, the reading after each out.
pub const TARGETS: [Target; 9] = [
    (
        Format::C,
        "motor.c",
        "import subprocess, sys
binary = sys.argv[1] + '.bin'
subprocess.check_call(['cc', '-std=c99', '-O1', '-DMOTOR_MAIN', '-o', binary, sys.argv[1], '-lm'])
sys.exit(subprocess.call([binary]))",
        "cc",
    ),
    (
        Format::Python,
        "motor.py",
        "import runpy, sys; runpy.run_path(sys.argv[1], run_name='__main__')",
        "Python",
    ),
    (Format::Modelica, "Motor.mo", MODELICA, "rumoca"),
    (Format::Fmu, "motor.fmu", FMU, "FMPy"),
    (Format::Mujoco, "motor.xml", MUJOCO, "MuJoCo"),
    (Format::Urdf, "motor.urdf", include_str!("urdf.py"), "MuJoCo"),
    (Format::Wpilib, "motor.txt", include_str!("wpilib.py"), "WPILib"),
    (Format::Bam, "motor.json", include_str!("bam.py"), "BAM"),
    (Format::Isaac, "isaac.py", include_str!("isaac.py"), "its equations"),
];
