//! Listening to a board that prints its runs as lines of text.

use super::Shaft;
use super::lines::{Line, Reader, Run};
use crate::log::{Metadata, Record, Warning, timing};
use std::path::Path;
use std::time::Duration;

/// A board that has not begun to print is asked to begin again after this time: opening the port starts many anew.
const ASK: Duration = Duration::from_secs(1);
/// A board that prints nothing at all is given up after this time, and one that falls silent in a run after the other.
const PATIENCE: Duration = Duration::from_secs(10);
const SILENCE: Duration = Duration::from_secs(3);
/// How often a board in a run hears that somebody listens.
const KEEP_ALIVE: Duration = Duration::from_millis(100);
/// Intervals longer than this many usual ones have samples missing.
const GAP: f64 = 1.5;
/// A measured supply is believed within these shares of the stated one.
const SUPPLY: std::ops::Range<f64> = 0.5..1.5;

/// How a run that was listened to ended.
#[derive(Debug, Clone, PartialEq)]
pub enum End {
    /// The board said how: `finished`, or why not.
    Told(String),
    /// It fell silent in the run.
    Silent,
    /// It was told to stop before it had begun, and has not begun since.
    Stopped,
    /// Nothing of the protocol came; bytes that were no lines of it, and what was wrong with the last.
    Nothing(u64, Option<String>),
}

impl End {
    /// Whether the programme was played to its end.
    pub fn finished(&self) -> bool {
        matches!(self, End::Told(why) if why == "finished")
    }

    /// The end as a log tells it.
    pub fn text(&self) -> &str {
        match self {
            End::Told(why) => why,
            End::Silent => "link loss",
            End::Stopped => "stopped",
            End::Nothing(..) => "nothing",
        }
    }
}

/// The state of listening to one run.
#[derive(Debug)]
pub struct Listen {
    number: u32,
    reader: Reader,
    run: Run,
    in_run: bool,
    asked: Option<Duration>,
    heard: Option<Duration>,
    spoke: Duration,
    damaged: u64,
    bytes: u64,
    trouble: Option<String>,
    stop: bool,
    /// Since when the board is told to stop.
    stopping: Option<Duration>,
    end: Option<End>,
}

impl Listen {
    /// Waits for run `number`, from 0.
    pub fn new(number: u32) -> Self {
        Self {
            number,
            reader: Reader::default(),
            run: Run::default(),
            in_run: false,
            asked: None,
            heard: None,
            spoke: Duration::ZERO,
            damaged: 0,
            bytes: 0,
            trouble: None,
            stop: false,
            stopping: None,
            end: None,
        }
    }

    /// What has come of the run.
    pub fn run(&self) -> &Run {
        &self.run
    }

    /// Lines that were no lines of the protocol since the run began.
    pub fn damaged(&self) -> u64 {
        self.damaged
    }

    /// Asks the board to end the run, again and again until it does; what it prints until then still counts. A run that has not begun is
    /// asked for no longer.
    pub fn stop(&mut self) {
        self.stop = true;
    }

    /// The end of the run, once there is one.
    pub fn end(&self) -> Option<&End> {
        self.end.as_ref()
    }

    /// Takes bytes from the board. What comes after the end of the run is not of this run.
    pub fn receive(&mut self, bytes: &[u8], now: Duration) {
        self.bytes += bytes.len() as u64;
        for byte in bytes {
            if self.end.is_some() {
                return;
            }
            match self.reader.push(*byte) {
                Some(Ok(line)) => self.line(line, now),
                Some(Err(why)) => self.damage(why),
                None => {}
            }
        }
    }

    fn line(&mut self, line: Line, now: Duration) {
        match line {
            Line::Header => {
                // A board that was started anew in a run begins anew; what it said before the header is of the new run.
                self.run = Run::new(std::mem::take(&mut self.run.pairs));
                (self.in_run, self.damaged, self.heard) = (true, 0, Some(now));
            }
            Line::Pair(key, why) if key == "end" => self.end = self.in_run.then_some(End::Told(why)),
            Line::Pair(key, value) => drop(self.run.pairs.insert(key, value)),
            Line::Row(row) if self.in_run => {
                self.heard = Some(now);
                if let Err(why) = self.run.push(row) {
                    self.damage(why);
                }
            }
            // The middle of a run that began before anybody listened.
            Line::Row(_) => {}
        }
    }

