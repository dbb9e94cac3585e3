//! One competitor's result.

use serde::{Deserialize, Serialize};

/// Chromosomes, as in the paper.
pub const POPULATION: usize = 80;
/// Generations, as in the paper.
pub const GENERATIONS: u64 = 800;
/// Everyone's region: each parameter from centre / factor to centre * factor, on a logarithmic scale.
pub const FACTOR: f64 = 4.0;

/// What one competitor needed.
#[derive(Debug, Clone, Serialize, Deserialize)]
pub struct Peer {
    /// Who.
    pub name: String,
    /// Processor time, s.
    pub seconds: f64,
    /// Candidates evaluated.
    pub evaluations: u64,
    /// Objective reached, rad s.
    pub iae: f64,
    /// What to know about the figure.
    pub remark: String,
}

impl Peer {
    /// Seconds for as many evaluations as the paper's run has: everyone's work made equal.
    pub fn seconds_of_the_run(&self) -> f64 {
        self.seconds / self.evaluations as f64 * (POPULATION as u64 * GENERATIONS) as f64
    }
}
