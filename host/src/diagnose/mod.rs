//! Which physical effect is missing.

pub mod candidate;
mod chance;
pub mod climb;
pub mod contained;
mod detours;
pub mod discover;
pub mod evidence;
pub mod floor;
pub mod ladder;
mod orders;
pub mod plan;
pub(crate) mod ripple;
pub mod rivals;
mod shake;
mod slow_pwm;
pub mod stage;
mod starts;
mod step;
pub(crate) mod tangent;
mod teeth;
pub mod way;
pub mod worth;
