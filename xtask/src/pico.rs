//! The Pico's unmodified image on an emulated RP2040, with the host's program at the other end of its USB line.
//! The Pico 2's runs in another emulator ([`crate::pico2`]).

use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::link::{Sample, Scaling};
use motorlens_shared::quickfit::{Arithmetic, Fixed, Keeper, QuickFit, Request, fit};
use object::{Object, ObjectSymbol, SymbolKind};
use serde::Deserialize;

use crate::report::Count;
use crate::{arm, documented, emulated, process, uf2};

/// One short programme, so that an emulator that is slower than the chip ends soon.
const PROGRAMME: [&str; 8] =
    ["--programme", "multisine", "--seconds", "1", "--rate", "500", "--counts-per-rev", COUNTS];
/// Its rate as a number.
const RATE_HZ: u16 = 500;
/// Counts of the encoder in a turn of the output shaft.
pub const COUNTS: &str = "1320";
/// What the README prints first for a board that is wired.
const CHECK: &str = "device check --port PORT";
/// And then; here each of its runs takes so long, s, instead of eight: an emulator is four times slower than the chip.
const CAPTURE: &str = "capture --port PORT --programme default --counts-per-rev COUNTS --out DIR";
const SHORTENED: [&str; 2] = ["--seconds", "1"];
/// And at last; here after a run that leaves as many samples for it as one of eight seconds does, of which every fifth is kept.
const FIT: &str = "device fit --port PORT --counts-per-rev COUNTS --coulomb";
const KEPT: u64 = 1600;
const KEPT_RUN: [&str; 6] = ["--rate", "2000", "--keep-every", "1", "--counts-per-rev", COUNTS];
const KEPT_RUN_S: f32 = 0.8;
/// Volts at which the emulated motor, with its dry friction, breaks away and has made the counts by which that is seen.
const BREAKAWAY_V: RangeInclusive<f64> = 0.48..=1.5;
/// What the emulated board's converter has at its inputs.
const WIRED: [&str; 4] = ["--divider", "11", "--amplifier", "165"];
/// Ticks of full voltage: the core's clock by the frequency of the PWM.
const TOP: u16 = (125_000_000_u32 / 20_000) as u16;
/// The stated supply, mV.
const SUPPLY_MV: u16 = 12_000;
/// Pins are off so soon after a fault, ms, at every sampling rate.
pub const OFF_MS: RangeInclusive<f64> = 0.0..=2.0;
/// And so soon after the host's last word: half a second, of which some may be over when the line goes silent.
pub const SILENT_MS: RangeInclusive<f64> = 300.0..=502.0;
/// The run at each rate and driver: a step of so many volts and seconds.
const STEP_V: f32 = 9.0;
const STEP_S: f32 = 0.5;

/// What is done to the emulated Pico.
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
const fn fault(name: &'static str, told: &'static str, test: &'static str) -> Fault {
    Fault { name, test, driver: "brake", options: &[], off_ms: OFF_MS, told }
}

/// With a limit of the current that the motor's own stays below.
const LIMITED: [&str; 4] = ["--amplifier", "165", "--current-limit", "4"];
/// What the board tells after a restart that it has noted no other reason for.
pub const HUNG: &str = "because the firmware hung";
const FAULTS: [Fault; 13] = [
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
    Fault { options: &LIMITED, ..fault("short", "over-current", "and a current above its limit") },
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
];

