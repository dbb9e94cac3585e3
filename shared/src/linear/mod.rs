//! The linear model sample by sample, exactly: an integral that all candidates share and a second-order filter.
//!
//! ```text
//! theta = G (I - z),   I = integral of V,   z = (s + alpha) / (s^2 + alpha s + beta) V
//! omega = G beta / (s^2 + alpha s + beta) V
//! ```
//!
//! with G = b/a3, alpha = a2/a1, beta = a3/a1. Pulling the integrator out leaves a filter of two states that
//! cannot drift, and the integral is computed once for a whole search. The filter is discretised in closed
//! form ([`Filter::new`]), so no step size can make it unstable or biased.
//!
//! The motor rests at the start of a record and the angle counts from the first sample: the true angle
//! there is a nuisance of each record, and subtracting the first sample removes it.

mod discrete;
mod kernel;
mod laned;
mod prepare;

pub use discrete::{Filter, Hold, Kind};
pub use kernel::{FLUSH, State, absolute_error};
pub use laned::Laned;
pub use prepare::{Prepare, Sample};
