//! The bar of every export: run in its own tool against a record, it errs by at most a hundredth more than the model does, or it
//! is refused. That error is `compare`'s own number, and every target begins as the model does there: at the record's first angle, and in
//! motion where the record is.

mod exported;
mod program;
#[path = "exported/tools.rs"]
mod tools;

use std::ops::ControlFlow;
use std::path::Path;
use std::time::{Duration, Instant};

use exported::{OPTIONS, model, truth};
use motorlens::compare::free_run::{free_runs, within_a_count};
use motorlens::compare::problem_of;
use motorlens::estimate;
use motorlens::export::cost::cost;
use motorlens::export::{Format, Options, export};
use motorlens::log::{self, ReadOptions, Record};
use motorlens::model_file::Model;
use motorlens::motor_file::{self, MotorFile};
use motorlens::{Error, Event};
use motorlens_shared::effects::Kind;
use tools::{Begin, HELD_MODELICA, MUJOCO, TARGETS, Target, python, run, volts};

/// Effects with their parameters.
type Effects = &'static [(Kind, &'static [f64])];

/// A record, its voltage in steps of a millisecond, and which of the readings after each step it measured.
struct Measured {
    record: Record,
    motor: MotorFile,
    volts: Vec<f64>,
    readings: Vec<(usize, f64)>,
    /// How `compare` begins, and what the model then misses the first reading by.
    begin: Begin,
    first_error: f64,
    /// What an angle may be moved by: an encoder begins anywhere within a count.
    count: f64,
    /// The model's own error by `compare`.
    own: f64,
}

impl Measured {
    fn new(model: &Model, record: &Record, motor: &MotorFile) -> Self {
        let problem = problem_of(model, std::slice::from_ref(record), motor).unwrap();
        let run = free_runs(&problem, &model.values()).remove(0);
        let (rig, speed) = (model.rig(1e-3), run.first_speed_rad_s);
        let first = record.angle_rad.as_ref().expect("it measures its angle")[0];
        let trail = first - model.start_moving(1e-3, first, speed).angle_rad();
        let steps: Vec<usize> =
            record.time_s.iter().map(|t| ((t - record.time_s[0]) * 1e3).round() as usize).collect();
        let volts =
            steps.windows(2).zip(&record.voltage_v).flat_map(|(w, v)| vec![*v; w[1] - w[0]]).collect();
        let angle = record.angle_rad.as_deref().expect("it measures its angle");
        Self {
            record: record.clone(),
            motor: motor.clone(),
            volts,
            readings: steps.iter().zip(angle).skip(1).map(|(step, x)| (step - 1, *x)).collect(),
            // The shaft is ahead of a filtered reading.
            begin: [angle[0] + trail, speed, speed * rig.nominal_v / rig.reference_speed],
            first_error: angle[0] - model.start_moving(1e-3, angle[0] + trail, speed).angle_rad(),
            count: problem.grids[0].offset(),
            own: run.measures().rmse,
        }
    }

    /// Root mean square of what `run` misses it by.
    fn error(&self, run: &[f64]) -> f64 {
        let later = self.readings.iter().map(|(step, x)| x - run[*step]);
        let errors: Vec<f64> = std::iter::once(self.first_error).chain(later).collect();
        let within = within_a_count(errors.iter().copied(), self.count);
        let sum: f64 = errors.iter().map(|error| (error - within).powi(2)).sum();
        (sum / errors.len() as f64).sqrt()
    }
}

/// Runs each of `targets` that takes `model`, and says which.
fn targets_that_take(
    python: &str,
    targets: &[Target],
    name: &str,
    model: &Model,
    measured: &Measured,
) -> Vec<Format> {
    let own = measured.own;
    let (mut taken, mut worse) = (Vec::new(), Vec::new());
    for (format, file, script, tool) in targets {
        let step_s = if *format == Format::Mujoco { None } else { OPTIONS.step_s };
        let options = Options { step_s, torque_per_volt: Some(0.1), ..OPTIONS };
        let exported = export(model, *format, &options).unwrap();
        let records = std::slice::from_ref(&measured.record);
        let price =
            cost(model, &exported, records, &measured.motor, None, &mut |_| ControlFlow::Continue(()));
        let price = price.unwrap();
        if !exported.lost.is_empty() || price.is_too_high() {
            println!("{name:<10} {format:?}: refused");
            continue;
        }
        let directory = tempfile::tempdir().unwrap();
        let path = directory.path().join(file);
        // Joints that leave weight and hoist to the robot are given a robot that has them.
        let effects = model.values().effects;
        let of = |kind: Kind, place: usize| {
            let found = effects.iter().find(|(other, _)| *other == kind);
            0.1 * found.map_or(0.0, |(_, parameters)| parameters[place])
        };
        let robot = [of(Kind::Gravity, 0), of(Kind::Gravity, 1), of(Kind::ConstantLoad, 0)];
        std::fs::write(format!("{}.robot", path.display()), robot.map(|x| x.to_string()).join(" ")).unwrap();
        std::fs::write(&path, &exported.content).unwrap();
        if let Some((ending, text)) = &exported.beside {
            std::fs::write(path.with_extension(ending), text).unwrap();
        }
        let is_held = *format == Format::Modelica && measured.volts != volts();
        let script = if is_held { HELD_MODELICA } else { script };
        let there = measured.error(&run(python, script, &path, &measured.volts, measured.begin));
        println!("{name:<10} {format:?}: {there:.5} rad in {tool}, {own:.5} rad by the model");
        taken.push(*format);
        if there > 1.01 * own {
            worse.push(format!("{name} in {format:?}: {there} rad, {own} rad by the model"));
        }
    }
    assert!(worse.is_empty(), "{worse:#?}");
    taken
}

