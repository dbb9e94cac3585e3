//! The examination of the diagnosis: hidden cases from the independent virtual motor, answered by the loop that users
//! run, and marked.

pub mod benches;
pub mod case;
mod mark;
mod picture;
mod question;
mod table;
mod trial;
mod truth;

pub use mark::{Marks, Part};
pub use picture::picture;
pub use question::{Group, Paper, Question};
pub use table::table;
pub use trial::{Answer, examine};
