//! The Pico 2's unmodified image on an emulated RP2350 (tests/pico2), with the host's program at the other end of its USB line.

use std::ffi::OsStr;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use anyhow::{Context, Result, ensure};
use motorlens_shared::quickfit::{Float, QuickFit};
use serde::Deserialize;

use crate::pico::{COUNTS, HUNG, OFF_MS, SILENT_MS, same_fit};
use crate::report::Count;
use crate::{arm, emulated, process, uf2};

/// 500 samples in each of the programme's four runs.
const PROGRAMME: [&str; 8] = programme("0.5");
/// A run outlasts the half second after which a silent host is taken for gone.
const LONGER: [&str; 8] = programme("1");
const RATE_HZ: u16 = 1000;
/// Ticks of full voltage: the core's clock by the frequency of the PWM.
const TOP: u16 = (150_000_000_u32 / 20_000) as u16;

/// What is done to the board while its motor is driven, the test's name, when the pins have to be off, ms after it, and what the host says.
type Fault = (&'static str, &'static str, RangeInclusive<f64>, &'static str);
const FAULTS: [Fault; 7] = [
    ("emergency", "the emergency contact takes the Pico 2's pins down", OFF_MS, "emergency input open"),
    ("bounce", "so does one that opens for an instant", OFF_MS, "emergency input open"),
    (
        "fault",
        "so does a fault of its core, which is told after the restart",
        OFF_MS,
        "because a fault of the chip's core",
    ),
    ("hang", "a program that hangs with interrupts off loses the bridge by the NMI", OFF_MS, HUNG),
    ("circle", "a main loop that runs in a circle loses it by the sampling interrupt", OFF_MS, HUNG),
    ("dead", "so does one whose sampling timer stands", OFF_MS, HUNG),
    ("silent", "a host that falls silent for half a second stops the Pico 2's motor", SILENT_MS, "link lost"),
];

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
    for (fault, test, off_ms, told) in FAULTS {
        emulated::case(&mut count, test, || {
            let board = [image.as_os_str(), fault.as_ref()];
            emulated::capture(program, &board, &LONGER, &out.join(fault))?.was_stopped(told, &off_ms)
        });
    }
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
    same_fit::<Float>(&QuickFit::deserialize(&ended.document["fit"])?, out, RATE_HZ, TOP)
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
