//! A log of 100 MB is read in seconds, in memory that follows the numbers kept and not the size of the file.

mod program;

use std::io::{BufWriter, Read, Write};
use std::path::Path;
use std::process::Stdio;
use std::time::{Duration, Instant};

use motorlens::log::{ReadOptions, data_faults, read};

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

/// Seconds of a clock for reading `rows` rows and looking for faults of the data, angle and speed beside each other.
fn looked_through(rows: u32) -> f64 {
    let directory = tempfile::tempdir().unwrap();
    let path = directory.path().join("rows.csv");
    let mut file = BufWriter::new(std::fs::File::create(&path).unwrap());
    writeln!(file, "time_s,voltage_v,angle_rad,speed_rad_s").unwrap();
    let (mut speed, mut angle) = (0.0_f64, 0.0_f64);
    for row in 0..rows {
        let volts = f64::from((row / 700 * 7) % 13) - 6.0;
        writeln!(file, "{:.3},{volts},{angle:.5},{speed:.4}", f64::from(row) * 1e-3).unwrap();
        speed += (0.6 * volts - speed) / 50.0;
        angle += 1e-3 * speed;
    }
    file.into_inner().unwrap();
    let start = Instant::now();
    let records = read(&path, &ReadOptions::default()).unwrap();
    let faults = data_faults(&records);
    let seconds = start.elapsed().as_secs_f64();
    println!("{rows} rows: {seconds:.2} s, {faults:?}");
    seconds
}

#[test]
fn a_million_rows_take_four_times_as_long_as_a_quarter_of_them() {
    // The shorter of two each, on a shared machine; eight times would be far from linear.
    let best = |rows| looked_through(rows).min(looked_through(rows));
    let (quarter, all) = (best(250_000), best(1_000_000));
    assert!(all < 8.0 * quarter, "{quarter} s, {all} s");
    assert!(all < 20.0, "{all} s on a shared machine");
}

/// Status, standard error, seconds (of the processor, where the system tells) and the highest memory in kB (0 where not).
fn watched(directory: &Path, words: &str) -> (i32, String, f64, usize) {
    let start = Instant::now();
    let mut child =
        program::command(directory, words).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().unwrap();
    let status_file = format!("/proc/{}/status", child.id());
    let times = format!("/proc/{}/stat", child.id());
    let (mut peak, mut busy) = (0, None);
    let status = loop {
        busy = std::fs::read_to_string(&times).ok().and_then(|text| processor_seconds(&text)).or(busy);
        if let Ok(text) = std::fs::read_to_string(&status_file) {
            let line = text.lines().find(|line| line.starts_with("VmHWM:"));
            let now = line.and_then(|l| l.split_whitespace().nth(1)?.parse().ok());
            peak = peak.max(now.unwrap_or(0));
        }
        if let Some(status) = child.try_wait().unwrap() {
            break status;
        }
        std::thread::sleep(Duration::from_millis(5));
    };
    let mut err = String::new();
    child.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    (status.code().unwrap(), err, busy.unwrap_or(start.elapsed().as_secs_f64()), peak)
}

/// User and system time from a line of `/proc/PID/stat`, which counts in hundredths of a second.
fn processor_seconds(stat: &str) -> Option<f64> {
    let mut after_name = stat.rsplit_once(')')?.1.split_whitespace().skip(11);
    let mut ticks = || after_name.next()?.parse::<f64>().ok();
    Some(0.01 * (ticks()? + ticks()?))
}

#[test]
fn a_hundred_megabytes_are_fitted_or_refused_by_the_program_in_seconds() {
    let directory = tempfile::tempdir().unwrap();
    let here = directory.path();
    let file = |name: &str| BufWriter::new(std::fs::File::create(here.join(name)).unwrap());

    // An hour of a first-order motor at 1 kHz, written with all digits.
    let mut log = file("motor.csv");
    writeln!(log, "time_s,voltage_v,angle_rad").unwrap();
    let (mut speed, mut angle, mut bytes, mut row) = (0.0_f64, 0.0_f64, 0, 0_u32);
    while bytes < 100_000_000 {
        let volts = f64::from((row / 700 * 7) % 13) - 6.0;
        let line = format!("{:.3},{volts},{:.6}\n", f64::from(row) * 1e-3, (angle * 1e4).floor() * 1e-4);
        log.write_all(line.as_bytes()).unwrap();
        speed += (0.6 * volts - speed) / 50.0;
        angle += 1e-3 * speed;
        (bytes, row) = (bytes + line.len(), row + 1);
    }
    drop(log);
    let (status, err, seconds, peak) = watched(here, "fit motor.csv --quiet");
    println!("fit of {row} rows: {seconds:.1} s, {} MB", peak / 1000);
    assert_eq!(status, 0, "{err}");
    assert!(seconds < 90.0 && peak < 1_500_000, "{seconds} s, {peak} kB");

    // No line ever ends: no table, and no reason to keep it.
    let mut one_line = file("line.csv");
    (0..100).for_each(|_| one_line.write_all(&[b'7'; 1_000_000]).unwrap());
    drop(one_line);
    let mut zeros = file("zeros.csv");
    (0..100).for_each(|_| zeros.write_all(&[0; 1_000_000]).unwrap());
    drop(zeros);
    for name in ["line.csv", "zeros.csv"] {
        let (status, err, seconds, peak) = watched(here, &format!("fit {name} --out m.json"));
        println!("{name}: {seconds:.1} s, {} MB: {err}", peak / 1000);
        assert_eq!(status, 3, "{err}");
        assert!(err.contains(name) && err.contains("  do: "), "{err}");
        assert!(seconds < 10.0 && peak < 300_000, "{seconds} s, {peak} kB");
        assert!(!here.join("m.json").exists());
    }
}
