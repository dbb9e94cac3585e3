//! What a model expects to see of a programme, and how much of that another one's parameters could imitate.

use motorlens_shared::effects::Kind;
use nalgebra::{DMatrix, DVector};

use super::menu::RATE_HZ;
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Layout;
use crate::fit::search::Problem;
use crate::fit::simulate::{LANES, predict_block};
use crate::select::fitted::Fitted;

/// Differences over 50 ms, every 4 ms.
const SPAN: usize = 25;
const STRIDE: usize = 2;

/// What each of `points` expects to see on `grid`, as differences over 50 ms in the unit that `problem` has measured: of the angle, or the mean
/// speed in that time.
pub(super) fn increments(
    problem: &Problem,
    layout: &Layout,
    points: &[Vec<f64>],
    grid: &Grid,
) -> Vec<DVector<f64>> {
    let speed = problem.grids.iter().any(|grid| grid.quantity != Quantity::Angle);
    let unit = if speed { f64::from(RATE_HZ) / SPAN as f64 } else { 1.0 };
    let mut seen: Vec<DVector<f64>> = Vec::new();
    let mut series = Vec::new();
    for chunk in points.chunks(LANES) {
        predict_block(layout, chunk, &problem.rig, grid, &mut series);
        for l in 0..chunk.len() {
            let n = series.len().saturating_sub(SPAN) / STRIDE;
            let step = |k: usize| unit * (series[k * STRIDE + SPAN].0[l] - series[k * STRIDE].0[l]);
            seen.push(DVector::from_fn(n, |k, _| step(k)));
        }
    }
    seen
}

/// What one rival expects to see, and how a change of its parameters would move that.
pub(super) struct View {
    pub(super) centre: DVector<f64>,
    tangent: DMatrix<f64>,
}

impl View {
    pub(super) fn new(problem: &Problem, layout: &Layout, x: &[f64], grid: &Grid) -> Self {
        let mut points = vec![x.to_vec()];
        let mut deltas = Vec::new();
        for k in 0..layout.len() {
            let d = layout.step(k, x[k]);
            let mut moved = x.to_vec();
            moved[k] += d;
            points.push(moved);
            deltas.push(d);
        }
        let mut seen = increments(problem, layout, &points, grid);
        let centre = seen.remove(0);
        let columns: Vec<DVector<f64>> = seen.iter().zip(&deltas).map(|(p, d)| (p - &centre) / *d).collect();
        Self { tangent: DMatrix::from_columns(&columns), centre }
    }

    /// rms of what this rival could not imitate of `other`.
    pub(super) fn left_of(&self, other: &DVector<f64>) -> f64 {
        left(&self.tangent, other - &self.centre)
    }

    /// rms of what the most visible parameter of this rival `c` that `simple` lacks would show at its usual size, and
    /// no other parameter could imitate.
    pub(super) fn added(&self, c: &Fitted, simple: Kind) -> f64 {
        let common = simple.spec().parameters;
        let own = c.kinds().last().map_or(&[][..], |kind| kind.spec().parameters);
        let first = c.layout.len() - own.len();
        let news = (0..own.len()).filter(|k| !common.iter().any(|p| p.name == own[*k].name));
        news.map(|k| {
            let others = self.tangent.clone().remove_column(first + k);
            left(&others, self.tangent.column(first + k).into_owned())
        })
        .fold(0.0, f64::max)
    }
}

/// rms of what is left of `difference` beside the columns of `tangent`.
fn left(tangent: &DMatrix<f64>, difference: DVector<f64>) -> f64 {
    let mut h = tangent.tr_mul(tangent);
    for k in 0..h.nrows() {
        h[(k, k)] += 1e-9 * h[(k, k)] + 1e-15;
    }
    let g = tangent.tr_mul(&difference);
    let bend = h.cholesky().map_or_else(|| DVector::zeros(g.len()), |f| f.solve(&g));
    let left = difference - tangent * bend;
    (left.norm_squared() / left.len().max(1) as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use motorlens_shared::excitation::{Programme, Shape};

    use super::super::menu::played;
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};

    #[test]
    fn records_of_speed_are_compared_with_speeds_and_records_of_angle_with_angles() {
        let case = Case::new(11, &[], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (evidence, base) = prepare(&case.records, &case.held_out, &case.motor).unwrap();
        let slow = Shape::Sine { amplitude_v: 6.0, frequency_hz: 0.1, offset_v: 0.0 };
        let programme = Programme::single("slow", slow, 10.0);
        let highest = |problem: &Problem| {
            let grid = played(&programme, problem).unwrap();
            let seen = increments(problem, &base.layout, std::slice::from_ref(&base.x), &grid);
            seen[0].max()
        };
        let steady = 6.0 * base.values().base.gain;
        let angle = evidence.train.clone();
        let mut speed = angle.clone();
        let means = |mut grid: Grid| {
            grid.quantity = Quantity::Speed;
            grid.read_as(Quantity::MeanSpeed)
        };
        speed.grids = speed.grids.into_iter().map(means).collect();
        assert!((highest(&angle) / (0.05 * steady) - 1.0).abs() < 0.02, "{} rad", highest(&angle));
        assert!((highest(&speed) / steady - 1.0).abs() < 0.02, "{} rad/s", highest(&speed));
    }
}
