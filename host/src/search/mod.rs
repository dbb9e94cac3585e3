//! Searches for the parameters of the linear model: genetic, fast and conventional, on the vector units.

pub mod dispatch;
pub mod fused;
pub mod record;

mod crew;
mod genetic;
mod islands;
#[cfg(test)]
mod trial;

pub use genetic::{GaOptions, GaResult, MOST, Start, genetic, genetic_on};
pub use record::{Candidates, LinearRecord, RecordError, Records};
