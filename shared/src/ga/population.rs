//! The population and one turn of the wheel.

use super::{Objective, Settings, Space, breed};
use crate::random::Stream;

/// A search of up to `P` chromosomes of `G` genes each, sorted by objective, best first.
#[derive(Debug, Clone)]
pub struct Genetic<const P: usize, const G: usize> {
    chromosomes: [[f64; G]; P],
    objectives: [f64; P],
    /// Room for the generation before; kept here because a copy of all `P` would be too large for a board's stack.
    parents: [[f64; G]; P],
    parents_objectives: [f64; P],
    size: usize,
    generation: u32,
    evaluations: u32,
    clamped_at_start: u32,
    clamped_later: u32,
}

impl<const P: usize, const G: usize> Genetic<P, G> {
    /// A first generation of all `P`, spread evenly over the space.
    pub fn uniform(settings: &Settings, space: &Space<G>, objective: &mut impl Objective<G>) -> Self {
        let anywhere =
            |stream: &mut Stream| core::array::from_fn(|k| stream.between(space.low[k], space.high[k]));
        Self::start(settings, space, P, anywhere, objective)
    }

    /// A first generation of `size` chromosomes, each made by `initial` from its own stream.
    ///
    /// `size` is limited to 2 ..= `P`.
    pub fn start(
        settings: &Settings,
        space: &Space<G>,
        size: usize,
        mut initial: impl FnMut(&mut Stream) -> [f64; G],
        objective: &mut impl Objective<G>,
    ) -> Self {
        let size = size.clamp(2, P);
        let mut search = Self {
            chromosomes: [[0.0; G]; P],
            objectives: [f64::INFINITY; P],
            parents: [[0.0; G]; P],
            parents_objectives: [f64::INFINITY; P],
            size,
            generation: 1,
            evaluations: 0,
            clamped_at_start: 0,
            clamped_later: 0,
        };
        for index in 0..size {
            let mut genes = initial(&mut stream(settings, 0, index));
            search.clamped_at_start += space.clamp(&mut genes);
            search.chromosomes[index] = genes;
        }
        search.evaluate_from(0, objective);
        search.sort();
        search
    }

    /// One generation: the best pass, children replace the rest.
    pub fn advance(&mut self, settings: &Settings, space: &Space<G>, objective: &mut impl Objective<G>) {
        let elites = settings.elites(self.size);
        self.parents[..self.size].copy_from_slice(&self.chromosomes[..self.size]);
        for index in elites..self.size {
            let mut genes = breed::child(
                &mut stream(settings, self.generation, index),
                &self.parents[..self.size],
                settings,
                space,
                self.generation,
            );
            self.clamped_later += space.clamp(&mut genes);
            self.chromosomes[index] = genes;
        }
        self.evaluate_from(elites, objective);
        self.sort();
        self.generation += 1;
    }

    /// Puts `genes` in the place of the worst chromosome: how one island tells another.
    pub fn immigrate(&mut self, genes: [f64; G], objective: f64) {
        self.chromosomes[self.size - 1] = genes;
        self.objectives[self.size - 1] = objective;
        self.sort();
    }

    fn evaluate_from(&mut self, first: usize, objective: &mut impl Objective<G>) {
        let values = &mut self.objectives[first..self.size];
        objective.evaluate(&self.chromosomes[first..self.size], values);
        for value in values.iter_mut().filter(|value| value.is_nan()) {
            *value = f64::INFINITY;
        }
        self.evaluations += (self.size - first) as u32;
    }

    fn sort(&mut self) {
        let size = self.size;
        let mut order: [u16; P] = core::array::from_fn(|k| k as u16);
        let value = |k: u16| self.objectives[usize::from(k)];
        // Equal objectives keep their order, so that the result does not depend on the sorting method.
        order[..size].sort_unstable_by(|&a, &b| value(a).total_cmp(&value(b)).then(a.cmp(&b)));
        self.parents[..size].copy_from_slice(&self.chromosomes[..size]);
        self.parents_objectives[..size].copy_from_slice(&self.objectives[..size]);
        for (place, &from) in order[..size].iter().enumerate() {
            self.chromosomes[place] = self.parents[usize::from(from)];
            self.objectives[place] = self.parents_objectives[usize::from(from)];
        }
    }

    /// The best chromosome so far.
    #[must_use]
    pub fn best(&self) -> &[f64; G] {
        &self.chromosomes[0]
    }

    /// Its objective.
    #[must_use]
    pub fn best_objective(&self) -> f64 {
        self.objectives[0]
    }

    /// The population, best first.
    #[must_use]
    pub fn chromosomes(&self) -> &[[f64; G]] {
        &self.chromosomes[..self.size]
    }

    /// Generations done, the first included.
    #[must_use]
    pub fn generation(&self) -> u32 {
        self.generation
    }

