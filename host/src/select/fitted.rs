//! A model fitted to the records, with its noise and its score.

use std::sync::OnceLock;

use motorlens_shared::effects::Kind;

use super::criterion::{
    AS_GOOD, LIKELY, RISE, SURE, WORTH, best_of, is_enough_for_expected, is_expected, is_large, is_trifle,
    is_worth, is_worth_alone, sure_enough,
};
use super::crossed::{Fall, crossed};
use super::gain::Gain;
use super::score::Scored;
use super::starts::places;
use crate::compare::free_run::simulated;
use crate::diagnose::evidence::Evidence;
use crate::fit::cost::Objective;
use crate::fit::layout::{Layout, Values};
use crate::fit::noise::{Coefficients, Noise, Response, coefficients};
use crate::fit::scales::{CHOOSING, KEEPING};
use crate::fit::uncertainty::Spread;
use crate::stop;

/// Rounds of weighing of a model that is kept, and steps of each.
pub const SETTLED: (usize, usize) = (3, 12);

/// A simulation error so many times that of the model before is no improvement, whatever the likelihood says; under a disturbance each run
/// drifts by chance, and the better model's may drift a little further.
const STRAYS: f64 = 1.25;

/// Steps of the last correction.
const LAST: usize = 12;

/// A model and how well it predicts.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// Its axes.
    pub layout: Layout,
    /// Where the search ended, on those axes.
    pub x: Vec<f64>,
    /// First speeds of the records, rad/s, as they were fitted with it.
    pub speeds: Vec<f64>,
    /// What it leaves, by time scale.
    pub noise: Noise,
    /// Held-out log-likelihood under its own noise.
    score: f64,
    scored: Scored,
    /// Logarithms of its cross-validated simulation errors, record by record, once they were asked for.
    crossed: OnceLock<Vec<f64>>,
    /// Its simulation error on all records of the fit, once it was asked for.
    simulated: OnceLock<f64>,
    /// Whether the records determine its gain, and its time constant, once that was asked for.
    knows: OnceLock<[bool; 2]>,
}

impl Fitted {
    /// Fits `layout` from `x`: so many `rounds` of weighing by the model's own noise and searching for at most `steps`.
    pub fn new(data: &Evidence, layout: Layout, x: &[f64], rounds: usize, steps: usize) -> Self {
        Self::weighed(data, layout, x, rounds, steps, CHOOSING)
    }

    /// The same with the plain simulation error at the weight `plain`.
    fn weighed(data: &Evidence, layout: Layout, x: &[f64], rounds: usize, steps: usize, plain: f64) -> Self {
        let mut problem = data.train.clone();
        let mut x = x.to_vec();
        problem.begin_under(&layout, &x);
        let noise_of = |errors: &[Coefficients], x: &[f64]| {
            let response = Response::of(&data.train, layout.unpack(x).base.tau_m);
            Noise::of(errors, data.reading, response)
        };
        let mut errors = coefficients(&problem, &layout, &x);
        let mut noise = noise_of(&errors, &x);
        for _ in 0..rounds.max(1) {
            noise.weigh(&mut problem, plain);
            x = problem.settle(&layout, Objective::Scales, &x, steps, 1e-4);
            errors = coefficients(&problem, &layout, &x);
            noise = noise_of(&errors, &x);
        }
        noise.weigh(&mut problem, plain);
        let scored = Scored::new(&problem, &layout, &x, errors, &noise);
        data.train.count_passes_of(&problem);
        let score = scored.under(&noise).iter().sum();
        let speeds = problem.first_speeds();
        Self {
            layout,
            x,
            speeds,
            noise,
            score,
            scored,
            crossed: OnceLock::new(),
            simulated: OnceLock::new(),
            knows: OnceLock::new(),
        }
    }

    /// Fits the model `values`.
    pub fn of(data: &Evidence, values: &Values, rounds: usize, steps: usize) -> Self {
        let layout = data.train.layout(&values.kinds());
        let x = layout.pack(values);
        Self::new(data, layout, &x, rounds, steps)
    }

    /// The same for use: fitted with the plain simulation error at its full weight, and corrected by that alone until it stops falling:
    /// the last drift of a long run hardly shows in the likelihood. The correction is kept where the likelihood hardly falls; where a
    /// disturbance made the drift, it does. Where the search is to stop it is as it was, for then nobody asks for what was found.
    #[must_use]
    pub fn simulating(&self, data: &Evidence) -> Self {
        if stop::asked() {
            return self.clone();
        }
        let kept = |x: &[f64], (rounds, steps): (usize, usize)| {
            Self::weighed(data, self.layout.clone(), x, rounds, steps, KEEPING)
        };
        let kept_first = kept(&self.x, SETTLED);
        let (_, corrected) = data.train.race(&self.layout, Objective::Position, &kept_first.x, LAST, 1e-6);
        let fine = kept(&corrected, (1, 0));
        let better = fine.score() > kept_first.score() - WORTH && fine.noise.mean() < kept_first.noise.mean();
        if better { fine } else { kept_first }
    }

