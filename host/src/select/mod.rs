//! Which model the records speak for: one criterion for every effect (docs/DIAGNOSIS.md).
//!
//! records -> [`dataset`] -> [`fitted`] (least squares on the whitened simulation error, its [`noise`] by time scale) -> [`score`]
//! (held-out log-likelihood) -> [`forward`] steps from [`starts`] -> [`run`] (forward and backward) -> [`found`].

pub mod dataset;
pub mod fitted;
pub mod forward;
pub mod found;
pub mod noise;
pub mod run;
pub mod score;
pub mod starts;

pub use found::discovery;

#[cfg(test)]
mod tests;
