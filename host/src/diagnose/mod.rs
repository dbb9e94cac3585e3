//! Which physical effect is missing.

pub mod candidate;
pub mod climb;
pub mod discover;
pub mod floor;
mod hold;
pub mod plan;
mod ripple;
pub mod stage;
mod tangent;
