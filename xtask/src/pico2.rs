//! The Pico 2's unmodified image on an emulated RP2350 (tests/pico2), with the host's program at the other end of its USB line.

use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use motorlens_shared::quickfit::{Float, QuickFit};
use serde::Deserialize;

use crate::picos::{COUNTS, WIRED, captured, checked, fitted, measured, same_fit, stopped};
use crate::report::Count;
use crate::{arm, emulated, process, uf2};

/// 500 samples in each of the programme's four runs.
const PROGRAMME: [&str; 8] = programme("0.5");
/// A run outlasts the half second after which a silent host is taken for gone.
const LONGER: [&str; 8] = programme("1");
const RATE_HZ: u16 = 1000;
/// The README says 0.13 s of such a fit, us.
const FIT_US: u32 = 200_000;
/// Ticks of full voltage: the core's clock by the frequency of the PWM.
const TOP: u16 = (150_000_000_u32 / 20_000) as u16;
/// Volts at which the emulated motor, which has no dry friction, has made the counts by which that it turns is seen.
const BREAKAWAY_V: RangeInclusive<f64> = 0.05..=1.0;
/// The largest current of its runs, A.
const CURRENT_A: RangeInclusive<f64> = 0.3..=7.0;
/// With a limit of the current that the motor's own stays below.
const LIMITED: [&str; 4] = ["--amplifier", "165", "--current-limit", "7"];

const fn programme(seconds: &'static str) -> [&'static str; 8] {
    ["--programme", "multisine", "--seconds", seconds, "--rate", "1000", "--counts-per-rev", COUNTS]
}

/// Writes the UF2 file, runs the emulator's own tests on it and captures from it.
pub fn tests() -> Result<Count> {
    let image = uf2::write(&arm::PICOS[1])?;
    let mut tests = cargo("test");
    tests.arg("--no-fail-fast").env("MOTORLENS_PICO2", &image);
    let mut count = process::run_tests(&mut tests)?;
    process::run(&mut cargo("build"))?;
    let program = target().join("release/motorlens-pico2");
    let program = program.to_str().context("a path in Unicode")?;
    let out = emulated::scratch("pico2")?;
    emulated::case(
        &mut count,
        "four runs come from the Pico 2 without a gap, and its fit is the host's, to the bit",
        || captured_and_fitted(program, &image, &out.join("fit")),
    );
    emulated::case(
        &mut count,
        "the Pico 2's log has the means of what its converter's inputs had, ripple and all",
        || {
            let out = out.join("wired");
            let options = [&PROGRAMME[..], &WIRED].concat();
            let ended = emulated::capture(program, &[image.as_os_str()], &options, &out)?;
            ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
            measured(&out.join("multisine-9v.csv"), &CURRENT_A, 0.5)
        },
    );
    emulated::case(
        &mut count,
        "the README's check finds the Pico 2's wires right, its divider too, and where the motor breaks away",
        || {
            let ended = checked(program, &image, &WIRED, &BREAKAWAY_V, &out)?;
            let findings = ended.document["findings"].as_array().context("no findings")?;
            ensure!(
                findings.iter().any(|found| found["check"] == "supply" && found["ok"] == true),
                "{ended:?}"
            );
            Ok(())
        },
    );
    emulated::case(
        &mut count,
        "the README's capture, in shorter runs, loses no sample of the Pico 2's",
        || captured(program, &image, &out),
    );
    emulated::case(
        &mut count,
        "the README's fit of a whole run with its friction feeds the Pico 2's watchdog",
        || fitted(program, &image, &out),
    );
    stopped(&mut count, program, &image, &arm::PICOS[1], &LONGER, &LIMITED, &out)?;
    Ok(count)
}

/// One caller captures, and the next has the board fit what it keeps of the last run.
fn captured_and_fitted(program: &str, image: &Path, out: &Path) -> Result<()> {
    let board: [&OsStr; 3] = [image.as_os_str(), "none".as_ref(), "2".as_ref()];
    let ended = emulated::talk(program, &board, |port| {
        let mut capture = emulated::motorlens(&["--json", "capture", "--keep-every", "1", "--port", port]);
        let told = process::output(capture.args(PROGRAMME).arg("--out").arg(out))?;
        let document: serde_json::Value = serde_json::from_str(&told)?;
        let logs = document["logs"].as_array().context("no logs")?;
        ensure!(logs.len() == 4, "not four logs: {told}");
        ensure!(logs.iter().all(|log| log["missing"] == 0 && log["samples"] == 500), "{told}");
        let mut fit = emulated::motorlens(&["--json", "device", "fit", "--port", port]);
        fit.args(["--counts-per-rev", COUNTS]);
        Ok(fit)
    })?;
    ensure!(ended.success && ended.board.contains(" 0 resets"), "{ended:?}");
    let fit = QuickFit::deserialize(&ended.document["fit"])?;
    ensure!(fit.micros < FIT_US, "{} us", fit.micros);
    same_fit::<Float>(&fit, out, RATE_HZ, TOP)
}

/// A cargo command in the emulated board's workspace.
fn cargo(subcommand: &str) -> std::process::Command {
    let mut command = process::cargo();
    command.current_dir(directory()).args([subcommand, "--release", "--locked"]);
    command.env("CARGO_TARGET_DIR", target());
    command
}

/// What is built there goes here, apart from the host's build.
fn target() -> PathBuf {
    process::target().join("pico2")
}

/// The directory of that workspace.
fn directory() -> PathBuf {
    process::root().join("tests/pico2")
}
