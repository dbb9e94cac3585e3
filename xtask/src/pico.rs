//! The Pico's unmodified image on an emulated RP2040, with the host's program at the other end of its USB line.

use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::report::Count;
use crate::{arm, emulated, uf2};

/// One short programme, so that an emulator that is slower than the chip ends soon.
const PROGRAMME: [&str; 8] =
    ["--programme", "multisine", "--seconds", "1", "--rate", "500", "--counts-per-rev", "1320"];
/// Pins are off so soon after a fault, ms, at every sampling rate.
const OFF_MS: f64 = 2.0;
/// And so soon where the main loop alone stands, which the watchdog ends: until then every sample is supervised as ever.
const WATCHDOG_MS: f64 = 510.0;

/// Writes the UF2 files of both Picos, and captures from an emulated one.
pub fn tests() -> Result<Count> {
    for pico in &arm::PICOS[1..] {
        uf2::write(pico)?;
    }
    let image = uf2::write(&arm::PICOS[0])?;
    let out = emulated::scratch("pico")?;
    let capture = |fault: &str| {
        emulated::capture("pico.js", &[image.as_os_str(), fault.as_ref()], &PROGRAMME, &out.join(fault), None)
    };
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
    for (fault, name, limit) in [
        ("emergency", "the emergency contact takes the pins down", OFF_MS),
        ("bounce", "a contact that opens for an instant does too, and the motor stays off", OFF_MS),
        ("fault", "a fault of the core takes the pins down", OFF_MS),
        ("hang", "a program that hangs with interrupts off loses the bridge by the NMI", OFF_MS),
        ("circle", "a main loop that runs in a circle is ended by the watchdog", WATCHDOG_MS),
        ("dead", "so does one whose sampling timer stands", OFF_MS),
    ] {
        emulated::case(&mut count, name, || {
            let ended = capture(fault)?;
            ensure!(!ended.success && ended.board.contains("driver off"), "{ended:?}");
            let off: f64 = ended
                .board
                .split("off ")
                .find_map(|rest| rest.split_once(" ms after the fault")?.0.parse().ok())
                .with_context(|| format!("the pins were never off: {ended:?}"))?;
            ensure!(off <= limit, "the pins were off after {off} ms");
            Ok(())
        });
    }
    Ok(count)
}

/// The angles of a log, rad.
fn angles(log: &Path) -> Result<Vec<f64>> {
    let text = std::fs::read_to_string(log).with_context(|| format!("cannot read {}", log.display()))?;
    let rows = text.lines().skip_while(|line| !line.starts_with("time_s")).skip(1);
    rows.map(|row| row.split(',').nth(2).context("a short row")?.parse().context("no number")).collect()
}
