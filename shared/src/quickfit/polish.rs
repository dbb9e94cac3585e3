//! Levenberg-Marquardt from the search's best, on the step model, with Coulomb friction where asked.

use super::Kept;
use crate::base::{Base, Coefficients};
use crate::lanes::Lanes;
use crate::scalar::Scalar;
use crate::step::{Drive, Laws, State, step};
use nalgebra::{SMatrix, SVector};

/// The motor's parameters: logarithms of gain, tau_m, tau_e; Coulomb friction in V.
const MOTOR: usize = 4;
const FRICTION: usize = 3;
/// With them, where within its count the encoder stood at the first sample.
const OFFSET: usize = 4;
const PARAMETERS: usize = 5;
/// The model and one variation of each of the motor's parameters go through the record side by side.
const LANES: usize = MOTOR + 1;
/// Share by which a parameter is varied to find its derivative: large enough for `f32` to see.
const VARIATION: f64 = 4e-3;
/// Samples summed in `f32` before the sums move to `f64`, which is slow software on the board.
const FLUSH: usize = 64;
/// Sweeps over the record at most.
const SWEEPS: u32 = 16;
/// The tried step is accepted with these shares of damping, and refused with the other.
const EASE: f64 = 0.1;
const BRAKE: f64 = 8.0;

/// Simulations in one sweep.
pub const SIMULATIONS: u32 = LANES as u32;

type Wide = Lanes<f32, LANES>;
type Normal = SMatrix<f64, PARAMETERS, PARAMETERS>;
type Gradient = SVector<f64, PARAMETERS>;

/// A motor with friction, per count.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Model {
    /// Counts per volt second.
    pub gain: f32,
    /// s.
    pub tau_m: f32,
    /// s.
    pub tau_e: f32,
    /// V.
    pub coulomb: f32,
    /// Counts to add to the prediction.
    pub offset: f32,
}

/// Where the polish ended.
#[derive(Clone, Copy)]
pub struct Polished {
    pub model: Model,
    /// Sum of squared errors, counts squared.
    pub square_sum: f64,
    /// Sum of absolute errors, counts.
    pub absolute_sum: f64,
    /// Of gain, tau_m and tau_e relative, of the friction in V, of the offset in counts.
    pub standard_errors: [f64; PARAMETERS],
}

/// One sweep: errors of a model and their derivatives, summed up.
struct Sweep {
    normal: Normal,
    gradient: Gradient,
    square_sum: f64,
    absolute_sum: f64,
}

/// Fits from `start`; `swept` is called after each sweep, `working` after each few samples. Friction stays where it is unless `coulomb`.
pub fn run(
    samples: &[Kept],
    step_s: f32,
    start: Model,
    coulomb: bool,
    swept: &mut dyn FnMut(),
    working: &mut dyn FnMut(),
) -> Polished {
    let peak = samples.iter().fold(0.0_f32, |peak, sample| peak.max(Scalar::abs(sample[0])));
    let mut sweep_of = |model: &Model| {
        let sweep = sweep(samples, step_s, model, VARIATION as f32 * peak, coulomb, working);
        swept();
        sweep
    };
    let mut model = start;
    let mut best = sweep_of(&model);
    let mut damping = 1e-2;
    for _ in 1..SWEEPS {
        let Some(change) = solve(&best, damping) else { break };
        let tried = moved(&model, &change, step_s, peak);
        let sweep = sweep_of(&tried);
        if sweep.square_sum < best.square_sum {
            let gained = 1.0 - sweep.square_sum / best.square_sum;
            (model, best) = (tried, sweep);
            damping = (damping * EASE).max(1e-9);
            if gained < 1e-4 {
                break;
            }
        } else {
            damping *= BRAKE;
            if damping > 1e6 {
                break;
            }
        }
    }
    let free = if coulomb { PARAMETERS } else { PARAMETERS - 1 };
    let variance = best.square_sum / samples.len().saturating_sub(free).max(1) as f64;
    let inverse = best.normal.cholesky().map(|factor| factor.inverse());
    let standard_errors = core::array::from_fn(|k| {
        inverse.map_or(f64::INFINITY, |inverse| libm::sqrt(variance * inverse[(k, k)]))
    });
    Polished { model, square_sum: best.square_sum, absolute_sum: best.absolute_sum, standard_errors }
}

