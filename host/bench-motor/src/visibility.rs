//! Whether records can show an effect at all: what it changes beyond what the linear motor's own parameters take over, as a
//! multiple of what two runs differ by.

use crate::bench::Setup;
use crate::case::{self, Log};
use crate::disturbance::Disturbance;
use crate::plant::Physics;
use crate::sensor::Sensor;

/// Size of `physics` and `sensor` against `without`, in multiples of the noise, on the training programmes. Two measures, the
/// larger counts: the error itself and its differences over a tenth of a second.
pub fn visibility(setup: &Setup, without: &(Physics, Sensor), seed: u64) -> f64 {
    let calm = |physics: &Physics, sensor: &Sensor| Setup {
        physics: physics.clone(),
        sensor: sensor.clone(),
        disturbance: Disturbance::NONE,
        ..setup.clone()
    };
    let with = calm(&setup.physics, &setup.sensor);
    let bare = calm(&without.0, &without.1);
    // Enough to tell, and not the whole protocol again.
    let which: Vec<usize> = (0..setup.programmes.len().min(4)).step_by(2).collect();
    let logs = |setup: &Setup, again: u64| -> Vec<Log> {
        which
            .iter()
            .map(|k| case::record(setup, &setup.programmes[*k], seed ^ (k + 1) as u64, again))
            .collect()
    };
    // In closed loop both follow the goal: the voltages of the real one are played to the other.
    let real = logs(&with, 0);
    let replay = |mut setup: Setup| {
        setup.loop_gain = 0.0;
        for (k, log) in which.iter().zip(&real) {
            setup.programmes[*k].values = log.voltage_v.clone();
        }
        setup
    };
    let bare = replay(bare);
    let other = logs(&bare, 0);
    let changed = |change: fn(&mut Setup)| {
        let mut setup = bare.clone();
        change(&mut setup);
        logs(&setup, 0)
    };
    let mut directions = vec![
        changed(|s| s.motor.constant *= 1.01),
        changed(|s| s.motor.inertia *= 1.02),
        changed(|s| s.motor.damping *= 1.1),
    ];
    if setup.physics.gravity.0 > 0.0 && without.0.gravity.0 > 0.0 {
        directions.push(changed(|s| s.physics.gravity.0 *= 1.05));
    }
    let mut noisy = setup.clone();
    noisy.loop_gain = 0.0;
    noisy.programmes = bare.programmes.clone();
    let (first, second) = (logs(&noisy, 1), logs(&noisy, 2));
    let lag = (0.1 * setup.rate).round() as usize;
    let of = |log: &[Log], base: &[Log], differences: bool| -> Vec<f64> {
        let mut all = Vec::new();
        for (a, b) in log.iter().zip(base) {
            let d: Vec<f64> = a.reading().iter().zip(b.reading()).map(|(a, b)| a - b).collect();
            if differences {
                all.extend(d.windows(lag + 1).map(|w| w[lag] - w[0]));
            } else {
                all.extend(d);
            }
        }
        all
    };
    let measure = |differences: bool| {
        let mut effect = of(&real, &other, differences);
        let mut basis: Vec<Vec<f64>> = Vec::new();
        for log in &directions {
            let mut d = of(log, &other, differences);
            basis.iter().for_each(|b| take(&mut d, b));
            let size = norm(&d);
            if size > 0.0 {
                d.iter_mut().for_each(|x| *x /= size);
                basis.push(d);
            }
        }
        basis.iter().for_each(|b| take(&mut effect, b));
        let noise = norm(&of(&first, &second, differences)) / std::f64::consts::SQRT_2;
        let counting = setup.reading_step() / 12.0_f64.sqrt() * (effect.len() as f64).sqrt();
        norm(&effect) / noise.max(counting).max(1e-12)
    };
    measure(false).max(measure(true))
}

fn norm(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum::<f64>().sqrt()
}

/// Takes the part along the unit vector `b` from `x`.
fn take(x: &mut [f64], b: &[f64]) {
    let along: f64 = x.iter().zip(b).map(|(x, b)| x * b).sum();
    x.iter_mut().zip(b).for_each(|(x, b)| *x -= along * b);
}
