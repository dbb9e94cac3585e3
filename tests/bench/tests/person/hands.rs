//! The bench as a process of its own, the host's program, and the line between the two.

use std::io::{BufRead, BufReader, ErrorKind, Read, Write};
use std::net::{Shutdown, TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::Ordering::Relaxed;
use std::sync::atomic::{AtomicBool, AtomicUsize};
use std::time::Duration;
use std::{env, fs, thread};

use serde_json::Value;

use crate::documented;

/// Virtual seconds in a second. Half of the link's timeout is then 125 ms on the wall: a busy machine keeps up.
const SPEED: &str = "2";

/// A running bench; it ends with the test.
pub struct Bench {
    child: Child,
    /// Where its board answers.
    pub address: String,
    /// What it says of its encoder.
    pub counts_per_rev: String,
}

impl Bench {
    pub fn start(hidden: &[&str]) -> Self {
        let mut child = bench(hidden)
            .args(["--port", "0", "--speed", SPEED])
            .stdout(Stdio::piped())
            .spawn()
            .expect("the bench starts");
        let mut line = String::new();
        let said = child.stdout.take().expect("piped above");
        BufReader::new(said).read_line(&mut line).expect("the bench says where it is");
        let word = |after: &str| {
            let rest = line.split_once(after).expect("the bench's line").1;
            rest.split([';', '\n']).next().expect("one word at least").trim().to_owned()
        };
        let (address, counts_per_rev) = (word("answers at "), word("--counts-per-rev "));
        Bench { child, address, counts_per_rev }
    }

    /// The printed command of this shape.
    pub fn printed(&self, shape: &str, out: &Path) -> Command {
        let line = documented::line(&root(), shape);
        let line = line.unwrap_or_else(|| panic!("no document prints motorlens {shape}"));
        let words = line.as_run(&self.address, out);
        program(&words.iter().map(String::as_str).collect::<Vec<_>>())
    }

    /// `motorlens VERB... --port ... --json`.
    pub fn program(&self, verb: &[&str]) -> Command {
        let mut command = program(verb);
        command.args(["--port", &self.address]);
        command
    }
}

/// A line between program and bench that can be pulled out and plugged in again.
pub struct Extension {
    /// What to connect to.
    pub address: String,
    plugged: Arc<AtomicBool>,
    /// Bytes that came from the board.
    carried: Arc<AtomicUsize>,
}

impl Extension {
    pub fn to(bench: &str) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").expect("a free port");
        let address = format!("tcp://{}", listener.local_addr().expect("bound above"));
        let (plugged, carried) = (Arc::new(AtomicBool::new(true)), Arc::new(AtomicUsize::new(0)));
        let bench = bench.trim_start_matches("tcp://").to_owned();
        let (state, count) = (Arc::clone(&plugged), Arc::clone(&carried));
        // Ends with the test's process.
        thread::spawn(move || {
            for near in listener.incoming().map_while(Result::ok) {
                if state.load(Relaxed) {
                    let far = TcpStream::connect(&bench).expect("the bench is there");
                    let nobody = Arc::new(AtomicUsize::new(0));
                    for (from, to, count) in [(&near, &far, &nobody), (&far, &near, &count)] {
                        let ends = (from.try_clone().expect("a socket"), to.try_clone().expect("a socket"));
                        let (state, count) = (Arc::clone(&state), Arc::clone(count));
                        thread::spawn(move || carry(ends, &state, &count));
                    }
                }
            }
        });
        Extension { address, plugged, carried }
    }

    /// Waits until the board has said so much; a second of log at 1 kHz is about 12 KiB.
    pub fn wait_for(&self, bytes: usize) {
        while self.carried.load(Relaxed) < bytes {
            thread::sleep(Duration::from_millis(5));
        }
    }

    pub fn plug(&self, plugged: bool) {
        self.plugged.store(plugged, Relaxed);
    }
}

/// Copies bytes until either end closes or the plug is out; then closes both.
fn carry((mut from, mut to): (TcpStream, TcpStream), plugged: &AtomicBool, carried: &AtomicUsize) {
    from.set_read_timeout(Some(Duration::from_millis(5))).expect("a socket");
    let mut buffer = [0; 4096];
    while plugged.load(Relaxed) {
        match from.read(&mut buffer) {
            Ok(length) if length > 0 && to.write_all(&buffer[..length]).is_ok() => {
                carried.fetch_add(length, Relaxed);
            }
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            _ => break,
        }
    }
    // Closed already, where the other direction was first.
    let _ = (from.shutdown(Shutdown::Both), to.shutdown(Shutdown::Both));
}

impl Drop for Bench {
    fn drop(&mut self) {
        // It may have ended by itself; then there is nothing to end.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// With `hidden`, the effects by number or by name.
pub fn bench(hidden: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_motorlens-bench"));
    command.arg("--image").arg(motorlens_bench::machine::image()).args(hidden);
    command
}

/// The project's directory.
pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

pub fn program(verb: &[&str]) -> Command {
    let program = env::var_os("MOTORLENS_PROGRAM")
        .expect("MOTORLENS_PROGRAM names the host program; run the bench by `cargo xtask test --only bench`");
    let mut command = Command::new(program);
    command.args(verb).args(["--json", "--quiet"]);
    command
}

pub fn json(mut command: Command) -> Value {
    let output = command.stderr(Stdio::inherit()).output().expect("the program starts");
    assert!(output.status.success(), "{command:?}: {}", output.status);
    serde_json::from_slice(&output.stdout).expect("one document")
}

pub fn fresh_directory(name: &str) -> PathBuf {
    let directory = Path::new(env!("CARGO_TARGET_TMPDIR")).join(name);
    let _ = fs::remove_dir_all(&directory);
    directory
}
