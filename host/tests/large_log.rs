//! A log of 100 MB is read in seconds, in memory that follows the numbers kept and not the size of the file.

use std::io::{BufWriter, Write};
use std::time::Instant;

use motorlens::log::{ReadOptions, read};

#[test]
fn a_hundred_megabytes_are_read_in_seconds() {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("large.csv");
    let mut file = BufWriter::new(std::fs::File::create(&path).unwrap());
    writeln!(file, "time_s,note,voltage_v,angle_rad").unwrap();
    let filler = "x".repeat(70);
    let mut rows = 0;
    let mut bytes = 0;
    while bytes < 100_000_000 {
        let time = f64::from(rows) * 1e-3;
        let line = format!("{time:.3},{filler},{:.4},{:.6}\n", time.sin(), time.cos());
        file.write_all(line.as_bytes()).unwrap();
        bytes += line.len();
        rows += 1;
    }
    file.into_inner().unwrap();
    let start = Instant::now();
    let record = read(&path, &ReadOptions::default()).unwrap().remove(0);
    let seconds = start.elapsed().as_secs_f64();
    println!("{bytes} bytes, {rows} rows: {seconds:.2} s");
    assert_eq!(record.len(), rows as usize);
    #[cfg(target_os = "linux")]
    {
        let status = std::fs::read_to_string("/proc/self/status").unwrap();
        let peak = status.lines().find(|line| line.starts_with("VmHWM:")).unwrap();
        let kilobytes: usize = peak.split_whitespace().nth(1).unwrap().parse().unwrap();
        // Three columns of a million numbers, twice while a column grows, and the program itself.
        assert!(kilobytes < 90_000, "{kilobytes} kB");
    }
    assert!(seconds < 20.0, "{seconds} s on a shared machine");
}