    /// Plain parameters.
    pub fn values(&self) -> Values {
        self.layout.unpack(&self.x)
    }

    /// Effects in order.
    pub fn kinds(&self) -> &[Kind] {
        &self.layout.kinds
    }

    /// The same from where it would be had those parameters their usual values that are as far above them as they may be; none where no
    /// parameter is.
    pub fn from_usual(&self, data: &Evidence, rounds: usize, steps: usize) -> Option<Self> {
        let (mut layout, mut x) = (self.layout.clone(), self.x.clone());
        for (axis, x) in layout.axes.iter_mut().zip(&mut x).filter(|(axis, _)| !axis.fixed) {
            let highest = *x > axis.high - 1e-3 * (axis.high - axis.low);
            if let Some((usual, _)) = axis.prior.filter(|_| highest) {
                (axis.fixed, *x) = (true, usual);
            }
        }
        let bent = layout.free().len() < self.layout.free().len();
        let held = bent.then(|| Self::new(data, layout, &x, rounds, steps))?;
        Some(Self::new(data, self.layout.clone(), &held.x, rounds, steps))
    }

    /// Number of fitted parameters.
    pub fn size(&self) -> usize {
        self.layout.free().len()
    }

    /// Held-out log-likelihood under its own noise: ranks models of the same records.
    pub fn score(&self) -> f64 {
        self.score
    }

    /// By how much it is better than `other`.
    pub fn gain_over(&self, other: &Self) -> Gain {
        let better = if self.score() < other.score() { other } else { self };
        let noise = better.noise.with_all_left();
        Gain::of(&self.scored.under(&noise), &other.scored.under(&noise))
    }

    /// The same, searched to the end.
    #[must_use]
    pub fn settled(self, data: &Evidence) -> Self {
        let settled = Self::of(data, &self.values(), SETTLED.0, SETTLED.1);
        self.or_better(Some(settled))
    }

    /// `other` where it has the higher score.
    #[must_use]
    pub fn or_better(self, other: Option<Self>) -> Self {
        other.filter(|other| other.score() > self.score()).unwrap_or(self)
    }

    /// Whether it is better than `other` beyond doubt, by what is worth mentioning beside all that it explains of what `base` leaves: the
    /// likelihood says so, and more surely where the cross-validated simulation error rises, or that error surely falls. A slow effect
    /// under a disturbance shows in the second: in the likelihood each block has a drift of its own, and says little.
    pub fn beats_surely(&self, other: &Self, data: &Evidence, base: &Self) -> bool {
        let places = self.places_beyond(other);
        let sure = |blocks: usize| best_of(places, sure_enough(blocks));
        let gain = self.gain_over(other);
        is_worth(gain, self.gain_over(base).total, places, || self.fall(other, data).sure())
            && (self.is_likelier(gain, sure(self.scored.blocks()), other, data)
                || self.fall(other, data).is_beyond_doubt(AS_GOOD, sure))
    }

    /// The same, or by so much that fewer standard errors do, or where it is expected.
    pub fn beats(&self, other: &Self, data: &Evidence, base: &Self) -> bool {
        self.beats_surely(other, data, base)
            || self.outweighs(other, data, base)
            || self.is_as_expected(other, data, base)
    }

    /// Whether it is better than `other` by so much that it has to be only likely: a disturbance that lasts makes the blocks differ by more
    /// than a likelihood foresees, so that a few of them hide what is plain in their sum; the sum itself it raises no further than `LARGE`.
    pub fn outweighs(&self, other: &Self, data: &Evidence, base: &Self) -> bool {
        let gain = self.gain_over(other);
        let places = self.places_beyond(other);
        let is_large = is_large(gain, self.gain_over(base).total, places, || self.fall(other, data).sure());
        is_large && self.is_likelier(gain, best_of(places, LIKELY), other, data)
    }

    /// Whether nearly every motor or log has all that it has beyond `other`, and its likelihood is higher by so much that nothing else has to be
    /// sure.
    pub fn is_as_expected(&self, other: &Self, data: &Evidence, base: &Self) -> bool {
        self.beyond(other).all(is_expected)
            && is_enough_for_expected(self.gain_over(other), self.gain_over(base).total)
            && self.fall(other, data).rise() <= 0.0
    }

    /// Whether `kind`, which gains so much beside it, would be accepted, as far as the likelihood alone tells, where `explained` natural
    /// logarithms are explained so far.
    pub fn would_accept(&self, kind: Kind, gain: Gain, explained: f64) -> bool {
        let (all, places) = (explained + gain.total, places(kind));
        is_worth_alone(gain, all, places) && gain.sure > best_of(places, sure_enough(self.scored.blocks()))
            || is_large(gain, all, places, || 0.0) && gain.sure > best_of(places, LIKELY)
            || is_enough_for_expected(gain, all) && is_expected(kind)
    }

