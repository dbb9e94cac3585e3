//! Eight candidates at a time through a record.

use motorlens_kernel::{self as kernel, Course, Reading, Shown, Sink};
pub use motorlens_kernel::{Block, LANES};
use motorlens_shared::base::Base;
use motorlens_shared::effects::{Kind, Rig};
use motorlens_shared::lanes::Lanes;
use motorlens_shared::scalar::Scalar;
use motorlens_shared::simulator::{Chosen, MAX_EFFECTS, Simulator, in_order};
use motorlens_shared::step::State;

use super::grid::{Grid, Place, Quantity};
use super::layout::{BASE_PARAMETERS, Layout};
use crate::stop;

/// Plain values, base first, then the effects' in order.
struct Parameters<'a, S> {
    base: Base<S>,
    effects: heapless::Vec<Chosen<'a, S>, MAX_EFFECTS>,
}

impl<'a, S: Scalar> Parameters<'a, S> {
    fn new(kinds: &[Kind], plain: &'a [S]) -> Self {
        let base = Base { gain: plain[0], tau_m: plain[1], tau_e: plain[2], viscous_share: plain[3] };
        let mut next = BASE_PARAMETERS;
        let effects = kinds.iter().map(|kind| {
            let n = kind.spec().parameters.len();
            next += n;
            (*kind, &plain[next - n..next])
        });
        Self { base, effects: in_order(effects) }
    }
}

/// Takes the first of the lanes alone.
#[cfg(target_arch = "x86_64")]
struct FirstLane<'a>(Sampler<'a, f64>);

#[cfg(target_arch = "x86_64")]
impl Sink<Block> for FirstLane<'_> {
    fn begin(&mut self, reading: Reading<Block>) {
        self.0.begin(reading.map(|lanes| lanes.0[0]));
    }
    fn take(&mut self, first: usize, readings: &[Reading<Block>]) {
        let shown: Vec<Reading<f64>> = readings.iter().map(|r| r.map(|lanes| lanes.0[0])).collect();
        self.0.take(first, &shown);
    }
}

/// Where a record begins, turning with `speed`, and how far it goes.
fn course<'a, S: Scalar>(
    base: &Base<S>,
    rig: &Rig,
    grid: &'a Grid,
    speed: S,
    [voltages, guide]: [&'a [S::Element]; 2],
) -> Course<'a, S> {
    // A motor already turning has the current that its speed leaves to the first voltage.
    let turning = if grid.rests() { 0.0 } else { 1.0 };
    let current = S::lit(turning) * (S::lit(grid.voltages[0]) - base.back_emf() * speed);
    let last = grid.places.last().map_or(0, |place| place.cell + 1);
    Course {
        start: State::moving(current, speed, S::lit(grid.start_angle)),
        voltages,
        cells: last.min(voltages.len() - 1),
        reading_age_s: grid.reading_age_s,
        encoder_on_motor: rig.encoder_on_motor,
        guide,
        seen: &grid.seen,
        count: grid.quantum,
    }
}

/// Turns readings at the ends of cells into predictions at the samples.
struct Sampler<'a, S> {
    grid: &'a Grid,
    out: &'a mut Vec<S>,
    /// At the end of the cell before the next.
    before: Reading<S>,
    /// Readings where the means begin, a sample after the other.
    since: Vec<S>,
}

impl<'a, S: Scalar> Sampler<'a, S> {
    fn new(grid: &'a Grid, out: &'a mut Vec<S>) -> Self {
        out.clear();
        out.reserve(grid.len());
        Self { grid, out, before: [S::zero(); 2], since: Vec::with_capacity(grid.since.len()) }
    }
}

impl<S: Scalar> Sink<S> for Sampler<'_, S> {
    fn begin(&mut self, reading: Reading<S>) {
        self.before = reading;
    }
    fn take(&mut self, first: usize, readings: &[Reading<S>]) {
        let grid = self.grid;
        let step = S::lit(grid.step_s);
        let end = first + readings.len();
        let ends = |cell: usize| {
            let k = cell - first;
            (if k == 0 { &self.before } else { &readings[k - 1] }, &readings[k])
        };
        let at = |place: &Place| {
            let (before, after) = ends(place.cell);
            match place.part {
                1.0 => after[0],
                // Before the record it turned as it does at its beginning.
                part if part < 0.0 => before[1].mul_add(step * S::lit(part), before[0]),
                part => hermite(part, step, before, after),
            }
        };
        let begun = grid.since[self.since.len()..].iter().take_while(|since| since.place.cell < end);
        self.since.extend(begun.map(|since| at(&since.place)));
        for (number, place) in grid.places.iter().enumerate().skip(self.out.len()) {
            if place.cell >= end {
                break;
            }
            let (before, after) = ends(place.cell);
            let sample = match grid.quantity {
                Quantity::Angle => at(place),
                Quantity::Speed if number == 0 => before[1],
                // The reading's own mean over the cell, and what the shaft's speed is beside its mean at that time.
                Quantity::Speed => {
                    let mean = (after[0] - before[0]) * S::lit(1.0 / grid.step_s);
                    (after[1] - before[1]).mul_add(S::lit(place.part - 0.5), mean)
                }
                Quantity::MeanSpeed | Quantity::WindowSpeed(_) => {
                    (at(place) - self.since[number]) * S::lit(grid.since[number].rate)
                }
            };
            self.out.push(sample);
        }
        self.before = readings[readings.len() - 1];
    }
}

