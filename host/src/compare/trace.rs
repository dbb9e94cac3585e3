//! Open-loop simulations as a table.

use std::io::Write;
use std::path::Path;

use super::free_run::FreeRun;
use crate::atomic_file;
use crate::error::Result;

/// Writes `record,time_s,measured,simulated`, whole or not at all.
///
/// # Errors
/// The file cannot be written.
pub fn write_trace(path: &Path, runs: &[FreeRun]) -> Result<()> {
    atomic_file::write_with(path, |file| {
        writeln!(file, "record,time_s,measured,simulated")?;
        for run in runs {
            let name = field(&run.record);
            for ((t, y), p) in run.time_s.iter().zip(&run.measured).zip(&run.simulated) {
                writeln!(file, "{name},{t},{y},{p}")?;
            }
        }
        Ok(())
    })
}

/// A name as a CSV field (RFC 4180).
fn field(name: &str) -> String {
    if name.contains([',', '"', '\n']) {
        format!("\"{}\"", name.replace('"', "\"\""))
    } else {
        name.to_owned()
    }
}

#[cfg(test)]
mod tests {
    #[test]
    fn names_with_commas_are_quoted() {
        assert_eq!(super::field("a,\"b\""), "\"a,\"\"b\"\"\"");
        assert_eq!(super::field("run-1"), "run-1");
    }
}