    /// Whether the search for one of its parameters ended at its bound, which is no minimum, while none of `other` did.
    pub fn is_lost(&self, other: &Self) -> bool {
        self.is_at_the_end() && !other.is_at_the_end()
    }

    /// Whether one of its parameters stands where the search for it ends.
    pub fn is_at_the_end(&self) -> bool {
        !self.layout.at_the_end(&self.x).is_empty()
    }

    /// Whether it simulates the records that it was fitted to clearly worse than `other` does. Fits hold the phase of what repeats with the angle at
    /// the measured angle; a model that only runs so is of no use.
    pub fn strays(&self, other: &Self, data: &Evidence) -> bool {
        self.error(data) > STRAYS * other.error(data)
    }

    /// Error of its simulation of the records that it was fitted to, rms, in the measured unit.
    pub fn error(&self, data: &Evidence) -> f64 {
        let run = || simulated(&data.whole, &self.values()).map_or(f64::INFINITY, |m| m.rmse);
        *self.simulated.get_or_init(run)
    }

    /// Whether it leaves the gain open that `other` determines, or by more than is expected the time constant: its effects then have taken what was
    /// known of the motor, and no record says how much of it (practical identifiability: A. Raue et al., *Bioinformatics* 25, 2009). What is late
    /// and a slow motor look alike in a short test, but nearly every log is late: then the time constant was not known before.
    pub fn opens_the_motor(&self, other: &Self, data: &Evidence) -> bool {
        let opens = |k: usize| !self.knows(data)[k] && other.knows(data)[k];
        opens(0) || opens(1) && !self.beyond(other).all(is_expected)
    }

    /// Whether the records determine anything of the motor itself beside its effects: its gain or its time constant.
    pub fn knows_the_motor(&self, data: &Evidence) -> bool {
        self.knows(data).contains(&true)
    }

    /// Whether the records determine its gain, and its time constant.
    fn knows(&self, data: &Evidence) -> [bool; 2] {
        let told = || {
            let spread = Spread::of(&data.train, &self.values());
            [0, 1].map(|k| spread.parameter(k).identifiable)
        };
        *self.knows.get_or_init(told)
    }

    /// Whether an effect that it has beyond those of `other` is a trifle beside the highest voltage.
    pub fn adds_a_trifle(&self, other: &Self, data: &Evidence) -> bool {
        let (values, highest) = (self.values(), data.highest_voltage());
        self.beyond(other)
            .any(|kind| values.parameters(kind).is_some_and(|own| is_trifle(kind, own, highest)))
    }

    /// At how many places together was looked for the effects that it has beyond those of `other`.
    fn places_beyond(&self, other: &Self) -> usize {
        self.beyond(other).map(places).product()
    }

    /// The effects that it has beyond those of `other`.
    fn beyond(&self, other: &Self) -> impl Iterator<Item = Kind> {
        self.kinds().iter().copied().filter(|kind| !other.kinds().contains(kind))
    }

    /// Whether its `gain` over `other` is so many standard errors `sure`, and a rise of the simulation error does not speak against it.
    fn is_likelier(&self, gain: Gain, sure: f64, other: &Self, data: &Evidence) -> bool {
        gain.sure > sure && gain.sure - RISE * self.fall(other, data).rise() > sure
    }

    fn fall(&self, other: &Self, data: &Evidence) -> Fall {
        Fall::of(self.unseen(data), other.unseen(data), data.folds().len() > 1)
    }

    /// Whether its likelihood is higher than that of `other`, worth it and so many standard errors `sure`.
    fn predicts_better(&self, other: &Self, base: &Self, sure: f64) -> bool {
        let gain = self.gain_over(other);
        gain.sure > sure && is_worth_alone(gain, self.gain_over(base).total, 1)
    }

    /// Whether it does as well as `other`: that does not predict better beyond doubt, and simulates records that it was not fitted to hardly
    /// better either. A few blocks may be too few to be sure of a gain that is plain in the simulation.
    pub fn is_as_good_as(&self, other: &Self, data: &Evidence, base: &Self) -> bool {
        !other.predicts_better(self, base, SURE) && self.crossed(data) < other.crossed(data) + AS_GOOD
    }

    /// Mean logarithm of the error with which the records are simulated by fits to the others ([`super::crossed`]).
    pub fn crossed(&self, data: &Evidence) -> f64 {
        let errors = self.unseen(data);
        errors.iter().sum::<f64>() / errors.len().max(1) as f64
    }

    /// The same of each record.
    fn unseen(&self, data: &Evidence) -> &[f64] {
        self.crossed.get_or_init(|| crossed(data, &self.layout, &self.x, &self.noise))
    }
}