    /// Chromosomes evaluated so far.
    #[must_use]
    pub fn evaluations(&self) -> u32 {
        self.evaluations
    }

    /// Genes of the first generation that had to be moved to a limit.
    #[must_use]
    pub fn clamped_at_start(&self) -> u32 {
        self.clamped_at_start
    }

    /// Genes of later generations that had to be moved to a limit.
    #[must_use]
    pub fn clamped_later(&self) -> u32 {
        self.clamped_later
    }
}

fn stream(settings: &Settings, generation: u32, index: usize) -> Stream {
    let place = (u32::from(settings.island) << 16) | index as u32;
    Stream::new(settings.seed, generation, place)
}

#[cfg(test)]
mod tests {
    use crate::ga::{Genetic, Settings, Space};

    /// Rastrigin's function: many local minima, the global one at (0.3, 0.3, 0.3).
    fn hilly(chromosomes: &[[f64; 3]], objectives: &mut [f64]) {
        for (x, objective) in chromosomes.iter().zip(objectives) {
            *objective = x
                .iter()
                .map(|x| {
                    let d = x - 0.3;
                    d * d + 10.0 * (1.0 - libm::cos(core::f64::consts::TAU * d))
                })
                .sum();
        }
    }

    const SPACE: Space<3> = Space { low: [-5.0; 3], high: [5.0; 3], spread: [10.0; 3] };

    fn run(seed: u64) -> Genetic<80, 3> {
        let settings = Settings { generations: 300, seed, ..Settings::default() };
        let mut search = Genetic::uniform(&settings, &SPACE, &mut hilly);
        let mut best = search.best_objective();
        while search.generation() < settings.generations {
            search.advance(&settings, &SPACE, &mut hilly);
            assert!(search.best_objective() <= best, "the elite must not get worse");
            best = search.best_objective();
        }
        search
    }

    #[test]
    fn the_global_minimum_is_found_among_many_local_ones() {
        for seed in 1..=10 {
            let search = run(seed);
            assert!(search.best_objective() < 0.01, "seed {seed}: {}", search.best_objective());
            assert_eq!(search.evaluations(), 80 + 299 * 76);
        }
    }

    #[test]
    fn a_seed_repeats_and_another_differs() {
        assert_eq!(run(4).chromosomes(), run(4).chromosomes());
        assert_ne!(run(4).chromosomes(), run(5).chromosomes());
    }

    #[test]
    fn the_population_is_sorted_and_inside_the_space() {
        let search = run(2);
        let mut objectives = [0.0; 80];
        hilly(search.chromosomes(), &mut objectives);
        assert!(objectives.is_sorted());
        for genes in search.chromosomes() {
            assert_eq!(SPACE.clone().clamp(&mut genes.clone()), 0);
        }
    }

    #[test]
    fn an_objective_that_is_not_a_number_is_never_best() {
        let settings = Settings { generations: 20, ..Settings::default() };
        let mut half = |chromosomes: &[[f64; 1]], objectives: &mut [f64]| {
            for (x, objective) in chromosomes.iter().zip(objectives) {
                *objective = if x[0] < 0.5 { f64::NAN } else { x[0] };
            }
        };
        let space = Space::within([0.0], [1.0]);
        let mut search = Genetic::<16, 1>::uniform(&settings, &space, &mut half);
        while search.generation() < settings.generations {
            search.advance(&settings, &space, &mut half);
        }
        assert!(search.best()[0] >= 0.5 && search.best()[0] < 0.51);
    }

    #[test]
    fn genes_outside_are_clamped_and_counted() {
        let settings = Settings { generations: 2, ..Settings::default() };
        let mut sum = |chromosomes: &[[f64; 2]], objectives: &mut [f64]| {
            for (x, objective) in chromosomes.iter().zip(objectives) {
                *objective = x[0] + x[1];
            }
        };
        let space = Space::within([0.0; 2], [1.0; 2]);
        let search = Genetic::<16, 2>::start(&settings, &space, 10, |_| [-1.0, 0.5], &mut sum);
        assert_eq!(search.clamped_at_start(), 10);
        assert_eq!(search.best(), &[0.0, 0.5]);
    }

    #[test]
    fn islands_draw_different_numbers_and_learn_from_an_immigrant() {
        let one = Settings { generations: 2, ..Settings::default() };
        let two = Settings { island: 1, ..one };
        let mut first = Genetic::<16, 3>::uniform(&one, &SPACE, &mut hilly);
        let second = Genetic::<16, 3>::uniform(&two, &SPACE, &mut hilly);
        assert_ne!(first.chromosomes(), second.chromosomes());
        first.immigrate([0.3; 3], 0.0);
        assert_eq!(first.best(), &[0.3; 3]);
    }
}
