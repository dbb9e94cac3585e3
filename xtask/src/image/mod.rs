//! What holds of a linked image, whatever its source says: that its interrupts cannot panic, and how deep its stack can be.

mod graph;
mod proof;
mod thumb;

pub use proof::prove;