    fn damage(&mut self, why: String) {
        self.damaged += 1;
        self.trouble = Some(why);
    }

    /// Lets time pass, and hands over what is to be sent: a board that plays nothing by itself begins with `start`,
    /// hears an empty line ten times a second while it plays, and ends with `stop`.
    pub fn poll(&mut self, now: Duration, out: &mut Vec<u8>) {
        if self.end.is_some() {
            return;
        }
        let begun = *self.asked.get_or_insert(now);
        let stopping = if self.stop { Some(*self.stopping.get_or_insert(now)) } else { None };
        let silent = now.saturating_sub(self.spoke);
        match (self.heard, stopping) {
            (Some(heard), _) if now.saturating_sub(heard) > SILENCE => self.end = Some(End::Silent),
            (None, Some(since)) if now.saturating_sub(since) > SILENCE => self.end = Some(End::Stopped),
            (None, None) if now.saturating_sub(begun) > PATIENCE => {
                self.end = Some(End::Nothing(self.bytes, self.trouble.take()));
            }
            // A line may lose it, and a board that waits for its shaft to rest does not read it yet.
            (_, Some(since)) if since == now || silent >= KEEP_ALIVE => self.say(now, "stop\n", out),
            (Some(_), None) if silent >= KEEP_ALIVE => self.say(now, "\n", out),
            (None, None) if self.spoke == Duration::ZERO || silent >= ASK => {
                self.say(now, &format!("start {}\n", self.number), out);
            }
            _ => {}
        }
    }

    fn say(&mut self, now: Duration, words: &str, out: &mut Vec<u8>) {
        // Not zero, which says that nothing was sent yet.
        self.spoke = now.max(Duration::from_nanos(1));
        out.extend_from_slice(words.as_bytes());
    }
}

/// The record of a run in SI units, with its data quality problems.
///
/// `supply_v` is the stated supply, in V, where the board measures none. Keys that the board prints and that the log
/// format does not admit are told as warnings.
///
/// # Errors
/// Too few samples to make a log.
pub fn to_record(run: &Run, end: &End, shaft: &Shaft, supply_v: f64, log: &Path) -> Result<Record, String> {
    if run.len() < crate::log::FEWEST_SAMPLES {
        return Err(format!("{} samples came, which is too few for a log", run.len()));
    }
    let place = log.display().to_string();
    let mut warnings = Vec::new();
    let mut warn = |what: String, fix: &str| {
        warnings.push(Warning { place: place.clone(), what, fix: fix.to_owned() });
    };
    let full = run.duty_full();
    let measured = run.measures_supply();
    let supply = run.supply_v(supply_v);
    if let Some(odd) = supply.iter().find(|supply| !SUPPLY.contains(&(*supply / supply_v))) {
        warn(
            format!("the board measures a supply of {odd:.2} V where --supply says {supply_v:.2} V"),
            "check the divider and its ratio in the sketch, or state the supply with --supply",
        );
    }
    if let Some(beyond) = run.duty.iter().find(|duty| f64::from(**duty).abs() > full) {
        warn(format!("a duty of {beyond} is beyond duty_full, {full}"), "correct the sketch's duty_full");
    }
    let time_s: Vec<f64> = run.time_us.iter().map(|time| *time as f64 * 1e-6).collect();
    let holes = holes(&time_s);
    if !holes.is_empty() {
        let fix = "sample less often, or raise the line's speed on both ends (--baud)";
        warn(format!("samples are missing: {}", holes.join(" ")), fix);
    }
    let lost = run.number("lost").unwrap_or(0.0);
    if lost > 0.0 {
        let fix = "the board is too slow for this encoder: drive more slowly, or count on a board with a counter in hardware";
        warn(format!("the board missed {lost} steps of the encoder, so the angle is wrong by more"), fix);
    }

    let mut meta = Metadata::default();
    for (key, value) in run.pairs.iter().filter(|(key, _)| *key != "runs") {
        if let Err(why) = meta.insert(key, value) {
            warn(why, "correct what the sketch prints");
        }
    }
    meta.insert("counts_per_rev", &shaft.counts_per_rev.to_string())?;
    if let Some(ratio) = shaft.gear_ratio {
        meta.insert("gear_ratio", &ratio.to_string())?;
    }
    if let Some(encoder) = shaft.encoder {
        meta.insert("encoder_shaft", &encoder.to_string())?;
    }
    meta.insert("supply", if measured { "measured" } else { "stated" })?;
    meta.insert("sample_rate_hz", &format!("{:.3}", 1.0 / timing::median_interval(&time_s)))?;
    meta.insert("ended", end.text())?;
    if !holes.is_empty() {
        meta.insert("missing_samples", &holes.join(" "))?;
    }
    Ok(Record {
        name: log.file_stem().map_or_else(String::new, |stem| stem.to_string_lossy().into_owned()),
        path: log.to_path_buf(),
        time_s,
        voltage_v: run.voltage_v(supply_v),
        angle_rad: Some(run.count.iter().map(|count| *count as f64 * shaft.rad_per_count()).collect()),
        supply_v: measured.then_some(supply),
        meta,
        warnings,
        ..Record::default()
    })
}

