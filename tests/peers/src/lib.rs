//! What the comparison with others and the counting of instructions share.

pub mod clock;
pub mod nonlinear;
pub mod peer;