/// Writes the UF2 file, and captures from an emulated Pico.
pub fn tests() -> Result<Count> {
    let image = uf2::write(&arm::PICOS[0])?;
    let out = emulated::scratch("pico")?;
    let capture_with = |fault: &str, more: &[&str], name: &str| {
        let options = [&PROGRAMME, more].concat();
        emulated::capture("pico.js", &[image.as_os_str(), fault.as_ref()], &options, &out.join(name))
    };
    let capture = |fault: &str| capture_with(fault, &[], fault);
    let mut count = Count::default();
    emulated::case(
        &mut count,
        "four runs are captured over USB without a gap, and the repeat repeats",
        || {
            let ended = capture("none")?;
            ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
            let logs = ended.document["logs"].as_array().context("no logs")?;
            ensure!(logs.len() == 4, "not four logs: {ended:?}");
            ensure!(logs.iter().all(|log| log["missing"] == 0 && log["samples"] == 500), "{ended:?}");
            let (first, again) = (
                angles(&out.join("none/multisine-9v.csv"))?,
                angles(&out.join("none/multisine-9v-repeat.csv"))?,
            );
            let apart = |(a, b): (&f64, &f64)| ((a - first[0]) - (b - again[0])).abs();
            let worst = first.iter().zip(&again).map(apart).fold(0.0, f64::max);
            let span = first.iter().fold(0.0_f64, |most, angle| most.max((angle - first[0]).abs()));
            // Where the shaft rests within a count, and within dry friction, differs from run to run.
            ensure!(span > 0.5 && worst < 0.05 * span, "the repeat is {worst} rad off, of {span}");
            Ok(())
        },
    );
    emulated::case(&mut count, "the fit on the board is the host's of the same log, to the bit", || {
        let out = out.join("fit");
        let ended = emulated::talk("pico.js", &[image.as_os_str(), "none".as_ref(), "2".as_ref()], |port| {
            let mut capture =
                emulated::motorlens(&["--quiet", "capture", "--keep-every", "1", "--port", port]);
            process::run(capture.args(PROGRAMME).arg("--out").arg(&out))?;
            let mut fit = emulated::motorlens(&["--json", "device", "fit", "--port", port]);
            fit.args(["--counts-per-rev", COUNTS]);
            Ok(fit)
        })?;
        ensure!(ended.success, "{ended:?}");
        same_fit::<Fixed>(&QuickFit::deserialize(&ended.document["fit"])?, &out, RATE_HZ, TOP)
    });
    emulated::case(
        &mut count,
        "supply and current in the log are the means of what the converter's inputs had, ripple and all",
        || {
            let ended = capture_with("none", &WIRED, "wired")?;
            ensure!(ended.success, "{ended:?}");
            let log = out.join("wired/multisine-9v.csv");
            let [supply, current] = [column(&log, "supply_v")?, column(&log, "current_a")?];
            let off = supply.iter().map(|v| (v - 12.0).abs()).fold(0.0, f64::max);
            ensure!(off < 0.012, "the supply is {off} V off");
            // The motor's own: what a volt less back-EMF drives through its resistance.
            let most = current.iter().fold(0.0_f64, |most, a| most.max(a.abs()));
            let mean = current.iter().sum::<f64>() / current.len() as f64;
            ensure!((0.3..3.0).contains(&most) && mean.abs() < 0.3, "{most} A at most, {mean} A in the mean");
            Ok(())
        },
    );
    emulated::case(
        &mut count,
        "the README's check finds the wires right and where the motor breaks away",
        || {
            let check =
                documented::line(&process::root(), CHECK).context("the README prints no such command")?;
            let ended = emulated::talk("pico.js", &[image.as_os_str(), "none".as_ref()], |port| {
                let mut command = emulated::motorlens(&["--json"]);
                command.args(check.as_run(port, &out));
                Ok(command)
            })?;
            ensure!(ended.success && ended.document["ok"] == true, "{ended:?}");
            for way in [0, 1] {
                let volts = ended.document["breakaway_v"][way].as_f64();
                ensure!(volts.is_some_and(|volts| BREAKAWAY_V.contains(&volts)), "{ended:?}");
            }
            Ok(())
        },
    );
    emulated::case(
        &mut count,
        "the README's capture of the default protocol, in shorter runs, loses no sample",
        || {
            let out = out.join("readme");
            let capture =
                documented::line(&process::root(), CAPTURE).context("the README prints no such command")?;
            let ended = emulated::talk("pico.js", &[image.as_os_str(), "none".as_ref()], |port| {
                let mut command = emulated::motorlens(&["--json"]);
                command.args(capture.as_run(port, &out)).args(SHORTENED);
                Ok(command)
            })?;
            ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
            let logs = ended.document["logs"].as_array().context("no logs")?;
            ensure!(logs.len() == 7, "not seven logs: {ended:?}");
            ensure!(logs.iter().all(|log| log["missing"] == 0 && log["samples"] == 1000), "{ended:?}");
            Ok(())
        },
    );
    emulated::case(
        &mut count,
        "the README's fit of a whole run with its friction feeds the watchdog on a core without a floating-point unit",
        || {
            let fit = documented::line(&process::root(), FIT).context("the README prints no such command")?;
            let programme = out.join("kept.json");
            let shape = Shape::Multisine { amplitude_v: 9.0, low_hz: 2.0, high_hz: 20.0, tones: 8, seed: 2 };
            let kept = Programme::single("kept", shape, KEPT_RUN_S);
            std::fs::write(&programme, serde_json::to_string(&kept)?)?;
            let board: [&OsStr; 3] = [image.as_os_str(), "none".as_ref(), "2".as_ref()];
            let ended = emulated::talk("pico.js", &board, |port| {
                let mut capture = emulated::motorlens(&["--quiet", "capture", "--port", port]);
                capture.args(KEPT_RUN).arg("--programme").arg(&programme).arg("--out").arg(out.join("kept"));
                process::run(&mut capture)?;
                let mut command = emulated::motorlens(&["--json"]);
                command.args(fit.as_run(port, &out));
                Ok(command)
            })?;
            ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
            ensure!(ended.document["fit"]["samples"] == KEPT, "{ended:?}");
            Ok(())
        },
    );
    at_each_rate(&mut count, &image, &out)?;
    let control = format!("panic:{}", address_of("CONTROL")?);
    for fault in &FAULTS {
        emulated::case(&mut count, fault.test, || {
            let done = if fault.name == "panic" { control.as_str() } else { fault.name };
            let board: [&OsStr; 4] = [image.as_os_str(), done.as_ref(), "1".as_ref(), fault.driver.as_ref()];
            let options: Vec<&str> = [&PROGRAMME[..], fault.options, &["--drive", fault.driver]].concat();
            let logs = out.join(format!("{}-{}", fault.name, fault.driver));
            emulated::capture("pico.js", &board, &options, &logs)?.was_stopped(fault.told, &fault.off_ms)
        });
    }
    Ok(count)
}

