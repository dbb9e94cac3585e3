//! From records to parameters.
//!
//! The way of the data: [`grid`] lays records on the model's time grid, and `guide` thins them to what is judged, [`sketch`] to what a first
//! comparison needs; [`layout`] names the numbers that are searched; [`simulate`] runs eight candidates through a record; [`cost`] turns
//! predictions into residuals, `loss` says how much each counts, and `normal` sums them for a step; `passes` does so for all records at once;
//! [`search`] makes them small, `begun` the first speeds with them; [`noise`] tells what they leave by time scale, and [`uncertainty`] how well
//! the data determine each number.

mod begun;
pub mod cost;
pub mod fixed;
pub mod grid;
mod guide;
mod held;
pub mod instants;
pub mod layout;
pub(crate) mod loss;
pub mod noise;
mod normal;
pub mod passes;
pub mod reading;
pub mod rig;
pub mod scales;
pub mod search;
pub mod setup;
pub mod simulate;
pub mod sketch;
pub mod start;
mod steps;
pub mod uncertainty;
mod voltages;
pub mod window;
