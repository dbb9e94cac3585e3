//! The Pico's unmodified image on an emulated RP2040, with the host's program at the other end of its USB line.
//! The Pico 2's runs in another emulator ([`crate::pico2`]).

use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use motorlens_shared::excitation::{Programme, Shape};
use motorlens_shared::quickfit::{Fixed, QuickFit};
use serde::Deserialize;

use crate::picos::{COUNTS, WIRED, angles, captured, checked, fitted, measured, same_fit, stopped};
use crate::report::Count;
use crate::{arm, emulated, process, uf2};

/// One short programme, so that an emulator that is slower than the chip ends soon.
const PROGRAMME: [&str; 8] =
    ["--programme", "multisine", "--seconds", "1", "--rate", "500", "--counts-per-rev", COUNTS];
/// Its rate as a number.
const RATE_HZ: u16 = 500;
/// Volts at which the emulated motor, with its dry friction, breaks away and has made the counts by which that is seen.
const BREAKAWAY_V: RangeInclusive<f64> = 0.48..=1.5;
/// The largest current of its runs, A.
const CURRENT_A: RangeInclusive<f64> = 0.3..=3.0;
/// The README says 8.5 s of such a fit, us.
const FIT_US: u32 = 10_000_000;
/// Ticks of full voltage: the core's clock by the frequency of the PWM.
const TOP: u16 = (125_000_000_u32 / 20_000) as u16;
/// The run at each rate and driver: a step of so many volts and seconds.
const STEP_V: f32 = 9.0;
const STEP_S: f32 = 0.5;
/// With a limit of the current that the motor's own stays below.
const LIMITED: [&str; 4] = ["--amplifier", "165", "--current-limit", "4"];

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
        let fit = QuickFit::deserialize(&ended.document["fit"])?;
        ensure!(fit.micros < FIT_US, "{} us", fit.micros);
        same_fit::<Fixed>(&fit, &out, RATE_HZ, TOP)
    });
    emulated::case(
        &mut count,
        "supply and current in the log are the means of what the converter's inputs had, ripple and all",
        || {
            let ended = capture_with("none", &WIRED, "wired")?;
            ensure!(ended.success, "{ended:?}");
            // The motor's own: what a volt less back-EMF drives through its resistance.
            measured(&out.join("wired/multisine-9v.csv"), &CURRENT_A, 0.3)
        },
    );
    emulated::case(
        &mut count,
        "the README's check finds the wires right and where the motor breaks away",
        || checked("pico.js", &image, &[], &BREAKAWAY_V, &out).map(|_| ()),
    );
    emulated::case(
        &mut count,
        "the README's capture of the default protocol, in shorter runs, loses no sample",
        || captured("pico.js", &image, &out),
    );
    emulated::case(
        &mut count,
        "the README's fit of a whole run with its friction feeds the watchdog on a core without a floating-point unit",
        || fitted("pico.js", &image, &out),
    );
    at_each_rate(&mut count, &image, &out)?;
    stopped(&mut count, "pico.js", &image, &arm::PICOS[0], &PROGRAMME, &LIMITED, &out)?;
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
