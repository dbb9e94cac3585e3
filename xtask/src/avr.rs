//! The Arduino sketch, compiled for an Uno with Debian's tool chain and run on an emulated one.

use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;

use anyhow::{Context, Result, ensure};

use crate::emulated::{self, Board, Ended};
use crate::report::Count;
use crate::{apt, documented, process};

/// Debian's Arduino core.
const CORE: &str = "/usr/share/arduino/hardware/arduino/avr";
/// Flash of an Uno less its boot loader, and RAM less what the stack is left, bytes.
const FLASH_LIMIT: u64 = 32_256;
const RAM_LIMIT: u64 = 2048 - 768;
/// A sketch that people are to read.
const LINES: usize = 150;

const COMPILE: [&str; 9] = [
    "-mmcu=atmega328p",
    "-DF_CPU=16000000L",
    "-DARDUINO=10819",
    "-DARDUINO_AVR_UNO",
    "-DARDUINO_ARCH_AVR",
    // The core asks C++ for what Debian's older compiler gives only to C.
    "-DDECIMAL_DIG=__DECIMAL_DIG__",
    "-Os",
    "-ffunction-sections",
    "-fdata-sections",
];
const CPP: [&str; 3] = ["-std=gnu++11", "-fno-exceptions", "-fno-threadsafe-statics"];

/// Compiles the sketch and returns its Intel HEX file; prints its sizes, fails when they are over the Uno's.
pub fn build() -> Result<PathBuf> {
    apt::ensure_apt(&["gcc-avr", "avr-libc", "binutils-avr", "arduino-core-avr"])?;
    let sketch = process::root().join("firmware/arduino/motorlens/motorlens.ino");
    let lines = std::fs::read_to_string(&sketch).context("cannot read the sketch")?.lines().count();
    ensure!(lines <= LINES, "the sketch has {lines} lines, of {LINES} at most");
    let out = process::root().join("target/avr");
    std::fs::create_dir_all(&out).context("cannot make target/avr")?;

    let object = out.join("sketch.o");
    let mut compile = compiler("avr-g++");
    compile.args(CPP).args(["-Wall", "-Wextra", "-Werror", "-include", "Arduino.h", "-x", "c++", "-c"]);
    process::run(compile.arg(&sketch).arg("-o").arg(&object))?;
    let mut objects = vec![object];
    for entry in std::fs::read_dir(Path::new(CORE).join("cores/arduino"))? {
        let source = entry?.path();
        let object = out.join(source.file_name().unwrap_or_default()).with_extension("core.o");
        let mut compile = match source.extension().and_then(|end| end.to_str()) {
            Some("c") => compiler("avr-gcc"),
            Some("cpp") => compiler("avr-g++"),
            _ => continue,
        };
        if source.extension().is_some_and(|end| end == "cpp") {
            compile.args(CPP);
        }
        process::run(compile.args(["-w", "-c"]).arg(&source).arg("-o").arg(&object))?;
        objects.push(object);
    }
    let elf = out.join("motorlens.elf");
    let mut link = Command::new("avr-gcc");
    link.args(["-mmcu=atmega328p", "-Os", "-Wl,--gc-sections", "-o"]).arg(&elf).args(&objects).arg("-lm");
    process::run(&mut link)?;
    sizes(&elf)?;
    let hex = elf.with_extension("hex");
    process::run(Command::new("avr-objcopy").args(["-O", "ihex", "-R", ".eeprom"]).arg(&elf).arg(&hex))?;
    Ok(hex)
}

fn compiler(name: &str) -> Command {
    let mut command = Command::new(name);
    command.args(COMPILE).arg(format!("-I{CORE}/cores/arduino")).arg(format!("-I{CORE}/variants/standard"));
    command
}

fn sizes(elf: &Path) -> Result<()> {
    let told = process::output(Command::new("avr-size").arg(elf))?;
    let numbers: Vec<u64> = told
        .lines()
        .nth(1)
        .unwrap_or_default()
        .split_whitespace()
        .take(3)
        .filter_map(|number| number.parse().ok())
        .collect();
    let [text, data, bss] = numbers[..] else { anyhow::bail!("avr-size told no sizes: {told}") };
    let (flash, ram) = (text + data, data + bss);
    println!(
        "Arduino Uno      flash {flash} bytes of {FLASH_LIMIT}, RAM {ram} of {RAM_LIMIT} without the stack"
    );
    ensure!(flash <= FLASH_LIMIT && ram <= RAM_LIMIT, "the sketch does not fit an Uno");
    Ok(())
}

/// The options of the command that the README prints for such a board, but for its port and its directory.
fn listening() -> Result<Vec<String>> {
    let shape = "capture --listen --port PORT --supply 12 --counts-per-rev COUNTS --out DIR";
    let line = documented::line(&process::root(), shape).context("the README prints no such command")?;
    let mut words = line.as_run("", Path::new(""));
    words.remove(0);
    for option in ["--port", "--out"] {
        let at = words.iter().position(|word| word == option).context("the shape has it")?;
        words.drain(at..at + 2);
    }
    Ok(words)
}

