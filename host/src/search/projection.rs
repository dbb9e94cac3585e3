//! Least squares with the gain projected out: two unknowns are searched, the third follows.
//!
//! The prediction is gain * v(rates), so for given rates the best gain is y.v / v.v, and what is left depends
//! on two numbers only (Golub and Pereyra, 1973; the Jacobian as Kaufman simplified it, 1975).

use super::dispatch::{DOUBLES, Work};
use super::record::Records;
use motorlens_shared::linear::{Filter, Laned, Sample, State};
use motorlens_shared::motor::Combinations;

/// A linear motor by numbers that are natural to search: gain, ln(beta / alpha) and ln(alpha), which for a
/// fast electrical part are the logarithms of the mechanical and the electrical rate.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rates {
    pub gain: f64,
    pub slow: f64,
    pub fast: f64,
}

impl Rates {
    pub fn of(motor: &Combinations) -> Self {
        Self {
            gain: motor.gain(),
            slow: (motor.a3_over_a1 / motor.a2_over_a1).ln(),
            fast: motor.a2_over_a1.ln(),
        }
    }

    pub fn combinations(&self) -> Combinations {
        let (slow, fast) = (self.slow.exp(), self.fast.exp());
        Combinations { b_over_a1: self.gain * slow * fast, a2_over_a1: fast, a3_over_a1: slow * fast }
    }

    /// Within what a record of any sensible rate could show: 1e-5 to 1e5 1/s, and 1e-5 to 1e7 1/s.
    fn moved(&self, slow: f64, fast: f64) -> Self {
        Self {
            slow: (self.slow + slow).clamp(-11.5, 11.5),
            fast: (self.fast + fast).clamp(-11.5, 16.1),
            ..*self
        }
    }
}

/// Step of the forward difference in a logarithm.
const DIFFERENCE: f64 = 1e-5;
/// Relative fall of the squared error below which the search has arrived.
const ARRIVED: f64 = 1e-7;
const MOST_STEPS: u32 = 40;

/// What one pass over the records tells about a pair of rates.
struct Look {
    squared: f64,
    gain: f64,
    /// J'e and J'J of the projected problem.
    gradient: [f64; 2],
    hessian: [[f64; 2]; 2],
}

/// Least-squares rates and gain from one start, with the squared error and the number of passes.
pub(super) fn least_squares(records: &Records, start: Rates) -> (Rates, f64, u64) {
    let mut at = start;
    let mut here = look(records, &at);
    let mut damping = 1e-3;
    let mut passes = 1;
    for _ in 0..MOST_STEPS {
        let Some([slow, fast]) = step(&here, damping) else { break };
        let next = at.moved(slow.clamp(-2.0, 2.0), fast.clamp(-2.0, 2.0));
        let there = look(records, &next);
        passes += 1;
        if there.squared < here.squared {
            let fall = (here.squared - there.squared) / here.squared;
            (at, here) = (next, there);
            damping *= 0.1;
            if fall < ARRIVED {
                break;
            }
        } else {
            damping *= 10.0;
            if damping > 1e6 {
                break;
            }
        }
    }
    at.gain = here.gain;
    (at, here.squared, passes)
}

/// Solves (J'J + damping diag J'J) x = -J'e.
fn step(look: &Look, damping: f64) -> Option<[f64; 2]> {
    let [[a, b], [_, d]] = look.hessian;
    let (a, d) = (a * (1.0 + damping), d * (1.0 + damping));
    let determinant = a * d - b * b;
    let [x, y] = look.gradient;
    (determinant > 0.0 && determinant.is_finite())
        .then(|| [(b * y - d * x) / determinant, (b * x - a * y) / determinant])
}

fn look(records: &Records, at: &Rates) -> Look {
    let unit = Rates { gain: 1.0, ..*at };
    let motors = [unit, unit.moved(DIFFERENCE, 0.0), unit.moved(0.0, DIFFERENCE)];
    let motors = motors.map(|rates| rates.combinations());
    let mut gram = [[0.0; DOUBLES]; DOUBLES];
    for (samples, filters) in records.with_filters(&motors) {
        let part = records.level().run_double(Gram { filters: &filters, samples });
        for (row, part) in gram.iter_mut().flatten().zip(part.iter().flatten()) {
            *row += part;
        }
    }
    // Vectors: v, a1 = dv/dslow, a2 = dv/dfast, y.
    let h = [1.0, 1.0 / DIFFERENCE, 1.0 / DIFFERENCE, 1.0];
    let dot = |i: usize, j: usize| gram[i][j] * h[i] * h[j];
    let (vv, vy, yy) = (dot(0, 0), dot(0, 3), dot(3, 3));
    let gain = vy / vv;
    Look {
        squared: yy - vy * gain,
        gain,
        gradient: [1, 2].map(|i| gain * (dot(0, i) * gain - dot(i, 3))),
        hessian: [1, 2].map(|i| [1, 2].map(|j| gain * gain * (dot(i, j) - dot(0, i) * dot(0, j) / vv))),
    }
}

/// Products of the four vectors v, v1 - v, v2 - v and y over one record.
struct Gram<'a> {
    filters: &'a [Filter<f64>; 3],
    samples: &'a [Sample<f64>],
}

impl Work for Gram<'_> {
    type Output = [[f64; DOUBLES]; DOUBLES];

    #[inline(always)]
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> Self::Output {
        let filter = Filter::<T>::gather(self.filters);
        let mut state = State::default();
        let mut rows = [T::zero(); DOUBLES];
        let samples: &[Sample<T::Element>] = bytemuck::cast_slice(self.samples);
        for (sample, [_, _, y]) in samples.iter().zip(self.samples) {
            let error = filter.error(&mut state, *sample);
            let (base, slow, fast) = (error.lane(0), error.lane(1), error.lane(2));
            let vectors = [base + y, slow - base, fast - base, *y];
            let block = T::from_lanes(|lane| vectors[lane]);
            for (row, x) in rows.iter_mut().zip(vectors) {
                *row = T::lit(x).mul_add(block, *row);
            }
        }
        rows.map(|row| core::array::from_fn(|lane| row.lane(lane)))
    }
}
