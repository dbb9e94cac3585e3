//! Emulated boards, with the host's program at the other end of their line: a script of tests/boards, or a program of its own.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader, Read};
use std::net::TcpStream;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Output, Stdio};
use std::time::Duration;

use anyhow::{Context, Result, bail, ensure};
use serde_json::Value;

use crate::report::Count;
use crate::{npm, process};

/// A board's answer may take so long.
const PATIENCE: Duration = Duration::from_secs(120);

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

impl Ended {
    /// Fails where a fault did not end the run, where the host's program has not `told` of it, or where the driver's pins were not off so long
    /// after it, ms, and from then on.
    pub fn was_stopped(&self, told: &str, allowed_ms: &RangeInclusive<f64>) -> Result<()> {
        ensure!(!self.success && self.board.contains("driver off"), "{self:?}");
        ensure!(self.document.to_string().contains(told), "{self:?}");
        let off: f64 = self
            .board
            .split("off ")
            .find_map(|rest| rest.split_once(" ms after the fault")?.0.parse().ok())
            .with_context(|| format!("the pins were never off: {self:?}"))?;
        ensure!(allowed_ms.contains(&off), "the pins were off after {off} ms");
        Ok(())
    }
}

/// Runs `motorlens capture --json` with `options` against the board in `script`, which gets `arguments`.
pub fn capture(script: &str, arguments: &[&OsStr], options: &[&str], out: &Path) -> Result<Ended> {
    talk(script, arguments, |port| Ok(capturing(port, options, out)))
}

/// As [`capture`], interrupted as by Ctrl-C as soon as the board prints a line: by its own time, since an emulator goes
/// faster on one machine than on another.
pub fn capture_until_told(script: &str, arguments: &[&OsStr], options: &[&str], out: &Path) -> Result<Ended> {
    let mut board = Board::start(script, arguments)?;
    let mut capture = capturing(&board.port, options, out);
    let capture = capture.stdout(Stdio::piped()).stderr(Stdio::piped()).spawn();
    let told = capture.context("cannot start motorlens").and_then(|capture| {
        let line = board.line()?;
        process::run(Command::new("kill").args(["-INT", &capture.id().to_string()]))
            .with_context(|| format!("after {line:?}"))?;
        Ok(capture.wait_with_output()?)
    });
    board.end(told)
}

/// As [`capture`], with its progress on a terminal of 100 columns; also what was shown there.
pub fn capture_on_terminal(
    script: &str,
    arguments: &[&OsStr],
    options: &[&str],
    out: &Path,
) -> Result<(Ended, String)> {
    std::fs::create_dir_all(out)?;
    let (document, shown) = (out.join("document.json"), out.join("shown"));
    let quoted = |word: &OsStr| format!("'{}'", word.to_string_lossy());
    let ended = talk(script, arguments, |port| {
        let capture = capturing(port, options, out);
        let words: Vec<String> =
            std::iter::once(capture.get_program()).chain(capture.get_args()).map(quoted).collect();
        let [document, shown] = [&document, &shown].map(|path| quoted(path.as_os_str()));
        let inside = format!("stty cols 100; {} >{document}", words.join(" "));
        let mut terminal = Command::new("sh");
        // util-linux's; its own status is that of the program, which `cat` would hide.
        terminal.arg("-c").arg(format!(
            "script -qec \"{inside}\" {shown} >/dev/null </dev/null; ended=$?; cat {document}; exit $ended"
        ));
        Ok(terminal)
    })?;
    Ok((ended, std::fs::read_to_string(shown)?))
}

/// Starts the board in `script` and runs the command that `talk` makes of its port, after whatever it has run before.
pub fn talk(script: &str, arguments: &[&OsStr], talk: impl FnOnce(&str) -> Result<Command>) -> Result<Ended> {
    let board = Board::start(script, arguments)?;
    let told = talk(&board.port).and_then(|mut talk| talk.output().context("cannot start motorlens"));
    board.end(told)
}

/// Has `speak` talk with the board in `script` over its line, in the place of the host's program.
pub fn speak(
    script: &str,
    arguments: &[&OsStr],
    speak: impl FnOnce(TcpStream, &mut Board) -> Result<()>,
) -> Result<()> {
    let mut board = Board::start(script, arguments)?;
    let spoken = TcpStream::connect(board.port.trim_start_matches("tcp://"))
        .context("cannot reach the emulated board")
        .and_then(|line| {
            line.set_read_timeout(Some(PATIENCE))?;
            speak(line, &mut board)
        });
    // With its line closed the board ends by itself.
    board.finish(spoken).map(|_| ())
}

fn capturing(port: &str, options: &[&str], out: &Path) -> Command {
    let mut capture = Command::new(program());
    capture.args(["--json", "capture", "--port", port]).args(options).arg("--out").arg(out);
    capture
}

/// An emulated board that runs until the host's program closes its line.
pub struct Board {
    process: Child,
    lines: BufReader<ChildStdout>,
    port: String,
}

impl Board {
    fn start(script: &str, arguments: &[&OsStr]) -> Result<Self> {
        process::program()?;
        let mut emulator = emulator(script)?;
        emulator.args(arguments).stdout(Stdio::piped());
        let mut process = emulator.spawn().with_context(|| format!("cannot start {script}"))?;
        let lines = BufReader::new(process.stdout.take().context("piped above")?);
        let mut board = Self { process, lines, port: String::new() };
        let first = board.line()?;
        match first.strip_prefix("port ") {
            Some(port) => board.port = format!("tcp://127.0.0.1:{port}"),
            None => {
                board.process.kill()?;
                bail!("{script} said {first:?}");
            }
        }
        Ok(board)
    }

    /// The next line that the board prints.
    pub fn line(&mut self) -> Result<String> {
        let mut line = String::new();
        self.lines.read_line(&mut line)?;
        Ok(line.trim().to_owned())
    }

    /// Waits for the board's end, which is made to come where what was `told` over its line failed; also what it has printed since.
    fn finish<T>(mut self, told: Result<T>) -> Result<(T, String)> {
        if told.is_err() {
            self.process.kill()?;
        }
        let mut rest = String::new();
        self.lines.read_to_string(&mut rest)?;
        self.process.wait()?;
        Ok((told?, rest))
    }

    /// As [`Board::finish`], after what the host's program `told`.
    fn end(self, told: Result<Output>) -> Result<Ended> {
        let (told, board) = self.finish(told)?;
        let document = serde_json::from_slice(&told.stdout).with_context(|| {
            format!(
                "no document: {}{}",
                String::from_utf8_lossy(&told.stdout),
                String::from_utf8_lossy(&told.stderr)
            )
        })?;
        Ok(Ended { success: told.status.success(), document, board })
    }
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
            count.fail(name, &format!("{error:?}"));
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

/// What runs a board: node, with the emulators that it needs fetched, or the program itself.
fn emulator(script: &str) -> Result<Command> {
    if !script.ends_with(".js") {
        return Ok(Command::new(script));
    }
    npm::ensure_modules(&directory())?;
    let mut node = Command::new("node");
    node.current_dir(directory()).arg(script);
    Ok(node)
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
