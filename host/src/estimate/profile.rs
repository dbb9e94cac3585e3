//! Profile likelihood: intervals where the curvature at the best point misleads.
//!
//! A parameter that the data hardly determine, or that ends at a bound, has a valley that is neither straight nor
//! alike on both sides. Its interval is walked: the parameter is held, all others are fitted again, and the end is
//! where the cost has risen by as much as it would at the end of the curvature's own interval if the valley were a
//! parabola. So where it is one, both intervals agree.

use serde::Serialize;

use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::Problem;
use crate::fit::sketch::Sketch;
use crate::fit::uncertainty::Spread;

/// An interval by profile, beside the curvature's.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Profile {
    /// Parameter.
    pub name: String,
    /// Unit of the numbers.
    pub unit: String,
    /// Lower end; the bound where the data set none.
    pub low: f64,
    /// Upper end; the bound where the data set none.
    pub high: f64,
    /// The data set no lower end within the bounds.
    pub open_below: bool,
    /// The data set no upper end within the bounds.
    pub open_above: bool,
    /// What the curvature at the best point promises.
    pub curvature: (f64, f64),
    /// The two intervals differ by more than a quarter of their width.
    pub curvature_misleads: bool,
}

/// Half widths of the 95 % interval in standard deviations.
const WIDTH: f64 = 1.96;
/// Parameters walked, the least certain first.
const MOST: usize = 3;
/// Intervals narrower than this share of the value, off the bounds, are taken from the curvature.
const CERTAIN: f64 = 0.1;
/// Steps of the fit of the others, and of the search for an end.
const REFIT: usize = 4;
const STEPS: usize = 6;

/// What of the records shows the shape of a valley; how wide it is, all of them say.
const SKETCH: Sketch = Sketch { samples: f64::MAX, cell_s: 4.01e-3, interval_s: 8.01e-3 };

/// Walks the parameters of `values` that the curvature does not settle.
pub fn profiles(problem: &Problem, values: &Values) -> Vec<Profile> {
    let layout = problem.layout(&values.kinds());
    let spread = Spread::of(problem, values);
    let problem = &problem.clone().sketch(SKETCH);
    let best = problem.search(&layout, Objective::Increments, &spread.x, REFIT, 1e-6);
    let free = layout.free();
    let Some(inverse) = best.curvature.clone().try_inverse() else { return Vec::new() };
    let mut doubtful: Vec<(f64, usize, f64)> = free
        .iter()
        .enumerate()
        .filter_map(|(place, &k)| {
            let half = WIDTH * spread.deviation(k);
            let variance = inverse[(place, place)];
            let at = best.x[k];
            let share = if layout.axes[k].unit_value == 0.0 { half } else { half / at.abs().max(1e-9) };
            let at_bound = at - half < layout.axes[k].low || at + half > layout.axes[k].high;
            let rise = half * half / variance;
            (half.is_finite() && rise.is_finite() && variance > 0.0 && (share > CERTAIN || at_bound))
                .then_some((share, k, rise))
        })
        .collect();
    doubtful.sort_by(|a, b| b.0.total_cmp(&a.0));
    doubtful.truncate(MOST);
    doubtful.sort_by_key(|d| d.1);
    doubtful
        .into_iter()
        .map(|(_, k, rise)| {
            let half = WIDTH * spread.deviation(k);
            let walk = Walk { problem, layout: &layout, x: &best.x, k, limit: best.cost + rise };
            let ((down, open_below), (up, open_above)) = (walk.end(-half), walk.end(half));
            let a = &layout.axes[k];
            let plain = |x: f64| layout.plain(k, x.clamp(a.low, a.high));
            let curvature = (plain(best.x[k] - half), plain(best.x[k] + half));
            let (low, high) = (plain(down), plain(up));
            let off = (low - curvature.0).abs().max((high - curvature.1).abs());
            Profile {
                name: a.name.clone(),
                unit: a.unit.into(),
                low,
                high,
                open_below,
                open_above,
                curvature,
                curvature_misleads: open_below || open_above || off > 0.25 * (curvature.1 - curvature.0),
            }
        })
        .collect()
}

/// A walk along one axis.
struct Walk<'a> {
    problem: &'a Problem,
    layout: &'a Layout,
    x: &'a [f64],
    k: usize,
    limit: f64,
}

impl Walk<'_> {
    /// Lowest cost with the axis held at `at`, and where the others went.
    fn cost(&self, at: f64, from: &[f64]) -> (f64, Vec<f64>) {
        let mut held = self.layout.clone();
        let axis = &mut held.axes[self.k];
        (axis.low, axis.high, axis.fixed) = (at, at, true);
        let mut start = from.to_vec();
        start[self.k] = at;
        let found = self.problem.search(&held, Objective::Increments, &start, REFIT, 1e-4);
        (found.cost, found.x)
    }

    /// Where the cost passes the limit in the direction of `half`, and whether it never does.
    fn end(&self, half: f64) -> (f64, bool) {
        let (axis, centre) = (&self.layout.axes[self.k], self.x[self.k]);
        let bound = if half < 0.0 { axis.low } else { axis.high };
        let within = |d: f64| if half < 0.0 { (centre + d).max(bound) } else { (centre + d).min(bound) };
        let (mut inside, mut outside): (f64, Option<f64>) = (0.0, None);
        let mut from = self.x.to_vec();
        let mut d = half;
        for _ in 0..STEPS {
            let at = within(d);
            let (cost, x) = self.cost(at, &from);
            if cost < self.limit {
                (inside, from) = (at - centre, x);
                if outside.is_none() && at == bound {
                    return (bound, true);
                }
            } else {
                outside = Some(at - centre);
            }
            d = outside.map_or(2.0 * d, |far| 0.5 * (inside + far));
        }
        match outside {
            Some(far) => (within(0.5 * (inside + far)), false),
            None => (within(inside), true),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::exam::case::{Case, Conditions};
    use crate::fit::setup;
    use motorlens_shared::effects::Kind;
    use motorlens_virtual_motor as plant;

    /// A friction on the edge of the data: its size cannot be negative, and the walk ends at zero.
    #[test]
    fn a_parameter_at_its_bound_is_open_on_that_side_and_a_certain_one_is_not_walked() {
        let case = Case::new(3, &[plant::Kind::Coulomb], Conditions { disturbed: 0.0, spoilt: 0.0 });
        let (mut problem, start) = setup::problem(&case.records[2..3], &case.motor);
        let (layout, x) = problem.fit_base(&start);
        let base = layout.unpack(&x);
        let with = base.with(Kind::Coulomb, vec![0.3]).with(Kind::ConstantLoad, vec![0.0]);
        let layout = problem.layout(&with.kinds());
        let found = problem.search(&layout, Objective::Increments, &layout.pack(&with), 20, 1e-7);
        let walked = profiles(&problem, &layout.unpack(&found.x));
        assert!(walked.iter().all(|p| p.name != "gain"), "{walked:?}");
        assert!(!walked.is_empty() && walked.len() <= MOST, "{walked:?}");
        for p in &walked {
            assert!(p.low <= p.high, "{p:?}");
            // Neither side ends before a tenth of what the curvature says.
            let width = p.curvature.1 - p.curvature.0;
            assert!(p.high - p.low > 0.1 * width || p.open_below || p.open_above, "{p:?}");
        }
    }
}
