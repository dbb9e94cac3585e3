//! Child processes: where they run, how they fail.

use std::io::{BufRead, BufReader, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use anyhow::{Context, Result, bail};

use crate::report::{Count, Listener};

/// The top of the repository.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .expect("xtask stands one level below the top")
        .to_path_buf()
}

/// `cargo` as it was called, in the top directory, with colours off so that logs stay readable.
pub fn cargo() -> Command {
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.current_dir(root()).env("CARGO_TERM_COLOR", "never");
    // Set by the `cargo run` that started this program; they describe xtask, not what is built next.
    for name in ["CARGO_MANIFEST_DIR", "CARGO_MANIFEST_PATH", "CARGO_PKG_NAME", "CARGO_PKG_VERSION"] {
        command.env_remove(name);
    }
    command
}

/// Builds the host's program, and returns its path.
///
/// With the features that `cargo test --workspace` chooses, so that after the host's own tests nothing is left to build:
/// alone, the package would get fewer features of its dependencies and be compiled once more.
pub fn program() -> Result<PathBuf> {
    run(cargo().args(["test", "--workspace", "--locked", "--no-run", "--test", "terminal"]))?;
    Ok(target().join("debug/motorlens"))
}

/// Where cargo puts what it builds.
pub fn target() -> PathBuf {
    std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| root().join("target"), PathBuf::from)
}

/// Runs a command with its output passed through. Fails with the command line when its status is not zero.
pub fn run(command: &mut Command) -> Result<()> {
    let line = describe(command);
    let status = command.status().with_context(|| format!("cannot start: {line}"))?;
    if !status.success() {
        bail!("{status}: {line}");
    }
    Ok(())
}

/// Runs a command, keeps its standard output, lets its standard error through.
pub fn output(command: &mut Command) -> Result<String> {
    let line = describe(command);
    let output =
        command.stderr(Stdio::inherit()).output().with_context(|| format!("cannot start: {line}"))?;
    if !output.status.success() {
        bail!("{}: {line}", output.status);
    }
    String::from_utf8(output.stdout).with_context(|| format!("output is not UTF-8: {line}"))
}

/// Runs a test command, passes its output through line by line, and counts what its `test result:` lines report.
/// A failing status with no failed test counted (a build error, say) is itself one failure.
pub fn run_tests(command: &mut Command) -> Result<Count> {
    let line = describe(command);
    let mut child =
        command.stdout(Stdio::piped()).spawn().with_context(|| format!("cannot start: {line}"))?;
    let mut listener = Listener::default();
    let out = child.stdout.take().expect("piped above");
    for text in BufReader::new(out).split(b'\n') {
        let text = text?;
        std::io::stdout().write_all(&text)?;
        println!();
        listener.hear(&String::from_utf8_lossy(&text));
    }
    let status = child.wait()?;
    let mut count = listener.count;
    if !status.success() {
        println!("{status}: {line}");
        count.failed = count.failed.max(1);
    }
    Ok(count)
}

fn describe(command: &Command) -> String {
    let mut words = vec![command.get_program().to_string_lossy().into_owned()];
    words.extend(command.get_args().map(|word| word.to_string_lossy().into_owned()));
    words.join(" ")
}
