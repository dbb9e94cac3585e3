//! A model on trial: its fit and its errors on records that it was fitted to and that it was not.

use motorlens_shared::effects::Kind;

use crate::fit::cost::Objective;
use crate::fit::fixed;
use crate::fit::grid::Grid;
use crate::fit::layout::{Layout, Values};
use crate::fit::search::{Found, Problem};

/// Two errors, each a root mean square; of a candidate in units of what a perfect model would leave.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Errors {
    /// Of the error's increments over 50 ms, robust.
    pub increments: f64,
    /// Of the error itself.
    pub position: f64,
}

impl Errors {
    /// What counting alone leaves.
    pub const COUNTING: Self = Self { increments: 1.0, position: 1.0 };

    /// In units of `floor`.
    #[must_use]
    pub fn over(self, floor: &Self) -> Self {
        Self { increments: self.increments / floor.increments, position: self.position / floor.position }
    }

    /// One number for ranking: a ratio of errors is a difference of merits.
    ///
    /// The increments count more, because the error itself drifts. Below the noise nothing is gained.
    pub fn merit(&self) -> f64 {
        self.increments.max(0.7).ln() + 0.5 * self.position.max(0.7).ln()
    }
}

/// An error itself below this many times its floor is no drift: it sums up every small fault of the parameters.
pub const STEADY: f64 = 3.0;

/// A model with its fit.
#[derive(Debug, Clone)]
pub struct Candidate {
    /// Search axes.
    pub layout: Layout,
    /// Where the search ended.
    pub found: Found,
    /// On the records fitted.
    pub train: Errors,
    /// On the records kept out.
    pub unseen: Errors,
}

impl Candidate {
    /// Effects in order.
    pub fn kinds(&self) -> &[Kind] {
        &self.layout.kinds
    }
    /// Plain parameters.
    pub fn values(&self) -> Values {
        self.layout.unpack(&self.found.x)
    }
    /// Ranking number over both sets of records; smaller is better.
    pub fn merit(&self) -> f64 {
        0.5 * (self.train.merit() + self.unseen.merit())
    }
    /// Near what a perfect model would leave, on the records fitted and on those kept out.
    ///
    /// The increments tell whether the physics is right; the error itself may be a few times its floor, not any times.
    pub fn explains(&self) -> bool {
        const NEAR: f64 = 1.3;
        [self.train, self.unseen].iter().all(|e| e.increments < NEAR && e.position < STEADY)
    }
    /// How far above the floor the increments are: 0 at the floor.
    pub fn excess(&self) -> f64 {
        ((self.train.increments * self.unseen.increments).sqrt() - 1.0).max(0.0)
    }
    /// Number of parameters that were searched.
    pub fn size(&self) -> usize {
        self.layout.axes.iter().filter(|a| !a.fixed).count()
    }
}

/// Records fitted and records kept out, as the diagnosis uses them.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// All records to learn from, whole.
    pub whole: Problem,
    /// Fitted, in guided runs.
    pub train: Problem,
    /// Kept out, in guided runs.
    pub unseen: Problem,
    /// What a perfect model would leave, in noise units of one reading: the unit of a candidate's errors.
    pub floor: Errors,
    /// Whether that was measured, by a repeated programme; else it is what counting alone leaves.
    pub repeated: bool,
}

impl Evidence {
    /// Candidate passes so far.
    pub fn simulations(&self) -> u64 {
        self.train.simulations.get() + self.unseen.simulations.get()
    }

    /// The highest voltage that the rig has shown to bear, V.
    pub fn highest_voltage(&self) -> f64 {
        let cells = self.whole.grids.iter().flat_map(|g| g.cells());
        cells.fold(0.0_f64, |p, v| p.max(v.abs())).max(0.5 * self.whole.rig.nominal_v)
    }

    /// The errors of `x` on both.
    pub fn judge(&self, layout: Layout, found: Found) -> Candidate {
        let train = self.train.errors(&layout, &found.x).over(&self.floor);
        let unseen = self.unseen.errors(&layout, &found.x).over(&self.floor);
        Candidate { layout, found, train, unseen }
    }

    /// Searches `values` in increments, then lets the error itself correct the drift of the parameters.
    pub fn fit(&self, values: &Values, iterations: usize) -> Candidate {
        let layout = self.train.layout(&values.kinds());
        let x = layout.pack(values);
        let rough = self.train.search(&layout, Objective::Increments, &x, iterations, 1e-4);
        self.polish(layout, rough)
    }

    /// The better of a fit in increments and its correction by the error itself.
    ///
    /// Where a disturbance makes the error drift, the correction would follow the drift: then it is refused.
    pub fn polish(&self, layout: Layout, rough: Found) -> Candidate {
        let fine = self.train.search(&layout, Objective::Position, &rough.x, 3, 1e-3);
        let a = self.judge(layout.clone(), rough);
        let b = self.judge(layout, fine);
        if b.merit() < a.merit() { b } else { a }
    }
}

impl Evidence {
    /// An accepted model's parameters, corrected by the error itself until it stops falling.
    ///
    /// The increments leave a slow drift undetermined, which the error of a long run shows. Where a disturbance
    /// makes the drift, the correction does not help on unseen records and is refused.
    pub fn finish(&self, accepted: Candidate) -> Candidate {
        let fine = self.train.search(&accepted.layout, Objective::Position, &accepted.found.x, 10, 1e-6);
        let fine = self.judge(accepted.layout.clone(), fine);
        let better = fine.unseen.position <= accepted.unseen.position
            && fine.unseen.increments < accepted.unseen.increments * 1.05;
        if better { fine } else { accepted }
    }
}

impl Evidence {
    /// Fits the first speeds of the records that begin in motion anew under `model`, and then the model.
    pub fn settle_starts(&mut self, model: Candidate) -> Candidate {
        let rest = |p: &Problem| p.grids.iter().all(Grid::rests);
        if [&self.whole, &self.train, &self.unseen].into_iter().all(rest) {
            return model;
        }
        let values = model.values();
        for problem in [&mut self.whole, &mut self.train, &mut self.unseen] {
            problem.refine_starts(&values);
        }
        self.fit(&values, 6)
    }
}

impl Problem {
    /// The search axes of a set of effects on this rig, with what the motor file fixes held.
    pub fn layout(&self, kinds: &[Kind]) -> Layout {
        let mut layout = Layout::new(kinds, &self.rig, &self.prior);
        fixed::hold(&mut layout, &self.fixed);
        layout
    }

    /// Errors of search numbers `x` on these records.
    pub fn errors(&self, layout: &Layout, x: &[f64]) -> Errors {
        let rms = |objective| {
            let (sum, count) = self.sum_of_squares(layout, objective, x);
            (sum / count.max(1) as f64).sqrt()
        };
        Errors {
            increments: rms(Objective::Increments) / std::f64::consts::SQRT_2,
            position: rms(Objective::Position),
        }
    }
}
