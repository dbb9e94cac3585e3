//! What both emulated Picos are asked, each in its own emulator ([`crate::pico`], [`crate::pico2`]).

use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Sample, Scaling};
use motorlens_shared::quickfit::{Arithmetic, Keeper, QuickFit, Request, fit};
use object::{Object, ObjectSymbol, SymbolKind};

use crate::emulated::{self, Ended};
use crate::report::Count;
use crate::{arm, documented, process};

/// Counts of the encoder in a turn of the output shaft.
pub const COUNTS: &str = "1320";
/// What the README prints first for a board that is wired.
const CHECK: &str = "device check --port PORT";
/// And then; here each of its runs takes so long, s, instead of eight: an emulator is several times slower than its chip.
const CAPTURE: &str = "capture --port PORT --programme default --counts-per-rev COUNTS --out DIR";
const SHORTENED: [&str; 2] = ["--seconds", "1"];
/// And at last; here after a run that leaves as many samples for it as one of eight seconds does, of which every fifth is kept.
const FIT: &str = "device fit --port PORT --counts-per-rev COUNTS --coulomb";
const KEPT: u64 = 1600;
const KEPT_RUN: [&str; 6] = ["--rate", "2000", "--keep-every", "1", "--counts-per-rev", COUNTS];
const KEPT_RUN_S: f32 = 0.8;
/// What the emulated boards' converters have at their inputs.
pub const WIRED: [&str; 4] = ["--divider", "11", "--amplifier", "165"];
/// The stated supply, mV.
const SUPPLY_MV: u16 = 12_000;
/// Pins are off so soon after a fault, ms, at every sampling rate.
const OFF_MS: RangeInclusive<f64> = 0.0..=2.0;
/// And so soon after the host's last word: half a second, of which some may be over when the line goes silent.
const SILENT_MS: RangeInclusive<f64> = 300.0..=502.0;
/// What the board tells after a restart that it has noted no other reason for.
const HUNG: &str = "because the firmware hung";

/// What is done to an emulated board while its motor is driven.
struct Fault {
    /// Its name there.
    name: &'static str,
    /// The test's.
    test: &'static str,
    /// The driver, as board and `capture` call it.
    driver: &'static str,
    /// More for `capture`.
    options: &'static [&'static str],
    /// When the pins have to be off, ms after it.
    off_ms: RangeInclusive<f64>,
    /// What the host says of it, after the watchdog's restart where there is one; nothing where the watchdog stands too, and the board
    /// does not come back.
    told: &'static str,
}

/// A fault at a driver with an enable, after which the pins are off at once.
fn fault(name: &'static str, told: &'static str, test: &'static str) -> Fault {
    Fault { name, test, driver: "brake", options: &[], off_ms: OFF_MS, told }
}

/// All of them; a current is `limited` by these options, above what the motor's own comes to.
fn faults(limited: &'static [&'static str]) -> [Fault; 13] {
    [
        fault("emergency", "emergency input open", "the emergency contact takes the pins down"),
        Fault {
            driver: "in-in",
            ..fault("emergency", "emergency input open", "and both inputs of a driver that has no enable")
        },
        fault(
            "bounce",
            "emergency input open",
            "a contact that opens for an instant does too, and the motor stays off",
        ),
        fault(
            "fault",
            "because a fault of the chip's core",
            "a fault of the core takes the pins down and is told after the restart",
        ),
        fault("panic", "because the firmware found itself at fault", "so does a panic, and so is it"),
        fault("hang", HUNG, "a program that hangs with interrupts off loses the bridge by the NMI"),
        fault("circle", HUNG, "a main loop that runs in a circle loses it by the sampling interrupt"),
        fault("dead", HUNG, "so does one whose sampling timer stands"),
        Fault { options: &WIRED, ..fault("pumped", "measured supply", "and a supply that is pumped up") },
        Fault { options: limited, ..fault("short", "over-current", "and a current above its limit") },
        Fault {
            off_ms: SILENT_MS,
            ..fault("silent", "link lost", "a host that falls silent for half a second stops the motor")
        },
        fault("crystal", "", "a crystal that stops while the PLL swings on takes the pins down"),
        fault(
            "crystal-back",
            "because the chip's crystal stopped",
            "and where it swings again the watchdog starts the board anew, which says so",
        ),
    ]
}

