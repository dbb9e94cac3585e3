//! The loop by itself: fit, diagnose, add, until nothing is worth adding.

use std::time::Instant;

use motorlens_shared::effects::Kind;

use super::evidence::Evidence;
use super::ladder::{Ranked, Rung, rung};
use super::plan::{self, Limits, Plan};
use crate::compare::laid_out;
use crate::error::Result;
use crate::findings::Experiment;
use crate::fit::grid::{Grid, Quantity};
use crate::fit::layout::Values;
use crate::fit::reading::fast_scatter;
use crate::fit::search::Problem;
use crate::fit::setup;
use crate::log::{Record, repeats};
use crate::model_file::Model;
use crate::motor_file::MotorFile;
use crate::select::adequacy::Adequacy;
use crate::select::fitted::Fitted;
use crate::select::run::{Rivals, Selected};
use crate::select::{self, Begin, DetectionLimit};

/// What is going on, for a progress bar.
#[derive(Debug, Clone)]
pub enum Progress {
    /// An effect is being tried on the model of so many effects.
    Trying {
        /// Effects in the model so far.
        depth: usize,
        /// The effect on trial.
        effect: Kind,
    },
    /// A model of the sequence is fitted.
    Rung(Rung),
    /// The speeds turn out to be read so: the ladder is climbed anew.
    Anew(Quantity),
}

/// What to look for.
#[derive(Debug, Clone)]
pub struct Options {
    /// Effects that may be added: the kinds of a [`Library`](crate::formula::Library), or some of them.
    pub library: Vec<Kind>,
    /// Most effects.
    pub most: usize,
}

impl Default for Options {
    fn default() -> Self {
        Self { library: Kind::ALL.to_vec(), most: 4 }
    }
}

/// Everything a discovery found.
#[derive(Debug)]
pub struct Discovery {
    /// Accepted effects in order.
    pub effects: Vec<Kind>,
    /// The noise level, rms in the measured unit.
    pub noise_floor: f64,
    /// What it leaves.
    pub adequacy: Adequacy,
    /// From the base model to the accepted one; a model that is diagnosed comes second, if it has effects.
    pub ladder: Vec<Rung>,
    /// Errors of kS-kV-kA fitted to the same records; none where they do not give it.
    pub baseline: Option<Rung>,
    /// The models of the selection's steps as they would be used: fitted for simulating.
    pub shown: Vec<Values>,
    /// First diagnosis, best first.
    pub candidates: Vec<Ranked>,
    /// The model on all records.
    pub model: Model,
    /// Time taken, s.
    pub seconds: f64,
    /// Candidate passes through all records.
    pub simulations: u64,
    /// The search's own view, for whoever digs further.
    pub evidence: Evidence,
    /// The models of the selection, its candidates and their rivals.
    pub selected: Selected,
    /// For every effect that was not accepted, what the records would have shown of it.
    pub limits: Vec<DetectionLimit>,
}

/// Runs the loop on `records`; the `validation` records touch no fit and no choice, and are scored once at the end.
///
/// # Errors
/// Records that no fit can use.
pub fn discover(
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
    options: &Options,
    progress: &mut dyn FnMut(Progress),
) -> Result<Discovery> {
    let at = Instant::now();
    let (evidence, model) = prepare(records, validation, motor)?;
    let select = |(evidence, model), progress: &mut dyn FnMut(Progress)| {
        let begin = Begin { at, evidence, plain: None, model };
        select::discovery(begin, records, validation, options, progress)
    };
    let found = select((evidence, model), progress);
    // How a speed is read was asked of a motor without the effects that are known now.
    let values = found.selected.model().values();
    let Some(otherwise) = found.evidence.whole.read_otherwise(&values) else { return Ok(found) };
    let read_so = settled(setup::problem_of(records, motor, Some(otherwise)), records, validation, motor);
    let again = select(read_so, &mut |told| {
        if matches!(told, Progress::Trying { .. }) {
            progress(told);
        }
    });
    if again.selected.model().score() <= found.selected.model().score() {
        return Ok(found);
    }
    progress(Progress::Anew(otherwise));
    again.ladder.iter().for_each(|rung| progress(Progress::Rung(rung.clone())));
    Ok(again)
}

