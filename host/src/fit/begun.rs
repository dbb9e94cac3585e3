//! First speeds of records that begin in motion, fitted with the model.
//!
//! Each is a parameter of one record only, and the run answers to it almost in a straight line. So it needs no axis of its own: it is
//! projected out of the record's derivatives, and follows each step of the others (variable projection; G. Golub and V. Pereyra,
//! *SIAM J. Numer. Anal.* 10, 1973, as L. Kaufman, *BIT* 15, 1975, has it).

use motorlens_shared::effects::Rig;

use super::cost::Objective;
use super::grid::Grid;
use super::layout::Layout;
use super::search::Problem;
use super::simulate::{Block, LANES};

/// How far apart the speeds are of which a derivative is taken, and the highest one, shares of the rig's reference speed.
pub(super) const APART: f64 = 0.02;
pub(super) const HIGHEST: f64 = 2.0;

/// A record's cost around a point, as far as its first speed has to do with it.
#[derive(Debug, Clone)]
pub struct Begun {
    /// Products of the derivative along the speed, per rad/s: with the residuals, then with those along each axis.
    products: Vec<f64>,
    /// Its square.
    square: f64,
}

/// The speed beside that of `grid` of which a derivative is taken, rad/s; none where it rests.
pub fn beside(grid: &Grid, rig: &Rig) -> Option<f64> {
    (!grid.rests()).then_some(APART * rig.reference_speed)
}

impl Begun {
    /// Takes what a first speed may make up for out of the neighbours along the axes in `blocks` (lanes as [`super::normal::accumulate`] has
    /// them, `inverse` distances). The lane behind theirs is the neighbour along the speed, `apart` from the centre.
    pub fn project_out(blocks: &mut [Vec<Block>], inverse: &[f64], apart: f64) -> Self {
        let speed = (inverse.len() / LANES, inverse.len() % LANES);
        // A block of lanes at a time; the centre, the neighbour along the speed and what is behind it stay as they are.
        let by_lane = |of: &dyn Fn(usize) -> f64| -> Vec<[f64; LANES]> {
            let lane = |b: usize, l: usize| {
                let f = b * LANES + l;
                if (1..inverse.len()).contains(&f) { of(f) } else { 0.0 }
            };
            (0..blocks.len()).map(|b| std::array::from_fn(|l| lane(b, l))).collect()
        };
        let mut sums = vec![[0.0; LANES]; blocks.len()];
        let (mut square, mut with_centre) = (0.0, 0.0);
        for k in 0..blocks[0].len() {
            let centre = blocks[0][k].0[0];
            let slope = (blocks[speed.0][k].0[speed.1] - centre) / apart;
            square += slope * slope;
            with_centre += slope * centre;
            for (sums, block) in sums.iter_mut().zip(&*blocks) {
                for l in 0..LANES {
                    sums[l] += slope * (block[k].0[l] - centre);
                }
            }
        }
        let mut products = vec![with_centre];
        products.extend((1..inverse.len()).map(|f| sums[f / LANES][f % LANES] * inverse[f]));
        if square > 0.0 {
            let shares = by_lane(&|f| products[f] / (inverse[f] * square));
            for k in 0..blocks[0].len() {
                let slope = (blocks[speed.0][k].0[speed.1] - blocks[0][k].0[0]) / apart;
                for (shares, block) in shares.iter().zip(&mut *blocks) {
                    for l in 0..LANES {
                        block[k].0[l] -= slope * shares[l];
                    }
                }
            }
        }
        Self { products, square }
    }

    /// By how much the speed changes, rad/s, where the axes do by `steps`.
    fn follows(&self, steps: impl Iterator<Item = f64>) -> f64 {
        let slope: f64 = self.products[1..].iter().zip(steps).map(|(product, step)| product * step).sum();
        if self.square > 0.0 { -(self.products[0] + slope) / self.square } else { 0.0 }
    }
}