/// A short run at the rates that [`PROGRAMME`] is not, and one with a driver that lets go in the off part.
fn at_each_rate(count: &mut Count, image: &Path, out: &Path) -> Result<()> {
    let programme = out.join("step.json");
    let step = Programme::single("step", Shape::Step { level_v: STEP_V }, STEP_S);
    std::fs::write(&programme, serde_json::to_string(&step)?)?;
    let mut braked = None;
    for rate in ["100", "1000", "2000"] {
        emulated::case(
            count,
            &format!("{rate} samples a second hold the shaft's own counts, none missing"),
            || {
                let (travel, _) = stepped(image, &programme, rate, "brake", &out.join(rate))?;
                braked = Some(travel);
                Ok(())
            },
        );
    }
    emulated::case(count, "a driver that floats in the off part is captured and named in the log", || {
        let braked = braked.context("there is none that brakes to compare with")?;
        let (travel, log) = stepped(image, &programme, "500", "coast", &out.join("coast"))?;
        ensure!(std::fs::read_to_string(log)?.contains("sign_magnitude_coast"), "the log does not say so");
        // In the off part its current flows on against the supply.
        ensure!((0.1..0.9).contains(&(travel / braked)), "{travel} rad, {braked} with a brake");
        Ok(())
    });
    Ok(())
}

/// Captures the step, compares the log with what the shaft's counter had, and returns how far it turned, rad, and the log.
fn stepped(image: &Path, programme: &Path, rate: &str, driver: &str, out: &Path) -> Result<(f64, PathBuf)> {
    std::fs::create_dir_all(out)?;
    let counts = out.join("counts.json");
    let board: [&OsStr; 5] =
        [image.as_os_str(), "none".as_ref(), "1".as_ref(), driver.as_ref(), counts.as_os_str()];
    let programme = programme.to_str().context("a path in Unicode")?;
    let options = ["--programme", programme, "--rate", rate, "--drive", driver, "--counts-per-rev", COUNTS];
    let ended = emulated::capture("pico.js", &board, &options, out)?;
    ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
    let log = &ended.document["logs"][0];
    let samples = (STEP_S * rate.parse::<f32>()?).round();
    ensure!(log["missing"] == 0 && log["samples"] == samples as u64, "{ended:?}");
    let log = PathBuf::from(log["log"].as_str().context("no path")?);
    let angles = angles(&log)?;
    let counts: Vec<f64> = serde_json::from_str(&std::fs::read_to_string(&counts)?)?;
    // Below 1000 samples a second the sampling timer interrupts between them too, each millisecond.
    let apart = 1000_usize.div_ceil(rate.parse()?);
    let rad_per_count = std::f64::consts::TAU / COUNTS.parse::<f64>()?;
    // An edge may come between the interrupt and the counter's being read, at the first sample and at this one.
    let agrees = |first: &usize| {
        angles.iter().enumerate().all(|(number, angle)| {
            counts.get(first + apart * number).is_some_and(|count| {
                let moved = (angle - angles[0]) / rad_per_count;
                (moved - (count - counts[*first])).abs() < 2.5
            })
        })
    };
    ensure!(
        (0..counts.len()).any(|first| agrees(&first)),
        "the log is not what the shaft did: {}",
        log.display()
    );
    let span = angles.iter().fold(0.0_f64, |most, angle| most.max((angle - angles[0]).abs()));
    ensure!(span > 0.5, "the shaft turned by {span} rad");
    Ok((span, log))
}

/// Where the Pico's image keeps a variable.
fn address_of(variable: &str) -> Result<u64> {
    let image = arm::build_pico(&arm::PICOS[0])?;
    let bytes = std::fs::read(&image).with_context(|| format!("cannot read {}", image.display()))?;
    let file = object::File::parse(&*bytes)?;
    // Mangled: the name's length stands before it.
    let mangled = format!("{}{variable}", variable.len());
    let found = file.symbols().find(|symbol| {
        symbol.kind() == SymbolKind::Data && symbol.name().is_ok_and(|name| name.contains(&mangled))
    });
    Ok(found.with_context(|| format!("the image has no variable {variable}"))?.address())
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
fn angles(log: &Path) -> Result<Vec<f64>> {
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
