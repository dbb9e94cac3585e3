//! motorlens
pub mod atomic_file;
pub mod error;
pub mod log;
pub mod motor_file;
pub mod search;
pub mod simulate;