/// The damped Gauss-Newton step.
fn solve(sweep: &Sweep, damping: f64) -> Option<Gradient> {
    let mut normal = sweep.normal;
    for k in 0..PARAMETERS {
        normal[(k, k)] += damping * sweep.normal[(k, k)];
    }
    normal.cholesky().map(|factor| -factor.solve(&sweep.gradient))
}

/// The model one step further, within what the step map can represent.
fn moved(model: &Model, change: &Gradient, step_s: f32, peak: f32) -> Model {
    // Not the float's own clamp: its panic message would bring float formatting into the image.
    let within = |value: f32, low: f32, high: f32| value.max(low).min(high);
    let grown = |value: f32, by: f64| value * libm::exp(by.clamp(-1.0, 1.0)) as f32;
    Model {
        gain: grown(model.gain, change[0]),
        tau_m: within(grown(model.tau_m, change[1]), 1e-3, 20.0),
        tau_e: within(grown(model.tau_e, change[2]), step_s / 40.0, 0.2),
        coulomb: within(model.coulomb + change[FRICTION] as f32, 0.0, peak),
        offset: model.offset + change[OFFSET] as f32,
    }
}

#[inline(never)]
fn sweep(
    samples: &[Kept],
    step_s: f32,
    model: &Model,
    friction_step: f32,
    coulomb: bool,
    working: &mut dyn FnMut(),
) -> Sweep {
    // Lane 0 is the model; lane k + 1 varies parameter k.
    let varied = |value: f32, k: usize| {
        let mut lanes = [value; LANES];
        lanes[k + 1] = value * (1.0 + VARIATION as f32);
        Lanes(lanes)
    };
    let base = Base {
        gain: varied(model.gain, 0),
        tau_m: varied(model.tau_m, 1),
        tau_e: varied(model.tau_e, 2),
        viscous_share: Wide::zero(),
    };
    let mut friction = [model.coulomb; LANES];
    friction[FRICTION + 1] += friction_step;
    let coefficients = Coefficients::new(&base, Wide::splat(step_s));
    // Per unit of the parameter: of the logarithm for the first three, of the volt for friction.
    let logarithmic = libm::log(1.0 + VARIATION) as f32;
    let per: [f32; MOTOR] = [1.0 / logarithmic, 1.0 / logarithmic, 1.0 / logarithmic, 1.0 / friction_step];

    let mut total =
        Sweep { normal: Normal::zeros(), gradient: Gradient::zeros(), square_sum: 0.0, absolute_sum: 0.0 };
    let mut state = State::<Wide>::rest();
    for block in samples.chunks(FLUSH) {
        let mut normal = [[0.0_f32; PARAMETERS]; PARAMETERS];
        let mut gradient = [0.0_f32; PARAMETERS];
        let (mut square, mut absolute) = (0.0_f32, 0.0_f32);
        for [voltage, _, measured] in block {
            let angle = state.angle.0;
            let error = angle[0] + model.offset - measured;
            let mut slope = [1.0; PARAMETERS];
            for k in 0..MOTOR {
                slope[k] = (angle[k + 1] - angle[0]) * per[k];
            }
            for row in 0..PARAMETERS {
                gradient[row] += slope[row] * error;
                for column in 0..=row {
                    normal[row][column] += slope[row] * slope[column];
                }
            }
            square += error * error;
            absolute += Scalar::abs(error);
            let drive = Drive {
                friction_forward: Lanes(friction),
                friction_backward: Lanes(friction),
                ..Drive::plain(Wide::splat(*voltage))
            };
            step(&coefficients, Laws { dry: true, ..Laws::default() }, &mut state, &drive);
        }
        for row in 0..PARAMETERS {
            total.gradient[row] += f64::from(gradient[row]);
            for column in 0..=row {
                total.normal[(row, column)] += f64::from(normal[row][column]);
            }
        }
        total.square_sum += f64::from(square);
        total.absolute_sum += f64::from(absolute);
        working();
    }
    if !coulomb {
        // Hold friction: an equation of its own, solved by no change.
        total.gradient[FRICTION] = 0.0;
        for k in 0..PARAMETERS {
            let unit = if k == FRICTION { 1.0 } else { 0.0 };
            total.normal[(FRICTION.max(k), FRICTION.min(k))] = unit;
        }
    }
    for row in 0..PARAMETERS {
        for column in 0..row {
            total.normal[(column, row)] = total.normal[(row, column)];
        }
    }
    total
}
