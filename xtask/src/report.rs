//! The parts of a test run: timed, counted, summed up with what failed in each and one plain last line.

use std::ops::AddAssign;
use std::time::Instant;

use anyhow::Result;

/// Lines that the summary repeats of what a failed check said: the first tell what and where.
const LINES: usize = 6;

/// How many checks passed and failed.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Checks that passed.
    pub passed: u64,
    /// Checks that failed.
    pub failed: u64,
    /// Checks that said why they cannot run here.
    pub skipped: u64,
    /// Those that failed, as far as they have names: the name, then the first lines of what it said.
    pub failures: Vec<Vec<String>>,
}

impl Count {
    /// One check that passed.
    pub const ONE: Count = Count { passed: 1, failed: 0, skipped: 0, failures: Vec::new() };

    /// Adds a check that failed, by its name, with what it said.
    pub fn fail(&mut self, name: &str, said: &str) {
        self.failed += 1;
        self.failures
            .push(std::iter::once(name).chain(said.lines().take(LINES)).map(str::to_owned).collect());
    }

    /// What a line such as `test result: ok. 3 passed; 0 failed; ...` reports; nothing for any other line.
    pub fn from_test_line(line: &str) -> Count {
        let Some(rest) = line.trim_start().strip_prefix("test result:") else {
            return Count::default();
        };
        let number_before = |word: &str| {
            let before = rest.split(word).next().unwrap_or_default();
            before.rsplit([' ', ';', '.']).find(|s| !s.is_empty()).and_then(|s| s.parse().ok()).unwrap_or(0)
        };
        Count { passed: number_before(" passed"), failed: number_before(" failed"), ..Count::default() }
    }
}

/// Listens to what Rust's test programs print.
#[derive(Default)]
pub struct Listener {
    /// What was heard so far.
    pub count: Count,
    /// Whether what comes is what the last of the failures said.
    telling: bool,
}

impl Listener {
    /// Hears a line.
    pub fn hear(&mut self, line: &str) {
        self.count += Count::from_test_line(line);
        if let Some(name) = line.strip_prefix("---- ").and_then(|rest| rest.strip_suffix(" stdout ----")) {
            // The passed ones' output may be shown too, in a section of its own before.
            self.telling = self.count.failures.iter().any(|failure| failure == &[name]);
            if self.telling {
                self.count.failures.retain(|failure| failure != &[name]);
                self.count.failures.push(vec![name.to_owned()]);
            }
        } else if let Some(name) =
            line.strip_prefix("test ").and_then(|rest| rest.strip_suffix(" ... FAILED"))
        {
            self.count.failures.push(vec![name.to_owned()]);
        } else if matches!(line, "failures:" | "successes:") {
            self.telling = false;
        } else if let Some(last) = self.count.failures.last_mut()
            && self.telling
            && last.len() <= LINES
            && !line.trim().is_empty()
        {
            last.push(line.to_owned());
        }
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Count) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
        self.failures.extend(other.failures);
    }
}

/// A run of several parts. A part that fails does not keep the following ones from running.
#[derive(Default)]
pub struct Report {
    total: Count,
    lines: Vec<String>,
    failed: Vec<String>,
}

impl Report {
    /// Runs a part. That it cannot run at all is one failure.
    pub fn part(&mut self, name: &str, part: impl FnOnce() -> Result<Count>) {
        println!("\n==== {name}");
        let start = Instant::now();
        let (count, verdict) = match part() {
            Ok(count) if count.failed == 0 && count.skipped > 0 => {
                let verdict = format!("ok, {} skipped", count.skipped);
                (count, verdict)
            }
            Ok(count) if count.failed == 0 => (count, "ok".to_owned()),
            Ok(count) => (count, "FAILED".to_owned()),
            Err(error) => (Count { failed: 1, ..Count::default() }, format!("FAILED: {error:#}")),
        };
        let told = count.failures.iter().map(|failure| format!("{name}: {}", failure.join("\n    ")));
        self.failed.extend(told);
        self.total += count;
        let line = format!("{:>8.1} s  {name}: {verdict}", start.elapsed().as_secs_f64());
        println!("---- {line}");
        self.lines.push(line);
    }

    /// Prints every part's time and verdict, what failed and why, then the sum alone on the last line. Whether nothing failed.
    pub fn finish(self) -> bool {
        println!("\n==== summary");
        for line in &self.lines {
            println!("{line}");
        }
        for failure in &self.failed {
            println!("FAILED {failure}");
        }
        println!("{} passed, {} failed", self.total.passed, self.total.failed);
        self.total.failed == 0
    }
}

#[cfg(test)]
mod tests {
    use anyhow::bail;

    use super::*;

    #[test]
    fn counts_come_from_result_lines_only() {
        let line = "test result: FAILED. 12 passed; 3 failed; 0 ignored; 0 measured; 0 filtered out; finished in 0.1s";
        assert_eq!(Count::from_test_line(line), Count { passed: 12, failed: 3, ..Count::default() });
        assert_eq!(Count::from_test_line("test a::b ... ok"), Count::default());
    }

    #[test]
    fn a_part_tells_how_much_of_it_was_skipped() {
        let mut report = Report::default();
        report.part("in part", || Ok(Count { passed: 3, skipped: 1, ..Count::default() }));
        assert!(report.lines[0].ends_with("in part: ok, 1 skipped"), "{}", report.lines[0]);
        assert!(report.finish());
    }

    #[test]
    fn a_part_that_cannot_run_is_a_failure() {
        let mut report = Report::default();
        report.part("good", || Ok(Count::ONE));
        report.part("no tool", || bail!("not installed"));
        assert_eq!(report.total, Count { passed: 1, failed: 1, ..Count::default() });
        assert!(!report.finish());
    }

    #[test]
    fn the_summary_names_each_test_that_failed_with_the_first_lines_of_what_it_said() {
        let mut listener = Listener::default();
        let said = "test a ... ok\ntest b ... FAILED\n\nsuccesses:\n\n---- a stdout ----\nfine\n\nsuccesses:\n    a\n\nfailures:\n\n\
                    ---- b stdout ----\nthread 'b' panicked at b.rs:3:5:\ntoo fast\n\nfailures:\n    b\n\n\
                    test result: FAILED. 1 passed; 1 failed; 0 ignored";
        said.lines().for_each(|line| listener.hear(line));
        assert_eq!(listener.count.failures, [["b", "thread 'b' panicked at b.rs:3:5:", "too fast"]]);
        let mut report = Report::default();
        report.part("host tests", || Ok(listener.count));
        assert_eq!(report.failed, ["host tests: b\n    thread 'b' panicked at b.rs:3:5:\n    too fast"]);
    }
}
