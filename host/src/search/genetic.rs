//! The paper's search on whole records: the compact genetic algorithm of `shared`, evaluated in lanes.

use super::crew::Crew;
use super::dispatch::Level;
use super::record::{Candidates, LinearRecord, RecordError, Records};
use crate::stop;
use motorlens_shared::ga::{Genetic, Settings, Space};
use motorlens_shared::motor::{Combinations, PARAMETERS, PaperMotor};
use motorlens_shared::random::Stream;
use serde::Serialize;
use std::time::Instant;

/// Largest population.
pub const MOST: usize = 1024;

/// Where the first generation is drawn and what the genes are.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Start {
    /// The paper's equations 14 and 15, taken literally: every gene is a parameter in its own unit, drawn
    /// evenly from centre - eps to centre + eps, with eps drawn from 0 to 1 for each chromosome. This makes
    /// negative inertias and resistances; they are set to a thousandth of the centre, and counted.
    Literal {
        /// x_sm, all parameters positive.
        centre: PaperMotor,
    },
    /// Every gene is the logarithm of a parameter, drawn evenly from centre / factor to centre * factor.
    Logarithmic {
        /// All parameters positive.
        centre: PaperMotor,
        /// Above 1.
        factor: f64,
    },
}

/// How much to search. Defaults: the paper's 80 chromosomes and 800 generations.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GaOptions {
    /// Chromosomes, 2 to [`MOST`].
    pub population: usize,
    /// Generations, the first included.
    pub generations: u32,
    /// Any number.
    pub seed: u64,
    /// Threads; changes the time and nothing else.
    pub threads: usize,
    /// Independent populations that exchange their best every 50 generations; the paper has 1.
    pub islands: u16,
}

impl Default for GaOptions {
    fn default() -> Self {
        Self { population: 80, generations: 800, seed: 1, threads: 1, islands: 1 }
    }
}

/// What a search found.
#[derive(Debug, Clone, Serialize)]
pub struct GaResult {
    /// One of infinitely many equal answers.
    pub motor: PaperMotor,
    /// The same in the paper's order.
    pub parameters: [f64; PARAMETERS],
    /// What the records determine.
    pub combinations: Combinations,
    /// Summed over the records, computed in double precision; rad s or rad.
    pub iae: f64,
    /// Best objective of each generation (single precision), as in the paper's Figure 5.
    pub history: Vec<f64>,
    /// Chromosomes evaluated.
    pub evaluations: u64,
    /// The search alone.
    pub seconds: f64,
    /// Genes of the first generation that were negative and had to be clamped.
    pub clamped: usize,
    /// Genes of later generations that had to be clamped.
    pub clamped_later: usize,
    /// Vector unit in use.
    pub level: Level,
}

/// Searches the paper's linear model on angle and speed records; the objective is the IAE summed over them.
///
/// `progress` gets the generation (from 1) and the best objective.
///
/// # Errors
/// See [`RecordError`].
pub fn genetic(
    records: &[LinearRecord],
    start: &Start,
    options: &GaOptions,
    progress: &mut dyn FnMut(u32, f64),
) -> Result<GaResult, RecordError> {
    let records = Records::new(records, Level::best())?;
    Ok(genetic_on(&records, start, options, progress))
}

/// [`genetic`] on records that are already prepared.
pub fn genetic_on(
    records: &Records,
    start: &Start,
    options: &GaOptions,
    progress: &mut dyn FnMut(u32, f64),
) -> GaResult {
    if options.islands > 1 {
        return super::islands::search(records, start, options, progress);
    }
    let began = Instant::now();
    let crew = Crew::new(records, options.population.min(MOST));
    let mut run = Run::new(start, options, 0);
    let mut history = Vec::with_capacity(options.generations as usize);
    crew.with_helpers(options.threads, || {
        let mut motors = Vec::with_capacity(MOST);
        let mut objective = |genes: &[[f64; PARAMETERS]], iae: &mut [f64]| {
            let fill = |candidates: &mut Candidates| {
                motors.clear();
                motors.extend(genes.iter().map(|g| start.motor(g).combinations()));
                records.discretise(&motors, candidates);
            };
            crew.iae_of(fill, iae);
        };
        for generation in 1..=options.generations.max(1) {
            run.advance(&mut objective);
            history.push(run.best_objective());
            progress(generation, run.best_objective());
            if stop::asked() {
                break;
            }
        }
    });
    finish(records, start, &[run], history, began)
}

/// One population on its way. Boxed once; nothing is allocated while it advances.
pub(super) struct Run {
    settings: Settings,
    space: Space<PARAMETERS>,
    start: Start,
    population: usize,
    pub(super) search: Option<Box<Genetic<MOST, PARAMETERS>>>,
}

impl Run {
    pub(super) fn new(start: &Start, options: &GaOptions, island: u16) -> Self {
        let settings =
            Settings { generations: options.generations, seed: options.seed, island, ..Settings::default() };
        Self { settings, space: start.space(), start: *start, population: options.population, search: None }
    }

    /// The first generation, or the next.
    pub(super) fn advance(&mut self, objective: &mut impl FnMut(&[[f64; PARAMETERS]], &mut [f64])) {
        let Self { settings, space, start, population, search } = self;
        match search {
            Some(search) => search.advance(settings, space, objective),
            None => {
                let first = |stream: &mut Stream| start.draw(stream);
                *search = Some(Box::new(Genetic::start(settings, space, *population, first, objective)));
            }
        }
    }

    pub(super) fn best_objective(&self) -> f64 {
        self.search.as_ref().map_or(f64::INFINITY, |s| s.best_objective())
    }
}

