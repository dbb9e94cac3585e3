use super::*;
use crate::base::{Base, Coefficients};
use crate::excitation::{Player, Programme, Shape};
use crate::step::{Drive, Laws, State, step};
use std::vec::Vec;

const STEP: f32 = 2e-3;
const COUNT: f64 = core::f64::consts::TAU / 3000.0;

/// Four seconds of a multisine on a known motor with a quantised encoder, in f64.
fn record(gain: f64, coulomb: f64) -> Vec<Kept> {
    let shape = Shape::Multisine { amplitude_v: 8.0, low_hz: 0.25, high_hz: 12.0, tones: 8, seed: 3 };
    let player = Player::new(&Programme::single("test", shape, 4.0), 500).unwrap();
    let base = Base { gain, tau_m: 0.045, tau_e: 0.0015, viscous_share: 0.0 };
    let coefficients = Coefficients::new(&base, f64::from(STEP));
    let mut state = State::<f64>::rest();
    let mut integral = 0.0;
    player
        .map(|volts| {
            let kept = [volts, integral as f32, libm::floor(state.angle / COUNT) as f32];
            integral += f64::from(STEP * volts);
            let drive = Drive {
                friction_forward: coulomb,
                friction_backward: coulomb,
                ..Drive::plain(f64::from(volts))
            };
            step(&coefficients, Laws { dry: true, ..Laws::default() }, &mut state, &drive);
            kept
        })
        .collect()
}

fn request(coulomb: bool) -> Request {
    Request { coulomb, rad_per_count: COUNT as f32, ..Request::default() }
}

fn close(estimate: Estimate, truth: f32, share: f32) {
    assert!((estimate.value / truth - 1.0).abs() < share, "{estimate:?} should be {truth}");
    assert!(estimate.standard_error.is_finite() && estimate.standard_error > 0.0, "{estimate:?}");
}

#[test]
fn the_frictionless_motor_is_found_to_a_count() {
    let fit = fit::<Float>(&record(0.9, 0.0), STEP, &request(false), |_| (), || ()).unwrap();
    close(fit.gain, 0.9, 2e-3);
    close(fit.tau_m, 0.045, 5e-3);
    close(fit.tau_e, 0.0015, 0.1);
    assert!(fit.rmse < COUNT as f32, "rmse {}", fit.rmse);
    assert!(fit.iae <= fit.iae_search * 1.01);
    assert_eq!(fit.coulomb, None);
}

#[test]
fn friction_is_found_when_asked_for_and_makes_the_fit_better() {
    let samples = record(0.9, 0.7);
    let without = fit::<Float>(&samples, STEP, &request(false), |_| (), || ()).unwrap();
    let with = fit::<Float>(&samples, STEP, &request(true), |_| (), || ()).unwrap();
    close(with.coulomb.unwrap(), 0.7, 0.02);
    close(with.gain, 0.9, 0.01);
    close(with.tau_m, 0.045, 0.03);
    assert!(with.rmse < 0.1 * without.rmse, "{} against {}", with.rmse, without.rmse);
}

#[test]
fn an_encoder_that_counts_backwards_gives_a_negative_gain() {
    let fit = fit::<Float>(&record(-0.9, 0.0), STEP, &request(false), |_| (), || ()).unwrap();
    close(fit.gain, -0.9, 2e-3);
}

#[test]
fn progress_falls_and_covers_every_generation() {
    let mut seen = Vec::new();
    fit::<Float>(&record(0.9, 0.2), STEP, &request(false), |progress| seen.push(progress), || ()).unwrap();
    // The polish repeats the last one.
    seen.dedup();
    assert_eq!(seen.len(), 40);
    assert!(
        seen.windows(2)
            .all(|pair| pair[1].iae <= pair[0].iae && pair[1].generation == pair[0].generation + 1)
    );
}

#[test]
fn who_feeds_a_watchdog_is_called_after_every_two_candidates_and_every_64_samples_of_a_sweep() {
    let samples = record(0.9, 0.2);
    let (mut told, mut worked) = (0, 0);
    fit::<Fixed>(&samples, STEP, &request(true), |_| told += 1, || worked += 1).unwrap();
    let (generations, sweeps) = (40, told - 40);
    // The best of a generation of 16 is not simulated again in the next.
    assert!(sweeps >= 3, "{sweeps}");
    assert_eq!(worked, 8 * generations + samples.len().div_ceil(64) * sweeps);
}

#[test]
fn nothing_comes_of_nothing() {
    assert_eq!(fit::<Float>(&record(0.9, 0.0)[..FEWEST - 1], STEP, &request(false), |_| (), || ()), None);
    assert_eq!(fit::<Float>(&[[0.0, 0.0, 0.0]; 200], STEP, &request(false), |_| (), || ()), None);
}

#[test]
fn the_fixed_point_search_leads_to_the_same_motor() {
    let samples = record(0.9, 0.0);
    let float = fit::<Float>(&samples, STEP, &request(false), |_| (), || ()).unwrap();
    let fixed = fit::<Fixed>(&samples, STEP, &request(false), |_| (), || ()).unwrap();
    // Two ways through the search end within a standard error of each other.
    for (one, other) in [(float.gain, fixed.gain), (float.tau_m, fixed.tau_m), (float.tau_e, fixed.tau_e)] {
        assert!((one.value - other.value).abs() < one.standard_error, "{one:?} and {other:?}");
    }
}

#[test]
fn a_candidate_has_the_same_error_in_floating_and_in_fixed_point() {
    let samples = record(0.9, 0.0);
    let gain = (0.9 / COUNT) as f32;
    let record = Record { samples: &samples, step_s: STEP, gain, peak_v: 8.0 };
    let motors = [[gain, 0.045, 0.0015], [1.5 * gain, 0.2, 0.004]];
    let (mut float, mut fixed) = ([0.0; 2], [0.0; 2]);
    Float::absolute_sums(&record, &motors, &mut float);
    Fixed::absolute_sums(&record, &motors, &mut fixed);
    for (float, fixed) in float.iter().zip(fixed) {
        // A tenth of a count per sample: neither is exact.
        assert!((float - fixed).abs() < 0.1 * samples.len() as f64, "{float} and {fixed} counts");
    }
}
