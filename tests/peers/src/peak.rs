//! How many multiply-adds this processor does per second, measured, and what share of them the kernels use.

use motorlens::paper::sines;
use motorlens::search::dispatch::{LANES, Level, Work};
use motorlens::search::{Candidates, Records};
use motorlens_peers::clock::fastest;
use motorlens_peers::nonlinear::Nonlinear;
use motorlens_shared::linear::Laned;
use motorlens_shared::motor::PaperMotor;
use std::hint::black_box;

/// Chains that do not wait for each other: enough to fill two units of four cycles' latency with 8-lane vectors.
const CHAINS: usize = 6;
const TURNS: usize = 4096;

struct Chains;

impl Work for Chains {
    type Output = f64;

    #[inline(always)]
    fn run<T: Laned<Element: bytemuck::Pod>>(self) -> f64 {
        let (factor, addend) = (T::lit(black_box(0.999)), T::lit(black_box(1e-3)));
        let mut chains: [T; CHAINS] = core::array::from_fn(|k| T::lit(k as f64));
        for _ in 0..TURNS {
            for chain in &mut chains {
                *chain = chain.mul_add(factor, addend);
            }
        }
        let sum = chains.into_iter().fold(T::zero(), |sum, chain| sum + chain);
        sum.lane(black_box(0))
    }
}

/// Single-precision multiply-adds per second, over all lanes.
pub fn multiply_adds() -> f64 {
    let level = Level::best();
    let seconds = fastest(400, || {
        black_box(level.run(Chains));
    });
    (CHAINS * TURNS * LANES) as f64 / seconds
}

/// Seconds per candidate and sample of the linear kernel, 16 candidates on `samples` samples.
pub fn linear_kernel(rate: u32) -> f64 {
    let records = Records::new(&sines::records(rate), Level::best()).expect("good records");
    let motor = sines::motor();
    let motors: Vec<_> = (0..LANES)
        .map(|k| {
            let resistance = motor.resistance * (1.0 + 0.01 * k as f64);
            PaperMotor { resistance, ..motor }.combinations()
        })
        .collect();
    let mut candidates = Candidates::default();
    records.discretise(&motors, &mut candidates);
    let mut iae = [0.0; LANES];
    // As long for a short record as for a long one: a second or two, in which a neighbour comes and goes.
    let times = 8_000 * 1000 / rate;
    let seconds = fastest(times, || records.iae_of(black_box(&candidates), &mut iae));
    seconds / (LANES * records.samples()) as f64
}

/// Linear kernel: multiply-adds per candidate and sample.
pub const LINEAR_MULTIPLY_ADDS: f64 = 6.0;

/// Blocks of lanes of the nonlinear kernel.
const SIDE_BY_SIDE: usize = 3;
/// Turns of lanes and scalar, one after the other: a few seconds, in which a neighbour on the same core comes and goes.
const ROUNDS: u32 = 3000;

/// Seconds per candidate and sample of the nonlinear model: in lanes, and as scalar `f64`.
pub fn nonlinear_kernel() -> (f64, f64) {
    let record = &sines::records(1000)[1];
    let samples = record.voltage.len() as f64;
    let single = |x: &[f64]| x.iter().map(|x| *x as f32).collect::<Vec<f32>>();
    let (voltages, measured) = (single(&record.voltage), single(&record.measured));
    let level = Level::best();
    let mut least = (f64::INFINITY, f64::INFINITY);
    for _ in 0..ROUNDS {
        let lanes = fastest(1, || {
            let work = Nonlinear::<f32, SIDE_BY_SIDE> { voltages: &voltages, measured: &measured };
            black_box(level.run(work));
        });
        let scalar = fastest(1, || {
            let work = Nonlinear::<f64> { voltages: &record.voltage[..], measured: &record.measured };
            black_box(work.sums::<f64>());
        });
        least = (least.0.min(lanes), least.1.min(scalar));
    }
    (least.0 / ((SIDE_BY_SIDE * LANES) as f64 * samples), least.1 / samples)
}