/// Picks the best population and computes what is reported of it.
pub(super) fn finish(
    records: &Records,
    start: &Start,
    runs: &[Run],
    history: Vec<f64>,
    began: Instant,
) -> GaResult {
    let searches = || runs.iter().filter_map(|run| run.search.as_deref());
    let best = searches()
        .min_by(|a, b| a.best_objective().total_cmp(&b.best_objective()))
        .map(|s| *s.best())
        .unwrap_or_default();
    let motor = start.motor(&best);
    let combinations = motor.combinations();
    GaResult {
        motor,
        parameters: motor.genes(),
        combinations,
        iae: records.exact_iae(&combinations),
        history,
        evaluations: searches().map(|s| u64::from(s.evaluations())).sum(),
        seconds: began.elapsed().as_secs_f64(),
        clamped: searches().map(|s| s.clamped_at_start() as usize).sum(),
        clamped_later: searches().map(|s| s.clamped_later() as usize).sum(),
        level: records.level(),
    }
}

impl Start {
    /// The parameters that a chromosome stands for.
    #[must_use]
    pub fn motor(&self, genes: &[f64; PARAMETERS]) -> PaperMotor {
        match self {
            Self::Literal { centre } => PaperMotor::from_genes(*genes, centre.gear_ratio),
            Self::Logarithmic { centre, .. } => {
                let at = centre.genes();
                let x = core::array::from_fn(|k| at[k] * genes[k].exp());
                PaperMotor::from_genes(x, centre.gear_ratio)
            }
        }
    }

    /// The middle of the region.
    #[must_use]
    pub fn centre(&self) -> PaperMotor {
        match self {
            Self::Literal { centre } | Self::Logarithmic { centre, .. } => *centre,
        }
    }

    /// One chromosome of the first generation, limited to what is admitted.
    pub(super) fn admitted(&self, stream: &mut Stream) -> [f64; PARAMETERS] {
        let mut genes = self.draw(stream);
        self.space().clamp(&mut genes);
        genes
    }

    fn space(&self) -> Space<PARAMETERS> {
        match self {
            Self::Literal { centre } => Space {
                low: centre.genes().map(|x| x * 1e-3),
                high: [f64::INFINITY; PARAMETERS],
                spread: [1.0; PARAMETERS],
            },
            Self::Logarithmic { factor, .. } => {
                Space::within([-factor.ln(); PARAMETERS], [factor.ln(); PARAMETERS])
            }
        }
    }

    fn draw(&self, stream: &mut Stream) -> [f64; PARAMETERS] {
        match self {
            Self::Literal { centre } => {
                let eps = stream.uniform();
                centre.genes().map(|x| stream.between(x - eps, x + eps))
            }
            Self::Logarithmic { factor, .. } => {
                [(); PARAMETERS].map(|()| stream.between(-factor.ln(), factor.ln()))
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::{GaOptions, Start, genetic_on};
    use crate::search::dispatch::Level;
    use crate::search::record::Records;
    use crate::search::trial::{MOTOR, three_sines};
    use motorlens_shared::linear::Kind;

    const START: Start = Start::Logarithmic { centre: MOTOR, factor: 4.0 };

    fn records(level: Level) -> Records {
        Records::new(&three_sines(100, Kind::Angle), level).expect("good records")
    }

    #[test]
    fn the_objective_comes_down_to_that_of_the_true_motor() {
        let records = records(Level::best());
        let truth = records.exact_iae(&MOTOR.combinations());
        let mut calls = 0;
        let result = genetic_on(&records, &START, &GaOptions::default(), &mut |_, _| calls += 1);
        assert!(result.iae <= truth * 1.001, "{} {truth}", result.iae);
        assert_eq!((calls, result.history.len()), (800, 800));
        assert_eq!(result.evaluations, 80 + 799 * 76);
        let gain = result.combinations.gain() / MOTOR.combinations().gain();
        assert!((gain - 1.0).abs() < 1e-3, "{gain}");
    }

    #[test]
    fn the_answer_is_the_same_for_any_number_of_threads() {
        let records = records(Level::best());
        for islands in [1, 3] {
            let run = |threads| {
                let options = GaOptions { generations: 120, threads, islands, ..GaOptions::default() };
                let result = genetic_on(&records, &START, &options, &mut |_, _| ());
                (result.parameters, result.history)
            };
            let one = run(1);
            assert_eq!(one, run(2), "{islands} islands");
            assert_eq!(one, run(5), "{islands} islands");
        }
    }

    #[test]
    fn every_vector_unit_finds_the_same_minimum() {
        let results: Vec<_> = Level::available()
            .into_iter()
            .map(|level| genetic_on(&records(level), &START, &GaOptions::default(), &mut |_, _| ()))
            .collect();
        for result in &results {
            assert!((result.iae / results[0].iae - 1.0).abs() < 1e-3);
            // Single precision in the lanes, double in the report.
            let last = result.history[result.history.len() - 1];
            assert!((last / result.iae - 1.0).abs() < 1e-3, "{last} {}", result.iae);
        }
    }

    #[test]
    fn the_literal_start_makes_negative_parameters_and_says_so() {
        let options = GaOptions { generations: 2, ..GaOptions::default() };
        let start = Start::Literal { centre: MOTOR };
        let result = genetic_on(&records(Level::best()), &start, &options, &mut |_, _| ());
        // Seven of eight genes are far below eps, so half of their draws are negative.
        assert!((200..360).contains(&result.clamped), "{}", result.clamped);
        assert!(result.parameters.iter().all(|p| *p > 0.0));
    }
}
