//! The parts of a test run: timed, counted, summed up in one plain last line.

use std::ops::AddAssign;
use std::time::Instant;

use anyhow::Result;

/// How many checks passed and failed.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Count {
    /// Checks that passed.
    pub passed: u64,
    /// Checks that failed.
    pub failed: u64,
    /// Checks that said why they cannot run here.
    pub skipped: u64,
}

impl Count {
    /// One check that passed.
    pub const ONE: Count = Count { passed: 1, failed: 0, skipped: 0 };

    /// What a line such as `test result: ok. 3 passed; 0 failed; ...` reports; nothing for any other line.
    pub fn from_test_line(line: &str) -> Count {
        let Some(rest) = line.trim_start().strip_prefix("test result:") else {
            return Count::default();
        };
        let number_before = |word: &str| {
            let before = rest.split(word).next().unwrap_or_default();
            before.rsplit([' ', ';', '.']).find(|s| !s.is_empty()).and_then(|s| s.parse().ok()).unwrap_or(0)
        };
        Count { passed: number_before(" passed"), failed: number_before(" failed"), skipped: 0 }
    }
}

impl AddAssign for Count {
    fn add_assign(&mut self, other: Count) {
        self.passed += other.passed;
        self.failed += other.failed;
        self.skipped += other.skipped;
    }
}

/// A run of several parts. A part that fails does not keep the following ones from running.
#[derive(Default)]
pub struct Report {
    total: Count,
    lines: Vec<String>,
}

impl Report {
    /// Runs a part. That it cannot run at all is one failure.
    pub fn part(&mut self, name: &str, part: impl FnOnce() -> Result<Count>) {
        println!("\n==== {name}");
        let start = Instant::now();
        let (count, verdict) = match part() {
            Ok(count) if count.failed == 0 && count.skipped > 0 => {
                (count, format!("ok, {} skipped", count.skipped))
            }
            Ok(count) if count.failed == 0 => (count, "ok".to_owned()),
            Ok(count) => (count, "FAILED".to_owned()),
            Err(error) => (Count { failed: 1, ..Count::default() }, format!("FAILED: {error:#}")),
        };
        self.total += count;
        let line = format!("{:>8.1} s  {name}: {verdict}", start.elapsed().as_secs_f64());
        println!("---- {line}");
        self.lines.push(line);
    }

    /// Prints every part's time and verdict, then the sum alone on the last line. Whether nothing failed.
    pub fn finish(self) -> bool {
        println!("\n==== summary");
        for line in &self.lines {
            println!("{line}");
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
        assert_eq!(Count::from_test_line(line), Count { passed: 12, failed: 3, skipped: 0 });
        assert_eq!(Count::from_test_line("test a::b ... ok"), Count::default());
    }

    #[test]
    fn a_part_tells_how_much_of_it_was_skipped() {
        let mut report = Report::default();
        report.part("in part", || Ok(Count { passed: 3, failed: 0, skipped: 1 }));
        assert!(report.lines[0].ends_with("in part: ok, 1 skipped"), "{}", report.lines[0]);
        assert!(report.finish());
    }

    #[test]
    fn a_part_that_cannot_run_is_a_failure() {
        let mut report = Report::default();
        report.part("good", || Ok(Count::ONE));
        report.part("no tool", || bail!("not installed"));
        assert_eq!(report.total, Count { passed: 1, failed: 1, skipped: 0 });
        assert!(!report.finish());
    }
}
