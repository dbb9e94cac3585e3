//! `capture --listen`: saves the runs that a board prints as lines of text.

use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicBool, Ordering};

use serde::Serialize;

use super::Console;
use super::capture::{Args, discover_next, shaft};
use super::interrupt::interrupted;
use super::strip::Strip;
use crate::device::{End, Fault, Listen, Port, Shaft, to_record};
use crate::error::{Error, Result};
use crate::log::{Warning, faults, suspicions, write_canonical};

/// The most runs that a board may say it plays.
const MOST_RUNS: u32 = 100;

#[derive(Serialize)]
struct Saved {
    log: PathBuf,
    ended: String,
    samples: usize,
    damaged_lines: u64,
    finished: bool,
    data_faults: Vec<Warning>,
}

#[derive(Serialize)]
struct Document {
    schema: u32,
    logs: Vec<Saved>,
}

/// Listens to as many runs as the board says it plays; each log is saved whole before the next begins.
pub fn run(args: &Args, console: &Console) -> Result<()> {
    let shaft = shaft(args)?;
    std::fs::create_dir_all(&args.out)
        .map_err(|source| Error::Io { doing: format!("cannot make {}", args.out.display()), source })?;
    let mut port = Port::open_at(&args.port, args.baud)?;
    let interrupted = interrupted();
    let mut document = Document { schema: 1, logs: Vec::new() };
    let (mut number, mut runs) = (0, 1);
    while number < runs {
        let mut listen = Listen::new(number);
        // The board says the run's name and length itself.
        let mut strip = Strip::new("", 0, Some(&shaft), console);
        let outcome = follow(&mut port, &mut listen, f64::from(args.supply), &interrupted, &mut strip);
        let end = listen.end().cloned().unwrap_or(End::Silent);
        if let End::Nothing(bytes, trouble) = end {
            outcome?;
            return Err(nothing(args, bytes, trouble));
        }
        if end == End::Stopped {
            outcome?;
            return Err(Fault::Stopped.into());
        }
        runs = listen.run().number("runs").map_or(1, |runs| runs as u32).clamp(1, MOST_RUNS);
        let name = listen.run().pairs.get("programme").map_or("", String::as_str);
        let log = args.out.join(format!("{}.csv", file_name(name, number)));
        let saved = save(&listen, &end, &shaft, args, &log);
        let kept = match &saved {
            Ok(_) => format!("the {} samples so far are in {}", listen.run().len(), log.display()),
            Err(error) => error.to_string(),
        };
        match outcome {
            Err(Error::Device { why, remedy }) => {
                return Err(Error::Device { why: format!("{why} ({kept})"), remedy });
            }
            Err(other) => return Err(other),
            Ok(()) if !end.finished() => {
                let why = format!("{name}: {} ({kept})", end.text());
                return Err(Error::device(why, "clear the cause and capture again"));
            }
            Ok(()) => document.logs.push(saved?),
        }
        number += 1;
    }
    console.answer(&document, || {
        let lines = document.logs.iter().map(|saved| {
            let odd = saved.data_faults.iter().map(|odd| format!("\n  {}\n    do: {}", odd.what, odd.fix));
            format!("{}: {} samples{}", saved.log.display(), saved.samples, odd.collect::<String>())
        });
        lines.collect::<Vec<_>>().join("\n")
    });
    discover_next(document.logs.iter().map(|saved| saved.log.as_path()), console);
    Ok(())
}

/// Listens to one run, to its end in whatever way.
fn follow(
    port: &mut Port,
    listen: &mut Listen,
    supply_v: f64,
    interrupted: &AtomicBool,
    strip: &mut Strip,
) -> Result<()> {
    let outcome = port.converse(|now, received, send| {
        listen.receive(received, now);
        if interrupted.swap(false, Ordering::Relaxed) {
            listen.stop();
        }
        listen.poll(now, send);
        strip.show_lines(listen.run(), supply_v, now);
        listen.end().is_some().then_some(())
    });
    strip.clear();
    outcome
}

/// Writes a run's log, whole or not at all, with the checks that every log gets when it is read.
fn save(listen: &Listen, end: &End, shaft: &Shaft, args: &Args, log: &Path) -> Result<Saved> {
    let run = listen.run();
    let record = to_record(run, end, shaft, f64::from(args.supply), log).map_err(|why| {
        Error::device(why, "let the board print at least 20 samples between the header and # end:")
    })?;
    write_canonical(&record, log)?;
    let mut data_faults = faults(&record);
    data_faults.extend(suspicions([&record]));
    Ok(Saved {
        log: log.to_path_buf(),
        ended: end.text().to_owned(),
        samples: run.len(),
        damaged_lines: listen.damaged(),
        finished: end.finished(),
        data_faults,
    })
}

/// A file's name from what the board calls its programme: nothing in it leads to another directory.
fn file_name(programme: &str, number: u32) -> String {
    let plain = |c: char| if c.is_ascii_alphanumeric() || "-_.".contains(c) { c } else { '-' };
    let name: String = programme.chars().take(64).map(plain).collect();
    let name = name.trim_start_matches('.');
    if name.is_empty() { format!("run-{number}") } else { name.to_owned() }
}

/// A port on which no run began.
fn nothing(args: &Args, bytes: u64, trouble: Option<String>) -> Error {
    let Args { port, baud, .. } = args;
    match (bytes, trouble) {
        (0, _) => Error::device(
            format!("{port}: not one byte came"),
            "check that the sketch is on the board, that the shaft rests (the sketch waits for it), and that no other program (a serial \
             monitor) has the port",
        ),
        (_, None) => Error::device(
            format!("{port}: {bytes} bytes came, but no run began"),
            "print the header t_us,duty,count,supply_mv before the samples (docs/LINE_PROTOCOL.md)",
        ),
        (_, Some(trouble)) => Error::device(
            format!("{port}: {bytes} bytes came, but no run began; {trouble}"),
            format!(
                "open the port at the sketch's speed (--baud, now {baud}); docs/LINE_PROTOCOL.md has the lines"
            ),
        ),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_programmes_name_stays_in_the_directory() {
        assert_eq!(file_name("../../etc/passwd", 0), "-..-etc-passwd");
        assert_eq!(file_name("holdout-prbs 2", 0), "holdout-prbs-2");
        assert_eq!((file_name("..", 3).as_str(), file_name("", 0).as_str()), ("run-3", "run-0"));
    }
}
