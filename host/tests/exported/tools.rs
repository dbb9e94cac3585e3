//! The tools that exports are for: a Python that has them, and a program for each.
#![allow(dead_code)] // each test file is a crate of its own and uses what it needs

use std::io::Write;
use std::path::Path;
use std::process::{Command, Stdio};

use motorlens::export::Format;

/// Reads volts, a line a millisecond; prints the reading after each. With the program beside the MJCF where there is one.
pub const MUJOCO: &str = "
import sys, pathlib, runpy, mujoco, numpy
m = mujoco.MjModel.from_xml_path(sys.argv[1])
d = mujoco.MjData(m)
angle, speed = map(float, sys.argv[2:4])
beside = pathlib.Path(sys.argv[1]).with_suffix('.py')
motor = runpy.run_path(str(beside))['Motor'](m, d) if beside.exists() else None
if motor:
    motor.reset(d, angle, speed)
else:
    d.qpos[:], d.qvel[:] = angle, speed
    winding = m.actuator_actadr[0] + m.actuator_actnum[0] - 1
    d.act[winding] = speed * m.numeric('holding_current').data[0]
    if m.actuator_delay[0] > 0:
        held = numpy.full((m.actuator_history[0, 0], 1), speed * m.numeric('holding_voltage').data[0])
        mujoco.mj_initCtrlHistory(m, d, 0, None, held)
encoder = m.jnt_qposadr[m.sensor('encoder').objid[0]]
parts = round(1e-3 / m.opt.timestep)
for line in sys.stdin:
    for _ in range(parts):
        if motor:
            reading = motor.step(d, float(line))
        else:
            d.ctrl[0] = float(line)
            mujoco.mj_step(m, d)
            reading = d.qpos[encoder]
    print(repr(float(reading)))
";

/// The same by FMPy, after it has checked the unit.
pub const FMU: &str = "
import sys, numpy, fmpy, fmpy.validation
problems = fmpy.validation.validate_fmu(sys.argv[1])
assert not problems, problems
volts = [float(line) for line in sys.stdin]
signals = numpy.array([(k * 1e-3, v) for k, v in enumerate(volts)], dtype=[('time', float), ('volts', float)])
first = dict(zip(['first_angle', 'first_speed'], map(float, sys.argv[2:4])))
result = fmpy.simulate_fmu(sys.argv[1], start_values=first, input=signals, output=['reading'], stop_time=len(volts) * 1e-3,
                           step_size=1e-3, output_interval=1e-3)
for row in result[1:]:
    print(repr(float(row['reading'])))
";

/// Drives the model by the sines of [`volts`]; prints the reading after every millisecond. Rumoca's explicit solver takes the integral of the
/// voltage to 1e-12; its implicit ones err by 2e-8, and stop at finer tolerances by a check of their own.
pub const MODELICA: &str = "
import sys, rumoca
angle, speed = map(float, sys.argv[2:4])
source = open(sys.argv[1]).read() + f'''
model Drive
  Motor motor(first_angle={angle!r}, first_speed={speed!r});
equation
  motor.v = 6*sin(6.283185307179586*time) + 3*sin(17*time);
end Drive;
'''
model = rumoca.Session().loads(source, model='Drive')
config = rumoca.SimConfig(solver='rk-like', rtol=1e-9, atol=1e-11)
result = model.simulate((0, 4), dt=1e-3, config=config)
# Events add points of their own: the last one up to each millisecond counts.
times, readings = list(result.time), list(result['motor.reading'])
at = 0
for k in range(1, 4001):
    while at + 1 < len(times) and times[at + 1] <= k * 1e-3 + 1e-9:
        at += 1
    print(repr(float(readings[at])))
";

/// The same with volts that are held: a line a millisecond, of which few differ from the line before.
pub const HELD_MODELICA: &str = "
import sys, rumoca
volts = [float(line) for line in sys.stdin]
changes = [k for k in range(1, len(volts)) if volts[k] != volts[k - 1]]
pieces = ' '.join(f'if time < {k * 1e-3!r} then {volts[k - 1]!r} else' for k in changes)
angle, speed = map(float, sys.argv[2:4])
source = open(sys.argv[1]).read() + f'''
model Drive
  Motor motor(first_angle={angle!r}, first_speed={speed!r});
equation
  motor.v = {pieces} {volts[-1]!r};
end Drive;
'''
model = rumoca.Session().loads(source, model='Drive')
config = rumoca.SimConfig(solver='rk-like', rtol=1e-9, atol=1e-11)
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

/// How a run begins: the first angle (rad) and speed (rad/s), and the voltage before (V).
pub type Begin = [f64; 3];
pub const AT_REST: Begin = [0.0; 3];

/// Runs `script` on `file` under `volts`.
pub fn run(python: &str, script: &str, file: &Path, volts: &[f64], begin: Begin) -> Vec<f64> {
    let mut command = Command::new(python);
    command
        .args(["-c", script])
        .arg(file)
        .args(begin.map(|x| format!("{x:?}")))
        .stdin(Stdio::piped())
        .stdout(Stdio::piped());
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

/// What each target is run by, in the order of the table below: the tool itself, or of Isaac Lab, whose simulator needs a graphics card, its
/// actuator. Its arguments are the file and how the run begins; volts a line a millisecond in, the
/// reading after each out.
pub const TARGETS: [Target; 9] = [
    (
        Format::C,
        "motor.c",
        "import subprocess, sys
binary = sys.argv[1] + '.bin'
subprocess.check_call(['cc', '-std=c99', '-O1', '-DMOTOR_MAIN', '-o', binary, sys.argv[1], '-lm'])
sys.exit(subprocess.call([binary, *sys.argv[2:4]]))",
        "cc",
    ),
    (
        Format::Python,
        "motor.py",
        "import runpy, sys; file = sys.argv.pop(1); runpy.run_path(file, run_name='__main__')",
        "Python",
    ),
    (Format::Modelica, "Motor.mo", MODELICA, "rumoca"),
    (Format::Fmu, "motor.fmu", FMU, "FMPy"),
    (Format::Mujoco, "motor.xml", MUJOCO, "MuJoCo"),
    (Format::Urdf, "motor.urdf", include_str!("urdf.py"), "MuJoCo"),
    (Format::Wpilib, "motor.txt", include_str!("wpilib.py"), "WPILib"),
    (Format::Bam, "motor.json", include_str!("bam.py"), "BAM"),
    (Format::Isaac, "isaac.py", concat!(include_str!("isaac_lab.py"), include_str!("isaac.py")), "Isaac Lab"),
];
