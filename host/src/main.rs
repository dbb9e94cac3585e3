//! The motorlens program.
fn main() {}