impl Fault {
    /// Captures `programme` from the board in `script`, to which `done` happens, and fails where its motor was not stopped in time.
    fn stops(&self, script: &str, image: &Path, done: &str, programme: &[&str], out: &Path) -> Result<()> {
        let board: [&OsStr; 4] = [image.as_os_str(), done.as_ref(), "1".as_ref(), self.driver.as_ref()];
        let options: Vec<&str> = [programme, self.options, &["--drive", self.driver]].concat();
        let logs = out.join(format!("{}-{}", self.name, self.driver));
        emulated::capture(script, &board, &options, &logs)?.was_stopped(self.told, &self.off_ms)
    }
}

/// Does every fault to the board of `image`, one after the other, and counts those after which its motor was stopped in time.
pub fn stopped(
    count: &mut Count,
    script: &str,
    image: &Path,
    pico: &arm::Pico,
    programme: &[&str],
    limited: &'static [&'static str],
    out: &Path,
) -> Result<()> {
    let panic = panic_of(pico)?;
    for fault in faults(limited) {
        let done = if fault.name == "panic" { panic.as_str() } else { fault.name };
        emulated::case(count, fault.test, || fault.stops(script, image, done, programme, out));
    }
    Ok(())
}

/// The command of this shape that the README prints.
fn printed(shape: &str) -> Result<documented::Line> {
    documented::line(&process::root(), shape).context("the README prints no such command")
}

/// Runs the README's check of the wires with `more` behind it, and fails where it finds one wrong or the motor breaks away elsewhere.
pub fn checked(
    script: &str,
    image: &Path,
    more: &[&str],
    breakaway_v: &RangeInclusive<f64>,
    out: &Path,
) -> Result<Ended> {
    let check = printed(CHECK)?;
    let ended = emulated::talk(script, &[image.as_os_str(), "none".as_ref()], |port| {
        let mut command = emulated::motorlens(&["--json"]);
        command.args(check.as_run(port, out)).args(more);
        Ok(command)
    })?;
    ensure!(ended.success && ended.document["ok"] == true, "{ended:?}");
    for way in [0, 1] {
        let volts = ended.document["breakaway_v"][way].as_f64();
        ensure!(volts.is_some_and(|volts| breakaway_v.contains(&volts)), "{ended:?}");
    }
    Ok(ended)
}

/// Runs the README's capture of the default protocol, in shorter runs, and fails where a sample is lost.
pub fn captured(script: &str, image: &Path, out: &Path) -> Result<()> {
    let capture = printed(CAPTURE)?;
    let out = out.join("readme");
    let ended = emulated::talk(script, &[image.as_os_str(), "none".as_ref()], |port| {
        let mut command = emulated::motorlens(&["--json"]);
        command.args(capture.as_run(port, &out)).args(SHORTENED);
        Ok(command)
    })?;
    ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
    let logs = ended.document["logs"].as_array().context("no logs")?;
    ensure!(logs.len() == 7, "not seven logs: {ended:?}");
    ensure!(logs.iter().all(|log| log["missing"] == 0 && log["samples"] == 1000), "{ended:?}");
    Ok(())
}

/// Runs the README's fit with friction after a run, and fails where it leaves samples out or the board starts anew meanwhile.
pub fn fitted(script: &str, image: &Path, out: &Path) -> Result<()> {
    let fit = printed(FIT)?;
    let programme = out.join("kept.json");
    let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 2.0, high_hz: 20.0, tones: 8, seed: 2 };
    let kept = Programme::single("kept", shape, KEPT_RUN_S);
    std::fs::write(&programme, serde_json::to_string(&kept)?)?;
    let board: [&OsStr; 3] = [image.as_os_str(), "none".as_ref(), "2".as_ref()];
    let ended = emulated::talk(script, &board, |port| {
        let mut capture = emulated::motorlens(&["--quiet", "capture", "--port", port]);
        capture.args(KEPT_RUN).arg("--programme").arg(&programme).arg("--out").arg(out.join("kept"));
        process::run(&mut capture)?;
        let mut command = emulated::motorlens(&["--json"]);
        command.args(fit.as_run(port, out));
        Ok(command)
    })?;
    ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
    ensure!(ended.document["fit"]["samples"] == KEPT, "{ended:?}");
    Ok(())
}

