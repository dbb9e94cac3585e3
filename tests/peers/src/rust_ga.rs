//! The same search by genevo, a genetic algorithm crate, with the scalar objective that one writes first.

use std::sync::atomic::{AtomicU64, Ordering};

use genevo::mutation::value::RandomValueMutator;
use genevo::operator::prelude::*;
use genevo::population::{GenomeBuilder, Population, build_population};
use genevo::prelude::*;
use genevo::random::Rng;
use motorlens::search::LinearRecord;
use motorlens_shared::motor::PaperMotor;

use motorlens_peers::clock::processor_seconds;
use motorlens_peers::peer::{FACTOR, GENERATIONS, POPULATION, Peer};

type Genes = Vec<f64>;

/// Second-order filter in direct form beside the integral of the voltage, in double precision.
fn iae(records: &[LinearRecord], motor: &PaperMotor) -> f64 {
    let c = motor.combinations();
    let (alpha, beta, gain) = (c.a2_over_a1, c.a3_over_a1, c.gain());
    let discriminant = alpha * alpha - 4.0 * beta;
    if discriminant <= 0.0 {
        return f64::MAX; // complex poles: a motor with this much inductance is outside the region's sense
    }
    let root = discriminant.sqrt();
    let (p1, p2) = (-2.0 * beta / (alpha + root), -0.5 * (alpha + root));
    let mut sum = 0.0;
    for r in records {
        let (e1, e2) = ((p1 * r.dt).exp(), (p2 * r.dt).exp());
        let (r1, r2) = ((p1 + alpha) / (p1 - p2), (p2 + alpha) / (p2 - p1));
        let (g1, g2) = (r1 * (e1 - 1.0) / p1, r2 * (e2 - 1.0) / p2);
        let (b1, b2) = (g1 + g2, -g1 * e2 - g2 * e1);
        let (d1, d2) = (e1 + e2, -e1 * e2);
        let (mut w1, mut w2, mut integral, mut errors) = (0.0, 0.0, 0.0, 0.0);
        let first = r.measured[0];
        for (u, y) in r.voltage.iter().zip(&r.measured) {
            let z = b1 * w1 + b2 * w2;
            errors += (gain * (integral - z) - (y - first)).abs();
            let w = u + d1 * w1 + d2 * w2;
            (w2, w1) = (w1, w);
            integral += r.dt * u;
        }
        sum += errors * r.dt;
    }
    sum
}

fn motor(centre: &PaperMotor, genes: &[f64]) -> PaperMotor {
    let at = centre.genes();
    PaperMotor::from_genes(core::array::from_fn(|k| at[k] * genes[k].exp()), centre.gear_ratio)
}

#[derive(Debug, Clone)]
struct Fitness<'a> {
    records: &'a [LinearRecord],
    centre: PaperMotor,
    count: &'a AtomicU64,
}

/// genevo maximises an integer.
const SCALE: f64 = 1e12;

impl FitnessFunction<Genes, i64> for Fitness<'_> {
    fn fitness_of(&self, genes: &Genes) -> i64 {
        self.count.fetch_add(1, Ordering::Relaxed);
        -((iae(self.records, &motor(&self.centre, genes)) * SCALE).min(1e18) as i64)
    }
    fn average(&self, fitness: &[i64]) -> i64 {
        fitness.iter().sum::<i64>() / fitness.len() as i64
    }
    fn highest_possible_fitness(&self) -> i64 {
        0
    }
    fn lowest_possible_fitness(&self) -> i64 {
        i64::MIN
    }
}

struct Anywhere;

impl GenomeBuilder<Genes> for Anywhere {
    fn build_genome<R: Rng + Sized>(&self, _: usize, rng: &mut R) -> Genes {
        (0..8).map(|_| rng.gen_range(-FACTOR.ln()..FACTOR.ln())).collect()
    }
}

/// genevo's own operators, with the paper's sizes.
pub fn run(records: &[LinearRecord], centre: &PaperMotor) -> Peer {
    let count = AtomicU64::new(0);
    let fitness = Fitness { records, centre: *centre, count: &count };
    let first: Population<Genes> =
        build_population().with_genome_builder(Anywhere).of_size(POPULATION).uniform_at_random();
    let (low, high): (Genes, Genes) = (vec![-FACTOR.ln(); 8], vec![FACTOR.ln(); 8]);
    let began = processor_seconds();
    let mut simulation = simulate(
        genetic_algorithm()
            .with_evaluation(fitness.clone())
            .with_selection(MaximizeSelector::new(0.5, 2))
            .with_crossover(UniformCrossBreeder::new())
            .with_mutation(RandomValueMutator::new(0.1, low[0], high[0]))
            .with_reinsertion(ElitistReinserter::new(fitness, true, 0.95))
            .with_initial_population(first)
            .build(),
    )
    .until(GenerationLimit::new(GENERATIONS))
    .build();
    let mut best = f64::INFINITY;
    loop {
        match simulation.step() {
            Ok(SimResult::Intermediate(step)) => {
                best = best.min(-step.result.best_solution.solution.fitness as f64 / SCALE);
            }
            Ok(SimResult::Final(..)) | Err(_) => break,
        }
    }
    Peer {
        name: "genevo (Rust, scalar f64)".into(),
        seconds: processor_seconds() - began,
        evaluations: count.load(Ordering::Relaxed),
        iae: best,
        remark: String::new(),
    }
}