/// Numbers of the samples that are missing, as `first-last`, by the usual interval.
fn holes(time_s: &[f64]) -> Vec<String> {
    let usual = timing::median_interval(time_s);
    let mut number = 0.0;
    let mut holes = Vec::new();
    for pair in time_s.windows(2) {
        let steps = ((pair[1] - pair[0]) / usual).round().max(1.0);
        if pair[1] - pair[0] > GAP * usual {
            holes.push(format!("{}-{}", number + 1.0, number + steps - 1.0));
        }
        number += steps;
    }
    holes
}

#[cfg(test)]
mod tests {
    use super::*;

    const SHAFT: Shaft = Shaft { counts_per_rev: 1000.0, gear_ratio: Some(10.0), encoder: None };

    fn heard(text: &str) -> Listen {
        let mut listen = Listen::new(0);
        listen.poll(Duration::ZERO, &mut Vec::new());
        listen.receive(text.as_bytes(), Duration::from_millis(5));
        listen
    }

    fn rows(count: u32, row: impl Fn(u32) -> String) -> String {
        let rows: String = (0..count).map(|k| row(k) + "\n").collect();
        format!("# programme: steps\n# duty_full: 200\nt_us,duty,count,supply_mv\n{rows}")
    }

    #[test]
    fn a_run_becomes_a_record_in_si_units() {
        let text = rows(50, |k| format!("{},{},{},10000", 1000 + 4000 * k, 100, -5 * k as i32));
        let listen = heard(&(text + "# lost: 0\n# end: finished\n1,2,3,4\n"));
        let end = listen.end().unwrap();
        assert!(end.finished());
        let record = to_record(listen.run(), end, &SHAFT, 12.0, Path::new("out/steps.csv")).unwrap();
        assert_eq!((record.len(), record.voltage_v[7], record.time_s[2]), (50, 5.0, 0.008));
        assert!((record.angle_rad.unwrap()[10] + 0.05 * std::f64::consts::TAU).abs() < 1e-12);
        assert_eq!(record.meta.get("programme"), Some("steps"));
        assert_eq!(record.meta.get("sample_rate_hz"), Some("250.000"));
        assert_eq!((record.meta.get("supply"), record.warnings.len()), (Some("measured"), 0));
    }

