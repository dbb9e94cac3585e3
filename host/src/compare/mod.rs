//! Model against measurement: open-loop simulations, their errors, and where the model fails.

mod course;
pub mod dependence;
pub mod effect_trace;
pub mod effect_views;
pub mod failure;
pub mod free_run;
pub mod measures;
pub mod residual_torque;
pub mod residual_views;
pub mod rise;
mod slices;
mod stage;
mod trace;

pub use failure::{Bin, FailureMap, Slice, failure_map};
pub(crate) use stage::problem_as_it_is;
pub use stage::{laid_out, problem_of};
pub use trace::write_trace;
