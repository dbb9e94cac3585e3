//! The Pico's unmodified image on an emulated RP2040, with the host's program at the other end of its USB line.
//!
//! The Pico 2's image is built, measured and proved ([`crate::sizes`]), and run nowhere: `rp2350-emu` 0.2.6 has the core, PIO, timers
//! and watchdog of its chip, but neither the USB that the host talks through nor the masks that send an interrupt to the NMI.

use std::path::Path;

use anyhow::{Context, Result, ensure};
use motorlens_shared::link::{Sample, Scaling};
use motorlens_shared::quickfit::{Fixed, Keeper, QuickFit, Request, fit};
use serde::Deserialize;

use crate::report::Count;
use crate::{arm, emulated, process, uf2};

/// One short programme, so that an emulator that is slower than the chip ends soon.
const PROGRAMME: [&str; 8] =
    ["--programme", "multisine", "--seconds", "1", "--rate", "500", "--counts-per-rev", COUNTS];
/// Counts of the encoder in a turn of the output shaft.
const COUNTS: &str = "1320";
/// What the emulated board's converter has at its inputs.
const WIRED: [&str; 4] = ["--divider", "11", "--amplifier", "165"];
/// Ticks of full voltage: the core's clock by the frequency of the PWM.
const TOP: u16 = (125_000_000_u32 / 20_000) as u16;
/// The stated supply, mV.
const SUPPLY_MV: u16 = 12_000;
/// Pins are off so soon after a fault, ms, at every sampling rate.
const OFF_MS: f64 = 2.0;

/// Writes the UF2 files of both Picos, and captures from an emulated one.
pub fn tests() -> Result<Count> {
    for pico in &arm::PICOS[1..] {
        uf2::write(pico)?;
    }
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
        same_fit(&QuickFit::deserialize(&ended.document["fit"])?, &out)
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
    for (fault, name) in [
        ("emergency", "the emergency contact takes the pins down"),
        ("bounce", "a contact that opens for an instant does too, and the motor stays off"),
        ("fault", "a fault of the core takes the pins down"),
        ("hang", "a program that hangs with interrupts off loses the bridge by the NMI"),
        ("circle", "a main loop that runs in a circle loses it by the sampling interrupt"),
        ("dead", "so does one whose sampling timer stands"),
        ("pumped", "and a supply that is pumped up"),
        ("crystal", "a crystal that stops while the PLL swings on takes the pins down"),
    ] {
        emulated::case(&mut count, name, || {
            let wired: &[&str] = if fault == "pumped" { &WIRED } else { &[] };
            let ended = capture_with(fault, wired, fault)?;
            ensure!(!ended.success && ended.board.contains("driver off"), "{ended:?}");
            let off: f64 = ended
                .board
                .split("off ")
                .find_map(|rest| rest.split_once(" ms after the fault")?.0.parse().ok())
                .with_context(|| format!("the pins were never off: {ended:?}"))?;
            ensure!(off <= OFF_MS, "the pins were off after {off} ms");
            Ok(())
        });
    }
    Ok(count)
}

/// Fits the last of the logs in a directory as the board does, and fails where a bit differs.
fn same_fit(board: &QuickFit, logs: &Path) -> Result<()> {
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
    let mut keeper = Keeper::new(Scaling { pwm_top: TOP, rate_hz: 500 }, 1);
    for row in text.lines().skip_while(|line| !line.starts_with("time_s")).skip(1) {
        let number = |place: usize| -> Result<f64> {
            Ok(row.split(',').nth(place).with_context(|| format!("a short row: {row}"))?.parse()?)
        };
        // The log has volts and rad; the board has ticks and counts, which are whole.
        let duty = (number(1)? * 1000.0 / f64::from(SUPPLY_MV) * f64::from(TOP)).round() as i16;
        let count = (number(2)? / rad_per_count).round() as i32;
        keeper.push(&Sample { duty, count, supply_mv: SUPPLY_MV, current_ma: 0, late_us: 0 });
    }
    let request = Request { rad_per_count: rad_per_count as f32, ..Request::default() };
    let host = fit::<Fixed>(keeper.samples(), keeper.step_s(), &request, |_| ()).context("nothing to fit")?;
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
