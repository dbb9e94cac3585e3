//! The evidence: records to learn from, as models are fitted to them and simulated on them, and records kept out of everything.

use std::sync::OnceLock;

use crate::diagnose::retraced::retraces;
use crate::estimate::feedforward::Usual;
use crate::fit::fixed;
use crate::fit::grid::Grid;
use crate::fit::layout::{Layout, Values};
use crate::fit::noise::{Coefficients, Noise, Response, reading};
use crate::fit::scales::CHOOSING;
use crate::fit::search::Problem;
use crate::fit::simulate::predict_one;
use crate::fit::sketch::Sketch;
use crate::log::Record;
use crate::log::repeats::find_repeats;
use crate::motor_file::MotorFile;
use crate::select::crossed::{Fold, folds};
use crate::select::fitted::Fitted;
use motorlens_shared::effects::{Kind, Search};

/// Records to learn from. Nothing here changes while models are compared.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// Simulations that start at the beginning of each record and are never tied to the measurement again.
    pub whole: Problem,
    /// The same for fits: equations tied to an angle act at the measured one, so that a model that drifts keeps their phase.
    pub train: Problem,
    /// Records kept out of every fit and every choice, for simulations only.
    pub kept_out: Option<Problem>,
    /// See [`Self::folds`], once they were asked for.
    folds: OnceLock<Vec<Fold>>,
    /// Whether the shaft comes back to where it was, once that was asked for.
    retraced: OnceLock<bool>,
    /// Pairs of records that run one programme, by their places.
    pub repeats: Vec<(usize, usize)>,
    /// kS-kV-kA fitted to the records; none where they do not give it.
    pub usual: Option<Usual>,
    /// Variance of one reading by its quantisation, in the square of the measured unit.
    pub reading: f64,
}

impl Evidence {
    /// Of `records`, laid out as `whole`, and of `validation` records, which are only simulated.
    pub fn new(whole: Problem, records: &[Record], validation: &[Record], motor: &MotorFile) -> Self {
        let kept_out = (!validation.is_empty()).then(|| whole.on(whole.lay_out(validation, motor)));
        let usual = Usual::of(&whole, records);
        Self { kept_out, usual, ..Self::of(whole, find_repeats(records)) }
    }

    /// Of records laid out as `whole`, of which `repeats` run one programme.
    pub fn of(whole: Problem, repeats: Vec<(usize, usize)>) -> Self {
        let reading = reading(&whole);
        let train = guided(&whole);
        let (folds, retraced) = (OnceLock::new(), OnceLock::new());
        Self { whole, train, kept_out: None, folds, retraced, repeats, usual: None, reading }
    }

    /// Records to fit and records to simulate, for the cross-validated simulation error. A plain fit never asks for them, and of a long record
    /// they are several times as large.
    pub fn folds(&self) -> &[Fold] {
        self.folds.get_or_init(|| folds(&self.train, &self.repeats))
    }

    /// The same where the records begin otherwise: as those of `whole` do now.
    pub(super) fn lay_out_again(&mut self) {
        let train = guided(&self.whole);
        train.simulations.set(self.train.simulations.get());
        self.folds = OnceLock::new();
        self.train = train;
    }

    /// One record of each programme as `sketch` has it, weighted by the noise of `model` and begun as it has them: for candidates that are
    /// only compared.
    pub fn sketch(&self, sketch: Sketch, model: &Fitted) -> Problem {
        let second = |k: &usize| self.repeats.iter().any(|(_, second)| second == k);
        let kept: Vec<usize> = (0..self.train.grids.len()).filter(|k| !second(k)).collect();
        let grids = kept.iter().map(|k| self.train.grids[*k].clone()).collect();
        let mut problem = self.train.on(grids).sketch(sketch);
        problem.begin_with(&kept.iter().map(|k| model.speeds[*k]).collect::<Vec<_>>());
        model.noise.weigh(&mut problem, CHOOSING);
        problem
    }

    /// The noise level at each time scale, from records that repeat a programme: half the variance of what they
    /// differ by beyond `model`, which takes off what differs in their voltages. None without repeats.
    pub fn repeat_noise(&self, model: &Values) -> Option<Noise> {
        let kinds = model.kinds();
        let layout = self.train.layout(&kinds);
        let plain = layout.all_plain(&layout.pack(model));
        let errors = |k: usize| -> Vec<f64> {
            let grid = &self.train.grids[k];
            let run = predict_one(&kinds, &plain, &self.train.rig, grid);
            grid.measured.iter().zip(run).map(|(y, p)| y - p).collect()
        };
        let pair = |&(first, second): &(usize, usize)| {
            let (a, b) = (errors(first), errors(second));
            let n = a.len().min(b.len());
            let grid = &self.train.grids[first];
            let alike = n * 20 >= a.len().max(b.len()) * 19 && n >= 2;
            alike.then(|| {
                let mut zero = grid.first(n);
                zero.measured = vec![0.0; n];
                let apart: Vec<f64> =
                    (0..n).map(|k| (a[k] - b[k]) * std::f64::consts::FRAC_1_SQRT_2).collect();
                Coefficients::of(&zero, &apart)
            })
        };
        let apart: Vec<Coefficients> = self.repeats.iter().filter_map(pair).collect();
        (!apart.is_empty())
            .then(|| Noise::of(&apart, self.reading, Response::of(&self.train, model.base.tau_m)))
    }

    /// The noise level: measured where a programme was run twice, else white noise of `model`'s quietest scale.
    pub fn noise_under(&self, model: &Fitted) -> Noise {
        self.repeat_noise(&model.values()).unwrap_or_else(|| model.noise.white())
    }

    /// What `model` leaves, in multiples of the noise, every time scale alike.
    pub fn left_over(&self, model: &Fitted) -> f64 {
        model.noise.over(&self.noise_under(model))
    }

    /// Whether records like these tell `kind` from everything else, as far as its row asks for more than a motion.
    pub fn may_show(&self, kind: Kind) -> bool {
        kind.spec().search != Search::Retraced || *self.retraced.get_or_init(|| retraces(&self.train))
    }

    /// Candidate passes so far.
    pub fn simulations(&self) -> u64 {
        self.train.simulations.get()
    }

    /// The highest voltage that the rig has shown to bear, V.
    pub fn highest_voltage(&self) -> f64 {
        let cells = self.whole.grids.iter().flat_map(|g| g.cells());
        cells.fold(0.0_f64, |p, v| p.max(v.abs())).max(0.5 * self.whole.rig.nominal_v)
    }
}

fn guided(whole: &Problem) -> Problem {
    whole.on(whole.grids.iter().cloned().map(Grid::guided).collect())
}

impl Problem {
    /// The search axes of a set of effects on this rig, with what the motor file fixes held.
    pub fn layout(&self, kinds: &[Kind]) -> Layout {
        let mut layout = Layout::new(kinds, &self.rig, &self.prior);
        fixed::hold(&mut layout, &self.fixed);
        layout
    }
}
