//! The built program, run as a user runs it.

use std::path::{Path, PathBuf};
use std::process::{Command, Output, Stdio};

use serde_json::Value;

/// What a run left.
pub struct Ran {
    pub status: i32,
    pub out: String,
    pub err: String,
}

impl Ran {
    /// The one document on standard output.
    #[allow(dead_code)] // each test file is a crate of its own and uses what it needs
    pub fn json(&self) -> Value {
        serde_json::from_str(&self.out).unwrap_or_else(|e| panic!("{e}: {}{}", self.out, self.err))
    }

    /// Panics with both streams unless the status is `status`.
    pub fn ends(self, status: i32) -> Self {
        assert_eq!(self.status, status, "stdout: {}\nstderr: {}", self.out, self.err);
        self
    }
}

/// Runs the program in `directory` with `words`, separated by blanks.
pub fn run(directory: &Path, words: &str) -> Ran {
    ran(&mut command(directory, words))
}

/// What a run of `command` left.
pub fn ran(command: &mut Command) -> Ran {
    let output: Output = command.output().expect("the program starts");
    Ran {
        status: output.status.code().expect("the program ends by itself"),
        out: String::from_utf8(output.stdout).expect("UTF-8"),
        err: String::from_utf8(output.stderr).expect("UTF-8"),
    }
}

/// The same, not yet started.
pub fn command(directory: &Path, words: &str) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motorlens"));
    command.current_dir(directory).args(words.split_whitespace()).stdin(Stdio::null());
    command
}

/// Logs of a motor with Coulomb friction in `directory`/s, at 100 Hz; the options that name them.
#[allow(dead_code)] // each test file is a crate of its own and uses what it needs
pub fn logs(directory: &Path) -> String {
    run(directory, "simulate --effect coulomb=0.4 --rate 100 --out s --quiet").ends(0);
    "s/triangle.csv s/multisine.csv s/prbs.csv --validate s/holdout-multisine-2.csv --motor s/motor.toml"
        .into()
}

/// Files in a directory, sorted.
#[allow(dead_code)]
pub fn files(directory: &Path) -> Vec<PathBuf> {
    let mut list: Vec<PathBuf> =
        std::fs::read_dir(directory).expect("a directory").map(|e| e.expect("an entry").path()).collect();
    list.sort();
    list
}

/// A model file with these effects, each with named parameters, of a motor whose encoder sits on the rotor.
#[allow(dead_code)]
pub fn model(directory: &Path, name: &str, gain: f64, effects: &str) {
    let text = format!(
        r#"{{"schema":1,"rig":{{"gear_ratio":30.0,"encoder_on_motor":true,"nominal_v":12.0,"supply_v":12.0,
        "reference_speed_rad_s":11.0,"count_rad":0.001}},"prior":{{"tau_e":[5e-4,0.4],"viscous_share":[0.08,0.05]}},
        "base":{{"gain":{gain},"tau_m":0.05,"tau_e":6e-4,"viscous_share":0.1}},"effects":[{effects}],
        "origin":{{"motorlens":"","records":[],"method":""}}}}"#
    );
    std::fs::write(directory.join(name), text).expect("a file can be written");
}

/// 0.4 V of dry friction, and a driver that swallows half a volt, as a model file has them.
#[allow(dead_code)]
pub const DRY: &str = r#"{"effect":"coulomb","parameters":[{"name":"level","value":0.4,"unit":"V"}]}"#;
#[allow(dead_code)]
pub const DEAD: &str = r#"{"effect":"dead_zone","parameters":[{"name":"width","value":0.5,"unit":"V"},
    {"name":"offset","value":0.0,"unit":"V"}]}"#;