impl Problem {
    /// First speeds of the records, rad/s.
    pub fn first_speeds(&self) -> Vec<f64> {
        self.grids.iter().map(|grid| grid.start_speed).collect()
    }

    /// Lets the records that begin in motion do so as they must under the model at `x`: by the error of the run.
    pub fn begin_under(&mut self, layout: &Layout, x: &[f64]) {
        if self.grids.iter().all(Grid::rests) {
            return;
        }
        let speeds = self.first_speeds();
        let mut begun = Vec::new();
        self.neighbours_on(&self.grids, &speeds, layout, Objective::Position, x, &[], &mut |_, _, _, own| {
            begun.push(own);
        });
        let found = self.follow(&speeds, &begun, &[Vec::new()]);
        self.begin_with(&found.iter().map(|lanes| lanes[0]).collect::<Vec<_>>());
    }

    /// First speeds of the records at several points, each the `steps` along the axes away from where their speeds are `now` and what they
    /// have to do with the cost is known (`begun`).
    pub(super) fn follow(
        &self,
        now: &[f64],
        begun: &[Option<Begun>],
        steps: &[Vec<f64>],
    ) -> Vec<[f64; LANES]> {
        let highest = HIGHEST * self.rig.reference_speed;
        let of = |(now, begun): (&f64, &Option<Begun>)| {
            std::array::from_fn(|lane| match begun {
                // A lane without a point of its own repeats the first one.
                Some(begun) => {
                    let steps = steps.get(lane).unwrap_or(&steps[0]);
                    (now + begun.follows(steps.iter().copied())).clamp(-highest, highest)
                }
                None => *now,
            })
        };
        now.iter().zip(begun).map(of).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use motorlens_shared::lanes::Lanes;

    /// Nine axes take two blocks with the speed's lane behind them; a straight line's least squares are known.
    #[test]
    fn what_the_first_speed_may_make_up_for_is_taken_out_of_the_neighbours() {
        let (axes, apart) = (9, 0.5);
        let slope = |k: usize, f: usize| ((k * (f + 2)) as f64 * 0.37).sin();
        let along = |k: usize| (-(k as f64) / 40.0).exp();
        let centre = |k: usize| 0.3 - 0.7 * along(k) + 0.05 * (k as f64).cos();
        let inverse: Vec<f64> = (0..=axes).map(|f| 10.0 + f as f64).collect();
        let lane = |k: usize, f: usize| match f {
            0 => centre(k),
            f if f <= axes => centre(k) + slope(k, f) / inverse[f],
            f if f == axes + 1 => centre(k) + apart * along(k),
            _ => 0.0,
        };
        let mut blocks: Vec<Vec<Block>> = (0..2)
            .map(|b| (0..200).map(|k| Lanes(std::array::from_fn(|l| lane(k, b * LANES + l)))).collect())
            .collect();
        let begun = Begun::project_out(&mut blocks, &inverse, apart);
        let left = |k: usize, f: usize| (blocks[f / LANES][k].0[f % LANES] - blocks[0][k].0[0]) * inverse[f];
        for f in 1..=axes {
            let dot: f64 = (0..200).map(|k| left(k, f) * along(k)).sum();
            assert!(dot.abs() < 1e-9, "axis {f}: {dot}");
        }
        let square: f64 = (0..200).map(|k| along(k).powi(2)).sum();
        let alone: f64 = -(0..200).map(|k| along(k) * centre(k)).sum::<f64>() / square;
        assert!((begun.follows(std::iter::repeat_n(0.0, axes)) - alone).abs() < 1e-9);
        let with_first: f64 = -(0..200).map(|k| along(k) * slope(k, 1)).sum::<f64>() / square;
        let one = (1..=axes).map(|f| if f == 1 { 1.0 } else { 0.0 });
        assert!((begun.follows(one) - alone - with_first).abs() < 1e-9);
    }
}
