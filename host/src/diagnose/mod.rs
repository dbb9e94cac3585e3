//! Which physical effect is missing.

pub mod candidate;
pub mod climb;
mod ripple;
pub mod stage;
