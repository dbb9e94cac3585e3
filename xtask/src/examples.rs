//! The examples of the library and of its virtual motor, run: each answers rightly on a small input.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::process;
use crate::report::Count;

/// What an example is given on its command line, and what looks at its output.
type Example = (&'static str, fn() -> Vec<PathBuf>, fn(&str, &Path) -> Result<()>);

/// Where they stand.
const DIRECTORIES: [&str; 2] = ["host/examples", "host/virtual-motor/examples"];

const EXAMPLES: [Example; 5] = [
    ("arrays", Vec::new, |said, _| {
        near(said, "gain = ", 0.9, 0.02)?;
        near(said, "dead_zone.width = ", 1.0, 0.05)
    }),
    ("own_effect", Vec::new, |said, _| {
        let names = said.trim_end().rsplit(": ").next().unwrap_or_default();
        ensure!(names.split(", ").any(|name| name == "fan"), "the fan is not among its effects: {said}");
        Ok(())
    }),
    // 3 V less 0.4 V of friction drive 0.9 rad/s a volt, from 0.05 s on; the controller stops where 20 V/rad give less than the friction.
    (
        "simulate",
        || vec![process::root().join("host/examples/model.json")],
        |said, _| {
            near(said, "after a second of 3 V: ", 2.22, 0.03)?;
            near(said, "1 rad: ", 1.0, 0.025)
        },
    ),
    (
        "csv",
        || ["run.csv", "--validate", "unseen.csv", "--motor", "motor.toml"].map(PathBuf::from).to_vec(),
        |said, here| {
            ensure!(said.lines().count() == 1, "it tells one line: {said}");
            let text = std::fs::read_to_string(here.join("model.json")).context("it writes no model.json")?;
            let model: serde_json::Value = serde_json::from_str(&text)?;
            let gain = model["base"]["gain"].as_f64().context("its model has no gain")?;
            ensure!((gain - 0.9).abs() < 0.02, "its model has a gain of {gain}, and the motor one of 0.9");
            ensure!(model["rig"]["gear_ratio"] == 30.0, "it does not heed the motor file: {}", model["rig"]);
            let effects = model["effects"].as_array().context("its model has no list of effects")?;
            ensure!(effects.iter().any(|e| e["effect"] == "coulomb"), "it misses the friction: {effects:?}");
            Ok(())
        },
    ),
    // How fast they run is up to the machine; that each effect runs for its 10 s is not.
    ("speed", Vec::new, |said, _| {
        for line in said.lines() {
            ensure!(line.ends_with(" x real time, 10000 rows"), "a line of another kind: {line}");
        }
        for name in ["none", "coulomb", "backlash"] {
            let told = said.lines().any(|line| line.split_whitespace().next() == Some(name));
            ensure!(told, "no line for {name}: {said}");
        }
        Ok(())
    }),
];

/// Builds all, with what `cargo test --workspace` built used again, and runs each in a directory of its own.
pub fn tests() -> Result<Count> {
    process::run(process::cargo().args(["build", "--workspace", "--locked", "--examples"]))?;
    let mut files = Vec::new();
    for directory in DIRECTORIES {
        for entry in std::fs::read_dir(process::root().join(directory))? {
            files.push(entry?.path());
        }
    }
    for file in files.iter().filter(|file| file.extension().is_some_and(|ending| ending == "rs")) {
        let known = EXAMPLES.iter().any(|(name, ..)| file.file_stem().is_some_and(|stem| stem == *name));
        ensure!(known, "{} is run by nobody: say in xtask/src/examples.rs what it answers", file.display());
    }
    for (name, arguments, holds) in EXAMPLES {
        let here = process::target().join("examples-run").join(name);
        if here.exists() {
            std::fs::remove_dir_all(&here)?;
        }
        std::fs::create_dir_all(&here)?;
        std::fs::write(here.join("run.csv"), log(&[6.0, 0.0, -4.0, 2.0, 9.0, -7.0, 1.5, -1.2]))?;
        std::fs::write(here.join("unseen.csv"), log(&[-3.0, 7.0, 0.0, -8.0, 4.0, 1.0, -2.0, 5.0]))?;
        std::fs::write(here.join("motor.toml"), "gear_ratio = 30\n")?;
        let mut example = Command::new(process::target().join("debug/examples").join(name));
        let said = process::output(example.current_dir(&here).args(arguments()))?;
        holds(&said, &here).with_context(|| format!("example {name}"))?;
    }
    Ok(Count { passed: EXAMPLES.len() as u64, ..Count::default() })
}

/// Whether the number behind `words` is `wanted`, but for `off`.
fn near(said: &str, words: &str, wanted: f64, off: f64) -> Result<()> {
    let (_, rest) = said.split_once(words).with_context(|| format!("no \"{words}\" in: {said}"))?;
    let number = rest.split_whitespace().next().unwrap_or_default();
    let number: f64 = number.parse().with_context(|| format!("\"{number}\" behind \"{words}\""))?;
    ensure!((number - wanted).abs() <= off, "{words}{number}, not {wanted}");
    Ok(())
}

/// A log of a motor with 0.6 V of dry friction under steps of 0.5 s: 4 s at 500 Hz, an angle in counts of a milliradian.
fn log(steps: &[f64]) -> String {
    let (mut angle, mut speed) = (0.0_f64, 0.0_f64);
    let mut text = "time_s,voltage_v,angle_rad\n".to_owned();
    for k in 0..2000 {
        let volts = steps[k / 250 % steps.len()];
        // Writing to a string does not fail.
        let _ = writeln!(text, "{:.3},{volts},{:.3}", k as f64 * 2e-3, (angle / 1e-3).round() * 1e-3);
        for _ in 0..20 {
            let free = speed + 1e-4 * (0.9 * volts - speed) / 0.05;
            speed = free.signum() * (free.abs() - 1e-4 * 0.9 * 0.6 / 0.05).max(0.0);
            angle += 1e-4 * speed;
        }
    }
    text
}
