//! Searches for the parameters of the linear model: genetic, fast and conventional, on the vector units.

pub mod dispatch;
pub mod fused;
pub mod record;

mod conventional;
mod crew;
mod fast;
mod genetic;
pub(crate) mod golden;
mod islands;
pub(crate) mod least_squares;
mod projection;
#[cfg(test)]
mod trial;

pub use conventional::{ConventionalResult, conventional, conventional_on};
pub use fast::{FastResult, STARTS, fast, fast_on};
pub use genetic::{GaOptions, GaResult, MOST, Start, genetic, genetic_on};
pub use record::{Candidates, LinearRecord, RecordError, Records};