/// Loads, friction, gear, driver and sensor, on the record of a motor that the model meets to half a percent, read by an encoder.
#[test]
fn every_target_has_the_models_own_error_on_a_record_or_is_refused() {
    let Some(python) = python() else { return };
    let cases: [(&str, Effects); 11] = [
        ("plain", &[]),
        ("friction", &[(Kind::Coulomb, &[0.2])]),
        ("dead zone", &[(Kind::Coulomb, &[0.2]), (Kind::DeadZone, &[0.4, 0.0])]),
        ("arm", &[(Kind::Gravity, &[0.8, -0.3]), (Kind::Coulomb, &[0.2])]),
        ("hoist", &[(Kind::ConstantLoad, &[0.5]), (Kind::Coulomb, &[0.3])]),
        ("spring", &[(Kind::Spring, &[0.5, -0.1]), (Kind::Saturation, &[0.5])]),
        ("delay", &[(Kind::Delay, &[0.0061]), (Kind::Stribeck, &[0.2, 0.3, 0.2, 0.4])]),
        ("late", &[(Kind::Delay, &[0.0061])]),
        ("worm gear", &[(Kind::LoadFriction, &[0.2, 0.3]), (Kind::Coulomb, &[0.1])]),
        ("backlash", &[(Kind::Backlash, &[0.05, 0.4, 0.3, 120.0, 0.4]), (Kind::Coulomb, &[0.2])]),
        (
            "shaft",
            &[(Kind::Compliance, &[8.0, 0.4, 0.05, 0.3]), (Kind::Cogging, &[0.2, -0.1, 0.05, -0.02, 3.0])],
        ),
    ];
    let volts = volts();
    let time: Vec<f64> = (0..=volts.len()).map(|k| k as f64 * 1e-3).collect();
    let mut taken = Vec::new();
    for (name, effects) in cases {
        let mut fitted = model(effects);
        let angles: Vec<f64> = truth(&fitted, &volts).iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
        fitted.base.gain *= 1.005;
        let (logged, held) = ([&[0.0], angles.as_slice()].concat(), [volts.as_slice(), &[0.0]].concat());
        let record = motorlens::record("record", &time, &held, motorlens::Measured::Angle(&logged)).unwrap();
        let measured = Measured::new(&fitted, &record, &MotorFile::default());
        let takes = targets_that_take(&python, &TARGETS, name, &fitted, &measured);
        // A delay by itself is in the comments of its lines.
        assert!(name != "late" || takes.contains(&Format::Wpilib), "{takes:?}");
        taken.extend(takes);
    }
    let times = |format: Format| taken.iter().filter(|other| **other == format).count();
    assert!(TARGETS[..5].iter().all(|(format, ..)| times(*format) == cases.len()), "{taken:?}");
    assert!(TARGETS.iter().all(|(format, ..)| times(*format) > 0), "{taken:?}");
}