/// Compiles the sketch and captures with `motorlens capture --listen` from an emulated Uno.
pub fn tests() -> Result<Count> {
    let hex = build()?;
    let out = emulated::scratch("uno")?;
    let line = listening()?;
    let line: Vec<&str> = line.iter().map(String::as_str).collect();
    let capture = |name: &str, fault: &str| {
        emulated::capture("uno.js", &[hex.as_os_str(), fault.as_ref()], &line, &out.join(name))
    };
    let mut count = Count::default();
    emulated::case(&mut count, "five runs are captured, and discover finds the friction in them", || {
        let ended = capture("sound", "none")?;
        ensure!(ended.success, "{ended:?}");
        ensure!(ended.document["logs"].as_array().map(Vec::len) == Some(5), "not five logs: {ended:?}");
        let found = emulated::discover(&out.join("sound"))?;
        ensure!(found["effects"][0] == "coulomb", "found {}", found["effects"]);
        ensure!(found["noise_floor_rad"].is_number(), "the repeat was not recognised: {found}");
        Ok(())
    });
    let stopped = |ended: Ended, cause: &str, log: &Path| {
        let why = ended.document["error"]["why"].as_str().unwrap_or_default().to_owned();
        ensure!(!ended.success && why.contains(cause), "{ended:?}");
        let text = std::fs::read_to_string(log).context("the log so far is not kept")?;
        ensure!(text.contains(&format!("# ended: {cause}")), "the log does not say {cause}");
        ensure!(ended.board.contains("driver off"), "the driver is left on: {ended:?}");
        Ok(())
    };
    emulated::case(&mut count, "a shaft that sticks ends the run with the driver off", || {
        stopped(capture("jam", "jam")?, "stall", &out.join("jam/staircase.csv"))
    });
    emulated::case(&mut count, "the emergency contact ends the run with the driver off", || {
        stopped(capture("contact", "emergency")?, "emergency", &out.join("contact/staircase.csv"))
    });
    emulated::case(&mut count, "Ctrl-C ends the run with the driver off", || {
        let board = [hex.as_os_str(), "tell".as_ref()];
        let ended = emulated::capture_until_told("uno.js", &board, &line, &out.join("ctrl-c"))?;
        stopped(ended, "stopped", &out.join("ctrl-c/staircase.csv"))
    });
    emulated::case(&mut count, "an encoder too fast for interrupts is told", || {
        let ended = capture("fast", "fast")?;
        let faults = ended.document["logs"][0]["data_faults"].to_string();
        ensure!(faults.contains("missed"), "lost steps are not told: {ended:?}");
        Ok(())
    });
    emulated::case(&mut count, "a terminal shows speed and voltage while a run goes on", || {
        let board = [hex.as_os_str(), "jam".as_ref()];
        let (ended, shown) = emulated::capture_on_terminal("uno.js", &board, &line, &out.join("terminal"))?;
        stopped(ended, "stall", &out.join("terminal/staircase.csv"))?;
        for part in ["staircase", "speed    ", " rad/s", "voltage  "] {
            ensure!(shown.contains(part), "no {part:?} in {shown:?}");
        }
        // The staircase rises until the shaft is blocked: duties of 40 to 200 of 255, the latest the highest so far.
        let levels = ["1.88", "3.76", "5.65", "7.53", "9.41"];
        ensure!(levels.iter().any(|level| shown.contains(&format!("\u{2588} {level} V"))), "{shown:?}");
        Ok(())
    });
    // Without the host's program, which asks once a second.
    let first_run = |turned: &str, ask: &dyn Fn(&mut TcpStream, &mut Board) -> Result<()>, name: &str| {
        let fault = format!("crank:{turned}");
        emulated::speak("uno.js", &[hex.as_os_str(), fault.as_ref()], |mut line, board| {
            ask(&mut line, board)?;
            let mut said = String::new();
            BufReader::new(line).read_line(&mut said)?;
            ensure!(said.starts_with(&format!("# programme: {name}")), "the board said {said:?}");
            Ok(())
        })
    };
    emulated::case(&mut count, "a run asked for while the shaft turns begins once it rests", || {
        first_run("3", &|line, _| Ok(line.write_all(b"start 0\n")?), "staircase")
    });
    emulated::case(
        &mut count,
        "a request is forgotten where the shaft turns for more than five seconds",
        || {
            let ask = |line: &mut TcpStream, board: &mut Board| -> Result<()> {
                line.write_all(b"start 0\n")?;
                let told = board.line()?;
                ensure!(told == "rested for 2 s", "{told:?}");
                Ok(line.write_all(b"start 1\n")?)
            };
            first_run("7", &ask, "triangle")
        },
    );
    Ok(count)
}
