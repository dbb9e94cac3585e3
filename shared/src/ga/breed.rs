//! How a child is made. A child depends on its own stream and on the sorted parents, on nothing else.

use super::{Settings, Space};
use crate::random::Stream;

/// How far beyond its parents a child of crossover may lie, as a share of their distance (Eshelman and
/// Schaffer's blend, 1993, without which a population can only shrink).
const BEYOND: f64 = 0.25;
/// Chance that a mutation replaces one particular gene.
const GENE_CHANCE: f64 = 0.25;
/// Standard deviation that mutations end with, in units of the gene's range.
const FINEST: f64 = 1e-4;

/// Makes one child of `sorted` parents (best first), not yet limited to the space.
///
/// # Panics
/// Where `sorted` is empty.
pub fn child<const G: usize>(
    stream: &mut Stream,
    sorted: &[[f64; G]],
    settings: &Settings,
    space: &Space<G>,
    generation: u32,
) -> [f64; G] {
    if stream.chance(settings.crossover) {
        let one = &sorted[tournament(stream, sorted.len())];
        let two = &sorted[tournament(stream, sorted.len())];
        core::array::from_fn(|k| {
            let weight = stream.between(-BEYOND, 1.0 + BEYOND);
            two[k] + weight * (one[k] - two[k])
        })
    } else {
        let mut genes = sorted[tournament(stream, sorted.len())];
        let left = 1.0 - f64::from(generation) / f64::from(settings.generations.max(1));
        let width = settings.mutation * left.max(0.0) + FINEST;
        let certain = stream.below(G);
        for k in 0..G {
            if k == certain || stream.chance(GENE_CHANCE) {
                genes[k] += width * space.spread[k] * stream.gaussian();
            }
        }
        genes
    }
}

/// The better of two drawn at random; positions in a sorted population are ranks.
fn tournament(stream: &mut Stream, population: usize) -> usize {
    stream.below(population).min(stream.below(population))
}
