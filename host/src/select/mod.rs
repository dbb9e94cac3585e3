//! Which model the records speak for: one criterion for every effect (docs/DIAGNOSIS.md).
//!
//! [`crate::diagnose::evidence`] -> [`fitted`] (least squares on the whitened simulation error, its [`crate::fit::noise`] by time scale) -> [`score`]
//! (held-out log-likelihood) -> [`gain`] (of one over another) -> `criterion` (what is asked of it) -> [`forward`] steps from [`starts`] ->
//! [`run`] (forward and backward) -> [`adequacy`] of what is accepted -> [`found`].

pub mod adequacy;
pub(crate) mod criterion;
pub mod crossed;
pub mod fitted;
pub mod forward;
pub mod found;
pub mod gain;
pub mod limits;
pub mod run;
pub mod score;
pub mod starts;

pub use forward::with;
pub use found::{Begin, discovery, fitted_from};
pub use limits::DetectionLimit;

#[cfg(test)]
mod tests;
