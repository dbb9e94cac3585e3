//! Model against measurement.

pub mod free_run;
pub mod measures;