/// What `export` says of a target that is MuJoCo's is what MuJoCo makes of it, and with steps that are too long it is refused.
#[test]
fn an_export_to_mujoco_is_judged_by_mujocos_own_run() {
    let Some(python) = python() else { return };
    let cases: [Effects; 2] =
        [&[(Kind::Coulomb, &[0.2])], &[(Kind::Delay, &[0.0061]), (Kind::DeadZone, &[0.4, 0.0])]];
    for effects in cases {
        let exact = model(effects);
        let volts = volts();
        let angles: Vec<f64> = truth(&exact, &volts).iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
        let mut fitted = model(effects);
        fitted.base.gain *= 1.005;
        let time: Vec<f64> = (0..=volts.len()).map(|k| k as f64 * 1e-3).collect();
        let (logged, held) = ([&[0.0], angles.as_slice()].concat(), [volts.as_slice(), &[0.0]].concat());
        let record = motorlens::record("record", &time, &held, motorlens::Measured::Angle(&logged)).unwrap();
        let measured = Measured::new(&fitted, &record, &MotorFile::default());
        let price = |fitted: &Model, step_s| {
            let exported = export(fitted, Format::Mujoco, &Options { step_s, ..OPTIONS }).unwrap();
            let records = std::slice::from_ref(&record);
            let mut told = 0.0;
            let python = Some(Path::new(&python));
            let price = cost(fitted, &exported, records, &measured.motor, python, &mut |event| {
                if let Event::Running { share } = event {
                    told = *share;
                }
                ControlFlow::Continue(())
            });
            let price = price.unwrap();
            assert_eq!((price.tool, price.not_run.as_deref(), told), (Some("MuJoCo"), None, 1.0));
            (exported, price)
        };
        let (exported, usual) = price(&fitted, None);
        let directory = tempfile::tempdir().unwrap();
        let file = directory.path().join("motor.xml");
        std::fs::write(&file, &exported.content).unwrap();
        if let Some((ending, text)) = &exported.beside {
            std::fs::write(file.with_extension(ending), text).unwrap();
        }
        let there = measured.error(&run(&python, MUJOCO, &file, &measured.volts, measured.begin));
        let [own, told] = usual.errors.unwrap();
        assert!((own / measured.own - 1.0).abs() < 1e-9, "{own} {}", measured.own);
        assert!((told / there - 1.0).abs() < 1e-3, "{told} {there}");
        assert!(!usual.is_too_high(), "{usual:?}");
        // Of a model without an error the step's own cannot cancel any.
        let (_, long) = price(&exact, Some(2e-3));
        assert!(long.is_too_high() && long.better_step_s().is_none(), "{long:?}");
    }
}

/// A minute of a motor, which MuJoCo takes seconds for.
#[test]
fn a_run_in_mujoco_ends_when_whoever_watches_it_stops_it() {
    let Some(python) = python() else { return };
    let fitted = model(&[(Kind::Coulomb, &[0.2]), (Kind::DeadZone, &[0.4, 0.0])]);
    let volts = volts().repeat(15);
    let time: Vec<f64> = (0..volts.len()).map(|k| k as f64 * 1e-3).collect();
    let angles = truth(&fitted, &volts);
    let record = motorlens::record("record", &time, &volts, motorlens::Measured::Angle(&angles)).unwrap();
    let exported = export(&fitted, Format::Mujoco, &Options { step_s: None, ..OPTIONS }).unwrap();
    let mut asked = None;
    let python = Some(Path::new(&python));
    let stopped =
        cost(&fitted, &exported, &[record], &MotorFile::default(), python, &mut |event| match event {
            Event::Running { share } => {
                assert!(*share < 1.0, "it ended before it could be stopped");
                asked = Some(Instant::now());
                ControlFlow::Break(())
            }
            _ => ControlFlow::Continue(()),
        });
    assert!(matches!(stopped, Err(Error::Cancelled)), "{stopped:?}");
    assert!(asked.is_some_and(|asked| asked.elapsed().as_secs_f64() < 2.0));
}

/// Ctrl-C ends the program; what it has begun in MuJoCo ends with it and leaves no file.
#[test]
fn mujocos_run_ends_with_the_program_that_began_it() {
    let Some(python) = python() else { return };
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    program::run(here, "simulate --effect coulomb=0.4 --rate 100 --seconds 60 --out s --quiet").ends(0);
    program::model(here, "m.json", 0.9, program::DEAD);
    let made = here.join("made");
    std::fs::create_dir(&made).unwrap();
    let words = "export m.json -f mujoco -o m.xml --on s/prbs.csv --motor s/motor.toml --quiet";
    let mut started =
        program::command(here, words).env("PYTHON", python).env("TMPDIR", &made).spawn().unwrap();
    let until = |what: &str, holds: &dyn Fn() -> bool| {
        let begun = Instant::now();
        while !holds() {
            assert!(begun.elapsed().as_secs() < 60, "{what}");
            std::thread::sleep(Duration::from_millis(10));
        }
    };
    // One directory for each run.
    let has_begun = || {
        let mut runs = std::fs::read_dir(&made).unwrap().flatten();
        runs.any(|run| run.path().join("motor.volts").exists())
    };
    until("MuJoCo is not begun", &has_begun);
    // Python is begun right after its files are written.
    std::thread::sleep(Duration::from_millis(500));
    started.kill().unwrap();
    assert!(!started.wait().unwrap().success(), "it ended before it was stopped");
    until("its files are left", &|| std::fs::read_dir(&made).unwrap().next().is_none());
}