/// The fault by which a board's program panics: with the address of the variable that points to its control.
fn panic_of(pico: &arm::Pico) -> Result<String> {
    let image = arm::build_pico(pico)?;
    let bytes = std::fs::read(&image).with_context(|| format!("cannot read {}", image.display()))?;
    let file = object::File::parse(&*bytes)?;
    // Mangled: the name's length stands before it.
    let found = file.symbols().find(|symbol| {
        symbol.kind() == SymbolKind::Data && symbol.name().is_ok_and(|name| name.contains("7CONTROL"))
    });
    Ok(format!("panic:{}", found.context("the image has no variable CONTROL")?.address()))
}

/// Fails where supply and current in a log are not the means of what the converter's inputs had, ripple and all: the stated supply, and the
/// motor's own current, of which the largest is within `most_a` and the mean of a run that ends nearly as it began is small.
pub fn measured(log: &Path, most_a: &RangeInclusive<f64>, mean_a: f64) -> Result<()> {
    let [supply, current] = [column(log, "supply_v")?, column(log, "current_a")?];
    let nominal = f64::from(SUPPLY_MV) * 1e-3;
    let off = supply.iter().map(|v| (v - nominal).abs()).fold(0.0, f64::max);
    ensure!(off < 0.012, "the supply is {off} V off");
    let most = current.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
    let mean = current.iter().sum::<f64>() / current.len() as f64;
    ensure!(most_a.contains(&most) && mean.abs() < mean_a, "{most} A at most, {mean} A in the mean");
    Ok(())
}

/// Fits the last of the logs in a directory, of 500 samples, as the board does in its arithmetic `A`, with `top` ticks of full voltage, and
/// fails where a bit differs.
pub fn same_fit<A: Arithmetic>(board: &QuickFit, logs: &Path, rate_hz: u16, top: u16) -> Result<()> {
    let mut last = None;
    for entry in std::fs::read_dir(logs)? {
        let entry = entry?;
        let age = entry.metadata()?.modified()?;
        if last.as_ref().is_none_or(|(latest, _)| age > *latest) {
            last = Some((age, entry.path()));
        }
    }
    let (_, log) = last.context("no logs")?;
    let text = std::fs::read_to_string(&log)?;
    ensure!(text.contains("# pwm_hz: 20000"), "another PWM: {}", log.display());
    let rad_per_count = std::f64::consts::TAU / COUNTS.parse::<f64>()?;
    let mut keeper = Keeper::new(Scaling { pwm_top: top, rate_hz }, 1);
    for row in text.lines().skip_while(|line| !line.starts_with("time_s")).skip(1) {
        let number = |place: usize| -> Result<f64> {
            Ok(row.split(',').nth(place).with_context(|| format!("a short row: {row}"))?.parse()?)
        };
        // The log has volts and rad; the board has ticks and counts, which are whole.
        let duty = (number(1)? * 1000.0 / f64::from(SUPPLY_MV) * f64::from(top)).round() as i16;
        let count = (number(2)? / rad_per_count).round() as i32;
        keeper.push(&Sample { duty, count, supply_mv: SUPPLY_MV, current_ma: 0, late_us: 0 });
    }
    let request = Request { rad_per_count: rad_per_count as f32, ..Request::default() };
    let host =
        fit::<A>(keeper.samples(), keeper.step_s(), &request, |_| (), || ()).context("nothing to fit")?;
    println!("{} samples in {} us on the board: {:?}", board.samples, board.micros, board.gain);
    let board = QuickFit { micros: 0, micros_search: 0, ..*board };
    ensure!(board == host && board.samples == 500, "the board {board:?}, the host {host:?}");
    Ok(())
}

/// The angles of a log, rad.
pub fn angles(log: &Path) -> Result<Vec<f64>> {
    column(log, "angle_rad")
}

/// A column of a log.
fn column(log: &Path, name: &str) -> Result<Vec<f64>> {
    let text = std::fs::read_to_string(log).with_context(|| format!("cannot read {}", log.display()))?;
    let mut rows = text.lines().skip_while(|line| !line.starts_with("time_s"));
    let head = rows.next().context("no head")?;
    let place =
        head.split(',').position(|other| other == name).with_context(|| format!("no {name}: {head}"))?;
    rows.map(|row| row.split(',').nth(place).context("a short row")?.parse().context("no number")).collect()
}
