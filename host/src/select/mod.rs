//! Which model the records speak for: one criterion for every effect.
//!
//! records -> [`dataset`] -> [`fitted`] (least squares on the whitened simulation error) -> [`score`] (held-out log-likelihood) ->
//! [`forward`] (forward, exchange and backward steps) -> [`select`]. Nothing here names an effect: what a search must know of one
//! stands in its row in `shared/src/effects`.

pub mod dataset;
pub mod fitted;
pub mod forward;
pub mod noise;
pub mod run;
pub mod score;
pub mod starts;