/// One step up from `model`, refitted to `records`: what of `library` it is missing.
///
/// # Errors
/// Records that no fit can use.
pub fn diagnose(
    model: &Model,
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
    library: &[Kind],
    progress: &mut dyn FnMut(Progress),
) -> Result<Discovery> {
    let at = Instant::now();
    crate::log::check_some(records)?;
    crate::log::check_all_usable(records.iter().chain(validation))?;
    let (evidence, plain) = settled(laid_out(model, records, motor), records, validation, motor);
    let given = model.values();
    let begin = Begin {
        at,
        model: select::fitted_from(&evidence, &given),
        plain: (!given.effects.is_empty()).then_some(plain),
        evidence,
    };
    let own = usize::from(begin.plain.is_some());
    let options = Options { library: library.to_vec(), most: 1 };
    let mut found = select::discovery(begin, records, validation, &options, progress);
    // The model's own errors are those of the model as it came.
    found.ladder[own] = rung(&found.evidence, &given);
    Ok(found)
}

/// Lays out the records and fits the base model.
///
/// # Errors
/// Records that no fit can use.
pub fn prepare(records: &[Record], validation: &[Record], motor: &MotorFile) -> Result<(Evidence, Fitted)> {
    crate::log::check_some(records)?;
    crate::log::check_all_usable(records.iter().chain(validation))?;
    Ok(settled(setup::problem(records, motor), records, validation, motor))
}

/// The evidence of records that are laid out, and the plain motor fitted to them.
fn settled(
    (whole, start): (Problem, Values),
    records: &[Record],
    validation: &[Record],
    motor: &MotorFile,
) -> (Evidence, Fitted) {
    let mut evidence = Evidence::new(whole, records, validation, motor);
    let (layout, x) = evidence.train.fit_base(&start);
    let base = select::fitted_from(&evidence, &layout.unpack(&x));
    // The first speeds were those of a rough model: what they are wrong by would look like an effect.
    let base = evidence.settle_starts(base);
    (evidence, base)
}

impl Discovery {
    /// The programme that would best tell the rivals of the first effect that has any apart.
    pub fn plan(&self, limits: Limits) -> Option<Plan> {
        let models: Vec<&Fitted> = self.selected.rivals.first()?.models.iter().collect();
        plan::choose(&self.evidence.whole, &models, limits)
    }

    /// What to run next within the limits of the rig.
    pub fn experiment(&self, within: Limits) -> Experiment {
        let open = self.selected.rivals.first();
        let open: Vec<&Fitted> = open.map_or_else(Vec::new, |rivals| rivals.models.iter().collect());
        Experiment::after(&self.evidence, self.selected.model(), &open, &self.limits, within)
    }

    /// Sets of effects that this data cannot tell apart, the accepted one of each first.
    pub fn open_sets(&self) -> Vec<Vec<Kind>> {
        self.selected.rivals.iter().map(Rivals::kinds).collect()
    }
}

/// The noise level: from a repeated programme where there is one, else from the counting or, where that is more, the
/// fast scatter of the readings: the decimals of a file are not what an encoder counts.
pub fn noise_floor(records: &[Record], validation: &[Record], problem: &Problem) -> f64 {
    let all: Vec<Record> = records.iter().chain(validation).cloned().collect();
    let floors: Vec<f64> = repeats::find_repeats(&all)
        .into_iter()
        .filter_map(|(a, b)| repeats::noise_floor(&all[a], &all[b]))
        .collect();
    let counting = reading_noise(problem);
    if floors.is_empty() { counting } else { rms(&floors).max(counting) }
}

/// What a single reading scatters by, over all records of `problem`, in the measured unit.
pub fn reading_noise(problem: &Problem) -> f64 {
    let reading = |g: &Grid| g.least_noise().max(fast_scatter(g));
    rms(&problem.grids.iter().map(reading).collect::<Vec<_>>())
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|f| f * f).sum::<f64>() / x.len() as f64).sqrt()
}
