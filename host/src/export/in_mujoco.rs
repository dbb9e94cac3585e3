//! An MJCF in MuJoCo itself, by its Python package: what its integrator makes of a voltage.

use std::path::Path;
use std::process::{Command, Stdio};

use motorlens_kernel::Reading;

use super::Exported;
use crate::model_file::Model;

/// Loads the files, steps, and writes what the sensor shows.
const PROGRAM: &str = include_str!("in_mujoco.py");

/// What is shown at the start and after each step of MuJoCo, which has a voltage of `volts` each; `exported` is `model`, and begins at an
/// angle, rad, and a speed, rad/s. Fails with why there is no run, a clause: most have no MuJoCo.
pub(super) fn run(
    model: &Model,
    exported: &Exported,
    python: &Path,
    volts: &[f64],
    [angle, speed]: [f64; 2],
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
    let ended = Command::new(python)
        .args(["-c", PROGRAM])
        .arg(&file)
        .args([angle, speed].map(|x| format!("{x:?}")))
        .stdin(Stdio::null())
        .output()
        .map_err(|_| format!("there is no Python \"{}\" here", python.display()))?;
    if !ended.status.success() {
        let said = String::from_utf8_lossy(&ended.stderr);
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::export::{Format, Options, export};

    #[test]
    fn without_a_python_it_says_so() {
        let model =
            Model::read(concat!(env!("CARGO_MANIFEST_DIR"), "/examples/model.json").as_ref()).unwrap();
        let exported = export(&model, Format::Mujoco, &Options::default()).unwrap();
        let why = run(&model, &exported, Path::new("no-such-python"), &[1.0], [0.0; 2]).unwrap_err();
        assert!(why.contains("no Python \"no-such-python\""), "{why}");
    }
}
