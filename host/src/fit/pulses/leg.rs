//! A record under a model with a bridge that coasts: what its run lacks, and what pulses would add to it.

use motorlens_shared::base::Coefficients;

use super::bridge::Bridge;
use crate::fit::cost::{increments, robust};
use crate::fit::grid::Grid;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::{predict_one, rotor_speeds};

/// The records of a problem under a model with a bridge that coasts.
pub(super) struct Ride<'a> {
    problem: &'a Problem,
    values: &'a Values,
    layout: Layout,
    /// `values`, as they are.
    plain: Vec<f64>,
}

/// One of them.
pub(super) struct Leg {
    /// Without pulses, running free.
    pub(super) grid: Grid,
    pub(super) bridge: Bridge,
    /// The base model, a cell long.
    motor: Coefficients<f64>,
    /// What the run without pulses lacks: increments, noise units.
    pub(super) lacks: Vec<f64>,
}

impl<'a> Ride<'a> {
    pub(super) fn new(problem: &'a Problem, values: &'a Values) -> Self {
        let layout = problem.layout(&values.kinds());
        let x = layout.pack(values);
        let plain = layout.all_plain(&x);
        Self { problem, values, layout, plain }
    }

    fn run(&self, grid: &Grid, plain: &[f64]) -> Vec<f64> {
        predict_one(&self.layout.kinds, plain, &self.problem.rig, grid)
    }

    /// None without such a bridge.
    pub(super) fn leg(&self, grid: &Grid) -> Option<Leg> {
        let grid = Grid { guide: Vec::new(), seen: Vec::new(), pulses: Vec::new(), ..grid.clone() };
        let rig = &self.problem.rig;
        let speeds = rotor_speeds(&self.layout.kinds, &self.plain, rig, &grid);
        let bridge = Bridge::new(self.values, rig, &grid, &speeds)?;
        let run = self.run(&grid, &self.plain);
        let lacks = apart(&grid, &grid.measured, &run);
        let motor = Coefficients::new(&self.values.base.base(), grid.step_s);
        Some(Leg { grid, bridge, motor, lacks })
    }
}

/// What `series` adds more than `other` in the time of an increment, noise units.
fn apart(grid: &Grid, series: &[f64], other: &[f64]) -> Vec<f64> {
    let difference: Vec<f64> = series.iter().zip(other).map(|(a, b)| a - b).collect();
    increments(grid, &difference)
}

pub(super) fn cost(lacks: &[f64]) -> f64 {
    lacks.iter().map(|d| robust(*d).powi(2)).sum()
}

pub(super) fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

impl Leg {
    /// What pulses add to the run: increments, noise units. To first order, of the base model under the bridge.
    pub(super) fn adds(&self, frequency: f64, phase: f64) -> Vec<f64> {
        let (c, beyond) = (&self.motor, self.bridge.beyond(frequency, phase));
        let (mut u, mut w, mut x) = (0.0, 0.0, 0.0);
        let mut angle = Vec::with_capacity(beyond.len());
        angle.push(0.0);
        for (slope, volts) in self.bridge.slopes.iter().zip(&beyond[1..]) {
            let v = volts + slope * c.back_emf * w;
            let after = c.wu * u + c.ww * w + c.wv * v;
            x += c.half_step * (w + after) + c.xu * u + c.xw * w + c.xv * v;
            (u, w) = (c.uu * u + c.uw * w + c.uv * v, after);
            angle.push(x);
        }
        let shown: Vec<f64> = (0..self.grid.len()).map(|k| angle[self.end(k)]).collect();
        increments(&self.grid, &shown)
    }

    /// The cell's end that is nearest to sample `k`.
    fn end(&self, k: usize) -> usize {
        let place = &self.grid.places[k];
        ((place.cell as f64 + place.part).round() as usize).min(self.bridge.cells())
    }

    /// What the run lacks with these pulses.
    pub(super) fn lacks(&self, frequency: f64, phase: f64) -> Vec<f64> {
        let adds = self.adds(frequency, phase);
        self.lacks.iter().zip(adds).map(|(d, a)| d - a).collect()
    }

    /// The phase under which it lacks least, by so many `tries`.
    pub(super) fn phase(&self, frequency: f64, tries: usize) -> f64 {
        let cost = |k: usize| cost(&self.lacks(frequency, k as f64 / tries as f64));
        let costs: Vec<f64> = (0..tries).map(cost).collect();
        let best = (0..tries).min_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap_or(0);
        // The bottom of the parabola through it and its neighbours.
        let at = |k: usize| costs[k % tries];
        let (before, here, after) = (at(best + tries - 1), at(best), at(best + 1));
        let bend = before - 2.0 * here + after;
        let off = if bend > 0.0 { 0.5 * (before - after) / bend } else { 0.0 };
        (best as f64 + off) / tries as f64
    }
}
