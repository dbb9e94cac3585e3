//! Which physical effect is missing.
//!
//! records -> [`evidence`] -> [`crate::select`] -> [`discover`], with [`ladder`] and [`plan`] for whoever tells of it.

pub mod contained;
pub mod discover;
pub mod evidence;
pub mod ladder;
pub mod plan;
pub(crate) mod retraced;
pub(crate) mod ripple;
mod starts;
pub(crate) mod tangent;