/// The same where the record begins in motion: friction, a late voltage and a filtered reading have a past there.
#[test]
fn every_target_begins_in_motion_where_the_record_does() {
    let Some(python) = python() else { return };
    let cases: [(&str, Effects); 5] = [
        ("plain", &[]),
        ("late", &[(Kind::Delay, &[0.0061]), (Kind::Coulomb, &[0.2])]),
        ("filter", &[(Kind::SensorLag, &[0.012, 0.0]), (Kind::DeadZone, &[0.4, 0.0])]),
        ("bell", &[(Kind::Stribeck, &[0.2, 0.3, 0.2, 0.0])]),
        ("shaft", &[(Kind::Compliance, &[8.0, 0.4, 0.05, 0.3]), (Kind::Gravity, &[0.4, -0.2])]),
    ];
    let volts: Vec<f64> = (0..3000).map(|k| [8.0, -5.0, 2.0, 0.0, 6.0, -3.0][k / 500]).collect();
    for (name, effects) in cases {
        let mut fitted = model(effects);
        let angles: Vec<f64> = truth(&fitted, &volts).iter().map(|x| (x / 1e-3).round() * 1e-3).collect();
        fitted.base.gain *= 1.005;
        // From the end of step 700 on, at more than 4 rad/s backward.
        let (logged, held) = (&angles[700..], &volts[701..]);
        let time: Vec<f64> = (0..logged.len()).map(|k| k as f64 * 1e-3).collect();
        let held = [held, &[0.0]].concat();
        let record = motorlens::record("record", &time, &held, motorlens::Measured::Angle(logged)).unwrap();
        let measured = Measured::new(&fitted, &record, &MotorFile::default());
        assert!(measured.begin[1].abs() > 0.5, "{name} begins at {:?}", measured.begin);
        let taken = targets_that_take(&python, &TARGETS, name, &fitted, &measured);
        assert!(TARGETS[..5].iter().all(|(format, ..)| taken.contains(format)), "{name}: {taken:?}");
    }
}

/// The logs of a teaching rig: two to fit, and a step that is kept out.
struct Rig {
    motor: MotorFile,
    training: Vec<Record>,
    kept_out: Record,
}

fn rig() -> Rig {
    let rig = Path::new(env!("CARGO_MANIFEST_DIR")).join("../python/examples/data/undcmotor-angle");
    let motor = motor_file::read(&rig.join("motor.toml")).unwrap();
    let options = ReadOptions { motor: motor.clone(), ..ReadOptions::default() };
    let read = |file: &str| log::read(&rig.join(file), &options).unwrap();
    let training = [read("train/profile.csv"), read("train/stairs.csv")].concat();
    Rig { motor, training, kept_out: read("validation/step.csv").remove(0) }
}

/// A model that was discovered on the logs of a teaching rig, on the step that was kept out of it: `compare` begins it in motion.
#[test]
fn every_target_has_the_models_own_error_on_a_real_record_or_is_refused() {
    let Some(python) = python() else { return };
    let rig = rig();
    let how = motorlens::Options { motor: rig.motor.clone(), ..motorlens::Options::default() };
    let found =
        motorlens::discover_records(&rig.training, &how, &mut |_| ControlFlow::Continue(())).unwrap().model;
    let measured = Measured::new(&found, &rig.kept_out, &rig.motor);
    println!("{:?} from {:?}", found.values(), measured.begin);
    let taken = targets_that_take(&python, &TARGETS, "real", &found, &measured);
    assert!(TARGETS[..5].iter().all(|(format, ..)| taken.contains(format)), "{taken:?}");
}

/// Two bodies in MuJoCo, with what a fit makes of gap and shaft on the logs of a rig, on each of its logs. The model's own error is that in
/// steps of a millisecond, as every export's: where the rig creeps and sticks, a motor with a gap goes another way with each rounding.
#[test]
fn mujoco_errs_as_the_model_does_with_two_bodies_on_every_log_of_a_rig() {
    let Some(python) = python() else { return };
    let rig = rig();
    let mujoco = TARGETS.map(|target| (target.0 == Format::Mujoco).then_some(target));
    let mujoco: Vec<_> = mujoco.into_iter().flatten().collect();
    for between in [Kind::Backlash, Kind::Compliance] {
        let how = estimate::Options { effects: vec![Kind::Coulomb, between], ..estimate::Options::default() };
        let fitted = estimate::fit(&rig.training, &[], &rig.motor, &how, &mut |_, _| {}).unwrap().model;
        for record in rig.training.iter().chain([&rig.kept_out]) {
            let mut measured = Measured::new(&fitted, record, &rig.motor);
            let [angle, speed, _] = measured.begin;
            let mut motor = fitted.start_moving(1e-3, angle, speed);
            let run: Vec<f64> = measured.volts.iter().map(|v| motor.step(*v)).collect();
            measured.own = measured.error(&run);
            let taken = targets_that_take(&python, &mujoco, between.name(), &fitted, &measured);
            assert_eq!(taken, [Format::Mujoco]);
        }
    }
}
