//! Runs one kernel so many times and prints how many samples one time has. Counted from outside, by callgrind:
//! the difference between two numbers of times, divided by the samples, is what a sample costs.

use std::hint::black_box;

use anyhow::{Context, Result, bail};
use motorlens::paper::sines;
use motorlens::search::dispatch::{LANES, Level};
use motorlens::search::{Candidates, Records};
use motorlens_peers::nonlinear::Nonlinear;
use motorlens_shared::linear::{Filter, absolute_error};
use motorlens_shared::motor::PaperMotor;

fn main() -> Result<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [level, kernel, times] = &arguments[..] else {
        bail!("usage: instructions baseline|avx2 linear|linear-scalar|nonlinear TIMES");
    };
    let level = match level.as_str() {
        "baseline" => Level::Baseline,
        "avx2" => Level::Avx2,
        other => bail!("no level {other}"),
    };
    if !level.present() {
        bail!("this processor lacks {}", level.name());
    }
    let times: u32 = times.parse().context("TIMES is a number")?;
    let motor = sines::motor();
    let records = sines::records(100);
    let one = &records[1];
    let single = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let samples = match kernel.as_str() {
        "linear" => {
            let prepared = Records::new(&records, level)?;
            let motors = [motor.combinations(); LANES];
            let mut candidates = Candidates::default();
            prepared.discretise(&motors, &mut candidates);
            let mut iae = [0.0; LANES];
            for _ in 0..times {
                prepared.iae_of(black_box(&candidates), &mut iae);
            }
            black_box(iae);
            prepared.samples()
        }
        "linear-scalar" => {
            let filter = Filter::<f32>::gather(&[filter_of(&motor, one.dt)]);
            let quiet: Vec<[f32; 3]> = one.voltage.iter().map(|v| [*v as f32, 0.5, 0.25]).collect();
            let mut sum = [0.0];
            for _ in 0..times {
                absolute_error(black_box(&filter), &quiet, &mut sum);
            }
            black_box(sum);
            quiet.len()
        }
        "nonlinear" => {
            let (voltages, measured) = (single(&one.voltage), single(&one.measured));
            for _ in 0..times {
                black_box(level.run(Nonlinear::<f32> { voltages: &voltages, measured: &measured }));
            }
            voltages.len()
        }
        other => bail!("no kernel {other}"),
    };
    println!("{samples}");
    Ok(())
}

fn filter_of(motor: &PaperMotor, step: f64) -> Filter<f64> {
    use motorlens_shared::linear::{Hold, Kind};
    Filter::new(&motor.combinations(), step, Hold::Zero, Kind::Angle)
}
