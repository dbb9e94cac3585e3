//! An MJCF in MuJoCo itself, by its Python package: what its integrator makes of a voltage.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

use motorlens_kernel::Reading;

use super::Exported;
use crate::model_file::Model;
use crate::stop;

/// Loads the files, steps, and writes what the sensor shows.
const PROGRAM: &str = include_str!("in_mujoco.py");

/// What is shown at the start and after each step of MuJoCo, which has a voltage of `volts` each; `exported` is `model`, and begins at an
/// angle, rad, and a speed, rad/s. Tells what share of the steps is done. Fails with why there is no run, a clause: most have no MuJoCo.
pub(super) fn run(
    model: &Model,
    exported: &Exported,
    python: &Path,
    volts: &[f64],
    [angle, speed]: [f64; 2],
    tell: &dyn Fn(f64),
) -> Result<Vec<Reading<f64>>, String> {
    let directory = tempfile::tempdir().map_err(|e| e.to_string())?;
    let file = directory.path().join("motor.xml");
    let write = |path: &Path, content: &[u8]| std::fs::write(path, content).map_err(|e| e.to_string());
    write(&file, &exported.content)?;
    if let Some((ending, text)) = &exported.beside {
        write(&file.with_extension(ending), text.as_bytes())?;
    }
    let bytes: Vec<u8> = volts.iter().flat_map(|volts| volts.to_ne_bytes()).collect();
    write(&file.with_extension("volts"), &bytes)?;
    let said = file.with_extension("said");
    let started = Command::new(python)
        .args(["-c", PROGRAM])
        .arg(&file)
        .args([angle, speed].map(|x| format!("{x:?}")))
        .stdin(Stdio::null())
        .stdout(Stdio::piped())
        .stderr(std::fs::File::create(&said).map_err(|e| e.to_string())?)
        .spawn()
        .map_err(|_| format!("there is no Python \"{}\" here", python.display()))?;
    let ended = watched(started, &|steps| tell(steps / volts.len() as f64))?;
    if !ended.success() {
        let said = std::fs::read(&said).unwrap_or_default();
        let said = String::from_utf8_lossy(&said);
        return Err(said.lines().last().unwrap_or("Python ended without a word").to_owned());
    }
    let shown = std::fs::read(file.with_extension("shown")).map_err(|e| e.to_string())?;
    let numbers: Vec<f64> = shown
        .chunks_exact(8)
        .filter_map(|number| Some(f64::from_ne_bytes(number.try_into().ok()?)))
        .collect();
    if numbers.len() != 2 * volts.len() {
        return Err(format!("it stopped after {} of {} steps", numbers.len() / 2, volts.len()));
    }
    // A reading may be behind the shaft, at the beginning too.
    let first = [model.start_moving(1e-3, angle, speed).angle_rad(), speed];
    let later = numbers.chunks_exact(2).map(|shown| [shown[0], shown[1]]);
    Ok(std::iter::once(first).chain(later).collect())
}

/// Waits for a program that prints how many steps it has done, and ends it where the search on this thread is to stop.
fn watched(mut program: Child, tell: &dyn Fn(f64)) -> Result<ExitStatus, String> {
    const PATIENCE: Duration = Duration::from_millis(100);
    let (lines, told) = channel();
    if let Some(out) = program.stdout.take() {
        std::thread::spawn(move || {
            BufReader::new(out).lines().map_while(Result::ok).try_for_each(|line| lines.send(line))
        });
    }
    loop {
        match told.recv_timeout(PATIENCE) {
            Ok(line) => {
                if let Ok(steps) = line.parse::<f64>() {
                    tell(steps);
                }
            }
            Err(RecvTimeoutError::Timeout) => {}
            Err(RecvTimeoutError::Disconnected) => break,
        }
        if stop::asked() {
            drop(program.kill());
            break;
        }
    }
    program.wait().map_err(|e| e.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Format, Options, export};

    #[test]
    fn without_a_python_it_says_so() {
        let model =
            Model::read(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json").as_ref()).unwrap();
        let exported = export(&model, Format::Mujoco, &Options::default()).unwrap();
        let why = run(&model, &exported, Path::new("no-such-python"), &[1.0], [0.0; 2], &|_| {}).unwrap_err();
        assert!(why.contains("no Python \"no-such-python\""), "{why}");
    }

    /// A program that says how far it is and would go on for a minute.
    #[cfg(unix)]
    #[test]
    fn a_run_tells_how_far_it_is_and_ends_when_it_is_to_stop() {
        use std::cell::RefCell;
        use std::time::Instant;

        use crate::stop::Stop;

        let slow = Command::new("sh")
            .args(["-c", "echo 20; echo 40; exec sleep 60"])
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let (stop, seen, begun) = (Stop::default(), RefCell::new(Vec::new()), Instant::now());
        let ended = stop.heeded_by(|| {
            watched(slow, &|steps| {
                seen.borrow_mut().push(steps);
                if steps >= 40.0 {
                    stop.ask();
                }
            })
        });
        assert!(!ended.unwrap().success() && begun.elapsed() < Duration::from_secs(30));
        assert_eq!(seen.into_inner(), [20.0, 40.0]);
    }
}
