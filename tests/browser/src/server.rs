//! The program, serving.

use std::ffi::OsStr;
use std::io::{BufRead, BufReader};
use std::path::PathBuf;
use std::process::{Child, Command, Stdio};

/// A running `motorlens serve`; ends with this value.
pub struct Server {
    child: Child,
    /// Where the page is.
    pub url: String,
}

/// The program under test: `MOTORLENS` names it.
pub fn program() -> PathBuf {
    std::env::var_os("MOTORLENS").expect("MOTORLENS names the built program").into()
}

impl Server {
    /// Serves with these arguments on any free port.
    pub fn start<A: AsRef<OsStr>>(arguments: &[A]) -> Self {
        let mut child = Command::new(program())
            .args(["serve", "--quiet", "--port", "0"])
            .args(arguments)
            .stdout(Stdio::piped())
            .spawn()
            .expect("the program starts");
        let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines();
        let url = lines.next().expect("the program tells its address").expect("as text");
        Self { child, url }
    }
}

impl Drop for Server {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// Runs another verb to its end.
pub fn run<A: AsRef<OsStr>>(arguments: &[A]) {
    let status = Command::new(program()).args(arguments).status().expect("the program starts");
    assert!(status.success(), "{status}");
}
