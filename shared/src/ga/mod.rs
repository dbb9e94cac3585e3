//! A compact genetic algorithm: fixed size, no heap, the same on the board as on the host.
//!
//! As in the paper (Algorithm 1): sort by objective, pass the best 5 % unchanged, make the rest by crossover
//! (probability 0.8) or Gaussian mutation (0.2) that replaces genes, stop at the last generation. What the
//! paper leaves open is listed with what was taken in [`OPEN_CHOICES`].
//!
//! ```
//! use motorlens_shared::ga::{Genetic, Settings, Space};
//! let space = Space::within([-4.0; 2], [4.0; 2]);
//! let settings = Settings { generations: 120, seed: 1, ..Settings::default() };
//! let mut bowl = |chromosomes: &[[f64; 2]], objectives: &mut [f64]| {
//!     for (x, objective) in chromosomes.iter().zip(objectives) {
//!         *objective = (x[0] - 1.0).abs() + (x[1] + 2.0).abs();
//!     }
//! };
//! let mut search = Genetic::<16, 2>::uniform(&settings, &space, &mut bowl);
//! while search.generation() < settings.generations {
//!     search.advance(&settings, &space, &mut bowl);
//! }
//! assert!(search.best_objective() < 1e-2);
//! ```

mod breed;
mod population;

pub use breed::child;
pub use population::Genetic;

/// Decisions that the paper does not make and every implementation must: (question, taken here).
pub const OPEN_CHOICES: &[(&str, &str)] = &[
    ("how parents are chosen", "the better of two drawn at random, twice"),
    (
        "how crossover mixes two parents",
        "gene by gene on the line through both, from a quarter beyond one to a quarter beyond the other",
    ),
    (
        "whether 0.8 and 0.2 are shares or independent chances",
        "each child is made by crossover (0.8) or else by mutation (0.2)",
    ),
    ("how many genes a mutation replaces", "each with probability 1/4, and at least one"),
    (
        "centre and width of the Gaussian",
        "centred on the parent's gene; 0.2 of the gene's range, falling linearly to 1e-4 of it",
    ),
    ("what happens at a limit", "the gene is set to the limit, and this is counted"),
];

/// How a search runs. The defaults are the paper's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Number of generations, the first included. At least 1.
    pub generations: u32,
    /// Any number; the same seed gives the same answer on any number of threads.
    pub seed: u64,
    /// Which of several independent populations this is; each draws from its own streams. Below 65,536.
    pub island: u16,
    /// Share of the population that passes unchanged; at least one does. 0 to 1.
    pub elite: f64,
    /// Probability that a child is made by crossover, otherwise by mutation. 0 to 1.
    pub crossover: f64,
    /// Standard deviation of a mutation at the start, in units of [`Space::spread`].
    pub mutation: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self { generations: 800, seed: 1, island: 0, elite: 0.05, crossover: 0.8, mutation: 0.2 }
    }
}

impl Settings {
    /// Number of chromosomes that pass unchanged.
    #[must_use]
    pub fn elites(&self, population: usize) -> usize {
        ((self.elite * population as f64 + 0.5) as usize).clamp(1, population)
    }
}

/// Where genes may be. Two equal limits keep a gene fixed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Space<const G: usize> {
    /// Lowest admitted value.
    pub low: [f64; G],
    /// Highest admitted value; may be infinite.
    pub high: [f64; G],
    /// Range of a gene, the unit of mutation. Finite.
    pub spread: [f64; G],
}

impl<const G: usize> Space<G> {
    /// Between two limits, which are also the range.
    #[must_use]
    pub fn within(low: [f64; G], high: [f64; G]) -> Self {
        Self { low, high, spread: core::array::from_fn(|k| high[k] - low[k]) }
    }

    /// Moves the genes that lie outside to their limit and returns how many did.
    pub fn clamp(&self, chromosome: &mut [f64; G]) -> u32 {
        let mut moved = 0;
        for k in 0..G {
            let inside = chromosome[k].max(self.low[k]).min(self.high[k]);
            moved += u32::from(inside != chromosome[k]);
            chromosome[k] = inside;
        }
        moved
    }
}

/// What is minimised.
pub trait Objective<const G: usize> {
    /// Writes the objective of each chromosome. All children of a generation come at once, so that they can
    /// go through vector lanes side by side. Not-a-number counts as infinite.
    fn evaluate(&mut self, chromosomes: &[[f64; G]], objectives: &mut [f64]);
}

impl<const G: usize, F: FnMut(&[[f64; G]], &mut [f64])> Objective<G> for F {
    fn evaluate(&mut self, chromosomes: &[[f64; G]], objectives: &mut [f64]) {
        self(chromosomes, objectives);
    }
}
