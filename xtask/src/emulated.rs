//! Boards emulated in JavaScript (tests/boards), with the host's program at the other end of their line.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, ensure};
use serde_json::Value;

use crate::report::Count;
use crate::{apt, process};

/// What a conversation with an emulated board came to.
#[derive(Debug)]
pub struct Ended {
    /// Whether the host's program was content.
    pub success: bool,
    /// The document that it printed.
    pub document: Value,
    /// What the board said when the line was closed.
    pub board: String,
}

/// Runs `motorlens capture --json` with `options` against the board in `script`, which gets `arguments`. After `seconds`,
/// where given, it is interrupted as by Ctrl-C.
pub fn capture(
    script: &str,
    arguments: &[&OsStr],
    options: &[&str],
    out: &Path,
    seconds: Option<&str>,
) -> Result<Ended> {
    talk(script, arguments, |port| {
        let mut capture = match seconds {
            Some(seconds) => {
                let mut timeout = Command::new("timeout");
                timeout.args(["--preserve-status", "--signal=INT", seconds]).arg(program());
                timeout
            }
            None => Command::new(program()),
        };
        capture.args(["--json", "capture", "--port", port]).args(options).arg("--out").arg(out);
        Ok(capture)
    })
}

/// Starts the board in `script` and runs the command that `talk` makes of its port, after whatever it has run before.
pub fn talk(script: &str, arguments: &[&OsStr], talk: impl FnOnce(&str) -> Result<Command>) -> Result<Ended> {
    prepare()?;
    let mut node = Command::new("node");
    node.current_dir(directory()).arg(script).args(arguments).stdout(Stdio::piped());
    let mut board = node.spawn().with_context(|| format!("cannot start node {script}"))?;
    let mut lines = BufReader::new(board.stdout.take().context("piped above")?);
    let mut first = String::new();
    lines.read_line(&mut first)?;
    let told = (|| {
        let port = first.trim().strip_prefix("port ").with_context(|| format!("{script} said {first:?}"))?;
        talk(&format!("tcp://127.0.0.1:{port}"))?.output().context("cannot start motorlens")
    })();
    if told.is_err() {
        board.kill()?;
    }
    let mut rest = String::new();
    lines.read_to_string(&mut rest)?;
    board.wait()?;
    let told = told?;
    let document = serde_json::from_slice(&told.stdout).with_context(|| {
        format!(
            "no document: {}{}",
            String::from_utf8_lossy(&told.stdout),
            String::from_utf8_lossy(&told.stderr)
        )
    })?;
    Ok(Ended { success: told.status.success(), document, board: rest })
}

/// `motorlens discover --json` on the logs of a directory, those named holdout kept out of every fit.
pub fn discover(directory: &Path) -> Result<Value> {
    let mut discover = Command::new(program());
    discover.args(["--json", "discover"]);
    let mut logs: Vec<PathBuf> =
        std::fs::read_dir(directory)?.map(|entry| Ok(entry?.path())).collect::<Result<_>>()?;
    logs.sort();
    ensure!(!logs.is_empty(), "no logs in {}", directory.display());
    for log in logs {
        if log.file_name().is_some_and(|name| name.to_string_lossy().starts_with("holdout")) {
            discover.arg("--validate");
        }
        discover.arg(log);
    }
    Ok(serde_json::from_str(&process::output(&mut discover)?)?)
}

/// One test, counted and told like cargo's own.
pub fn case(count: &mut Count, name: &str, test: impl FnOnce() -> Result<()>) {
    match test() {
        Ok(()) => {
            println!("test {name} ... ok");
            count.passed += 1;
        }
        Err(error) => {
            println!("test {name} ... FAILED\n{error:?}");
            count.failed += 1;
        }
    }
}

/// An empty directory for a board's logs.
pub fn scratch(name: &str) -> Result<PathBuf> {
    let directory = process::root().join("target/boards").join(name);
    if directory.exists() {
        std::fs::remove_dir_all(&directory)?;
    }
    std::fs::create_dir_all(&directory)?;
    Ok(directory)
}

/// Fetches the emulators and builds the host's program.
fn prepare() -> Result<()> {
    if !directory().join("node_modules").is_dir() {
        // Not everybody's npm is Debian's.
        if Command::new("npm").arg("--version").output().is_err() {
            apt::ensure_apt(&["nodejs", "npm"])?;
        }
        process::run(Command::new("npm").current_dir(directory()).args(["ci", "--no-audit", "--no-fund"]))?;
    }
    process::program().map(|_| ())
}

/// The host's program with these arguments.
pub fn motorlens(arguments: &[&str]) -> Command {
    let mut command = Command::new(program());
    command.args(arguments);
    command
}

fn program() -> PathBuf {
    process::target().join("debug/motorlens")
}

/// Where the emulated boards stand.
fn directory() -> PathBuf {
    process::root().join("tests/boards")
}
