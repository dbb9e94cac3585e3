//! Eight candidates at a time through a record.

use motorlens_shared::base::Base;
use motorlens_shared::effects::{Kind, Rig};
use motorlens_shared::lanes::Lanes;
use motorlens_shared::scalar::Scalar;
use motorlens_shared::simulator::Simulator;
use motorlens_shared::step::State;

use super::grid::{Grid, Quantity};
use super::layout::{BASE_PARAMETERS, Layout};

/// Candidates that share a pass.
pub const LANES: usize = 8;
/// One number of each of them.
pub type Block = Lanes<f64, LANES>;

/// What a candidate predicts at the samples of `grid`, in the measured quantity.
///
/// `parameters`: plain values, base first, then the effects' in order.
#[inline(always)]
fn predict<S: Scalar<Element = f64>>(
    kinds: &[Kind],
    parameters: &[S],
    rig: &Rig,
    grid: &Grid,
    out: &mut Vec<S>,
) {
    let rig = Rig { step_s: grid.step_s, ..*rig };
    let base = Base {
        gain: parameters[0],
        tau_m: parameters[1],
        tau_e: parameters[2],
        viscous_share: parameters[3],
    };
    let mut next = BASE_PARAMETERS;
    let effects = kinds.iter().map(|kind| {
        let n = kind.spec().parameters.len();
        next += n;
        (*kind, &parameters[next - n..next])
    });
    let simulator = Simulator::new(&base, effects, &rig);
    let speed = S::lit(grid.start_speed);
    // A motor already turning has the current that its speed leaves to the first voltage.
    let turning = if grid.start_speed == 0.0 { 0.0 } else { 1.0 };
    let current = S::lit(turning) * (S::lit(grid.voltages[0]) - base.back_emf() * speed);
    let mut motion = simulator.start(State::moving(current, speed, S::lit(grid.start_angle)));

    out.clear();
    let mut before = simulator.read(&motion);
    let mut slope_before = motion.state.speed;
    let mut last_sample = before;
    let mut samples = grid.places.iter().enumerate().peekable();
    let per_step = S::lit(1.0 / grid.step_s);
    let step = S::lit(grid.step_s);
    for cell in 0..grid.voltages.len() {
        simulator.advance(&mut motion, &grid.voltages, cell);
        let after = simulator.read(&motion);
        let slope_after = if rig.encoder_on_motor { motion.state.speed } else { motion.state.load_speed };
        while let Some((k, place)) = samples.next_if(|(_, p)| p.cell == cell) {
            let reading = if place.part == 1.0 {
                after
            } else {
                hermite(place.part, step, [before, after], [slope_before, slope_after])
            };
            out.push(match grid.quantity {
                Quantity::Angle => reading,
                Quantity::Speed if k == 0 => slope_before,
                Quantity::Speed => (after - before) * per_step,
                Quantity::MeanSpeed if k == 0 => slope_before,
                Quantity::MeanSpeed => {
                    let since = 1.0 / (grid.time_s[k] - grid.time_s[k - 1]);
                    let mean = (reading - last_sample) * S::lit(since);
                    last_sample = reading;
                    mean
                }
            });
        }
        if samples.peek().is_none() {
            break;
        }
        (before, slope_before) = (after, slope_after);
    }
}

/// Between two readings with known slopes, at `part` of the cell.
#[inline(always)]
fn hermite<S: Scalar>(part: f64, step: S, y: [S; 2], slope: [S; 2]) -> S {
    let (s, r) = (part, 1.0 - part);
    let ends = y[0] * S::lit(r * r * (1.0 + 2.0 * s)) + y[1] * S::lit(s * s * (3.0 - 2.0 * s));
    ends + step * (slope[0] * S::lit(s * r * r) - slope[1] * S::lit(s * s * r))
}

/// One set of plain parameters.
pub fn predict_one(kinds: &[Kind], parameters: &[f64], rig: &Rig, grid: &Grid) -> Vec<f64> {
    let mut out = Vec::with_capacity(grid.len());
    predict(kinds, parameters, rig, grid, &mut out);
    out
}

/// Up to eight search vectors; missing lanes repeat the first.
pub fn predict_block(layout: &Layout, xs: &[Vec<f64>], rig: &Rig, grid: &Grid, out: &mut Vec<Block>) {
    let parameters: Vec<Block> = (0..layout.len())
        .map(|k| Lanes(std::array::from_fn(|l| layout.plain(k, xs.get(l).unwrap_or(&xs[0])[k]))))
        .collect();
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx2") && std::arch::is_x86_feature_detected!("fma") {
        // SAFETY: the processor has the features that the function was compiled for.
        unsafe { predict_avx2(&layout.kinds, &parameters, rig, grid, out) };
        return;
    }
    predict(&layout.kinds, &parameters, rig, grid, out);
}

#[cfg(target_arch = "x86_64")]
#[target_feature(enable = "avx2,fma")]
fn predict_avx2(kinds: &[Kind], parameters: &[Block], rig: &Rig, grid: &Grid, out: &mut Vec<Block>) {
    predict(kinds, parameters, rig, grid, out);
}