    #[test]
    fn what_is_odd_about_a_run_is_told() {
        let text = rows(60, |k| match k {
            7 => "28000,100,3".to_owned(),
            k => format!("{},{},0,30000", 4000 * k, 201),
        });
        let listen = heard(&(text + "# lost: 4\n# end: stall\n"));
        assert_eq!((listen.damaged(), listen.end()), (1, Some(&End::Told("stall".into()))));
        let record =
            to_record(listen.run(), listen.end().unwrap(), &SHAFT, 12.0, Path::new("x.csv")).unwrap();
        let odd: Vec<&str> = record.warnings.iter().map(|warning| warning.what.as_str()).collect();
        for (warning, word) in odd.iter().zip(["30.00 V", "duty of 201", "7-7", "missed 4 steps"]) {
            assert!(warning.contains(word), "{warning}");
        }
        assert_eq!((odd.len(), record.meta.get("missing_samples")), (4, Some("7-7")));
    }

    #[test]
    fn the_board_is_asked_until_it_begins_then_kept_alive_then_given_up() {
        let mut listen = Listen::new(2);
        let said = |listen: &mut Listen, ms| {
            let mut out = Vec::new();
            listen.poll(Duration::from_millis(ms), &mut out);
            String::from_utf8(out).unwrap()
        };
        assert_eq!(said(&mut listen, 0), "start 2\n");
        assert_eq!(said(&mut listen, 500), "");
        assert_eq!(said(&mut listen, 1001), "start 2\n");
        // The end of an earlier run, of which nothing was heard, and a first sample without its header.
        listen.receive(b"8,1,1,0\n# end: finished\nt_us,duty,count,supply_mv\n0,1,1,0\n", ms(1200));
        assert_eq!((said(&mut listen, 1300).as_str(), listen.run().len()), ("\n", 1));
        assert_eq!(said(&mut listen, 1350), "");
        listen.stop();
        assert_eq!(said(&mut listen, 1360), "stop\n");
        assert_eq!((said(&mut listen, 4300).as_str(), listen.end()), ("", Some(&End::Silent)));

        let mut nobody = heard("");
        nobody.receive(b"hello\n", ms(8));
        assert_eq!(said(&mut nobody, 10_001), "");
        assert!(matches!(nobody.end(), Some(End::Nothing(6, Some(why))) if why.contains("hello")));
    }

    fn ms(ms: u64) -> Duration {
        Duration::from_millis(ms)
    }

    #[test]
    fn a_run_that_was_stopped_before_it_began_is_asked_for_no_more_and_one_that_goes_on_is_stopped_again() {
        let said = |listen: &mut Listen, at: u64| {
            let mut out = Vec::new();
            listen.poll(ms(at), &mut out);
            String::from_utf8(out).unwrap()
        };
        let begun = |listen: &mut Listen| {
            assert_eq!(said(listen, 0), "start 0\n");
            listen.stop();
            assert_eq!(said(listen, 10), "stop\n");
        };
        let mut waits = Listen::new(0);
        begun(&mut waits);
        for at in (20..=3010).step_by(10) {
            assert!(!said(&mut waits, at).contains("start"), "at {at} ms");
        }
        assert_eq!((said(&mut waits, 3020).as_str(), waits.end()), ("", Some(&End::Stopped)));

        let mut late = Listen::new(0);
        begun(&mut late);
        late.receive(b"t_us,duty,count,supply_mv\n0,1,1,0\n", ms(500));
        assert_eq!((said(&mut late, 510).as_str(), said(&mut late, 520).as_str()), ("stop\n", ""));
        assert_eq!(said(&mut late, 610), "stop\n");
        late.receive(b"# end: stopped\n", ms(620));
        assert_eq!((said(&mut late, 710).as_str(), late.end()), ("", Some(&End::Told("stopped".into()))));
    }

    #[test]
    fn a_board_that_starts_anew_begins_a_new_log() {
        let again = rows(3, |k| format!("{},1,0,0", 4000 * k));
        let listen = heard(&(rows(9, |k| format!("{},1,0,0", 4000 * k)) + &again));
        assert_eq!(listen.run().len(), 3);
    }
}
