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
    /// `values`, as they are searched and as they are.
    x: Vec<f64>,
    plain: Vec<f64>,
}

/// One of them.
pub(super) struct Leg {
    /// Without pulses, running free.
    pub(super) grid: Grid,
    pub(super) bridge: Bridge,
    /// The base model, a cell long.
    motor: Coefficients<f64>,
    run: Vec<f64>,
    /// What the run without pulses lacks: increments, noise units.
    pub(super) lacks: Vec<f64>,
    /// The same without what other parameters, or a delay, would make good: they follow the commands as the pulses do.
    pub(super) stripped: Vec<f64>,
}

impl<'a> Ride<'a> {
    pub(super) fn new(problem: &'a Problem, values: &'a Values) -> Self {
        let layout = problem.layout(&values.kinds());
        let x = layout.pack(values);
        let plain = layout.all_plain(&x);
        Self { problem, values, layout, x, plain }
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
        Some(Leg { grid, bridge, motor, run, lacks, stripped: Vec::new() })
    }

    /// The same, for a look at the spectrum.
    pub(super) fn stripped(&self, grid: &Grid) -> Option<Leg> {
        let leg = self.leg(grid)?;
        let neighbour = |k: usize| {
            let mut x = self.x.clone();
            x[k] += self.layout.step(k, x[k]);
            apart(&leg.grid, &self.run(&leg.grid, &self.layout.all_plain(&x)), &leg.run)
        };
        let mut directions: Vec<Vec<f64>> = self.layout.free().into_iter().map(neighbour).collect();
        let mut late = leg.run[1..].to_vec();
        late.extend(leg.run.last());
        directions.push(apart(&leg.grid, &late, &leg.run));
        Some(Leg { stripped: beside(leg.lacks.clone(), directions), ..leg })
    }
}

/// What `series` adds more than `other` in the time of an increment, noise units.
fn apart(grid: &Grid, series: &[f64], other: &[f64]) -> Vec<f64> {
    let difference: Vec<f64> = series.iter().zip(other).map(|(a, b)| a - b).collect();
    increments(grid, &difference)
}

/// What of `series` is at right angles to all `directions`.
fn beside(mut series: Vec<f64>, directions: Vec<Vec<f64>>) -> Vec<f64> {
    const ALIKE: f64 = 1e-8;
    let less = |from: &mut [f64], what: &[f64], times: f64| {
        from.iter_mut().zip(what).for_each(|(a, b)| *a -= times * b);
    };
    let mut known: Vec<Vec<f64>> = Vec::new();
    for mut direction in directions {
        let whole = product(&direction, &direction);
        for unit in &known {
            let share = product(&direction, unit);
            less(&mut direction, unit, share);
        }
        let length = product(&direction, &direction);
        if length > ALIKE * whole {
            direction.iter_mut().for_each(|d| *d /= length.sqrt());
            let share = product(&series, &direction);
            less(&mut series, &direction, share);
            known.push(direction);
        }
    }
    series
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

    /// What every cell's voltage would have to bring for the error to vanish: the adjoint of [`Self::adds`].
    pub(super) fn wanted(&self) -> Vec<f64> {
        let (c, cells) = (&self.motor, self.bridge.cells());
        let span = self.grid.len() - self.stripped.len();
        let mut weights = vec![0.0; cells + 1];
        for (k, d) in self.stripped.iter().enumerate() {
            weights[self.end(k + span)] += d;
            weights[self.end(k)] -= d;
        }
        let mut wanted = vec![0.0; cells];
        let (mut u, mut w, mut x) = (0.0, 0.0, weights[cells]);
        for n in (0..cells).rev() {
            // The speed after a step brings half of its way.
            let after = w + c.half_step * x;
            wanted[n] = c.uv * u + c.wv * after + c.xv * x;
            let held = self.bridge.slopes[n] * c.back_emf * wanted[n];
            (u, w) = (
                c.uu * u + c.wu * after + c.xu * x,
                c.uw * u + c.ww * after + (c.half_step + c.xw) * x + held,
            );
            x += weights[n];
        }
        wanted
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::diagnose::discover::prepare;
    use crate::exam::case::{Case, Conditions};
    use motorlens_shared::effects::Kind;
    use motorlens_virtual_motor::Kind as Hidden;

    /// The error, weighed with what pulses add to the run, is what the voltages would have to bring, weighed with the pulses.
    #[test]
    fn what_voltages_would_have_to_bring_is_the_adjoint_of_what_pulses_add() {
        let case = Case::new(5, &[Hidden::Coast], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (evidence, base) = prepare(&case.records[3..4], &case.held_out, &case.motor).unwrap();
        let values = base.values().with(Kind::Coast, vec![0.6, 500.0]);
        let ride = Ride::new(&evidence.whole, &values);
        let leg = ride.stripped(&evidence.whole.grids[0]).expect("it coasts");
        assert!(product(&leg.stripped, &leg.stripped) < product(&leg.lacks, &leg.lacks));
        for phase in [0.1, 0.6] {
            let seen = product(&leg.stripped, &leg.adds(437.0, phase));
            // Increments count in noise units.
            let wanted = product(&leg.wanted(), &leg.bridge.beyond(437.0, phase)[1..]) / leg.grid.sigma;
            assert!((seen / wanted - 1.0).abs() < 1e-9, "{seen} {wanted}");
        }
    }
}
