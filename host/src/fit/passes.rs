//! Passes of candidates through all records: their costs, their errors, and what the neighbours of a point leave.

use std::cell::Cell;

use super::begun::{Begun, beside};
use super::cost::{Objective, residuals, squares};
use super::grid::Grid;
use super::layout::Layout;
use super::search::{PRIOR_WEIGHT, Problem};
use super::simulate::{Block, LANES, predict_from};

/// Takes a record, its residual series of a point and its neighbours in blocks of lanes, and the neighbours' inverse distances.
pub type OfRecord<'a> = dyn FnMut(&Grid, &[Vec<Block>], &[f64]) + 'a;
/// The same, and what a record's first speed has to do with its cost where it begins in motion.
pub(super) type OfBegun<'a> = dyn FnMut(&Grid, &[Vec<Block>], &[f64], Option<Begun>) + 'a;

/// Blocks of lanes that are kept from pass to pass: 640 MB, an hour at 1 kHz.
const MOST_KEPT: usize = 10 << 20;

thread_local! {
    /// Room for the series of a pass, whatever records it is through: a fresh one is paged in again by every pass, a third of the time of a long fit.
    static ROOM: Cell<Vec<Vec<Block>>> = const { Cell::new(Vec::new()) };
}

/// Keeps of `room` for this thread's next pass what is not so large that the memory is wanted elsewhere.
fn keep(mut room: Vec<Vec<Block>>) {
    let mut blocks = 0;
    let mut fits = |series: &&Vec<Block>| {
        blocks += series.capacity();
        blocks <= MOST_KEPT
    };
    let kept = room.iter().take_while(|series| fits(series)).count();
    room.truncate(kept);
    ROOM.set(room);
}

impl Problem {
    /// Counts so many `candidates` that went through all records.
    pub fn count_passes(&self, candidates: usize) {
        self.simulations.set(self.simulations.get() + candidates as u64);
    }

    /// Counts what went through `other`, which was laid out of these records, here too.
    pub fn count_passes_of(&self, other: &Self) {
        self.simulations.set(self.simulations.get() + other.simulations.get());
    }

    /// Samples of all records.
    pub fn samples(&self) -> usize {
        self.grids.iter().map(Grid::len).sum()
    }

    pub(super) fn prior_cost(&self, layout: &Layout, x: &[f64]) -> f64 {
        layout
            .axes
            .iter()
            .zip(x)
            .filter_map(|(a, x)| a.doubt(*x).map(|(doubt, _)| doubt * doubt))
            .sum::<f64>()
            * PRIOR_WEIGHT
    }

    /// Sum of squared residuals of up to eight candidates.
    pub fn costs(&self, layout: &Layout, objective: Objective, xs: &[Vec<f64>]) -> Vec<f64> {
        let speeds: Vec<[f64; LANES]> = self.first_speeds().into_iter().map(|speed| [speed; LANES]).collect();
        self.costs_from(layout, objective, xs, &speeds)
    }

    /// The same where the records begin with these `speeds`, a record after the other.
    pub(super) fn costs_from(
        &self,
        layout: &Layout,
        objective: Objective,
        xs: &[Vec<f64>],
        speeds: &[[f64; LANES]],
    ) -> Vec<f64> {
        let mut sums: Vec<f64> = xs.iter().map(|x| self.prior_cost(layout, x)).collect();
        self.count_passes(xs.len());
        let mut room = ROOM.take();
        room.resize_with(room.len().max(1), Vec::new);
        for (grid, speeds) in self.grids.iter().zip(speeds) {
            let series = &mut room[0];
            predict_from(layout, xs, speeds, &self.rig, grid, series);
            for (sum, own) in sums.iter_mut().zip(squares(grid, objective, series).0) {
                *sum += own;
            }
        }
        keep(room);
        sums.iter().map(|s| if s.is_finite() { *s } else { f64::MAX }).collect()
    }

    /// Any number of candidates with their [`Self::costs`], cheapest first.
    pub fn costed(&self, layout: &Layout, objective: Objective, xs: Vec<Vec<f64>>) -> Vec<(f64, Vec<f64>)> {
        let costs: Vec<f64> =
            xs.chunks(LANES).flat_map(|chunk| self.costs(layout, objective, chunk)).collect();
        let mut costed: Vec<(f64, Vec<f64>)> = costs.into_iter().zip(xs).collect();
        costed.sort_by(|a, b| a.0.total_cmp(&b.0));
        costed
    }

    /// `x` and its neighbours along `axes`, with the inverse of each one's distance.
    fn around(layout: &Layout, x: &[f64], axes: &[usize]) -> (Vec<Vec<f64>>, Vec<f64>) {
        let mut points = vec![x.to_vec()];
        let mut inverse = vec![0.0];
        for &k in axes {
            let d = layout.step(k, x[k]);
            let mut moved = x.to_vec();
            moved[k] += d;
            points.push(moved);
            inverse.push(1.0 / d);
        }
        (points, inverse)
    }

    /// Hands every record's residuals of centre and neighbours, a series of blocks each, to `each`. What its first speed may make up for is
    /// taken out of the neighbours of a record that begins in motion.
    pub fn neighbours(
        &self,
        layout: &Layout,
        objective: Objective,
        x: &[f64],
        axes: &[usize],
        each: &mut OfRecord,
    ) {
        let mut each = |grid: &Grid, blocks: &[Vec<Block>], inverse: &[f64], _| each(grid, blocks, inverse);
        self.neighbours_on(&self.grids, &self.first_speeds(), layout, objective, x, axes, &mut each);
    }

    /// The same of some of the records, which begin with these `speeds`.
    pub(super) fn neighbours_on(
        &self,
        grids: &[Grid],
        speeds: &[f64],
        layout: &Layout,
        objective: Objective,
        x: &[f64],
        axes: &[usize],
        each: &mut OfBegun,
    ) {
        let (mut points, inverse) = Self::around(layout, x, axes);
        self.count_passes((points.len() * grids.len()).div_ceil(self.grids.len().max(1)));
        // Room for the neighbour along the first speed, which differs in nothing else.
        points.push(x.to_vec());
        let mut room = ROOM.take();
        room.resize_with(room.len().max(points.len().div_ceil(LANES)), Vec::new);
        for (grid, speed) in grids.iter().zip(speeds) {
            let apart = beside(grid, &self.rig);
            let used = inverse.len() + usize::from(apart.is_some());
            let blocks = used.div_ceil(LANES);
            for (block, series) in room[..blocks].iter_mut().enumerate() {
                let lanes = block * LANES..used.min((block + 1) * LANES);
                let mut begun = [*speed; LANES];
                if let Some(apart) = apart.filter(|_| lanes.contains(&inverse.len())) {
                    begun[inverse.len() % LANES] += apart;
                }
                predict_from(layout, &points[lanes], &begun, &self.rig, grid, series);
                residuals(grid, objective, series);
            }
            let begun = apart.map(|apart| Begun::project_out(&mut room[..blocks], &inverse, apart));
            each(grid, &room[..inverse.len().div_ceil(LANES)], &inverse, begun);
        }
        keep(room);
    }
}