/// Between two readings with known slopes, at `part` of the cell.
#[inline(always)]
pub(super) fn hermite<S: Scalar>(
    part: f64,
    step: S,
    [y0, slope0]: &Reading<S>,
    [y1, slope1]: &Reading<S>,
) -> S {
    let (s, r) = (part, 1.0 - part);
    let ends = *y0 * S::lit(r * r * (1.0 + 2.0 * s)) + *y1 * S::lit(s * s * (3.0 - 2.0 * s));
    ends + step * (*slope0 * S::lit(s * r * r) - *slope1 * S::lit(s * s * r))
}

fn predict<S: Shown<Plain = S, Element = f64>>(
    kinds: &[Kind],
    plain: &[S],
    rig: &Rig,
    grid: &Grid,
    speed: S,
    out: &mut Vec<S>,
) {
    let rig = Rig { step_s: grid.step_s, ..*rig };
    let Parameters { base, effects } = Parameters::new(kinds, plain);
    let simulator = Simulator::new(&base, effects, &rig);
    let course = course(&base, &rig, grid, speed, [&grid.voltages, &grid.guide]);
    kernel::run(&simulator, &course, &mut Sampler::new(grid, out));
}

/// One set of plain parameters; a shaft that stands still where the search is to stop, as in [`predict_from`].
pub fn predict_one(kinds: &[Kind], parameters: &[f64], rig: &Rig, grid: &Grid) -> Vec<f64> {
    if stop::asked() {
        return vec![0.0; grid.len()];
    }
    let mut out = Vec::with_capacity(grid.len());
    #[cfg(target_arch = "x86_64")]
    if kernel::has_wide() {
        // Eight of a kind in the loop that is compiled for these effects take a quarter of the time of one in the loop for any.
        let of_all = |p: &f64| kernel::Wide::from_block(&Lanes([*p; LANES]));
        let plain: Vec<_> = parameters.iter().map(of_all).collect();
        let mut sink = FirstLane(Sampler::new(grid, &mut out));
        predict_wide(kinds, &plain, rig, grid, of_all(&grid.start_speed), &mut sink);
        return out;
    }
    predict(kinds, parameters, rig, grid, grid.start_speed, &mut out);
    out
}

/// The samples of `grid`, of what another simulator shows at the start and at the end of every cell.
pub(crate) fn samples(grid: &Grid, shown: &[Reading<f64>]) -> Vec<f64> {
    let mut out = Vec::new();
    if let [first, later @ ..] = shown
        && !later.is_empty()
    {
        let mut sampler = Sampler::new(grid, &mut out);
        sampler.begin(*first);
        sampler.take(0, later);
    }
    out
}

/// Up to eight search vectors; missing lanes repeat the first.
pub fn predict_block(layout: &Layout, xs: &[Vec<f64>], rig: &Rig, grid: &Grid, out: &mut Vec<Block>) {
    predict_from(layout, xs, &[grid.start_speed; LANES], rig, grid, out);
}

/// The same of records that begin with these `speeds`, rad/s; of those that begin at rest they are zero.
pub fn predict_from(
    layout: &Layout,
    xs: &[Vec<f64>],
    speeds: &[f64; LANES],
    rig: &Rig,
    grid: &Grid,
    out: &mut Vec<Block>,
) {
    if stop::asked() {
        // The search's answer is thrown away: a shaft that stands still will do.
        out.clear();
        out.resize(grid.len(), Lanes([0.0; LANES]));
        return;
    }
    let plain: Vec<Block> = (0..layout.len())
        .map(|k| Lanes(std::array::from_fn(|l| layout.plain(k, xs.get(l).unwrap_or(&xs[0])[k]))))
        .collect();
    #[cfg(target_arch = "x86_64")]
    if kernel::has_wide() {
        let plain: Vec<_> = plain.iter().map(kernel::Wide::from_block).collect();
        let speed = kernel::Wide::from_block(&Lanes(*speeds));
        predict_wide(&layout.kinds, &plain, rig, grid, speed, &mut Sampler::new(grid, out));
        return;
    }
    predict(&layout.kinds, &plain, rig, grid, Lanes(*speeds), out);
}

/// [`predict`] on the vector unit.
#[cfg(target_arch = "x86_64")]
fn predict_wide(
    kinds: &[Kind],
    plain: &[kernel::Wide],
    rig: &Rig,
    grid: &Grid,
    speed: kernel::Wide,
    sink: &mut dyn Sink<Block>,
) {
    let rig = Rig { step_s: grid.step_s, ..*rig };
    let Parameters { base, effects } = Parameters::new(kinds, plain);
    let course = course(&base, &rig, grid, speed, [&grid.voltages, &grid.guide]);
    kernel::run_wide(&base, &effects, &rig, &course, sink);
}
