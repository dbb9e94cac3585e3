//! A model on trial: its fit and its errors on records that it was fitted to and that it was not.

use motorlens_shared::effects::Kind;

use crate::fit::fixed;
use crate::fit::layout::{Layout, Values};
use crate::fit::pulses::FREQUENCY;
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

    /// From mean squares of increments and of the error itself.
    pub fn of([increments, position]: [f64; 2]) -> Self {
        Self { increments: (0.5 * increments).sqrt(), position: position.sqrt() }
    }

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

/// Times the floor that a record's increments leave where something shows on it: a lag after quick changes of voltage, a ripple
/// at low speed, of which the mean over all records shows little.
pub const STANDS_OUT: f64 = 1.35;

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
    /// Of the increments on every record fitted, then on every one kept out.
    pub records: Vec<f64>,
    /// Whether nothing disturbs the motor, where a repeated programme tells.
    pub calm: Option<bool>,
    /// Whether it has an effect that two runs of a programme show without any model.
    pub foretold: bool,
}

impl Candidate {
    /// The same where its errors were counted in units of `old` and are now in units of `new`.
    #[must_use]
    pub fn over(&self, old: &Errors, new: &Errors) -> Self {
        let unit = new.over(old);
        let records = self.records.iter().map(|increments| increments / unit.increments).collect();
        Self { train: self.train.over(&unit), unseen: self.unseen.over(&unit), records, ..self.clone() }
    }
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
    /// Near what a perfect model would leave, on the records fitted and on those kept out: a search need not go on.
    ///
    /// The increments tell whether the physics is right; the error itself may be a few times its floor, not any times.
    pub fn explains(&self) -> bool {
        const NEAR: f64 = 1.3;
        self.is_within(NEAR)
    }
    /// Nearer still, and on every record: so a model that is believed to be all that there is must be.
    pub fn explains_all(&self) -> bool {
        const AT_THE_NOISE: f64 = 1.2;
        self.is_within(AT_THE_NOISE) && self.worst() < STANDS_OUT
    }
    fn is_within(&self, times: f64) -> bool {
        [self.train, self.unseen].iter().all(|e| e.increments < times && e.position < STEADY)
    }
    /// The increments' error over the floor, on both sets of records.
    pub fn increments(&self) -> f64 {
        (self.train.increments * self.unseen.increments).sqrt()
    }
    /// How far above the floor the increments are: 0 at the floor.
    pub fn excess(&self) -> f64 {
        (self.increments() - 1.0).max(0.0)
    }
    /// The error itself over the floor, on both sets of records.
    pub fn drift(&self) -> f64 {
        (self.train.position * self.unseen.position).sqrt()
    }
    /// The larger of the increments' errors on the two sets of records, over the floor.
    pub fn larger_increments(&self) -> f64 {
        self.train.increments.max(self.unseen.increments)
    }
    /// The larger of the errors themselves on the two sets of records, over the floor.
    pub fn larger_drift(&self) -> f64 {
        self.train.position.max(self.unseen.position)
    }
    /// The record that it fits worst, by its increments.
    pub fn worst(&self) -> f64 {
        self.records.iter().copied().fold(0.0, f64::max)
    }
    /// Number of parameters that were searched.
    pub fn size(&self) -> usize {
        self.layout.free().len()
    }
}

impl Problem {
    /// The search axes of a set of effects on this rig, with what the motor file fixes held, and what pulses show.
    pub fn layout(&self, kinds: &[Kind]) -> Layout {
        let mut layout = self.open_layout(kinds);
        if let Some(hz) = self.pulse_hz {
            fixed::hold(&mut layout, &[(FREQUENCY.to_owned(), hz)].into());
        }
        layout
    }

    /// The same with the frequency of pulses open: where commands change at a beat of their own, its mirrors in that beat would do
    /// nearly as well.
    pub fn open_layout(&self, kinds: &[Kind]) -> Layout {
        let mut layout = Layout::new(kinds, &self.rig, &self.prior);
        fixed::hold(&mut layout, &self.fixed);
        layout
    }

    /// Errors of up to eight candidates on these records.
    pub fn errors(&self, layout: &Layout, xs: &[Vec<f64>]) -> Vec<Errors> {
        self.mean_squares(layout, xs).into_iter().map(Errors::of).collect()
    }
}
