//! A record under a model with a bridge that coasts: what its run lacks, and what pulses would add to it.

use motorlens_shared::base::Coefficients;

use super::bridge::Bridge;
use crate::fit::cost::{SPAN_S, robust};
use crate::fit::grid::Grid;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::simulate::{predict_one, rotor_speeds};

/// The records of a problem under a model with a bridge that coasts.
pub(super) struct Ride<'a> {
    layout: Layout,
    plain: Vec<f64>,
    values: &'a Values,
    problem: &'a Problem,
}

/// One of them.
pub(super) struct Leg<'a> {
    ride: &'a Ride<'a>,
    /// Without pulses, running free.
    pub(super) grid: Grid,
    pub(super) speeds: Vec<f64>,
    /// What the run without pulses lacks: increments, noise units.
    pub(super) lacks: Vec<f64>,
    /// The same without what other parameters, or a delay, would make good: they follow the commands as the pulses do.
    pub(super) stripped: Vec<f64>,
    run: Vec<f64>,
    /// How much more voltage the law gives every cell for a back-EMF that is higher by one volt.
    pub(super) slopes: Vec<f64>,
    /// The base model, a cell long.
    motor: Coefficients<f64>,
}

impl<'a> Ride<'a> {
    pub(super) fn new(problem: &'a Problem, values: &'a Values) -> Self {
        let layout = problem.layout(&values.kinds());
        let plain = layout.all_plain(&layout.pack(values));
        Self { layout, plain, values, problem }
    }

    fn run(&self, grid: &Grid) -> Vec<f64> {
        predict_one(&self.layout.kinds, &self.plain, &self.problem.rig, grid)
    }

    pub(super) fn leg(&'a self, grid: &Grid) -> Leg<'a> {
        let grid = Grid { guide: Vec::new(), seen: Vec::new(), pulses: Vec::new(), ..grid.clone() };
        let run = self.run(&grid);
        let error: Vec<f64> = grid.measured.iter().zip(&run).map(|(y, p)| y - p).collect();
        let lacks = increments(&grid, &error);
        let mut leg = Leg {
            ride: self,
            speeds: rotor_speeds(&self.layout.kinds, &self.plain, &self.problem.rig, &grid),
            stripped: Vec::new(),
            slopes: Vec::new(),
            motor: Coefficients::new(&self.values.base.base(), grid.step_s),
            lacks,
            run,
            grid,
        };
        // Any frequency: the law's own stays what it is.
        leg.slopes = leg
            .bridge(1.0)
            .map_or_else(Vec::new, |bridge| (0..bridge.cells()).map(|n| bridge.slope(n)).collect());
        leg
    }

    /// The same, for a look at the spectrum.
    pub(super) fn stripped(&'a self, grid: &Grid) -> Leg<'a> {
        let leg = self.leg(grid);
        let x = self.layout.pack(self.values);
        let neighbour = |k: usize| -> Vec<f64> {
            let mut x = x.clone();
            x[k] += self.layout.step(k, x[k]);
            let moved =
                predict_one(&self.layout.kinds, &self.layout.all_plain(&x), &self.problem.rig, &leg.grid);
            increments(&leg.grid, &moved.iter().zip(&leg.run).map(|(a, b)| a - b).collect::<Vec<f64>>())
        };
        let mut directions: Vec<Vec<f64>> = self.layout.free().into_iter().map(neighbour).collect();
        let late: Vec<f64> =
            (0..leg.run.len()).map(|k| leg.run[(k + 1).min(leg.run.len() - 1)] - leg.run[k]).collect();
        directions.push(increments(&leg.grid, &late));
        Leg { stripped: beside(leg.lacks.clone(), directions), ..leg }
    }
}

fn increments(grid: &Grid, series: &[f64]) -> Vec<f64> {
    let span = ((SPAN_S / grid.interval_s).round() as usize).max(1);
    series.windows(span + 1).map(|w| (w[span] - w[0]) / grid.sigma).collect()
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

impl Leg<'_> {
    pub(super) fn bridge(&self, frequency: f64) -> Option<Bridge<'_>> {
        Bridge::new(self.ride.values, frequency, &self.ride.problem.rig, &self.grid, &self.speeds)
    }

    /// What pulses bring in every cell beyond their mean, V.
    pub(super) fn beyond(&self, frequency: f64, phase: f64) -> Vec<f64> {
        self.bridge(frequency).map_or_else(Vec::new, |bridge| bridge.beyond(frequency, phase))
    }

    /// What pulses add to the run: increments, noise units. To first order, of the base model under the bridge.
    pub(super) fn adds(&self, frequency: f64, phase: f64) -> Vec<f64> {
        let (c, beyond) = (&self.motor, self.beyond(frequency, phase));
        let (mut u, mut w, mut x) = (0.0, 0.0, 0.0);
        let mut angle = Vec::with_capacity(beyond.len());
        angle.push(0.0);
        for (slope, volts) in self.slopes.iter().zip(&beyond[1..]) {
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
        ((place.cell as f64 + place.part).round() as usize).min(self.slopes.len())
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
        let (c, cells) = (&self.motor, self.slopes.len());
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
            let held = self.slopes[n] * c.back_emf * wanted[n];
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
        let leg = ride.stripped(&evidence.whole.grids[0]);
        assert!(product(&leg.stripped, &leg.stripped) < product(&leg.lacks, &leg.lacks));
        for phase in [0.1, 0.6] {
            let seen = product(&leg.stripped, &leg.adds(437.0, phase));
            // Increments count in noise units.
            let wanted = product(&leg.wanted(), &leg.beyond(437.0, phase)[1..]) / leg.grid.sigma;
            assert!((seen / wanted - 1.0).abs() < 1e-9, "{seen} {wanted}");
        }
    }
}
