//! motorlens
pub mod atomic_file;
pub mod cli;
pub mod compare;
pub mod device;
pub mod diagnose;
pub mod error;
pub mod estimate;
pub mod exam;
pub mod fit;
pub mod log;
pub mod model_file;
pub mod motor_file;
pub mod paper;
pub mod report;
pub mod search;
pub mod serve;
pub mod simulate;
