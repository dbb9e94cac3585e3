//! Helpers for tests across crates.
