//! Which physical effect is missing.

pub mod candidate;
pub mod climb;
pub mod discover;
mod ripple;
pub mod stage;
